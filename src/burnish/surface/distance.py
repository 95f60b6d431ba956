"""The signed distance to a mould on a regular grid: one number wherever a tool may be.

The tip of the tool is a sphere, so its contact with any surface is one look at this grid: φ is the distance
of the sphere's centre, φ − r the gap (negative: the penetration) and ∇φ the normal.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from typing_extensions import Self

from burnish.core import Array, read_only
from burnish.errors import InputError
from burnish.surface.columns import inside
from burnish.surface.lattice import STRIDE, distances
from burnish.surface.mould import Mould
from burnish.surface.nearest import Nearest
from burnish.surface.winding import Edges, Faces, face_vectors

MOST_NODES = 2_200_000
"""Nodes of the largest grid that is built: 18 MB, and two to four seconds."""

_LOG = logging.getLogger(__name__)
_THINNEST = 1e-9
"""Height over longest side below which a triangle is a line, and its neighbours' sides stand for it."""

_FACING_UP = 0.5
"""Least z of the normals of the surface that the grid must cover: steeper than 60° no tool works."""


@dataclass(frozen=True, kw_only=True)
class DistanceGrid:
    """Signed distance φ [m] at the nodes ``origin + spacing · (ix, iy, iz)``, positive outside the mould."""

    origin: Array
    """First node, mould frame [m], (3,)."""
    spacing: float
    """Distance of the nodes along each axis [m]."""
    values: Array
    """φ at the nodes [m], (nx, ny, nz), C order."""

    @classmethod
    def of(
        cls, mould: Mould, spacing: float = 1e-3, *, above: float = 35e-3, below: float = 5e-3, aside: float = 15e-3
    ) -> Self:
        """Measure the distance to the mould around all that faces up.

        Deeper than ``below`` under the surface the values are bounds, |φ| may be too large. An open
        surface counts as a solid whose border drops straight down. A large mould gets a coarser grid, with
        a warning, so that no grid has many more than MOST_NODES nodes.

        Args:
            mould: what to measure.
            spacing: wanted distance of the nodes [m].
            above: room above the highest point [m].
            below: room under the lowest point of what faces up [m].
            aside: room around the bounding box in x and y [m].

        Raises:
            InputError: a length is not positive.
        """
        if not min(spacing, above, below, aside) > 0.0:
            raise InputError(f"DistanceGrid: {spacing=}, {above=}, {below=}, {aside=}; expected positive lengths [m]")
        up = mould.vertices[mould.faces[_steepness(mould) > _FACING_UP]].reshape(-1, 3)
        floor = float(up[:, 2].min() if len(up) else mould.vertices[:, 2].max()) - below
        low, high = mould.vertices.min(axis=0), mould.vertices.max(axis=0)
        low, high = np.array([*(low[:2] - aside), floor]), high + [aside, aside, above]
        wanted, spacing = spacing, max(spacing, float(np.cbrt(np.prod(high - low) / MOST_NODES)))
        if spacing > wanted:
            _LOG.warning("%s: distance grid of %.2f mm instead of %.2f mm: the mould is large", mould.name,
                         1e3 * spacing, 1e3 * wanted)  # fmt: skip
        cells = np.ceil((high - low) / (STRIDE * spacing)).astype(np.int64)
        origin = low - (STRIDE * spacing * cells - (high - low)) / 2.0 * [1.0, 1.0, 0.0]
        vertices, faces = _solid(mould, floor - below)
        values = distances(Nearest(vertices, faces, spacing), origin, spacing, cells)
        values[inside(mould.vertices, mould.faces, origin, spacing, values.shape)] *= -1.0
        return cls(origin=read_only(origin), spacing=spacing, values=read_only(values))

    @cached_property
    def slope(self) -> Array:
        """∇φ at the nodes by central differences, (nx, ny, nz, 3)."""
        return np.stack([np.gradient(self.values, self.spacing, axis=i) for i in range(3)], axis=-1)

    def at(self, points: ArrayLike) -> tuple[Array, Array]:
        """Distance and its gradient by trilinear interpolation between the nodes.

        The gradient is interpolated between central differences, so it is continuous, and an edge is
        blurred over one spacing; its length is 1 but for that. Outside the grid the distance continues
        linearly from the nearest point of the grid, with the gradient there.

        Args:
            points: mould frame [m], (N, 3).

        Returns:
            Signed distance [m], (N,), and gradient, (N, 3).
        """
        points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        last = np.array(self.values.shape) - 1
        place = (points - self.origin) / self.spacing
        within = np.clip(place, 0.0, last)
        node = np.minimum(within.astype(np.int64), last - 1)
        weights = _corner_weights(within - node)
        corner = tuple(np.moveaxis(node[:, None, :] + _CORNERS, -1, 0))
        distance = np.einsum("nc,nc->n", weights, self.values[corner])
        gradient = np.einsum("nc,nci->ni", weights, self.slope[corner])
        beyond = (place - within) * self.spacing
        return distance + np.einsum("ni,ni->n", gradient, beyond), gradient


_CORNERS = np.array([(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)])


def _corner_weights(f: Array) -> Array:
    """Trilinear weights of the eight corners of a cell for the fractions f (N, 3), (N, 8)."""
    return np.asarray(np.prod(np.where(_CORNERS == 1, f[:, None, :], 1.0 - f[:, None, :]), axis=2))


def _steepness(mould: Mould) -> Array:
    """z of the unit normal of each face, (F,); 0 where a face has no area."""
    normal = face_vectors(mould.vertices, mould.faces)
    return np.asarray(normal[:, 2] / np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny))


def _solid(mould: Mould, floor: float) -> tuple[Array, Faces]:
    """The faces that have an area and reach above the floor, and walls under the border of an open surface."""
    start, end = Edges(mould.faces).border.T
    below = len(mould.vertices)
    foot = np.column_stack((mould.vertices[:, :2], np.full(below, floor)))
    walls = (np.column_stack((start, end, end + below)), np.column_stack((start, end + below, start + below)))
    vertices, faces = np.concatenate((mould.vertices, foot)), np.concatenate((mould.faces, *walls))
    corners = vertices[faces]
    area = np.linalg.norm(face_vectors(vertices, faces), axis=1)
    longest = np.linalg.norm(np.roll(corners, 1, axis=1) - corners, axis=2).max(axis=1)
    return vertices, faces[(corners[:, :, 2].max(axis=1) > floor) & (area > _THINNEST * longest**2)]
