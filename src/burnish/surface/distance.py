"""The signed distance to a mould on a regular grid: one number wherever a tool may be.

The tip of the tool is a sphere, so its contact with any surface is one look at this grid: φ is the distance
of the sphere's centre, φ − r the gap (negative: the penetration) and ∇φ the normal.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Self

from burnish.core import Array, read_only
from burnish.errors import InputError
from burnish.surface.columns import inside
from burnish.surface.lattice import STRIDE, distances
from burnish.surface.mould import Mould
from burnish.surface.nearest import Nearest
from burnish.surface.winding import Edges, Faces, face_vectors

MOST_NODES = 1_600_000
"""Nodes of the largest grid that is built, or little more: 13 MB, and two to three seconds."""

_LOG = logging.getLogger(__name__)
_THINNEST = 1e-9
"""Height over longest side below which a triangle is a line, and its neighbours' sides stand for it."""

_FACING_UP = 0.5
"""Least z of the normals of the surface that the grid must cover: steeper than 60° no tool works."""


_CORNERS = np.array([(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)])


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
        cls, mould: Mould, spacing: float = 1e-3, *, above: float = 35e-3, below: float = 5e-3, aside: float = 12e-3
    ) -> Self:
        """Measure the distance to the mould around all that faces up.

        Deeper than ``below`` under the surface the values are bounds, |φ| may be too large. An open
        surface counts as a solid whose border drops straight down. A large mould gets a coarser grid of about
        MOST_NODES nodes, which is logged.

        Args:
            mould: what to measure.
            spacing: wanted distance of the nodes [m].
            above: room above the highest point [m].
            below: room under the lowest point of what faces up [m].
            aside: room around the bounding box in x and y [m].

        Raises:
            InputError: a length is not positive.
            MouldError: the triangles lie over each other by the thousand.
        """
        if not all(0.0 < length < np.inf for length in (spacing, above, below, aside)):
            raise InputError(f"DistanceGrid: {spacing=}, {above=}, {below=}, {aside=}; expected positive lengths [m]")
        up = mould.vertices[mould.faces[_steepness(mould) > _FACING_UP]].reshape(-1, 3)
        floor = float(up[:, 2].min() if len(up) else mould.vertices[:, 2].max()) - below
        low, high = mould.vertices.min(axis=0), mould.vertices.max(axis=0)
        low, high = np.array([*(low[:2] - aside), floor]), high + [aside, aside, above]
        wanted, spacing = spacing, max(spacing, float(np.cbrt(np.prod(high - low) / MOST_NODES)))
        if spacing > wanted:
            level = logging.WARNING if spacing > 1.5 * wanted else logging.INFO
            _LOG.log(
                level, "%s: distance grid of %.2f mm, not %.2f mm: it is large", mould.name, 1e3 * spacing, 1e3 * wanted
            )
        cells = np.ceil((high - low) / (STRIDE * spacing) - 1e-6).astype(np.int64)
        origin = low - (STRIDE * spacing * cells - (high - low)) / 2.0 * [1.0, 1.0, 0.0]
        solid = inside(mould.vertices, mould.faces, origin, spacing, tuple(STRIDE * cells + 1))
        vertices, faces = _solid(mould, floor - below)
        values = distances(Nearest(vertices, faces, spacing), origin, spacing, cells)
        values[solid] *= -1.0
        return cls(origin=read_only(origin), spacing=spacing, values=read_only(values))

    @cached_property
    def slope(self) -> Array:
        """∇φ at the nodes by central differences, (nx, ny, nz, 3)."""
        return np.stack([np.gradient(self.values, self.spacing, axis=i) for i in range(3)], axis=-1)

    def at(self, points: ArrayLike) -> tuple[Array, Array]:
        """Distance and its gradient by trilinear interpolation between the nodes.

        The gradient is interpolated between central differences, so it is continuous, and an edge is
        blurred over one spacing; its length is 1 but for that. Where two parts of the surface are equally
        near, the distance is too small by up to half a spacing. Outside the grid the distance continues
        linearly from the nearest point of the grid, with the gradient there.

        Args:
            points: mould frame [m], (N, 3).

        Returns:
            Signed distance [m], (N,), and gradient, (N, 3).
        """
        corner, weights, beyond = self._cells(points)
        gradient = np.einsum("nc,nci->ni", weights, self.slope.reshape(-1, 3)[corner])
        distance = np.einsum("nc,nc->n", weights, self.values.reshape(-1)[corner])
        return distance + np.einsum("ni,ni->n", gradient, beyond), gradient

    def distance(self, points: ArrayLike) -> Array:
        """The distance of :meth:`at` alone [m], (N,), in a third of the time."""
        corner, weights, beyond = self._cells(points)
        distance = np.einsum("nc,nc->n", weights, self.values.reshape(-1)[corner])
        outside = np.flatnonzero(beyond.any(axis=1))
        gradient = np.einsum("nc,nci->ni", weights[outside], self.slope.reshape(-1, 3)[corner[outside]])
        distance[outside] += np.einsum("ni,ni->n", gradient, beyond[outside])
        return np.asarray(distance)

    def _cells(self, points: ArrayLike) -> tuple[NDArray[np.int64], Array, Array]:
        """Numbers and weights of the eight nodes around each point, (N, 8), and how far it lies outside [m], (N, 3)."""
        place = (np.asarray(points, dtype=np.float64).reshape(-1, 3) - self.origin) / self.spacing
        _, ny, nz = self.values.shape
        last = np.array(self.values.shape) - 1
        within = np.clip(place, 0.0, last)
        node = np.minimum(within.astype(np.int64), last - 1)
        stride = np.array([ny * nz, nz, 1])
        corner = (node @ stride)[:, None] + _CORNERS @ stride
        share = np.stack((1.0 - (within - node), within - node), axis=1)
        weights = share[:, :, None, None, 0] * share[:, None, :, None, 1] * share[:, None, None, :, 2]
        return corner, weights.reshape(-1, 8), (place - within) * self.spacing


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
