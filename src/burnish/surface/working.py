"""The surface to be worked, in triangles fine enough to carry what the tool did at every place."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from typing_extensions import Self

from burnish.core import Array, read_only
from burnish.errors import MouldError
from burnish.surface.mould import Mould
from burnish.surface.winding import Faces, face_vectors

STEEPEST = np.deg2rad(80.0)
"""Slope from which a face is a wall and no surface to be worked from above [rad]."""

MOST_FACES = 2_000_000
"""Triangles of the finest working surface; more take longer than the job."""


@dataclass(frozen=True, kw_only=True)
class WorkingSurface:
    """The faces of a mould that face up, subdivided."""

    vertices: Array
    """Mould frame [m], (V, 3)."""
    faces: Faces
    """Vertex numbers, counter-clockwise seen from outside, (F, 3)."""

    @classmethod
    def of(cls, mould: Mould, edge: float) -> Self:
        """The working surface of a mould with sides of at most ``edge`` [m].

        Raises:
            MouldError: there is nothing to work, or the sides are too short for so large a mould.
        """
        vertices, faces = refine(mould, edge)
        return cls(vertices=read_only(vertices), faces=faces)

    @cached_property
    def areas(self) -> Array:
        """Area that each vertex stands for, a third of its triangles [m²], (V,)."""
        return vertex_areas(self.vertices, self.faces)

    @cached_property
    def normals(self) -> Array:
        """Outward unit normals, the mean over the triangles of a vertex by area, (V, 3)."""
        vectors = face_vectors(self.vertices, self.faces)
        total = np.stack([_gathered(self.faces, vectors[:, i], len(self.vertices)) for i in range(3)], axis=1)
        length = np.linalg.norm(total, axis=1, keepdims=True)
        return read_only(total / np.maximum(length, np.finfo(float).tiny))


def refine(mould: Mould, edge: float) -> tuple[Array, Faces]:
    """The upward faces of a mould, subdivided until no side is longer than ``edge`` [m].

    New vertices lie in the middle of a side, for both of its triangles, so the shape and its area stay and
    no gaps open.

    Returns:
        Vertices [m], (V, 3), and faces, (F, 3).

    Raises:
        MouldError: there is nothing to work, or the sides are too short for so large a mould.
    """
    vectors = face_vectors(mould.vertices, mould.faces)
    size = np.linalg.norm(vectors, axis=1)
    up = vectors[:, 2] > np.cos(STEEPEST) * size
    if not up.any():
        raise MouldError(f"{mould.name}: nothing of it is flatter than {np.rad2deg(STEEPEST):.0f}°; turn the part over")
    if not edge > 0.0 or size[up].sum() > MOST_FACES * edge**2:
        raise MouldError(
            f"{mould.name}: {1e4 * size[up].sum() / 2.0:.0f} cm² in triangles of {1e3 * edge:.3g} mm are more than "
            f"{MOST_FACES} of them; use longer sides"
        )
    used, faces = np.unique(mould.faces[up], return_inverse=True)
    vertices, faces = mould.vertices[used], faces.reshape(-1, 3)
    while True:
        sides = np.linalg.norm(vertices[faces] - vertices[np.roll(faces, -1, axis=1)], axis=2)
        if not (sides > edge).any() or len(faces) > MOST_FACES:
            return vertices, faces
        vertices, faces = _split(vertices, faces, sides > edge)


def vertex_areas(vertices: Array, faces: Faces) -> Array:
    """Area that each vertex stands for, a third of its triangles [m²], (V,)."""
    return _gathered(faces, np.linalg.norm(face_vectors(vertices, faces), axis=1) / 6.0, len(vertices))


def _gathered(faces: Faces, values: Array, count: int) -> Array:
    """Sum over the triangles of each vertex, (count,)."""
    return np.asarray(np.bincount(faces.ravel(), np.repeat(values, 3), count), dtype=np.float64)


def _split(vertices: Array, faces: Faces, long: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> tuple[Array, Faces]:
    """Cut the marked sides (F, 3) in the middle; side i runs from corner i to the next."""
    ends = np.stack((faces, np.roll(faces, -1, axis=1)), axis=2)
    key = ends.min(axis=2) * len(vertices) + ends.max(axis=2)
    keys, number = np.unique(key[long], return_inverse=True)
    low, high = np.divmod(keys, len(vertices))
    middle = np.full(faces.shape, -1, dtype=np.int64)
    middle[long] = len(vertices) + number
    vertices = np.concatenate((vertices, (vertices[low] + vertices[high]) / 2.0))
    count = long.sum(axis=1)
    pieces = [faces[count == 0]]
    for marked, first in ((1, long), (2, np.roll(~long, 1, axis=1)), (3, long)):
        rows = np.flatnonzero(count == marked)
        turn = (np.argmax(first[rows], axis=1)[:, None] + np.arange(3)) % 3
        a, b, c = np.take_along_axis(faces[rows], turn, axis=1).T
        ab, bc, ca = np.take_along_axis(middle[rows], turn, axis=1).T
        triangles = {
            1: [(a, ab, c), (ab, b, c)],
            2: [(ab, b, bc), (a, ab, bc), (a, bc, c)],
            3: [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)],
        }[marked]
        pieces += [np.column_stack(triangle) for triangle in triangles]
    return vertices, np.concatenate(pieces)
