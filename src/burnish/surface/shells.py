"""A mesh looked at from above: which of its separate pieces are seen, from which side, and what floats.

Only what is seen from above is worked, so that is what has to be sound. Columns of a grid cross the mesh; the
highest crossing of each must face up.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from burnish.core import Array
from burnish.errors import MouldError
from burnish.surface.columns import crossings
from burnish.surface.nearest import ragged
from burnish.surface.winding import Edges, Faces

COLUMNS = 128
"""Columns along the longer side."""

TOUCHING = 50e-6
"""Gap up to which two pieces touch [m]: as far as a path may lie off the surface."""

_SHARE = 0.02
"""Share of the columns over the smaller of two pieces from which they count as lying over each other."""

_NEAR = 1.5
"""Columns around an opening in which the inside may be seen."""

_MOST_INSIDE = 0.1
"""Share of what is seen that may be the inside, through openings."""


@dataclass(frozen=True, kw_only=True)
class View:
    """All crossings, column by column, each from the top down."""

    column: NDArray[np.int64]
    """Number of the column, rising, (N,)."""
    height: Array
    """[m], (N,), falling within a column."""
    sign: NDArray[np.int64]
    """+1 where the triangle faces up, −1 where it faces down, (N,)."""
    piece: NDArray[np.int64]
    """Number of the piece, (N,)."""
    pitch: float
    """Distance of the columns [m]."""
    low: Array
    """First column [m], (2,)."""
    shape: tuple[int, int]
    """Columns along x and y."""

    @classmethod
    def of(cls, vertices: Array, faces: Faces, piece: NDArray[np.int64]) -> View:
        """Cross the mesh; ``piece`` is that of each face."""
        low, high = vertices[faces].min(axis=(0, 1)), vertices[faces].max(axis=(0, 1))
        pitch = float((high - low)[:2].max()) / COLUMNS
        shape = tuple(int(n) for n in np.ceil((high - low)[:2] / pitch).astype(np.int64) + 1)
        parts = list(crossings(vertices, faces, low, pitch, (shape[0], shape[1])))
        triangle = np.concatenate([part[0] for part in parts] or [np.empty(0, dtype=np.int64)])
        place = np.concatenate([part[1] for part in parts] or [np.empty((0, 2), dtype=np.int64)])
        height = np.concatenate([part[2] for part in parts] or [np.empty(0)]) * pitch + low[2]
        sign = np.concatenate([part[3].astype(np.int64) for part in parts] or [np.empty(0, dtype=np.int64)])
        column = place[:, 0] * shape[1] + place[:, 1]
        order = np.lexsort((-sign, -height, column))
        return cls(
            column=column[order], height=height[order], sign=sign[order], piece=piece[triangle[order]], pitch=pitch,
            low=low[:2], shape=(shape[0], shape[1]),
        )  # fmt: skip

    @property
    def first(self) -> NDArray[np.bool_]:
        """Whether each crossing is the highest of its column, (N,)."""
        return np.asarray(np.r_[True, self.column[1:] != self.column[:-1]][: len(self.column)])

    def count(self, sign: NDArray[np.int64]) -> NDArray[np.int64]:
        """How often the surface has been entered on the way down, after each crossing, (N,)."""
        total = np.cumsum(sign)
        start = np.flatnonzero(self.first)
        before = np.r_[0, total[start[1:] - 1]] if len(start) else np.empty(0, dtype=np.int64)
        return np.asarray(total - np.repeat(before, np.diff(np.r_[start, len(total)])))


def seen_from_above(source: str, vertices: Array, faces: Faces) -> tuple[Faces, tuple[str, ...]]:
    """The faces of one part, with pieces turned round that are seen from their back.

    Pieces that touch, overlap or stand beside each other are one part, of which the outside is worked.

    Returns:
        The faces, and a sentence for everything that was found.

    Raises:
        MouldError: a piece floats over another, two open surfaces lie over each other, or the surface shows its
            inside where there is no opening: nobody can tell what is to be worked.
    """
    edges = Edges(faces)
    piece = pieces(faces, edges)
    count = int(piece.max()) + 1
    view = View.of(vertices, faces, piece)
    solid = np.ones(count, dtype=bool)
    solid[piece[edges.border_face]] = False
    turned = _seen_from_behind(view, solid)
    sign = np.where(turned[view.piece], -view.sign, view.sign)
    notes = []
    if turned.any():
        faces = np.where(turned[piece][:, None], faces[:, ::-1], faces)
        notes.append(f"{int(turned.sum())} separate pieces faced the wrong way and were turned round")
    notes += _inside_out(source, view, sign, vertices, edges)
    if count > 1:
        _refuse_floating(source, view, sign, solid, vertices, edges, piece)
        notes.append(f"it has {count} separate pieces, taken as one part seen from above")
    inner = np.count_nonzero(view.count(sign) > 1) if solid.all() else 0
    if inner:
        area = 1e4 * len(np.unique(view.column[view.count(sign) > 1])) * view.pitch**2
        notes.append(f"it cuts through itself over {area:.2g} cm² seen from above; its outside is worked")
    return faces, tuple(notes)


def pieces(faces: Faces, edges: Edges) -> NDArray[np.int64]:
    """Number of the piece of each face, (F,): what hangs together by edges of two triangles."""
    f, g = edges.pairs.T
    graph = coo_array((np.ones(len(f), dtype=np.int8), (f, g)), shape=(len(faces), len(faces)))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def _seen_from_behind(view: View, solid: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The pieces that are to be turned round: closed ones always, open ones if most of what is seen is right."""
    top = view.first
    back = np.bincount(view.piece[top & (view.sign < 0)], minlength=len(solid))
    front = np.bincount(view.piece[top & (view.sign > 0)], minlength=len(solid))
    behind = back > front
    right = front[~behind].sum() + back[behind & solid].sum()
    return np.asarray(behind & (solid | (back[behind & ~solid].sum() < right)))


def _inside_out(source: str, view: View, sign: NDArray[np.int64], vertices: Array, edges: Edges) -> list[str]:
    """What is said of the inside that is seen through openings.

    Raises:
        MouldError: it is seen where there is no opening, so the surface crosses itself; or more than a tenth of all.
    """
    image = np.zeros(view.shape, dtype=bool)
    image.ravel()[view.column[view.first & (sign < 0)]] = True
    region, count = label(image, np.ones((3, 3)))
    if not count:
        return []
    start, end = vertices[edges.border[:, 0], :2], vertices[edges.border[:, 1], :2]
    parts = np.maximum(np.ceil(np.linalg.norm(end - start, axis=1) / view.pitch), 1.0).astype(np.int64)
    edge, number = ragged(parts)
    rim = start[edge] + ((number + 0.5) / parts[edge])[:, None] * (end - start)[edge]
    place = np.argwhere(image)
    far = np.full(len(place), np.inf)
    if len(rim):
        far = cKDTree(rim).query(view.low + view.pitch * place)[0]
    nearest = np.full(count, np.inf)
    number = region[image] - 1
    np.minimum.at(nearest, number, far)
    lost = ((nearest > _NEAR * view.pitch) & (np.bincount(number, minlength=count) > 1))[number]
    if image.sum() > _MOST_INSIDE * np.count_nonzero(view.first):
        lost[:] = True
    area = 1e4 * view.pitch**2
    if lost.any():
        x, y = 1e3 * (view.low + view.pitch * place[lost].mean(axis=0))
        raise MouldError(
            f"{source} shows its inside over {area * lost.sum():.2g} cm² seen from above, about x {x:.1f}, y {y:.1f} "
            "mm: it crosses itself there, or is open or wound the wrong way; repair it in CAD"
        )
    if image.sum() < 3:  # a seam
        return []
    seen = area * image.sum()
    return [f"it shows its inside over {seen:.2g} cm² seen from above, through openings, and is not worked there"]


def _refuse_floating(
    source: str,
    view: View,
    sign: NDArray[np.int64],
    solid: NDArray[np.bool_],
    vertices: Array,
    edges: Edges,
    piece: NDArray[np.int64],
) -> None:
    """Refuse a piece that lies over another one, clear of it and of all that carries it."""
    depth = view.count(sign)
    same = np.r_[view.column[1:] == view.column[:-1], False]
    following = np.minimum(np.arange(len(sign)) + 1, max(len(sign) - 1, 0))
    other = same & (view.piece != view.piece[following])
    gap = view.height - view.height[following]
    # A solid ends over the air and the next begins; or an open surface hides the next one.
    air = other & (depth <= 0) & (sign < 0) & (sign[following] > 0)
    hides = other & (sign > 0) & (sign[following] > 0) & ~(solid[view.piece] & solid[view.piece[following]])
    over = (air | hides) & (gap > TOUCHING)
    touch = other & ((gap <= TOUCHING) | (~air & solid[view.piece] & solid[view.piece[following]]))
    joined = _joined(len(solid), view.piece[touch], view.piece[following][touch], vertices, edges, piece)
    apart = over & (joined[view.piece] != joined[view.piece[following]])
    if not apart.any():
        return
    pair = np.sort(np.column_stack((view.piece, view.piece[following])), axis=1)[apart]
    pairs, index, times = np.unique(pair, axis=0, return_inverse=True, return_counts=True)
    columns = np.bincount(view.piece, minlength=len(solid))
    bad = times > np.maximum(_SHARE * columns[pairs].min(axis=1), 1)
    if bad.any():
        worst = int(np.argmax(np.where(bad, times, 0)))
        distance = 1e3 * float(np.median(gap[apart][index.ravel() == worst]))
        raise MouldError(
            f"{source} has two pieces over each other, {distance:.3g} mm apart, that nothing joins; expected one part, "
            "or pieces that touch: export only what is to be worked"
        )


def _joined(
    count: int,
    one: NDArray[np.int64],
    other: NDArray[np.int64],
    vertices: Array,
    edges: Edges,
    piece: NDArray[np.int64],
) -> NDArray[np.int64]:
    """Number of the group of pieces that touch each other, (P,); borders that meet count as well."""
    rim, first = np.unique(edges.border[:, 0], return_index=True)
    owner = piece[edges.border_face[first]]
    if len(rim):
        away, near = cKDTree(vertices[rim]).query(vertices[rim], k=min(8, len(rim)), distance_upper_bound=TOUCHING)
        away, near = away.reshape(len(rim), -1), near.reshape(len(rim), -1)
        row, place = np.nonzero(np.isfinite(away))
        one, other = np.r_[one, owner[row]], np.r_[other, owner[near[row, place]]]
    graph = coo_array((np.ones(len(one), dtype=np.int8), (one, other)), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)
