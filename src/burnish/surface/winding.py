"""Triangles that agree about which side is outside.

Two neighbours agree when they run along their common edge in opposite directions. The sign of the
distance to the surface rests on this, and files do not always respect it.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from burnish.core import Array
from burnish.errors import MouldError

Faces: TypeAlias = NDArray[np.int64]


def face_vectors(vertices: Array, faces: Faces) -> Array:
    """Twice the area of each triangle times its outward unit normal [m²], (F, 3)."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return np.asarray(np.cross(b - a, c - a))


def merged(corners: Array) -> tuple[Array, Faces]:
    """Loose triangles (F, 3, 3) joined at equal corners: vertices (V, 3) and faces (F, 3).

    Corners are equal when their coordinates are; triangles that collapse to a line are left out.
    """
    points = corners.reshape(-1, 3) + 0.0  # turns −0 into +0
    order = np.lexsort(points.T)
    new = np.ones(len(points), dtype=bool)
    new[1:] = np.any(points[order[1:]] != points[order[:-1]], axis=1)
    index = np.empty(len(points), dtype=np.int64)
    index[order] = np.cumsum(new) - 1
    faces = index.reshape(-1, 3)
    distinct = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return points[order[new]], faces[distinct]


class Edges:
    """The edges of a triangle mesh, and who shares them."""

    def __init__(self, faces: Faces) -> None:
        """Sort the 3 F directed edges so that the copies of one edge lie next to each other."""
        start, end = faces.T.ravel(), np.roll(faces, -1, axis=1).T.ravel()
        owner = np.tile(np.arange(len(faces)), 3)
        many = int(faces.max(initial=0)) + 1
        order = np.argsort(np.minimum(start, end) * many + np.maximum(start, end), kind="stable")
        start, end, owner = start[order], end[order], owner[order]
        low, high = np.minimum(start, end), np.maximum(start, end)
        first = np.flatnonzero(np.r_[True, (low[1:] != low[:-1]) | (high[1:] != high[:-1])])
        count = np.diff(np.r_[first, len(low)])
        single, pair = first[count == 1], first[count == 2]
        self.border: Faces = np.column_stack((start[single], end[single]))
        """Edges of a single triangle, in its direction, (B, 2) vertex numbers."""
        self.border_face: NDArray[np.int64] = owner[single]
        """The triangle of each border edge, (B,)."""
        self.inner: Faces = np.column_stack((start[pair], end[pair]))
        """Edges of exactly two triangles, (E, 2) vertex numbers."""
        self.pairs: NDArray[np.int64] = np.column_stack((owner[pair], owner[pair + 1]))
        """The two triangles of each inner edge, (E, 2)."""
        self.agree: NDArray[np.bool_] = start[pair] == end[pair + 1]
        """Whether the two run along the edge in opposite directions, as they should, (E,)."""
        self.closed: bool = bool(np.all(count % 2 == 0))
        """Whether the surface has no border: an even number of triangles at every edge."""


def oriented(name: str, vertices: Array, faces: Faces) -> tuple[Faces, tuple[str, ...]]:
    """The faces, turned round where needed so that neighbours agree and a closed surface faces outward.

    A surface that agrees with itself and is open is left as it is: only its author knows which side is
    meant.

    Returns:
        The faces, and a sentence if any were turned.

    Raises:
        MouldError: the surface has only one side, like a Möbius strip.
    """
    edges = Edges(faces)
    if not edges.agree.all():
        turned = _turned(name, vertices, faces, edges)
        count = int(np.any(turned != faces, axis=1).sum())
        return turned, (f"neighbouring triangles disagreed about which side is outside: {count} were turned round",)
    if edges.closed and _worth(vertices, faces).sum() < 0.0:
        return faces[:, ::-1].copy(), ("all triangles faced inward and were turned round",)
    return faces, ()


def _turned(name: str, vertices: Array, faces: Faces, edges: Edges) -> Faces:
    """Faces of which each connected part agrees with itself and faces outward, or up where it is open.

    A triangle and its reverse are the two nodes 2 × F of a graph whose links join what fits together.
    """
    count = len(faces)
    f, g = edges.pairs.T
    other = np.where(edges.agree, 0, count)
    rows, columns = np.r_[f, f + count], np.r_[g + other, g + count - other]
    graph = coo_array((np.ones(len(rows), dtype=np.int8), (rows, columns)), shape=(2 * count, 2 * count))
    label = connected_components(graph, directed=False)[1]
    if np.any(label[:count] == label[count:]):
        raise MouldError(f"{name} has a surface with only one side; expected one with an outside: repair it in CAD")
    reverse = label[:count] > label[count:]
    turned = np.where(reverse[:, None], faces[:, ::-1], faces)
    part = np.minimum(label[:count], label[count:])
    worth = np.bincount(part, weights=_worth(vertices, turned))
    return np.where((worth[part] < 0.0)[:, None], turned[:, ::-1], turned)


def _worth(vertices: Array, faces: Faces) -> Array:
    """Share of each triangle in ∫ (z − z₀) n_z dA [m³], (F,): the volume of a closed surface.

    With z₀ well below the surface it is also positive for an open one that faces up.
    """
    height = vertices[:, 2] - vertices[:, 2].min() + np.ptp(vertices, axis=0).max()
    return np.asarray(height[faces].mean(axis=1) * face_vectors(vertices, faces)[:, 2] / 2.0)
