"""Surfaces with a known shape, files of them, and grids that several test files share."""

from __future__ import annotations

import struct
from functools import cache

import numpy as np
from trimesh.triangles import closest_point

from burnish.core import Array
from burnish.surface import DistanceGrid, Mould, bundled


@cache
def mould(name: str) -> Mould:
    return Mould.load(name)


@cache
def grid(name: str) -> DistanceGrid:
    return DistanceGrid.of(mould(name))


def binary_stl(corners: Array, *, count: int | None = None, header: bytes = b"") -> bytes:
    """A binary STL of triangles (F, 3, 3) whose header may lie about their number."""
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *triangle.ravel(), 0) for triangle in np.asarray(corners))
    return header.ljust(80, b"\0") + struct.pack("<I", len(corners) if count is None else count) + body


def ascii_stl(corners: Array) -> bytes:
    lines = ["solid part"]
    for triangle in np.asarray(corners):
        lines += ["facet normal 0 0 0", " outer loop"]
        lines += [f"  vertex {x:.9g} {y:.9g} {z:.9g}" for x, y, z in triangle]
        lines += [" endloop", "endfacet"]
    return "\n".join([*lines, "endsolid part", ""]).encode()


def box(x: float, y: float, z: float) -> Array:
    """Triangles of a closed box on z = 0, centred in plan [m]."""
    return bundled.block(np.array([-x / 2, x / 2]), np.array([-y / 2, y / 2]), lambda u, v: np.full_like(u, z))


def tray(x: Array, y: Array, height: Array) -> Array:
    """A closed solid with heights (nx, ny) over grid lines, its base on z = 0 [m]."""
    return bundled.block(x, y, lambda u, v: height)


def sheet(x: Array, y: Array, height: Array) -> Array:
    """The upper surface alone: it faces up and is open all round [m]."""
    solid = tray(x, y, height)
    return solid[: 2 * (len(x) - 1) * (len(y) - 1)]


def box_distance(points: Array, x: float, y: float, z: float) -> Array:
    """Signed distance to that box in closed form [m]."""
    q = np.abs(points - [0.0, 0.0, z / 2]) - np.array([x, y, z]) / 2
    return np.linalg.norm(np.maximum(q, 0.0), axis=1) + np.minimum(q.max(axis=1), 0.0)


def dome_centre() -> Array:
    """Centre of the sphere of the bundled dome, mould frame [m]."""
    return np.array([0.0, 0.0, bundled.DOME_SKIRT - np.sqrt(bundled.DOME_RADIUS**2 - bundled.DOME_SIDE**2 / 2)])


def wave_normal(x: Array) -> Array:
    """True unit normals of the bundled wave, (N, 3)."""
    k = 2 * np.pi / bundled.WAVE_LENGTH
    slope = -bundled.WAVE_AMPLITUDE * k * np.sin(k * x)
    normal = np.column_stack((-slope, np.zeros_like(x), np.ones_like(x)))
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def distance_by_brute_force(part: Mould, points: Array) -> Array:
    """Distance to the nearest of all triangles, by another library [m], (N,)."""
    # In millimetres: in metres it takes small triangles for points.
    triangles, points = 1e3 * part.vertices[part.faces], 1e3 * points
    every = np.arange(len(triangles))
    middle = triangles.mean(axis=1)
    radius = np.linalg.norm(triangles - middle[:, None], axis=2).max(axis=1)
    distance = np.empty(len(points))
    for i, point in enumerate(points):
        away = np.linalg.norm(middle - point, axis=1)
        near = every[away - radius <= (away + radius).min()]  # the others cannot be the nearest
        foot = closest_point(triangles[near], np.broadcast_to(point, (len(near), 3)))
        distance[i] = np.linalg.norm(foot - point, axis=1).min()
    return 1e-3 * distance


def angle_deg(one: Array, other: Array) -> Array:
    """Angle between vectors (N, 3) [deg], (N,)."""
    one = one / np.linalg.norm(one, axis=1, keepdims=True)
    other = other / np.linalg.norm(other, axis=1, keepdims=True)
    return np.rad2deg(np.arctan2(np.linalg.norm(np.cross(one, other), axis=1), np.einsum("ij,ij->i", one, other)))
