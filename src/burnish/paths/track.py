"""From a curve in plan to a stroke: points of contact that the tip really touches, and the normals there.

All patterns end here. A curve is cut where the tip may not go; of what is left, the tip is lowered onto the distance
grid at every place, so no point gouges whatever the curve was drawn from.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from burnish.core import Array
from burnish.paths.reach import Reach
from burnish.paths.stroke import Stroke
from burnish.surface import DistanceGrid, top, touching
from burnish.surface.touch import unit

POINT_SPACING = 0.5e-3
"""Distance of the points of a stroke along the surface [m]: 40 points a second at 20 mm/s."""

SHORTEST_STROKE = 10e-3
"""A stroke that is shorter than this costs more time to approach than it works [m]."""

TURN_SLACK = 0.2e-3
"""What the inset may fall short by where a curve bends along a border that is not straight [m]."""

PLAN_PITCH = 0.25e-3
"""Distance of the places along a curve in plan [m]."""

DISC = 1.5e-3
"""Radius of the disc over which the normal is averaged [m]: more than the facets of a fine mesh, and less than
a contact patch, so that facets do not make the tool nod. On a wave 60 mm long it flattens the slope by 1 %."""

ALIKE = np.deg2rad(5.0)
"""Angle up to which a normal nearby belongs to the same face and counts in the mean [rad]."""


def projected(reach: Reach, xy: Array, feed: float, force: ArrayLike) -> Stroke | None:
    """Evenly spaced points of contact along a dense path of the tip in plan; None if that is too short.

    Args:
        reach: tip and mould.
        xy: places along the path that are free, (N, 2) [m].
        feed: speed along the surface [m/s].
        force: normal force at these places [N], (N,), or one for all.
    """
    force = np.broadcast_to(np.asarray(force, dtype=np.float64), len(xy))
    surface = top(reach.grid, xy)
    there = ~np.isnan(surface[:, 2])  # a hole that is smaller than the probes are apart is passed over
    surface, xy, force = surface[there], xy[there], force[there]
    if len(xy) < 2:
        return None
    arc = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(surface, axis=0), axis=1))))
    if arc[-1] < SHORTEST_STROKE:
        return None
    even = np.linspace(0.0, arc[-1], int(np.ceil(arc[-1] / POINT_SPACING)) + 1)
    place = np.column_stack([np.interp(even, arc, xy[:, i]) for i in range(2)])
    centre = touching(reach.grid, place, reach.tip_radius).centre
    met = ~np.isnan(centre[:, 2])
    centre = centre[met]
    normal = mean_normal(reach.grid, centre)
    return Stroke(
        points=centre - reach.tip_radius * normal,
        normals=normal,
        feed=np.full(len(centre), feed),
        force=np.interp(even, arc, force)[met],
    )


def mean_normal(grid: DistanceGrid, centre: Array) -> Array:
    """Unit normals of the surface as the tip sees them from centres (N, 3), averaged over a small disc, (N, 3).

    A disc, not a piece of the path: it has no direction, so it does not lag where the path turns round.
    """
    normal = unit(grid.at(centre)[1])
    aside = unit(np.cross(normal, [0.0, 1.0, 0.0]))
    ahead = np.cross(normal, aside)
    total = normal.copy()
    for angle in np.arange(6) * np.pi / 3.0:
        other = unit(grid.at(centre + DISC * (np.cos(angle) * aside + np.sin(angle) * ahead))[1])
        total += np.where(np.einsum("ij,ij->i", other, normal)[:, None] > np.cos(ALIKE), other, 0.0)
    return unit(total)


def dense(xy: Array) -> Array:
    """A polyline (N, 2) or, with its force, (N, 3), with a place every quarter of a millimetre, corners kept."""
    length = np.linalg.norm(np.diff(xy[:, :2], axis=0), axis=1)
    xy, length = np.concatenate((xy[:1], xy[1:][length > 0.0])), length[length > 0.0]
    arc = np.concatenate(([0.0], np.cumsum(length)))
    count = np.maximum(np.ceil(length / PLAN_PITCH), 1.0).astype(np.int64)
    at = [start + np.arange(n) * (size / n) for start, size, n in zip(arc[:-1], length, count, strict=True)]
    s = np.concatenate([*at, arc[-1:]])
    return np.column_stack([np.interp(s, arc, xy[:, i]) for i in range(xy.shape[1])])


def broken(reach: Reach, curve: Array, shortest: float) -> list[Array]:
    """The pieces of a dense curve, (N, 2) or with its force (N, 3), that the tip may work, of at least a length [m]."""
    free = reach.free(curve[:, :2], TURN_SLACK)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], free.astype(np.int8), [0]))))
    pieces = [curve[a:b] for a, b in zip(edges[::2], edges[1::2], strict=True)]
    return [piece for piece in pieces if plan_length(piece) >= shortest]


def plan_length(curve: Array) -> float:
    """Length of a curve in plan [m]."""
    return float(np.linalg.norm(np.diff(curve[:, :2], axis=0), axis=1).sum())
