"""The cell: where the mould is mounted in front of the arm, and from where the arm starts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from burnish.core import Array, read_only
from burnish.model.model import Model

MOUNT = np.array([0.0, -0.34, 0.22])
"""The centre of the work's upper side stands here in the base frame [m]: of the places in front of the arm, the one
where joint speed for a given feed is lowest over a dome of radius 150 mm (36 % of the limit at 20 mm/s)."""
TURN = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""Rotation, base ← mould: strokes run along the mould's x, which points away from the arm; there the wrist, weak
sideways, has least to do."""
HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
"""The vendor's home pose [rad] (thesis B, eq. 5.1)."""
READY = np.array([4.532, 3.254, 1.369, 5.85, 1.492, 1.3233])
"""Joint positions from which the working poses are found [rad]: elbow up, tool down; joint 6 as at home, because
the tool looks the same from every side."""


@dataclass(frozen=True, kw_only=True)
class Placement:
    """Where a mould stands, as far as anyone knows."""

    p: Array
    """Origin of the mould's frame in the base frame [m], (3,)."""
    R: Array
    """Rotation, base ← mould, (3, 3)."""

    def points(self, points: Array) -> Array:
        """Points of the mould in the base frame [m], (N, 3)."""
        return np.asarray(points @ self.R.T + self.p)

    def directions(self, directions: Array) -> Array:
        """Directions of the mould in the base frame, (N, 3)."""
        return np.asarray(directions @ self.R.T)


def nominal_placement(top: float) -> Placement:
    """Where a mould is meant to stand, ``top`` [m] being the height of its highest point in its own frame."""
    return Placement(p=read_only(MOUNT - np.array([0.0, 0.0, top])), R=read_only(TURN))


def tool_down(model: Model) -> Array:
    """The tool rotation that the ready pose has, set exactly upright, base ← tool, (3, 3)."""
    _, R, _ = model.kinematics(READY)
    x = R[:, 0] - np.array([0.0, 0.0, R[2, 0]])
    x /= np.linalg.norm(x)
    z = np.array([0.0, 0.0, -1.0])
    return np.column_stack([x, np.cross(z, x), z])
