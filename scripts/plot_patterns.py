"""Draws the tool paths over the bundled moulds from above, for docs/images/patterns.png.

python scripts/plot_patterns.py [FILE.png]
"""

from __future__ import annotations

import sys
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from burnish.analysis.mould_map import TopView
from burnish.analysis.plot import new_figure
from burnish.model.tool import PolishingTool
from burnish.paths.order import ordered
from burnish.paths.patterns import Contour, CrossHatch, Geodesic, Pattern, Polyline, Raster, Spiral
from burnish.paths.reach import Reach
from burnish.polish.recipe import MARGIN
from burnish.surface import DistanceGrid, Mould

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PICTURE = Path(__file__).parents[1] / "docs" / "images" / "patterns.png"
STEP = 5e-3
"""Twice the usual step, so that single lines can be seen [m]."""
LINE, AIR = "#0b4f8a", "#e8a23a"
"""Colours of a stroke, and of the way through the air to the next one."""
ANGLE = np.linspace(0.0, 4.0 * np.pi, 200)
ROSE = Polyline(points=np.column_stack((np.cos(ANGLE), np.sin(ANGLE))) * (0.024 + 0.014 * np.cos(2.5 * ANGLE))[:, None])

PICTURES: list[tuple[str, str, Pattern]] = [
    ("mould", "raster", Raster()),
    ("dome", "raster at 30°", Raster(angle=np.pi / 6.0)),
    ("wave", "cross-hatch", CrossHatch()),
    ("dome", "spiral", Spiral()),
    ("mould", "contour", Contour()),
    ("mould", "geodesic", Geodesic()),
    ("wave", "contour", Contour()),
    ("dome", "polyline", ROSE),
]


def main() -> None:
    """Write the picture."""
    figure = new_figure(height=6.2, width=13.0)
    parts = {name: part(name) for name in {name for name, _, _ in PICTURES}}
    for axes, (name, title, pattern) in zip(figure.subplots(2, 4).flat, PICTURES, strict=True):
        mould, reach = parts[name]
        strokes = ordered(pattern.strokes(reach, mould, step=STEP, feed=0.02, force=10.0))
        axes.set_title(f"{title}, {name}", loc="left", fontsize=10)
        shade(axes, mould)
        for stroke in strokes:
            axes.plot(*(1e3 * stroke.points[:, :2].T), color=LINE, linewidth=1.0)
        for one, after in pairwise(strokes):
            way = 1e3 * np.array([one.points[-1, :2], after.points[0, :2]])
            axes.plot(*way.T, color=AIR, linewidth=1.0, linestyle=":")
    figure.savefig(Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURE, dpi=110)


def part(name: str) -> tuple[Mould, Reach]:
    """A bundled mould, and what the tip of the cell reaches of it."""
    tool, mould = PolishingTool(), Mould.load(name)
    return mould, Reach.of(mould, DistanceGrid.of(mould), tip_radius=tool.tip_radius, margin=MARGIN)


def shade(axes: Axes, mould: Mould) -> None:
    """The mould from above in grey, lit from the upper left."""
    view = TopView.of(mould.vertices, mould.faces)
    height = view.image(mould.vertices[:, 2])
    left, right, bottom, top = view.extent_mm
    dy, dx = np.gradient(1e3 * height, (top - bottom) / height.shape[0], (right - left) / height.shape[1])
    light = (1.0 + 0.5 * dx - 0.5 * dy) / np.sqrt(1.0 + dx**2 + dy**2)
    axes.imshow(light, "gray", origin="lower", extent=view.extent_mm, vmin=-0.6, vmax=1.15)
    axes.set_xticks([])
    axes.set_yticks([])
    for side in axes.spines.values():
        side.set_visible(False)


if __name__ == "__main__":
    main()
