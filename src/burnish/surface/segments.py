"""Distance from many points to many straight segments, in the plane or in space."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from burnish.core import Array
from burnish.surface.nearest import ragged

_PIECE = 1e-3
"""Segments are looked up in pieces of at most this length [m]."""

_TRIED = 4
"""Pieces with the nearest middles that are tried for each point."""


class Segments:
    """Segments in short pieces, with a tree of their middles."""

    def __init__(self, ends: Array) -> None:
        """Cut them; ends (E, 2, D) [m]."""
        start, end = ends[:, 0], ends[:, 1]
        count = np.maximum(np.ceil(np.linalg.norm(end - start, axis=1) / _PIECE), 1.0).astype(np.int64)
        segment, number = ragged(count)
        self._vector: Array = ((end - start) / count[:, None])[segment]
        self._first: Array = start[segment] + number[:, None] * self._vector
        self._tree = cKDTree(self._first + self._vector / 2.0)

    def distance(self, points: Array) -> Array:
        """Distance of each point (N, D) to the nearest segment [m], (N,); ∞ without one."""
        if not len(self._first):
            return np.full(len(points), np.inf)
        tried = min(_TRIED, len(self._first))
        piece = self._tree.query(points, k=tried)[1].reshape(len(points), tried)
        to, along = points[:, None, :] - self._first[piece], self._vector[piece]
        square = np.maximum(np.einsum("npi,npi->np", along, along), np.finfo(float).tiny)
        share = np.clip(np.einsum("npi,npi->np", to, along) / square, 0.0, 1.0)
        return np.asarray(np.linalg.norm(to - share[:, :, None] * along, axis=2).min(axis=1))
