"""Parallel tracks over everything of a mould that a spherical tip can work, as strokes of contact points.

The tip is lowered onto the distance grid so that it touches each place of the raster: no point of the path
gouges, and what the tip cannot reach is left out. Lines run along x and lie so close that their distance on
the surface nowhere exceeds the step; they are joined on the surface by half circles, and broken where there is
nothing to work.
"""

from __future__ import annotations

import numpy as np

from burnish.errors import PlanError
from burnish.paths.area import Area
from burnish.paths.hertz import contact_width, recommended_step
from burnish.paths.reach import STEEPEST, Reach
from burnish.paths.snake import chains, plan_view
from burnish.paths.stroke import Stroke, as_plan, from_plan
from burnish.paths.track import TURN_SLACK, projected
from burnish.surface import DistanceGrid, Mould

__all__ = ["Stroke", "as_plan", "contact_width", "from_plan", "raster", "recommended_step"]


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
    reach = Reach.of(mould, grid, tip_radius=tip_radius, margin=margin, max_slope=max_slope)
    return required(lines(reach, mould, step=step, feed=feed, force=force, angle=0.0), reach, mould)


def lines(reach: Reach, mould: Mould, *, step: float | None, feed: float, force: float, angle: float) -> list[Stroke]:
    """Parallel lines at an angle [rad] from the mould's x, and where a step is left open 0.3 contact widths apart.

    With the step left open, lines that lie closer are pressed with less force. May be empty.

    Raises:
        PlanError: a value is out of range.
    """
    check(tip_radius=reach.tip_radius, step=step, feed=feed, force=force)
    area = Area.probed(reach, mould, step, force, angle)
    strokes = []
    for own in area.lines():
        trim = np.diff(own.y).max(initial=0.0) / 2.0
        rows = area.rows(own, trim)
        for chain in chains(own.y, rows, lambda xy: bool(area.free(xy, TURN_SLACK).all())):
            path = plan_view(chain)
            pressed = force / area.spacing.typical * np.interp(path[:, 1], own.y, own.step)
            stroke = projected(reach, path @ area.turn.T, feed, pressed)
            if stroke is not None:
                strokes.append(stroke)
    return strokes


def required(strokes: list[Stroke], reach: Reach, mould: Mould) -> list[Stroke]:
    """The strokes, of which there has to be one.

    Raises:
        PlanError: there is none.
    """
    if not strokes:
        raise PlanError(
            f"nothing of '{mould.name}' is left to work with a tip of {1e3 * reach.tip_radius:.3g} mm radius, an inset "
            f"of {1e3 * reach.margin:.3g} mm from its borders and slopes up to {np.rad2deg(reach.max_slope):.0f}°; "
            "reduce the inset, or use a smaller tip"
        )
    return strokes


def check(*, tip_radius: float, step: float | None, feed: float, force: float) -> None:
    """All values positive and finite; a step may be left open.

    Raises:
        PlanError: one is not.
    """
    for name, value in (("tip_radius", tip_radius), ("step", step), ("feed", feed), ("force", force)):
        if value is not None and not 0.0 < value < np.inf:
            raise PlanError(f"path: {name} is {value}; expected a positive number in SI units")
