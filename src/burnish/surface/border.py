"""Where the surface to be worked ends, and how far in plan a point is from there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree
from typing_extensions import Self

from burnish.core import Array, read_only
from burnish.errors import InputError
from burnish.surface.mould import Mould
from burnish.surface.nearest import ragged
from burnish.surface.winding import Edges, face_vectors

SHARP = np.deg2rad(20.0)
"""Angle between neighbouring facets from which a convex edge is an edge and not a facetted curve [rad]:
CAD programs facet their curves by 5–15°. A choice between the two."""

_PIECE = 1e-3
"""Segments are looked up in pieces of at most this length [m]."""

_TRIED = 4
"""Pieces with the nearest middles that are tried for each point."""


@dataclass(frozen=True, kw_only=True)
class Border:
    """The edges that end the workable surface: its outline, the rims of holes and pockets, sharp ridges.

    A tool that is centred on such an edge overhangs it and rounds it off. A rounded edge is none, and nor is
    a concave corner, which keeps the tool out by itself.
    """

    segments: Array
    """Ends of the edges, mould frame [m], (E, 2, 3)."""

    @classmethod
    def of(cls, mould: Mould, max_slope: float) -> Self:
        """The border of everything that is no steeper than ``max_slope`` [rad] from facing up.

        Raises:
            InputError: the slope is not between 0 and 90°.
        """
        if not 0.0 < max_slope < np.pi / 2.0:
            raise InputError(f"max_slope is {max_slope} rad; expected an angle between 0 and π/2")
        edges = Edges(mould.faces)
        normals = face_vectors(mould.vertices, mould.faces)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
        workable = normals[:, 2] >= np.cos(max_slope)
        f, g = edges.pairs.T
        across = mould.vertices[mould.faces[g]].mean(axis=1) - mould.vertices[edges.inner[:, 0]]
        convex = np.einsum("ij,ij->i", across, normals[f]) < 0.0
        flat = np.einsum("ij,ij->i", normals[f], normals[g]) >= np.cos(SHARP)
        real = np.any(normals[f] != 0.0, axis=1) & np.any(normals[g] != 0.0, axis=1)
        sharp = (workable[f] | workable[g]) & convex & ~flat & real
        ends = np.concatenate((edges.border[workable[edges.border_face]], edges.inner[sharp]))
        return cls(segments=read_only(mould.vertices[ends]))

    @cached_property
    def _pieces(self) -> tuple[Array, Array, cKDTree]:
        """Starts and vectors of short pieces in plan, (P, 2) each, and a tree of their middles."""
        start, end = self.segments[:, 0, :2], self.segments[:, 1, :2]
        count = np.maximum(np.ceil(np.linalg.norm(end - start, axis=1) / _PIECE), 1.0).astype(np.int64)
        segment, number = ragged(count)
        vector = ((end - start) / count[:, None])[segment]
        first = start[segment] + number[:, None] * vector
        return first, vector, cKDTree(first + vector / 2.0)

    def distance(self, points: ArrayLike) -> Array:
        """Horizontal distance of points (N, 2) or (N, 3) to the nearest border [m], (N,); ∞ without one."""
        points = np.asarray(points, dtype=np.float64)[:, :2]
        first, vector, tree = self._pieces
        if not len(first):
            return np.full(len(points), np.inf)
        tried = min(_TRIED, len(first))
        piece = tree.query(points, k=tried)[1].reshape(len(points), tried)
        to, along = points[:, None, :] - first[piece], vector[piece]
        square = np.maximum(np.einsum("npi,npi->np", along, along), np.finfo(float).tiny)
        share = np.clip(np.einsum("npi,npi->np", to, along) / square, 0.0, 1.0)
        return np.asarray(np.linalg.norm(to - share[:, :, None] * along, axis=2).min(axis=1))
