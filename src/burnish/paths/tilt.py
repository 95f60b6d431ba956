"""A tool that leans on purpose, and where its frame then stands so that the tip still touches the same point.

The tip is a sphere of radius r, its centre r behind the apex along the tool's axis z, which points into the work.
Leaning rolls the contact over the tip and leaves its centre over the contact c with the normal n. The apex p is

    z = −cos α n + sin α d,   p = c + r n + r z

with d the direction in the surface to which the apex swings: the body of the tool leans to −d. A disc or a tip that
spins about z would rub with its centre, which stands still, if it did not lean; then the contact runs at ω r sin α.

Source of the range: compliant discs are held at 5–25°, Int. J. Adv. Manuf. Technol., 10.1007/s00170-022-09407-6.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from burnish.core import Array
from burnish.errors import PlanError
from burnish.surface.touch import unit
from burnish.trajectory.path import tool_rotations

FLATTEST, STEEPEST_LEAN = float(np.deg2rad(5.0)), float(np.deg2rad(25.0))
"""Range of an angle that is not 0 [rad]: below it the middle of the contact hardly rubs, above it the rim digs in."""


@dataclass(frozen=True, kw_only=True)
class Tilt:
    """How the tool leans against the way it goes."""

    angle: float = 0.0
    """Between the tool's axis and the inward normal [rad]: 0, or 5° to 25°."""
    heading: float = 0.0
    """To which side the body leans, from the direction of travel about the outward normal [rad]: 0 leans it forwards,
    so that the tip is dragged; π leans it back; ±π/2 to the left or right. On a path back and forth the tool swings
    over at each end; with ±π/2 always to one side of the path, and so to either side of the part in turn."""

    def __post_init__(self) -> None:
        """Refuse angles that no tool works at."""
        if not (self.angle == 0.0 or FLATTEST - 1e-9 <= self.angle <= STEEPEST_LEAN + 1e-9):
            raise PlanError(f"tilt: the angle is {np.rad2deg(self.angle):.3g}°; expected 0, or 5° to 25°")
        if not abs(self.heading) <= np.pi + 1e-9:
            raise PlanError(f"tilt: the heading is {np.rad2deg(self.heading):.3g}°; expected -180° to 180°")


def tool_axes(normals: Array, travel: Array, tilt: Tilt) -> Array:
    """The tool's axis at each point of a path, a unit vector into the work, (N, 3).

    Args:
        normals: outward unit normals, (N, 3).
        travel: direction of travel, any length, (N, 3); its part along the normal does not count.
        tilt: how the tool leans.

    Raises:
        PlanError: it leans, and a direction of travel is zero or along the normal.
    """
    if tilt.angle == 0.0:
        return -normals
    along = travel - np.einsum("ij,ij->i", travel, normals)[:, None] * normals
    if np.any(np.linalg.norm(along, axis=1) <= 1e-6 * np.linalg.norm(travel, axis=1)):
        raise PlanError("tilt: the path stands still, or goes along the normal; expected a direction over the surface")
    forward = unit(along)
    left = np.cross(normals, forward)
    body = np.cos(tilt.heading) * forward + np.sin(tilt.heading) * left
    return np.asarray(-np.cos(tilt.angle) * normals - np.sin(tilt.angle) * body)


def tool_poses(
    points: Array, normals: Array, travel: Array, tip_radius: float, tilt: Tilt, R0: Array
) -> tuple[Array, Array]:
    """Where the tool frame, at the apex of the tip, stands so that the tip touches these points.

    Args:
        points: points of contact [m], (N, 3).
        normals: outward unit normals there, (N, 3).
        travel: direction of travel, any length, (N, 3).
        tip_radius: radius of the tip [m].
        tilt: how the tool leans.
        R0: tool rotation from which the tool turns least, (3, 3).

    Returns:
        p, (N, 3) [m], and R, (N, 3, 3), in the axes of the points; without tilt p is the point of contact.

    Raises:
        PlanError: see :func:`tool_axes`.
        InputError: an axis points away from that of R0 by more than 170°.
    """
    axis = tool_axes(normals, travel, tilt)
    return points + tip_radius * (normals + axis), tool_rotations(-axis, R0)


def travel_of(points: Array) -> Array:
    """Direction of travel along a path (N, 3), unit vectors, (N, 3)."""
    return unit(np.gradient(points, axis=0))
