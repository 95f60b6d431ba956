"""Distance from many points to a triangle surface, without a spatial library.

The surface is sampled; the sample that is nearest to a point names the triangle to which the distance is
then exact. A wrong triangle is only ever a neighbour of the right one, within a sample's spacing s of the
foot, and costs less than s²/2φ at the distance φ; close to the surface several triangles are tried.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from burnish.core import Array
from burnish.surface.triangles import Triangles, parts
from burnish.surface.winding import Faces

_RING = 16
"""Neighbouring samples that are tried around the nearest one."""

MOST_SAMPLES = 1_000_000
"""Samples of the largest surface; about half a kilobyte each."""

_GAIN = 1e-10
"""Gain in squared distance from which another sample is better [m²]: above the rounding of single precision, so that
a climb ends, and a few nanometres at 15 mm."""


class Nearest:
    """Samples of a surface, each with its triangle."""

    def __init__(self, vertices: Array, faces: Faces, spacing: float) -> None:
        """Sample the surface as :func:`sampled` does."""
        corners = vertices[faces]
        self.triangles = Triangles(corners)
        self.samples, self.owner, self.spacing = sampled(corners, spacing)
        self.tree = cKDTree(self.samples, leafsize=32)
        ring = min(_RING + 1, len(self.samples))
        self.ring: NDArray[np.int64] = self.tree.query(self.samples, k=ring)[1].reshape(-1, ring)
        """Each sample and its neighbours, nearest first, (S, R)."""
        offset = self.samples[self.ring] - self.samples[:, None, :]
        self._offset = np.moveaxis(offset, 1, 2).astype(np.float32)
        self._square = np.einsum("sri,sri->sr", offset, offset).astype(np.float32)

    def sample(self, points: Array) -> NDArray[np.int64]:
        """Number of the sample nearest to each point (N, 3), (N,); the slow, sure way."""
        return np.asarray(self.tree.query(points)[1])

    def climb(self, points: Array, start: NDArray[np.int64]) -> NDArray[np.int64]:
        """From a sample that is already near, on to the best of its ring as long as that gains, (N,)."""
        best, moved = start.copy(), np.arange(len(points))
        while len(moved):
            before, best[moved] = best[moved], self._best_of_ring(points[moved], best[moved])
            moved = moved[best[moved] != before]
        return best

    def _best_of_ring(self, points: Array, sample: NDArray[np.int64]) -> NDArray[np.int64]:
        """The sample nearest to each point among a sample and its ring, (N,)."""
        best = np.empty(len(points), dtype=np.int64)
        for part in parts(len(points)):
            here = sample[part]
            to = (points[part] - self.samples[here]).astype(np.float32)
            farther = self._square[here] - 2.0 * np.einsum("ni,nir->nr", to, self._offset[here])
            farther[:, 0] = -_GAIN  # the sample itself
            best[part] = self.ring[here, np.argmin(farther, axis=1)]
        return best

    def distance(self, points: Array, sample: NDArray[np.int64]) -> Array:
        """Distance of points (N, 3) to the triangles at their nearest samples [m], (N,).

        Within four spacings of the surface all triangles of the ring are tried.
        """
        distance = self.triangles.distance(points, self.owner[sample])
        near = np.flatnonzero(distance < 4.0 * self.spacing)
        for k in range(self.ring.shape[1]):
            ring = self.owner[self.ring[sample[near], k]]
            other = ring != self.owner[sample[near]]
            rows = near[other]
            distance[rows] = np.minimum(distance[rows], self.triangles.distance(points[rows], ring[other]))
        return distance


def sampled(corners: Array, spacing: float) -> tuple[Array, NDArray[np.int64], float]:
    """Samples of triangles (F, 3, 3) of which every point of them has one within about 0.7 of the spacing [m].

    Where that takes more than MOST_SAMPLES, besides some for each triangle, the spacing grows.

    Returns:
        Samples [m], (S, 3), their triangles, (S,), and the spacing that was kept [m].
    """
    while _expected(corners, spacing) > MOST_SAMPLES + 2 * len(corners):
        spacing *= 1.5
    return *_samples(corners, spacing), spacing


def _expected(corners: Array, spacing: float) -> float:
    """About how many samples triangles (F, 3, 3) take: by their area, and by the length of slender ones."""
    sides = np.roll(corners, -1, axis=1) - corners
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2.0
    return float(area.sum() / spacing**2 + longest.sum() / spacing + len(corners))


def _samples(corners: Array, spacing: float) -> tuple[Array, NDArray[np.int64]]:
    """Points on the triangles in columns across each longest side: (S, 3) and their triangles (S,).

    Columns and the points of a column are at most one spacing apart, so slender triangles are covered too.
    """
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    turn = (np.argmax(sides, axis=1)[:, None] + np.arange(3)) % 3
    start, end, apex = np.moveaxis(np.take_along_axis(corners, turn[:, :, None], axis=1), 1, 0)
    along, length = end - start, sides.max(axis=1)
    foot = np.clip(np.einsum("ij,ij->i", apex - start, along) / length**2, 1e-9, 1.0 - 1e-9)
    up = apex - start - foot[:, None] * along
    columns = np.ceil(length / spacing).astype(np.int64)
    triangle, column = ragged(columns)
    right = (column + 0.5) / columns[triangle]
    share = np.minimum(right / foot[triangle], (1.0 - right) / (1.0 - foot[triangle]))
    points = np.maximum(np.ceil(share * np.linalg.norm(up, axis=1)[triangle] / spacing), 1.0).astype(np.int64)
    line, point = ragged(points)
    triangle, right, high = triangle[line], right[line], share[line] * (point + 0.5) / points[line]
    return start[triangle] + right[:, None] * along[triangle] + high[:, None] * up[triangle], triangle


def ragged(counts: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """For items that occur ``counts`` times: the item of each occurrence, and its number within the item."""
    item = np.repeat(np.arange(len(counts)), counts)
    return item, np.arange(len(item)) - np.repeat(np.cumsum(counts) - counts, counts)
