"""Polygons of a file cut into triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from burnish.core import Array
from burnish.errors import MouldError
from burnish.surface.nearest import ragged
from burnish.surface.winding import Faces, face_vectors

MAX_FACES = 1_200_000
"""Most triangles that are accepted: finer than any surface that a 15 mm tip could tell apart."""


def check_count(source: str, faces: int) -> None:
    """A number of triangles that is worth parsing.

    Raises:
        MouldError: there are none, or too many.
    """
    if faces == 0:
        raise MouldError(f"{source} has no triangles; expected a surface: export it again")
    if faces > MAX_FACES:
        raise MouldError(
            f"{source} has {faces} triangles; at most {MAX_FACES} are read: export it with a coarser tolerance"
        )


def triangulated(source: str, vertices: Array, index: NDArray[np.int64], count: NDArray[np.int64]) -> Array:
    """Corners of triangles, (F, 3, 3), in fans from the first corner of each polygon.

    Args:
        source: what a message calls the file.
        vertices: places, (V, 3).
        index: vertex numbers of all polygons, one polygon after the other.
        count: corners of each polygon, (P,).

    Raises:
        MouldError: a number names no vertex, a place is not finite, or a polygon is no fan: then its triangles
            would lie over each other.
    """
    if np.any(count < 3):
        raise MouldError(f"{source} has a polygon with {count.min()} corners; expected 3 or more: export it again")
    check_count(source, int(np.sum(count - 2)))
    if index.min() < 0 or index.max() >= len(vertices):
        raise MouldError(
            f"{source} is damaged: a triangle names a corner beyond its {len(vertices)} vertices; export it again"
        )
    check_finite(source, vertices[index])
    polygon, number = ragged(count - 2)
    first = (np.cumsum(count) - count)[polygon]
    faces: Faces = np.column_stack((index[first], index[first + number + 1], index[first + number + 2]))
    if np.any(count > 3):
        vectors = face_vectors(vertices, faces)
        whole = np.column_stack([np.bincount(polygon, vectors[:, i], len(count)) for i in range(3)])
        back = np.einsum("ij,ij->i", vectors, whole[polygon]) < 0.0
        if back.any():
            raise MouldError(
                f"{source} has {len(np.unique(polygon[back]))} polygons that are not convex; expected triangles: "
                "let the program that wrote it triangulate them"
            )
    return vertices[faces]


def check_finite(source: str, corners: Array) -> None:
    """Refuse places (…, 3) that are no numbers, or beyond all lengths.

    Raises:
        MouldError: says how many.
    """
    bad = int(np.count_nonzero(~(np.abs(corners) < 1e30).all(axis=-1)))
    if bad:
        raise MouldError(f"{source}: {bad} corners have a coordinate that is not a finite number; export it again")
