"""Parallel tracks over everything of a mould that a spherical tip can work, as strokes of contact points.

The tip is lowered onto the distance grid so that it touches each place of the raster: no point of the path
gouges, and what the tip cannot reach is left out. Lines run along x and lie so close that their distance on
the surface nowhere exceeds the step; they are joined on the surface by half circles, and broken where there is
nothing to work.
"""

from __future__ import annotations

import numpy as np

from burnish.core import Array
from burnish.errors import PlanError
from burnish.polish.area import Area
from burnish.polish.hertz import contact_width, recommended_step
from burnish.polish.reach import STEEPEST, Reach
from burnish.polish.snake import chains, plan_view
from burnish.polish.stroke import Stroke, as_plan, from_plan
from burnish.surface import DistanceGrid, Mould, top, touching
from burnish.surface.touch import unit

__all__ = ["Stroke", "as_plan", "contact_width", "from_plan", "raster", "recommended_step"]

POINT_SPACING = 0.5e-3
"""Distance of the points of a stroke along the surface [m]: 40 points a second at 20 mm/s."""

SHORTEST_STROKE = 10e-3
"""A stroke that is shorter than this costs more time to approach than it works [m]."""

DISC = 1.5e-3
"""Radius of the disc over which the normal is averaged [m]: more than the facets of a fine mesh, and less than
a contact patch, so that facets do not make the tool nod. On a wave 60 mm long it flattens the slope by 1 %."""

ALIKE = np.deg2rad(5.0)
"""Angle up to which a normal nearby belongs to the same face and counts in the mean [rad]."""

TURN_SLACK = 0.2e-3
"""What the inset may fall short by in a half circle, where the border is not straight [m]."""


def raster(
    mould: Mould,
    grid: DistanceGrid,
    *,
    tip_radius: float,
    step: float,
    feed: float,
    force: float,
    margin: float,
    max_slope: float = STEEPEST,
) -> list[Stroke]:
    """Cover a mould with parallel lines along x in snake order.

    The first and the last line lie at the inset; the others divide the surface between them evenly. Beside a
    hole or a pocket the lines are divided anew.

    Args:
        mould: what to work.
        grid: the distance to it.
        tip_radius: radius of the spherical tip [m].
        step: greatest distance of neighbouring lines on the surface [m].
        feed: speed along the surface [m/s].
        force: normal force [N].
        margin: inset of the points of contact from the border of the workable surface, in plan [m].
        max_slope: steepest surface that is worked, from facing up [rad].

    Returns:
        Strokes of evenly spaced points, at least one.

    Raises:
        PlanError: a value is out of range, or nothing of the mould is left to work.
        InputError: the grid is too coarse or too low for this tip.
    """
    _check(tip_radius=tip_radius, step=step, feed=feed, force=force)
    reach = Reach.of(mould, grid, tip_radius=tip_radius, margin=margin, max_slope=max_slope)
    area = Area.probed(reach, mould, step)
    strokes = []
    for lines in area.lines(step):
        turn = np.diff(lines.y).max(initial=0.0) / 2.0
        rows = area.rows(lines, turn, step)
        for chain in chains(lines.y, rows, lambda xy: bool(reach.free(xy, TURN_SLACK).all())):
            stroke = _stroke(reach, plan_view(chain), feed, force)
            if stroke is not None:
                strokes.append(stroke)
    if not strokes:
        raise PlanError(
            f"nothing of '{mould.name}' is left to work with a tip of {1e3 * tip_radius:.3g} mm radius, an inset of "
            f"{1e3 * margin:.3g} mm from its borders and slopes up to {np.rad2deg(max_slope):.0f}°; "
            "reduce the inset, or use a smaller tip"
        )
    return strokes


def _check(**values: float) -> None:
    """All values positive and finite."""
    for name, value in values.items():
        if not 0.0 < value < np.inf:
            raise PlanError(f"raster: {name} is {value}; expected a positive number in SI units")


def _stroke(reach: Reach, xy: Array, feed: float, force: float) -> Stroke | None:
    """Evenly spaced points of contact along a dense path of the tip in plan; None if that is too short."""
    surface = top(reach.grid, xy)
    there = ~np.isnan(surface[:, 2])  # a hole that is smaller than the probes are apart is passed over
    surface, xy = surface[there], xy[there]
    arc = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(surface, axis=0), axis=1))))
    if arc[-1] < SHORTEST_STROKE:
        return None
    even = np.linspace(0.0, arc[-1], int(np.ceil(arc[-1] / POINT_SPACING)) + 1)
    place = np.column_stack([np.interp(even, arc, xy[:, i]) for i in range(2)])
    centre = touching(reach.grid, place, reach.tip_radius).centre
    centre = centre[~np.isnan(centre[:, 2])]
    normal = _mean_normal(reach.grid, centre)
    level = np.ones(len(centre))
    return Stroke(points=centre - reach.tip_radius * normal, normals=normal, feed=feed * level, force=force * level)


def _mean_normal(grid: DistanceGrid, centre: Array) -> Array:
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
