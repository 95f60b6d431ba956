"""Where the surface to be worked ends, and how far in plan a point is from there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from typing_extensions import Self

from burnish.core import Array, read_only
from burnish.errors import InputError
from burnish.surface.mould import Mould
from burnish.surface.segments import Segments
from burnish.surface.winding import Edges, face_vectors

SHARP = np.deg2rad(20.0)
"""Angle between neighbouring facets from which a convex edge is an edge and not a facetted curve [rad]:
CAD programs facet their curves by 5–15°. A choice between the two."""


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
    def _plan(self) -> Segments:
        """The edges seen from above."""
        return Segments(self.segments[:, :, :2])

    def distance(self, points: ArrayLike) -> Array:
        """Horizontal distance of points (N, 2) or (N, 3) to the nearest border [m], (N,); ∞ without one."""
        return self._plan.distance(np.asarray(points, dtype=np.float64)[:, :2])
