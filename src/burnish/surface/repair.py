"""Small faults of a mesh mended: what no tool could feel, and what only the program that wrote the file did.

Nothing here moves the surface by more than 3 µm, except that openings of up to 2 mm are closed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from burnish.core import Array
from burnish.errors import MouldError
from burnish.surface.nearest import ragged
from burnish.surface.winding import Edges, Faces, face_vectors

WELD = 3e-6
"""Corners on a border that are nearer than this are one [m]: what rounding to micrometres tears apart, and a third of
the thinnest sliver that is a shape."""

THIN = 1e-6
"""Height below which a triangle is a line [m]: its normal is made of rounding."""

HOLE = 2e-3
"""Width up to which an opening is closed [m]: a tip of 15 mm sinks 0.03 mm into it, closed or not."""

_LOOSE = 0.2
"""Share of the triangles that may hang on nothing."""

_CROWD = 64
"""Corners that lie on each corner of a border, on average, from which it is a tangle."""

_MOST_NEAR = 20_000_000
"""Pairs of an open edge and a corner near it that are tried: a million loose triangles have fewer."""

_ROUNDS = 12
"""Times that edges are cut at the corners that lie on them; each face is cut once a time."""


def welded(source: str, vertices: Array, faces: Faces) -> tuple[Faces, tuple[str, ...]]:
    """Faces in which corners of borders that lie next to each other are one; the first of them is kept.

    Raises:
        MouldError: thousands of corners lie on each other.
    """
    rim = np.unique(Edges(faces).border)
    if not len(rim):
        return faces, ()
    tree = cKDTree(vertices[rim])
    if tree.count_neighbors(tree, WELD) > _CROWD * len(rim):
        raise MouldError(f"{source}: its corners crowd within {1e6 * WELD:.0f} µm; expected a part: check its unit")
    pairs = rim[tree.query_pairs(WELD, output_type="ndarray")]
    if not len(pairs):
        return faces, ()
    first = np.arange(len(vertices))
    np.minimum.at(first, pairs.max(axis=1), pairs.min(axis=1))
    keeps = first == np.arange(len(vertices))
    first = np.where(keeps[first], first, np.arange(len(vertices)))  # to one that stays, so nothing moves farther
    faces = first[faces]
    return _solid(faces), (
        f"{int((first != np.arange(len(vertices))).sum())} corners within 3 µm of another were joined",
    )


def check_joined(source: str, faces: Faces) -> None:
    """Refuse a heap of triangles most of which share no edge: nobody knows where its surface goes on.

    Raises:
        MouldError: says how many are loose.
    """
    edges = Edges(faces)
    loose = int(np.count_nonzero(np.bincount(edges.border_face, minlength=len(faces)) == 3))
    if loose > max(_LOOSE * len(faces), 100):
        raise MouldError(
            f"{source}: {loose} of {len(faces)} triangles hang on nothing: their corners lie more than "
            f"{1e6 * WELD:.0f} µm from any other; expected a surface: join its corners, or export it with more digits"
        )


def without_thin(vertices: Array, faces: Faces) -> tuple[Faces, tuple[str, ...]]:
    """Faces without those that are lines."""
    sides = vertices[np.roll(faces, -1, axis=1)] - vertices[faces]
    longest = np.sqrt(np.einsum("fij,fij->fi", sides, sides).max(axis=1))
    thin = np.linalg.norm(face_vectors(vertices, faces), axis=1) <= THIN * longest
    if not thin.any() or thin.all():
        return faces, ()
    return faces[~thin], (f"{int(thin.sum())} triangles without an area were left out",)


def without_doubles(faces: Faces) -> tuple[Faces, tuple[str, ...]]:
    """Faces each of which is there once.

    Two that are back to back are a wall inside a part, and both go; where all of them are, the surface was written
    from both sides, and one stays.
    """
    order = np.sort(faces, axis=1)
    low, mid, high = order.T
    sequence = np.lexsort((high, mid, low))
    new = np.r_[True, np.any(order[sequence][1:] != order[sequence][:-1], axis=1)]
    if new.all():
        return faces, ()
    group = np.empty(len(faces), dtype=np.int64)
    group[sequence] = np.cumsum(new) - 1
    a, b, c = faces.T
    even = (((a < b) & (b < c)) | ((b < c) & (c < a)) | ((c < a) & (a < b))).astype(np.int64)
    forward, backward = np.bincount(group, even), np.bincount(group, 1 - even)
    both = (forward > 0) & (backward > 0)
    once = np.zeros(len(faces), dtype=bool)
    once[np.unique(group, return_index=True)[1]] = True
    if both.mean() > 0.9:
        return faces[once], (f"{len(faces) - int(once.sum())} triangles that were there twice were left out",)
    kept = once & ~both[group]
    notes = []
    if both.any():
        notes.append(f"{int(both.sum())} pairs of triangles back to back, walls inside the part, were left out")
    doubles = len(faces) - int(kept.sum()) - 2 * int(both.sum())
    if doubles:
        notes.append(f"{doubles} triangles that were there twice were left out")
    return faces[kept], tuple(notes)


def stitched(source: str, vertices: Array, faces: Faces) -> tuple[Faces, tuple[str, ...]]:
    """Faces whose border edges are cut at the corners of other faces that lie on them, which closes such seams.

    Raises:
        MouldError: the border is a tangle.
    """
    cuts = 0
    for _ in range(_ROUNDS):
        edges = Edges(faces)
        if not len(edges.border):
            break
        edge, corner = _on_edges(source, vertices, edges)
        face = edges.border_face[edge]
        apart = np.all(faces[face] != corner[:, None], axis=1)
        edge, corner, face = edge[apart], corner[apart], face[apart]
        lowest = np.full(len(faces), len(edges.border), dtype=np.int64)
        np.minimum.at(lowest, face, edge)
        now = edge == lowest[face]  # one edge of a face at a time
        if not now.any():
            break
        cuts += int(now.sum())
        faces = _cut(vertices, faces, edges, edge[now], corner[now])
    return faces, (f"{cuts} corners that lay on an edge of a neighbour were joined to it",) if cuts else ()


def _on_edges(source: str, vertices: Array, edges: Edges) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Numbers of border edges and of the border corners that lie on them."""
    rim = np.unique(edges.border)
    start, end = vertices[edges.border[:, 0]], vertices[edges.border[:, 1]]
    middle, half = (start + end) / 2.0, np.linalg.norm(end - start, axis=1) / 2.0
    tree = cKDTree(vertices[rim])
    count = tree.query_ball_point(middle, half, return_length=True)
    if count.sum() > _MOST_NEAR:
        raise MouldError(
            f"{source}: its {len(edges.border)} open edges are a tangle; expected a surface: repair it in CAD"
        )
    near = tree.query_ball_point(middle, half)
    edge = ragged(np.asarray(count))[0]
    corner = rim[np.concatenate([np.asarray(one, dtype=np.int64) for one in near])]
    along = end[edge] - start[edge]
    square = np.maximum(np.einsum("ij,ij->i", along, along), np.finfo(float).tiny)
    to = vertices[corner] - start[edge]
    share = np.einsum("ij,ij->i", to, along) / square
    aside = np.linalg.norm(to - share[:, None] * along, axis=1)
    room = WELD / np.sqrt(square)
    on = (aside <= WELD) & (share > room) & (share < 1.0 - room)
    return edge[on], corner[on]


def _cut(vertices: Array, faces: Faces, edges: Edges, edge: NDArray[np.int64], corner: NDArray[np.int64]) -> Faces:
    """Faces of which each with such an edge is a fan from the corner opposite of it."""
    start, end = edges.border[edge].T
    order = np.lexsort((np.linalg.norm(vertices[corner] - vertices[start], axis=1), edge))
    edge, corner, start, end = edge[order], corner[order], start[order], end[order]
    face = edges.border_face[edge]
    first = np.r_[True, edge[1:] != edge[:-1]]
    last = np.r_[first[1:], True]
    apex = faces[face].sum(axis=1) - start - end
    before = np.where(first, start, np.roll(corner, 1))
    pieces = np.column_stack((before, corner, apex))
    tails = np.column_stack((corner, end, apex))[last]
    whole = np.ones(len(faces), dtype=bool)
    whole[face] = False
    return np.concatenate((faces[whole], pieces, tails))


def closed(vertices: Array, faces: Faces) -> tuple[Array, Faces, tuple[str, ...]]:
    """Vertices and faces with the openings of up to HOLE across closed, by triangles from the middle of each."""
    border = Edges(faces).border
    loops = _loops(border)
    small = [loop for loop in loops if np.linalg.norm(np.ptp(vertices[loop], axis=0)) <= HOLE]
    notes = []
    if small:
        size = [float(np.linalg.norm(np.ptp(vertices[loop], axis=0))) for loop in small]
        notes.append(f"{len(small)} openings of up to {1e3 * max(size):.2g} mm were closed")
    added, middles = [], []
    for loop in small:
        if len(loop) == 3:
            added.append(loop[None, ::-1])
            continue
        middles.append(vertices[loop].mean(axis=0))
        centre = np.full(len(loop), len(vertices) + len(middles) - 1)
        added.append(np.column_stack((np.roll(loop, -1), loop, centre)))
    return (
        np.concatenate((vertices, np.array(middles).reshape(-1, 3))),
        np.concatenate((faces, *added)),
        tuple(notes),
    )


def _loops(border: Faces) -> list[NDArray[np.int64]]:
    """The closed lines that border edges (B, 2) form, each vertex once; those that cross themselves are left out."""
    if not len(border):
        return []
    start, following = border.T
    vertex, number = np.unique(border, return_inverse=True)
    number = number.reshape(-1, 2)
    leaving, entering = (np.bincount(number[:, i], minlength=len(vertex)) for i in (0, 1))
    plain = (leaving == 1) & (entering == 1)
    follower = dict(zip(start.tolist(), following.tolist(), strict=True))
    odd = set(vertex[~plain].tolist())
    seen: set[int] = set()
    loops = []
    for first in follower:
        loop = []
        at = first
        while at not in seen and at not in odd:
            seen.add(at)
            loop.append(at)
            at = follower[at]
        if len(loop) >= 3 and at == first:
            loops.append(np.array(loop, dtype=np.int64))
    return loops


def _solid(faces: Faces) -> Faces:
    """Faces with three different corners."""
    a, b, c = faces.T
    return np.asarray(faces[(a != b) & (b != c) & (c != a)])
