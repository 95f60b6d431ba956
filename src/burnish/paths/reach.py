"""Which places of a mould a spherical tip can work."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from typing_extensions import Self

from burnish.core import Array
from burnish.errors import PlanError
from burnish.paths.hertz import FELT
from burnish.surface import Border, DistanceGrid, Mould, laid, unobstructed

STEEPEST = float(np.deg2rad(40.0))
"""Slope up to which a surface is worked unless told otherwise [rad]. A choice: the arm must tilt the tool as far."""

CLEARANCE = 2.5e-3
"""Distance that is kept from what the tip cannot reach [m]: nearer to a corner the tip feels both sides of it at
once, through the spacing of the distance grid."""

EDGE = 2.0
"""Spacings of the distance grid around a border within which its normals are none."""

ROUNDING = 1e-7
"""What the inset may fall short by, so that a place at the inset counts as inside [m]."""


@dataclass(frozen=True, kw_only=True)
class Reach:
    """A tip, a mould, and what is asked of a place before it is worked."""

    grid: DistanceGrid
    """Distance to the mould."""
    border: Border
    """Border of what is flat enough."""
    tip_radius: float
    """Radius of the tip [m]."""
    margin: float
    """Inset of the point of contact from the border, in plan [m]."""
    max_slope: float
    """Steepest surface that is worked, from facing up [rad]."""
    modulus: float = FELT
    """Contact modulus E* of tip and surface [Pa]."""

    @classmethod
    def of(
        cls,
        mould: Mould,
        grid: DistanceGrid,
        *,
        tip_radius: float,
        margin: float,
        max_slope: float = STEEPEST,
        modulus: float = FELT,
    ) -> Self:
        """The reach of a tip on a mould.

        Raises:
            PlanError: the margin is no distance.
            InputError: the slope is not between 0 and 90°.
        """
        if not 0.0 <= margin < np.inf:
            raise PlanError(f"the margin is {margin} m; expected a distance of 0 or more")
        border = Border.of(mould, max_slope)
        return cls(grid=grid, border=border, tip_radius=tip_radius, margin=margin, max_slope=max_slope, modulus=modulus)

    def free(self, xy: Array, slack: float = ROUNDING) -> NDArray[np.bool_]:
        """Whether the tip can work these places: flat enough, within reach, far enough from the border.

        Args:
            xy: horizontal positions, mould frame [m], (N, 2).
            slack: what the inset may fall short by [m].

        Raises:
            InputError: the grid is too coarse or too low for this tip.
        """
        good = self.border.distance(xy) >= self.margin - slack
        touch = laid(self.grid, xy[good], self.tip_radius)
        with np.errstate(invalid="ignore"):  # NaN where there is nothing to touch
            flat = touch.normal[:, 2] >= np.cos(self.max_slope)
        good[good] = flat & unobstructed(self.grid, touch.centre, self.tip_radius)
        for aside in np.array([(1, 0), (0, 1), (-1, 0), (0, -1)]) * CLEARANCE:
            beside = xy[good] + aside
            centre = laid(self.grid, beside, self.tip_radius).centre
            edge = self.border.distance(beside) < EDGE * self.grid.spacing  # the grid rounds it off
            good[good] = np.isnan(centre[:, 2]) | edge | unobstructed(self.grid, centre, self.tip_radius)
        return np.asarray(good)
