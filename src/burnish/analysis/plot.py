"""Figures of a run for a page or for paper: time series, the histogram of the removal, the mould from above.

Colours can be told apart by everybody and survive a black-and-white print; no global state of the plotting
library is touched.
"""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from burnish.core import Array, read_only
from burnish.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TRUE, MEASURED, SET = "#0b4f8a", "#e8a23a", "#222222"
"""Colours of what really happened, of what a sensor said, and of what was wanted."""
ENVELOPE_BINS = 900
"""Intervals of a decimated line: about one a pixel of a wide page, each with its extremes."""
WIDTH = 9.0
"""Width of a figure in inches; a page scales it to its own."""


@dataclass(frozen=True, kw_only=True)
class RunSeries:
    """What happened over a whole run; arrays (N,), NaN where a quantity did not exist."""

    t: Array
    """Time [s], increasing."""
    force: Array
    """True contact force along the normal [N]; the measured one where nobody knows the true one."""
    force_set: Array
    """Set force [N]."""
    tilt: Array
    """Angle between the tool's axis and the inward surface normal [rad]."""
    speed: Array
    """Speed of the tool along the surface [m/s]."""
    feed: Array
    """Commanded feed [m/s]."""
    force_measured: Array = field(default_factory=lambda: read_only(()))
    """What the force sensor said [N]; empty when it is not shown."""
    phases: tuple[tuple[float, str], ...] = ()
    """Starts of the phases of the run: time [s] and name."""

    def __post_init__(self) -> None:
        for name in ("t", "force", "force_set", "tilt", "speed", "feed", "force_measured"):
            values = read_only(getattr(self, name))
            object.__setattr__(self, name, values)
            if values.shape != np.shape(self.t) and not (name == "force_measured" and values.size == 0):
                raise InputError(f"RunSeries: {name} has shape {values.shape}; expected that of t, {np.shape(self.t)}")


def envelope(t: Array, y: Array, bins: int = ENVELOPE_BINS) -> tuple[Array, Array]:
    """A line with at most 2·``bins`` points that still touches every extreme of ``y`` (N,).

    In each of ``bins`` intervals of equal count, the smallest and the largest sample stay, in their order;
    an interval without a number becomes a gap.
    """
    if len(t) <= 2 * bins:
        return t, y
    edges = np.linspace(0, len(t), bins + 1).astype(int)[:-1]
    low = np.fmin.reduceat(y, edges)
    high = np.fmax.reduceat(y, edges)
    owner = np.repeat(np.arange(bins), np.diff(np.append(edges, len(t))))
    ordinal = np.arange(len(t))
    first_low = np.minimum.reduceat(np.where(y == low[owner], ordinal, len(t)), edges)
    first_high = np.minimum.reduceat(np.where(y == high[owner], ordinal, len(t)), edges)
    empty = first_low == len(t)
    first_low, first_high = np.where(empty, edges, first_low), np.where(empty, edges, first_high)
    kept = np.sort(np.stack([first_low, first_high], axis=1), axis=1).ravel()
    return t[kept], y[kept]


def motion_figure(series: RunSeries) -> Figure:
    """Contact force, tilt and feed over time, one above the other."""
    figure = new_figure(height=6.2)
    force, tilt, feed = figure.subplots(3, 1, sharex=True, height_ratios=(2.0, 1.0, 1.0))
    if series.force_measured.size:
        _line(force, series.t, series.force_measured, MEASURED, "measured", 0.7)
    _line(force, series.t, series.force, TRUE, "contact force", 0.8)
    _line(force, series.t, series.force_set, SET, "set", 1.1, "--")
    _line(tilt, series.t, np.degrees(series.tilt), TRUE, "tilt", 0.8)
    _line(feed, series.t, 1e3 * series.speed, TRUE, "speed", 0.8)
    _line(feed, series.t, 1e3 * series.feed, SET, "commanded feed", 1.1, "--")
    for axes, label in ((force, "force [N]"), (tilt, "tilt [°]"), (feed, "feed [mm/s]")):
        axes.set_ylabel(label)
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
        for start, _ in series.phases:
            axes.axvline(start, color="#9aa3ad", linewidth=0.6, zorder=0)
    _name_phases(force, series)
    for axes, columns in ((force, 3), (feed, 2)):
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.1, ncols=columns)
    feed.set_xlabel("time [s]")
    if len(series.t):
        feed.set_xlim(float(series.t[0]), max(float(series.t[-1]), float(series.t[0]) + 1e-3))
    figure.align_ylabels()
    return figure


def new_figure(height: float, width: float = WIDTH) -> Figure:
    """An empty figure of our own, in inches, that no global state knows of."""
    from matplotlib.figure import Figure  # Half a second to load: only those who draw pay for it.

    return Figure(figsize=(width, height), layout="constrained", facecolor="white")


def svg(figure: Figure, title: str) -> str:
    """The figure as an ``<svg>`` element for a page: text as outlines, ids that do not meet those of others."""
    import matplotlib

    tidy(figure)
    buffer = io.StringIO()
    metadata: dict[str, Any] = dict.fromkeys(("Creator", "Date", "Format", "Type"))
    with matplotlib.rc_context({"svg.hashsalt": title, "svg.fonttype": "path"}):
        figure.savefig(buffer, format="svg", metadata=metadata)
    text = buffer.getvalue()
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
    return text.replace("<svg", '<svg role="img"', 1)


def png_data(figure: Figure, dots_per_inch: int = 130) -> str:
    """The figure as a ``data:`` address of a PNG."""
    tidy(figure)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=dots_per_inch)
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")


def tidy(figure: Figure) -> None:
    """One look for all figures: thin grid, small dark type, no box."""
    for axes in figure.axes:
        axes.tick_params(labelsize=8, colors="#333333", width=0.6, length=3)
        for item in (axes.xaxis.label, axes.yaxis.label):
            item.set_fontsize(9)
        axes.title.set_fontsize(10)
        for side in ("top", "right"):
            axes.spines[side].set_visible(False)
        for spine in axes.spines.values():
            spine.set_linewidth(0.6)
        legend = axes.get_legend()
        if legend is not None:
            legend.get_frame().set(alpha=0.85, linewidth=0.0)
            for text in legend.get_texts():
                text.set_fontsize(8)


def _line(axes: Axes, t: Array, y: Array, colour: str, label: str, width: float, style: str = "-") -> None:
    axes.plot(*envelope(t, y), color=colour, linewidth=width, linestyle=style, label=label)
    axes.grid(True, color="#e3e6ea", linewidth=0.6)
    axes.set_axisbelow(True)


def _name_phases(axes: Axes, series: RunSeries) -> None:
    """The names of the phases in the upper edge of the plot, where they have room."""
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.12 * (high - low))
    if not series.phases or not len(series.t):
        return
    ends = [*(start for start, _ in series.phases[1:]), float(series.t[-1])]
    length = max(float(series.t[-1] - series.t[0]), 1e-9)
    for (start, name), end in zip(series.phases, ends, strict=True):
        # About 1.1 % of the width a letter at this size.
        if (end - start) / length > 0.011 * (len(name) + 1):
            place = (start + 0.004 * length, 0.98)
            axes.text(*place, name, transform=axes.get_xaxis_transform(), fontsize=7.5, va="top", color="#5b6470")


def classes(removal: Array, evaluated: NDArray[np.bool_], target: float) -> NDArray[np.int64]:
    """Class of each value: 0 under half the target, 1 within, 2 over 1.5 times, 3 outside the evaluated area."""
    ratio = np.asarray(removal) / target
    return np.where(evaluated, (ratio >= 0.5).astype(int) + (ratio > 1.5), 3)


CLASS_COLOURS = ("#2f6db5", "#cbd5c0", "#d55e00", "#eceef0")
CLASS_NAMES = ("under 50 %", "50–150 %", "over 150 %", "not evaluated")
"""Removal relative to the target. Blue and orange, the two faults, differ for every eye; what is right is pale."""


def vertex_areas(vertices: Array, faces: NDArray[np.int64]) -> Array:
    """A third of the area of the faces around each vertex [m²], (V,)."""
    corners = np.asarray(vertices)[faces]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return np.asarray(np.bincount(np.ravel(faces), np.repeat(area / 3.0, 3), len(vertices)), dtype=np.float64)


def share_lines(axes: Axes, target_um: float, names: Sequence[str] = ("50 %", "target", "150 %")) -> None:
    """Vertical lines at the borders of the classes and at the target."""
    for factor, name in zip((0.5, 1.0, 1.5), names, strict=True):
        axes.axvline(factor * target_um, color=SET, linewidth=0.9, linestyle="-" if factor == 1.0 else ":")
        axes.annotate(name, (factor * target_um, 1.0), (3, -2), xycoords=axes.get_xaxis_transform(),
                      textcoords="offset points", fontsize=7.5, va="top", color="#333333")  # fmt: skip
