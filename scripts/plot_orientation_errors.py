"""Draws the published orientation errors over the angle to the target, for docs/orientation-errors.md.

python scripts/plot_orientation_errors.py [FILE.svg]
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

from burnish.analysis.plot import new_figure, svg
from burnish.core import Array
from burnish.rotation import (
    continuous_error,
    exp,
    quaternion,
    quaternion_error,
    rotation_vector_error,
    sine_error,
    skew,
)

PICTURE = Path(__file__).parents[1] / "docs" / "images" / "orientation-errors.svg"
AXIS = np.array([0.48, 0.6, 0.64])
TARGET = exp(np.array([0.3, -0.9, 0.5]))
"""A unit axis and a target, both arbitrary; only the faulty error depends on them."""


def method_4_as_printed(R: Array, R_d: Array) -> Array:
    """The blog's listing: S of the first three of [η, ε_x, ε_y, ε_z] in the place of the last three."""
    Q, Q_d = quaternion(R), quaternion(R_d)
    return np.asarray(-(Q_d[0] * Q[1:] - Q[0] * Q_d[1:] + skew(Q_d[:3]) @ Q[1:]))


CURVES: list[tuple[str, Callable[[Array, Array], Array], str, str]] = [
    ("θ: thesis A", rotation_vector_error, "#0b4f8a", "-"),
    ("θ, faded: our laws", continuous_error, "#5fa3d9", "--"),
    ("sin(θ/2): methods 1, 2 and 4", quaternion_error, "#e8a23a", "-"),
    ("sin θ: method 3", sine_error, "#2e7d4f", "-"),
    ("method 4 as printed", method_4_as_printed, "#b3261e", ":"),
]


def curve(error: Callable[[Array, Array], Array], theta: Array) -> Array:
    """Length of the error at the angles θ from the target about `AXIS`."""
    return np.array([np.linalg.norm(error(exp(-angle * AXIS) @ TARGET, TARGET)) for angle in theta])


def main(path: Path) -> None:
    """Write the picture."""
    theta = np.linspace(0.0, np.pi - 1e-9, 721)
    figure = new_figure(height=3.6, width=7.0)
    axes = figure.subplots()
    for name, error, colour, style in CURVES:
        axes.plot(np.degrees(theta), curve(error, theta), color=colour, linestyle=style, linewidth=1.4, label=name)
    axes.set(xlabel="angle θ to the target [°]", ylabel="length of the error", xlim=(0.0, 180.0), ylim=(0.0, 3.3))
    axes.set_xticks(range(0, 181, 30))
    axes.grid(True, color="#e3e6ea", linewidth=0.6)
    axes.legend(loc="upper left")
    path.write_text(svg(figure, "orientation errors") + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURE)
