"""A tool that leans on purpose, to the same side all over the part.

The tip is a sphere of radius r, its centre r behind the apex along the tool's axis z, which points into the work.
Leaning rolls the contact over the tip and leaves its centre over the contact c with the normal n:

    z = −cos α n − sin α b,   apex p = c + r (n + z)

with b the direction in the surface to which the body of the tool leans. A disc or a tip that spins about z would rub
with its centre, which stands still, if it did not lean; then the contact runs at ω r sin α.

b is fixed in the part, not to the direction of travel: a tool that leaned along its way would have to swing over by
twice its lean at each end of a raster, where the path turns on a few millimetres and the wrist is the slowest. So the
tip is dragged on one line and pushed on the next; with the heading across the lines it does neither.

Source of the range: compliant discs are held at 5–25°, Int. J. Adv. Manuf. Technol., 10.1007/s00170-022-09407-6.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from burnish.core import Array
from burnish.errors import PlanError
from burnish.surface.touch import unit

FLATTEST, STEEPEST_LEAN = float(np.deg2rad(5.0)), float(np.deg2rad(25.0))
"""Range of an angle that is not 0 [rad]: below it the middle of the contact hardly rubs, above it the rim digs in."""


@dataclass(frozen=True, kw_only=True)
class Tilt:
    """How the tool leans over the part."""

    angle: float = 0.0
    """Between the tool's axis and the inward normal [rad]: 0, or 5° to 25°."""
    heading: float = 0.0
    """To which side the body leans, from the mould's x axis about the outward normal [rad]: 0 leans it to x, π to −x,
    ±π/2 to ±y on a level surface. It does not turn with the path."""

    def __post_init__(self) -> None:
        """Refuse angles that no tool works at."""
        if not (self.angle == 0.0 or FLATTEST - 1e-9 <= self.angle <= STEEPEST_LEAN + 1e-9):
            raise PlanError(f"tilt: the angle is {np.rad2deg(self.angle):.3g}°; expected 0, or 5° to 25°")
        if not abs(self.heading) <= np.pi + 1e-9:
            raise PlanError(f"tilt: the heading is {np.rad2deg(self.heading):.3g}°; expected -180° to 180°")


def tool_axes(normals: Array, tilt: Tilt) -> Array:
    """The tool's axis at each point, a unit vector into the work, mould frame, (N, 3).

    Args:
        normals: outward unit normals, mould frame, (N, 3).
        tilt: how the tool leans.

    Raises:
        PlanError: it leans, and a normal is along the mould's x axis, from which the heading counts.
    """
    if tilt.angle == 0.0:
        return -normals
    x = np.array([1.0, 0.0, 0.0]) - normals[:, :1] * normals
    if np.any(np.linalg.norm(x, axis=1) <= 1e-3):
        raise PlanError("tilt: the surface faces along the mould's x axis; expected a heading over it: turn the mould")
    x = unit(x)
    body = np.cos(tilt.heading) * x + np.sin(tilt.heading) * np.cross(normals, x)
    return np.asarray(-np.cos(tilt.angle) * normals - np.sin(tilt.angle) * body)
