"""Lines along the ends of what can be worked, and what they share with other curves over a sheet."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from burnish.core import Array
from burnish.paths.raster import check
from burnish.paths.reach import Reach
from burnish.paths.sheet import Sheet, level_curves
from burnish.paths.spacing import across_curvature, spacing_for
from burnish.paths.stroke import Stroke
from burnish.paths.track import SHORTEST_STROKE, TURN_SLACK, broken, projected
from burnish.surface import Mould

INSIDE = 0.1e-3
"""Distance of the outermost line from where the workable places end [m]; corners are rounded by about as much."""

_HEM = 0.5
"""Force on the line along an end, in those of the others."""

_NO_BORDER = 0.5e-3
"""How much further than the inset a border is from the end of the workable places if it is not what ends them [m]."""


def hem(reach: Reach, mould: Mould, *, step: float | None, feed: float, force: float) -> list[Stroke]:
    """Lines along the ends of the workable places that are no border: feet of walls, and where it gets too steep.

    Lines that end there leave half of the depth, and steps between line and line. Along a border that lies in the
    edge band, which nobody judges; here it does not. Half of the force makes up for what is missing.
    """
    check(tip_radius=reach.tip_radius, step=step, feed=feed, force=force)
    sheet = Sheet.of(reach, mould)
    if not sheet.good.any():
        return []
    across = directions(sheet.inset, sheet)
    spacing = spacing_for(reach, step, force, across_curvature(reach, sheet.xy[sheet.good], across[sheet.good]))
    curves = []
    for curve in level_curves(sheet, sheet.inset, INSIDE):
        own = reach.border.distance(curve) > reach.margin + _NO_BORDER
        edges = np.flatnonzero(np.diff(np.concatenate(([0], own.astype(np.int8), [0]))))
        heading = np.gradient(curve, axis=0)
        aside = heading[:, ::-1] * [-1.0, 1.0] / np.maximum(np.linalg.norm(heading, axis=1, keepdims=True), 1e-12)
        pressed = _HEM * force / spacing.typical * spacing.at(across_curvature(reach, curve, aside))
        for a, b in zip(edges[::2], edges[1::2], strict=True):
            curves += broken(reach, np.column_stack((curve[a:b], pressed[a:b])), SHORTEST_STROKE)
    return strokes_along(reach, curves, feed)


def directions(field: Array, sheet: Sheet) -> Array:
    """Unit vectors of the gradient of a field in plan, (ny, nx, 2)."""
    dy, dx = np.gradient(field, sheet.y, sheet.x)
    gradient = np.stack((dx, dy), axis=-1)
    return np.asarray(gradient / np.maximum(np.linalg.norm(gradient, axis=-1, keepdims=True), 1e-9))


def room(reach: Reach) -> Callable[[Array], bool]:
    """Whether the tip may go to all places (N, 2)."""
    return lambda xy: bool(reach.free(xy, TURN_SLACK).all())


def strokes_along(reach: Reach, curves: Sequence[Array], feed: float) -> list[Stroke]:
    """Dense curves in plan with their force, (N, 3) each, as strokes; those that are too short are left out."""
    found = (projected(reach, curve[:, :2], feed, curve[:, 2]) for curve in curves)
    return [stroke for stroke in found if stroke is not None]
