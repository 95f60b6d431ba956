"""Exact distance from points to triangles, one triangle a point.

Each triangle is kept in its own plane frame: a corner at the origin, the first side along x, the
normal along z. There the distance is √(z² + d²) with d the plane distance to the triangle, 0 inside and
else the least distance to its three sides.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from burnish.core import Array

CHUNK = 1 << 15
"""Points worked on at a time: what they need then fits into a processor's cache."""


def parts(count: int) -> list[slice]:
    """Slices of at most CHUNK that cover ``count`` points."""
    return [slice(start, start + CHUNK) for start in range(0, count, CHUNK)]


class Triangles:
    """Triangles with an area, ready for many distances."""

    def __init__(self, corners: Array) -> None:
        """Place the frames; corners (F, 3, 3) [m] of triangles that are no lines."""
        a, b, c = np.moveaxis(corners, 1, 0)
        length = np.linalg.norm(b - a, axis=1)
        x = (b - a) / length[:, None]
        normal = np.cross(x, c - a)
        height = np.linalg.norm(normal, axis=1)
        z = normal / height[:, None]
        shift = np.einsum("ij,ij->i", x, c - a)
        self._frame: Array = np.concatenate((a, x, np.cross(z, x), z), axis=1).T.copy()
        self._shape: Array = np.stack((length, shift, height))

    def distance(self, points: Array, triangle: NDArray[np.int64]) -> Array:
        """Distance of each point (N, 3) to its triangle [m], (N,)."""
        distance = np.empty(len(points))
        for part in parts(len(points)):
            distance[part] = self._distance(points[part].T, triangle[part])
        return distance

    def _distance(self, points: Array, triangle: NDArray[np.int64]) -> Array:
        """The same for points (3, N) that fit into the cache."""
        frame = self._frame[:, triangle]
        length, shift, height = self._shape[:, triangle]
        to = points - frame[:3]
        x, y, z = (to[0] * axis[0] + to[1] * axis[1] + to[2] * axis[2] for axis in frame[3:].reshape(3, 3, -1))
        back, rest = x - length, length - shift
        within = (y >= 0.0) & (shift * y <= height * x) & (back * height + rest * y <= 0.0)
        squared = _to_side(x, y, length, 0.0 * length)
        np.minimum(squared, _to_side(x, y, shift, height), out=squared)
        np.minimum(squared, _to_side(back, y, -rest, height), out=squared)
        squared[within] = 0.0
        return np.asarray(np.sqrt(squared + z * z))


def _to_side(x: Array, y: Array, side_x: Array, side_y: Array) -> Array:
    """Squared distance from (x, y) to the segment from the origin to (side_x, side_y) [m²]."""
    share = np.clip((x * side_x + y * side_y) / (side_x * side_x + side_y * side_y), 0.0, 1.0)
    dx, dy = x - share * side_x, y - share * side_y
    return np.asarray(dx * dx + dy * dy)
