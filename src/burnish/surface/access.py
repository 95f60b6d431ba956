"""Where a spherical tip finds room on a mould: how large a ball fits against each place of the surface.

A ball of radius R that touches the surface at p with the normal n has its centre at p + R n. It fits if no other
place q of the surface lies inside it, R ≤ |q − p|² / 2 n·(q − p). The largest that fits is found by shrinking: take
the place nearest to its centre, give the ball the radius at which it also touches there, and go on until nothing lies
inside. In a hollow that is the radius of curvature; beside a wall it is what the wall leaves.

Source: J. Ma, S. W. Bae, S. Choi, 3D medial axis point approximation using nearest neighbors and the normal field,
The Visual Computer 28 (2012), section 3. Depths below a tolerance are passed over, because facets are no hollows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from typing_extensions import Self

from burnish.core import Array, read_only
from burnish.errors import InputError
from burnish.surface.mould import Mould
from burnish.surface.nearest import sampled
from burnish.surface.working import WorkingSurface

ROOM = 0.8
"""Greatest radius of the tip over that of a hollow: a larger one bridges it. A rule of thumb."""

SPACING = 1e-3
"""Distance of the vertices that are looked at [m]: a quarter of the footprint of a 15 mm tip."""

_TOLERANCE = 30e-6
"""How deep a ball may lie in the surface and still fit [m]: facets and samples 1 mm apart make 8 µm of depth for a
ball of 15 mm, a normal that is off by 3° makes 20 µm."""

_ROUNDS = 30
"""Times that a ball shrinks at most; most need three."""


@dataclass(frozen=True, kw_only=True)
class Access:
    """What a tip can get at of the surface that faces up."""

    surface: WorkingSurface
    """Vertices that were looked at."""
    tip_radius: float
    """Radius of the tip [m]."""
    radius: Array
    """Radius of the largest ball that fits against each vertex [m], (V,), at most tip_radius / ROOM."""

    @classmethod
    def of(cls, mould: Mould, tip_radius: float, spacing: float = SPACING) -> Self:
        """Fit balls against all that faces up.

        Args:
            mould: what is to be worked.
            tip_radius: radius of the spherical tip [m].
            spacing: longest side of the triangles whose vertices are looked at [m].

        Raises:
            InputError: the radius is no length.
            MouldError: there is nothing to work, or the spacing is too fine for so large a mould.
        """
        if not 0.0 < tip_radius < np.inf:
            raise InputError(f"the tip radius is {tip_radius} m; expected a positive length")
        surface = WorkingSurface.of(mould, spacing)
        around = cKDTree(_thinned(sampled(mould.vertices[mould.faces], spacing)[0], spacing / 2.0), leafsize=64)
        radius = _largest(around, surface.vertices, surface.normals, tip_radius / ROOM)
        return cls(surface=surface, tip_radius=tip_radius, radius=read_only(radius))

    @property
    def out_of_reach(self) -> NDArray[np.bool_]:
        """Vertices that the tip cannot touch, (V,)."""
        return np.asarray(self.radius < self.tip_radius)

    @property
    def tight(self) -> NDArray[np.bool_]:
        """Vertices in hollows that the tip reaches but nearly bridges, r ≥ 0.8 R, (V,)."""
        return np.asarray(~self.out_of_reach & (self.radius * ROOM < self.tip_radius * (1.0 - 1e-9)))

    def area(self, marked: NDArray[np.bool_]) -> float:
        """Area that marked vertices (V,) stand for [m²]."""
        return float(self.surface.areas[marked].sum())

    @property
    def summary(self) -> str:
        """What is out of reach and what is tight, in one sentence."""
        whole = 1e4 * float(self.surface.areas.sum())
        out, tight = 1e4 * self.area(self.out_of_reach), 1e4 * self.area(self.tight)
        return (
            f"of {whole:.1f} cm² that face up a tip of {1e3 * self.tip_radius:.3g} mm cannot reach {out:.1f} cm², and "
            f"{tight:.1f} cm² lie in hollows under {1e3 * self.tip_radius / ROOM:.3g} mm, too tight to work evenly"
        )


def _thinned(points: Array, side: float) -> Array:
    """One of the points (N, 3) in each cube of a side [m]: slender triangles have many more than the surface needs.

    That matters because all of a hollow is about as far from a ball's centre, and a tree then looks at everything.
    """
    cube = np.floor((points - points.min(axis=0)) / side).astype(np.int64)
    span = cube.max(axis=0) + 1
    first = np.unique((cube[:, 0] * span[1] + cube[:, 1]) * span[2] + cube[:, 2], return_index=True)[1]
    return np.asarray(points[first])


def _largest(around: cKDTree, places: Array, normals: Array, most: float) -> Array:
    """Radius of the largest ball up to ``most`` that fits against each place (N, 3) on the side of its normal, (N,)."""
    radius = np.full(len(places), most)
    active = np.flatnonzero(np.any(normals != 0.0, axis=1))
    for _ in range(_ROUNDS):
        centre = places[active] + radius[active, None] * normals[active]
        away, nearest = around.query(centre)
        inside = away < radius[active] - _TOLERANCE
        active, nearest = active[inside], nearest[inside]
        if not len(active):
            break
        to = around.data[nearest] - places[active]
        square, height = np.einsum("ij,ij->i", to, to), np.einsum("ij,ij->i", to, normals[active])
        radius[active] = np.minimum(square / (2.0 * np.maximum(height, np.finfo(float).tiny)), radius[active])
    return radius
