"""Tool paths by name: a pattern makes the strokes that work a mould.

Every pattern is a frozen record with one method, ``strokes``, and ends in the same projection onto the surface. Give a
step [m] to choose the distance of the lines on the surface; without one it is 0.3 of the local width of the
contact, and where lines lie closer for that they are pressed with less force, so that the removal stays even.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from burnish.core import Array, read_only
from burnish.errors import PlanError
from burnish.paths.hem import hem, strokes_along
from burnish.paths.raster import check, lines, required
from burnish.paths.reach import Reach
from burnish.paths.rings import Contour, Geodesic, Spiral
from burnish.paths.stroke import Stroke
from burnish.paths.track import SHORTEST_STROKE, broken, dense
from burnish.surface import Mould

__all__ = ["Contour", "CrossHatch", "Geodesic", "Pattern", "Polyline", "Raster", "Spiral"]


class Pattern(Protocol):
    """How a surface is covered."""

    def strokes(self, reach: Reach, mould: Mould, *, step: float | None, feed: float, force: float) -> list[Stroke]:
        """The strokes, at least one.

        Args:
            reach: tip, grid, and what is asked of a place.
            mould: what to work.
            step: greatest distance of neighbouring lines on the surface [m], or None for 0.3 of the contact's width.
            feed: speed along the surface [m/s].
            force: normal force [N].

        Raises:
            PlanError: a value is out of range, or nothing of the mould is left to work.
            InputError: the grid is too coarse or too low for this tip.
        """


@dataclass(frozen=True, kw_only=True)
class Raster:
    """Parallel lines back and forth, and a lighter one along what keeps the tip off."""

    angle: float = 0.0
    """Of the lines from the mould's x, about z [rad]."""

    def __post_init__(self) -> None:
        _check_angle(self.angle)

    def strokes(self, reach: Reach, mould: Mould, *, step: float | None, feed: float, force: float) -> list[Stroke]:
        """See :class:`Pattern`."""
        found = lines(reach, mould, step=step, feed=feed, force=force, angle=self.angle)
        return required(found + hem(reach, mould, step=step, feed=feed, force=force), reach, mould)


@dataclass(frozen=True, kw_only=True)
class CrossHatch:
    """Two rasters at a right angle: the second one breaks up the lay of the first. It removes twice as much."""

    angle: float = 0.0
    """Of the first lines from the mould's x, about z [rad]."""

    def __post_init__(self) -> None:
        _check_angle(self.angle)

    def strokes(self, reach: Reach, mould: Mould, *, step: float | None, feed: float, force: float) -> list[Stroke]:
        """See :class:`Pattern`."""
        angles = (self.angle, self.angle + np.pi / 2.0)
        first, second = (lines(reach, mould, step=step, feed=feed, force=force, angle=angle) for angle in angles)
        end = hem(reach, mould, step=step, feed=feed, force=force)
        return required(first + end + second + end, reach, mould)


@dataclass(frozen=True, kw_only=True)
class Polyline:
    """A path that the user has drawn, laid onto the surface; there is nothing to choose a step for."""

    points: Array
    """Its corners in the mould's frame [m], (N, 2) or (N, 3); the height does not count."""

    def __post_init__(self) -> None:
        """Copy the points and refuse what is no path."""
        try:
            points = read_only(self.points)
        except (TypeError, ValueError):
            raise PlanError("polyline: its points are no array of numbers; expected rows of x, y in metres") from None
        if points.ndim != 2 or points.shape[1] not in (2, 3) or not np.isfinite(points).all():
            raise PlanError(f"polyline: points of shape {points.shape}; expected finite numbers, (N, 2) or (N, 3) [m]")
        if not len(points) or not np.ptp(points[:, :2], axis=0).max() > 0.0:
            raise PlanError("polyline: all its points are one in plan; expected at least two")
        object.__setattr__(self, "points", points)

    def strokes(self, reach: Reach, mould: Mould, *, step: float | None, feed: float, force: float) -> list[Stroke]:
        """See :class:`Pattern`."""
        check(tip_radius=reach.tip_radius, step=step, feed=feed, force=force)
        path = dense(self.points[:, :2])
        curves = [
            np.column_stack((piece, np.full(len(piece), force))) for piece in broken(reach, path, SHORTEST_STROKE)
        ]
        return required(strokes_along(reach, curves, feed), reach, mould)


def _check_angle(angle: float) -> None:
    if not np.isfinite(angle):
        raise PlanError(f"raster: the angle is {angle} rad; expected a finite number")
