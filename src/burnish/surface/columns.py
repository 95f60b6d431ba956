"""Which points of a grid lie inside the solid, by counting the surfaces above each of them.

A ray straight up leaves the solid through every triangle that faces up and enters it through every one
that faces down. The count needs no closed surface: under an open one that faces up it is positive, as if
its border were dropped straight down, which is what a part to be worked from above stands for.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from burnish.core import Array
from burnish.errors import MouldError
from burnish.surface.nearest import ragged
from burnish.surface.winding import Faces

_ASIDE = np.array([0.737, 0.419]) * 1e-3
"""Offset of the rays from the columns, in spacings: the corners of made-up surfaces like to lie exactly on
the columns, where a ray could miss both neighbours or hit both. It costs a thousandth of a spacing."""

MOST_PAIRS = 20_000_000
"""Pairs of a triangle and a column under its bounding box that are tried at all: some seconds. A part of half a
million small triangles has a few million of them; a heap of triangles from end to end has no end."""

_PAIRS = 1 << 20
"""Pairs of a triangle and a column that are tried at a time; bounds the memory."""


def inside(vertices: Array, faces: Faces, origin: Array, spacing: float, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Whether each node origin + spacing · (ix, iy, iz) lies in the solid, (nx, ny, nz).

    Args:
        vertices: corners [m], (V, 3).
        faces: triangles, counter-clockwise seen from outside, (F, 3).
        origin: first node [m], (3,).
        spacing: distance of the nodes [m].
        shape: number of nodes along x, y and z.

    Raises:
        MouldError: the triangles lie over each other by the thousand.
    """
    exits = np.zeros(shape, dtype=np.int16)
    for _, column, height, sign in crossings(vertices, faces, origin, spacing, (shape[0], shape[1])):
        level = np.clip(np.ceil(height), 0, shape[2]).astype(np.int64)  # nodes below the crossing
        hit = level > 0
        np.add.at(exits, (column[hit, 0], column[hit, 1], level[hit] - 1), sign[hit])
    return np.asarray(np.cumsum(exits[:, :, ::-1], axis=2)[:, :, ::-1] > 0)


def crossings(
    vertices: Array, faces: Faces, origin: Array, spacing: float, shape: tuple[int, int]
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], Array, NDArray[np.int16]]]:
    """Where the columns over origin + spacing · (ix, iy) cross the triangles, some at a time.

    Args:
        vertices: corners [m], (V, 3).
        faces: triangles, counter-clockwise seen from outside, (F, 3).
        origin: first node [m], (3,).
        spacing: distance of the columns [m].
        shape: number of columns along x and y.

    Yields:
        Numbers of the triangles, (N,), and of the columns, (N, 2); height above the origin in spacings, (N,); and
        +1 where the triangle faces up, −1 where it faces down, (N,).

    Raises:
        MouldError: the triangles lie over each other by the thousand.
    """
    corners = (vertices[faces] - origin) / spacing
    corners[:, :, :2] -= _ASIDE
    low = np.clip(np.ceil(corners[:, :, :2].min(axis=1)), 0, None).astype(np.int64)
    high = np.minimum(np.floor(corners[:, :, :2].max(axis=1)), np.array(shape) - 1).astype(np.int64)
    size = np.maximum(high - low + 1, 0)
    count = size[:, 0] * size[:, 1]
    if count.sum() > MOST_PAIRS:
        raise MouldError(
            f"the {len(faces)} triangles lie over each other {count.sum() / (shape[0] * shape[1]):.0f} deep seen from "
            "above; expected the surface of a part: remove what is inside it"
        )
    for part in _batches(count):
        triangle, number = ragged(count[part])
        triangle = part[triangle]
        column = low[triangle] + np.stack(np.divmod(number, size[triangle, 1]), axis=1)
        height, sign = _crossing(corners[triangle], column)
        hit = sign != 0
        yield triangle[hit], column[hit], height[hit], sign[hit]


def _crossing(corners: Array, column: NDArray[np.int64]) -> tuple[Array, NDArray[np.int16]]:
    """Height at which each column crosses its triangle (N, 3, 3), and +1 up, −1 down, 0 where it misses."""
    to = corners[:, :, :2] - column[:, None, :]
    following = np.roll(to, -1, axis=1)
    area = to[:, :, 0] * following[:, :, 1] - to[:, :, 1] * following[:, :, 0]  # opposite the third corner
    total = area.sum(axis=1)
    hit = (np.all(area > 0.0, axis=1) & (total > 0.0)) | (np.all(area < 0.0, axis=1) & (total < 0.0))
    sign = np.where(hit, np.sign(total), 0.0).astype(np.int16)
    weight = area / np.where(hit, total, 1.0)[:, None]
    height = np.einsum("ij,ij->i", weight, np.roll(corners[:, :, 2], 1, axis=1))
    return height, sign


def _batches(count: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Numbers of the triangles that touch any column, in groups of about _PAIRS pairs."""
    some = np.flatnonzero(count)
    if not len(some):
        return []
    group = np.cumsum(count[some]) // _PAIRS
    return np.split(some, np.flatnonzero(np.diff(group)) + 1)
