"""A mould cut into patches that a polisher would name: the top, a flank, a fillet, the floor of a pocket.

Faces grow together across edges that are not sharp, as long as their normals are nearest to the same axis of the
mould. So a patch ends at edges, and where a rounded part has turned away from the direction it began with.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from burnish.core import Array, read_only
from burnish.errors import InputError
from burnish.surface.border import SHARP
from burnish.surface.mould import Mould
from burnish.surface.segments import Segments
from burnish.surface.touch import unit
from burnish.surface.winding import Edges, Faces, face_vectors

SMALLEST = 25e-6
"""Patches below this area go to the neighbour with which they share most of their border [m²]: 5 × 5 mm, a third of
the footprint of a 15 mm tip."""

_ON_BORDER = 1e-6
"""Distance to the border up to which a vertex is on it [m]."""

_ROUNDS = 8
"""Times that small patches are given away; each round at least halves the number of a chain of them."""


@dataclass(frozen=True, kw_only=True)
class Region:
    """A patch of a mould."""

    faces: NDArray[np.int64]
    """Numbers of its faces in the mould, rising, (F,)."""
    area: float
    """[m²]."""
    normal: Array
    """Mean outward unit normal by area, (3,); zero for a closed patch, which has none."""
    spread: float
    """Greatest angle of a face of it to the mean normal [rad]."""
    border: Array
    """Ends of the edges at which it ends, mould frame [m], (E, 2, 3)."""


def regions(mould: Mould, *, crease: float = SHARP, smallest: float = SMALLEST) -> list[Region]:
    """The patches of a mould, the largest first; every face belongs to exactly one.

    Args:
        mould: what to cut.
        crease: angle between neighbouring faces from which their edge is sharp [rad].
        smallest: area below which a patch joins a neighbour across an edge that is not sharp [m²].

    Raises:
        InputError: the crease is no angle between 0 and π, or the area is negative.
    """
    if not (0.0 < crease < np.pi and 0.0 <= smallest < np.inf):
        raise InputError(f"regions: {crease=} rad, {smallest=} m²; expected an angle below π and an area")
    vectors = face_vectors(mould.vertices, mould.faces)
    normals, areas = unit(vectors), np.linalg.norm(vectors, axis=1) / 2.0
    edges = Edges(mould.faces)
    f, g = edges.pairs.T
    smooth = np.einsum("ij,ij->i", normals[f], normals[g]) > np.cos(crease)
    axis = _axis(normals)
    label = _components(edges.pairs[smooth & (axis[f] == axis[g])], len(mould.faces))
    length = np.linalg.norm(mould.vertices[edges.inner[:, 1]] - mould.vertices[edges.inner[:, 0]], axis=1)
    label = _absorbed(label, areas, edges.pairs[smooth], length[smooth], smallest)
    return _described(mould, label, vectors, areas, edges)


def _axis(normals: Array) -> NDArray[np.int64]:
    """Which of ±x ±y ±z each normal (F, 3) is nearest to, (F,). A tie, as of a chamfer of 45°, goes to z, then y."""
    size = np.abs(normals) * [1.0, 1.0 + 1e-6, 1.0 + 2e-6]
    axis = np.argmax(size, axis=1)
    return np.asarray(2 * axis + (np.take_along_axis(normals, axis[:, None], axis=1)[:, 0] < 0.0))


def _components(pairs: Faces, count: int) -> NDArray[np.int64]:
    """Number of the component of each of so many faces, (F,)."""
    graph = coo_array((np.ones(len(pairs), dtype=np.int8), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def _absorbed(
    label: NDArray[np.int64], areas: Array, pairs: Faces, length: Array, smallest: float
) -> NDArray[np.int64]:
    """Labels of which small ones have become that of the larger neighbour with the longest common border."""
    for _ in range(_ROUNDS):
        count = int(label.max()) + 1
        area = np.bincount(label, areas, count)
        one, other = label[pairs].T
        between = np.r_[np.column_stack((one, other)), np.column_stack((other, one))]
        shared = np.r_[length, length]
        gives = (between[:, 0] != between[:, 1]) & (area[between[:, 0]] < smallest)
        gives &= area[between[:, 1]] > area[between[:, 0]]
        if not gives.any():
            break
        edges, number = np.unique(between[gives], axis=0, return_inverse=True)
        total = np.bincount(number.ravel(), shared[gives])
        order = np.lexsort((total, edges[:, 0]))
        best = np.r_[edges[order][1:, 0] != edges[order][:-1, 0], True]
        target = np.arange(count)
        target[edges[order][best, 0]] = edges[order][best, 1]
        for _ in range(_ROUNDS):
            target = target[target]  # along chains; they end, because each goes to a larger one
        label = np.unique(target[label], return_inverse=True)[1]
    return label


def _described(mould: Mould, label: NDArray[np.int64], vectors: Array, areas: Array, edges: Edges) -> list[Region]:
    """The patches with these labels, the largest first."""
    order = np.argsort(label, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(label[order])) + 1)
    one, other = label[edges.pairs].T
    apart = one != other
    ends = np.concatenate((edges.inner[apart], edges.inner[apart], edges.border))
    owner = np.r_[one[apart], other[apart], label[edges.border_face]]
    sequence = np.argsort(owner, kind="stable")
    starts = np.searchsorted(owner[sequence], np.arange(len(groups) + 1))
    found = []
    for number, faces in enumerate(groups):
        mean = unit(vectors[faces].sum(axis=0)[None])[0]
        real = faces[areas[faces] > 0.0]
        cosine = np.einsum("ij,j->i", unit(vectors[real]), mean)
        part = sequence[starts[number] : starts[number + 1]]
        faces.flags.writeable = False
        found.append(
            Region(
                faces=faces,
                area=float(areas[faces].sum()),
                normal=read_only(mean),
                spread=float(np.arccos(np.clip(cosine.min(initial=1.0), -1.0, 1.0))),
                border=read_only(mould.vertices[ends[part]]),
            )
        )
    return sorted(found, key=lambda region: -region.area)


def edge_band(vertices: Array, faces: Faces, border: Array, width: float) -> NDArray[np.bool_]:
    """Which vertices of a surface lie within a band along its border, measured in the surface, (V,).

    A vertex is in the band when its distance to the border is at most ``width`` and it can be reached from there along
    edges of the surface without leaving the band: a thin wall does not put its other side into the band. Within the
    band the straight distance is taken for the distance in the surface; on a radius R it is too short by width²/24R²,
    0.7 % for 6 mm on 15 mm.

    The border runs along edges of the surface, as that of a :class:`Region` does, also after a refinement.

    Args:
        vertices: of the surface, mould frame [m], (V, 3).
        faces: its triangles, (F, 3); those of a patch alone.
        border: ends of the edges at which it ends [m], (E, 2, 3).
        width: of the band [m].

    Raises:
        InputError: the width is no length.
    """
    if not 0.0 <= width < np.inf:
        raise InputError(f"edge_band: the width is {width} m; expected a length of 0 or more")
    marked = np.zeros(len(vertices), dtype=bool)
    if not len(border):
        return marked
    used = np.unique(faces)
    distance = np.full(len(vertices), np.inf)
    distance[used] = Segments(border).distance(vertices[used])
    near = distance <= width
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    inside = near[start] & near[end]
    graph = coo_array(
        (np.ones(int(inside.sum()), dtype=np.int8), (start[inside], end[inside])), shape=(len(vertices),) * 2
    )
    group = connected_components(graph, directed=False)[1]
    at_border = distance <= _ON_BORDER
    reached = np.zeros(int(group.max()) + 1, dtype=bool)
    reached[group[at_border]] = True
    return np.asarray(near & reached[group])
