"""Many guesses of where a mould stands, and what a touch makes of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from typing_extensions import Self

from burnish.core import Array
from burnish.polish.cell import Placement
from burnish.polish.locate import TOUCH_DOUBT
from burnish.rotation import exp, log
from burnish.surface import DistanceGrid

STEPS = 12
"""Gauss–Newton steps of a fit; from a few centimetres away it takes about six."""
TRACED = 40
"""Steps of the march of a tip towards a surface."""
MET = 20e-6
"""Gap at which a marching tip counts as touching [m]."""


@dataclass(frozen=True, kw_only=True)
class Doubt:
    """How far a mould may stand from where it is meant to."""

    slide: float = 50e-3
    """In the plane of the table, in any direction [m]."""
    height: float = 5e-3
    """Up or down [m]."""
    yaw: float = float(np.deg2rad(30.0))
    """About the vertical, either way [rad]."""
    tilt: float = float(np.deg2rad(3.0))
    """About any horizontal axis [rad]."""

    def scale(self) -> Array:
        """The same by axis of shift and turn, as standard deviations would be [m, rad], (6,)."""
        return np.array([self.slide, self.slide, self.height, self.tilt, self.tilt, self.yaw])


@dataclass(frozen=True, kw_only=True)
class Guesses:
    """K placements of one mould."""

    p: Array
    """Origins of the mould's frame in the base frame [m], (K, 3)."""
    R: Array
    """Rotations, base ← mould, (K, 3, 3)."""

    def __len__(self) -> int:
        return len(self.p)

    @classmethod
    def drawn(cls, nominal: Placement, doubt: Doubt, count: int, rng: np.random.Generator) -> Self:
        """Evenly over the doubt about a placement: the disc, the height, the yaw and the tilt."""
        angle, way = 2.0 * np.pi * rng.random((2, count)), np.sqrt(rng.random((2, count)))
        flat = np.stack([np.cos(angle), np.sin(angle)], axis=-1) * way[..., None]
        shift = np.column_stack([doubt.slide * flat[0], rng.uniform(-doubt.height, doubt.height, count)])
        yaw = rng.uniform(-doubt.yaw, doubt.yaw, count)
        turns = [
            exp(np.array([0.0, 0.0, z])) @ exp(np.array([x, y, 0.0]))
            for x, y, z in zip(*(doubt.tilt * flat[1]).T, yaw, strict=True)
        ]
        return cls(p=nominal.p + shift, R=np.array(turns) @ nominal.R)

    def near(self, count: int, rng: np.random.Generator) -> Self:
        """``count`` more, spread about these as these are about each other."""
        pick = rng.integers(len(self), size=count)
        x = self.offsets()
        moved = x.std(axis=0) * rng.normal(size=(count, 6)) * 0.5
        turn = np.array([exp(w) for w in moved[:, 3:]])
        return type(self)(p=self.p[pick] + moved[:, :3], R=turn @ self.R[pick])

    def kept(self, mask: NDArray[np.bool_]) -> Self:
        """Those of a mask (K,)."""
        return type(self)(p=self.p[mask], R=self.R[mask])

    def with_more(self, other: Self) -> Self:
        """These and the others."""
        return type(self)(p=np.concatenate([self.p, other.p]), R=np.concatenate([self.R, other.R]))

    def one(self, k: int) -> Placement:
        """The guess of number k."""
        return Placement(p=self.p[k], R=self.R[k])

    def middle(self) -> int:
        """Number of the guess that is nearest to the mean of all."""
        x = self.offsets()
        spread = np.maximum(x.std(axis=0), 1e-9)
        return int(np.argmin((((x - x.mean(axis=0)) / spread) ** 2).sum(axis=1)))

    def offsets(self) -> Array:
        """Shift and turn of each from the first, base axes [m, rad], (K, 6)."""
        turn = np.array([log(R @ self.R[0].T) for R in self.R])
        return np.column_stack([self.p - self.p[0], turn])

    def local(self, points: Array) -> Array:
        """Points of the base frame (N, 3) in the mould's frame of each guess [m], (K, N, 3)."""
        return np.asarray(np.einsum("knj,kji->kni", points[None] - self.p[:, None], self.R))

    def gaps(self, grid: DistanceGrid, centres: Array, radius: float) -> Array:
        """Gap between the mould and a tip at these centres (N, 3), for each guess [m], (K, N)."""
        local = self.local(centres)
        return np.asarray(grid.distance(local.reshape(-1, 3)).reshape(local.shape[:2]) - radius)

    def met(self, grid: DistanceGrid, start: Array, way: Array, radius: float, far: float) -> Array:
        """How far a tip goes from ``start`` along the unit vector ``way`` until it touches [m], (K,).

        Infinite where it comes ``far`` without a touch. The tip marches by its gap, which cannot jump a surface.
        """
        t, open_ = np.zeros(len(self)), np.ones(len(self), dtype=bool)
        for _ in range(TRACED):
            k = np.flatnonzero(open_)
            if not len(k):
                break
            local = np.einsum("kj,kji->ki", start + t[k, None] * way - self.p[k], self.R[k])
            gap = grid.distance(local) - radius
            t[k] += np.maximum(gap, 0.0)
            open_[k] = (gap > MET) & (t[k] < far)
        return np.where(t < far, t, np.inf)

    def pulled(self, grid: DistanceGrid, centres: Array, radius: float, doubt: Array, noise: Array) -> Self:
        """Each guess moved, as little as need be, to where its surface passes through what was touched.

        Least squares in a small shift s and turn w about the mean touch, for each guess by itself:
        minimise ``Σ (φ(c_i) − r + ε_i)²/σ² + |s, w|²/doubt²``, by Gauss–Newton. Perturbed touches ε and scattered
        starts make the results a sample of what the touches leave open (randomized maximum likelihood: Kitanidis
        1995; Oliver, He and Reynolds 1996).

        Args:
            grid: distance to the mould.
            centres: of the tip at each touch, base frame [m], (N, 3).
            radius: of the tip [m].
            doubt: how far each guess may have to move, by axis [m, rad], (6,).
            noise: ε [m], (K, N).
        """
        pivot, start, R = centres.mean(axis=0), self.p, self.R
        x, p = np.zeros((len(self), 6)), self.p
        for _ in range(STEPS):
            local = np.einsum("knj,kji->kni", centres[None] - p[:, None], R)
            phi, gradient = grid.at(local.reshape(-1, 3))
            n = np.einsum("kni,kji->knj", gradient.reshape(local.shape), R)
            e = (phi.reshape(local.shape[:2]) - radius + noise) / TOUCH_DOUBT
            A = -np.concatenate([n, np.cross(centres - pivot, n)], axis=2) / TOUCH_DOUBT
            normal = np.einsum("kni,knj->kij", A, A) + np.diag(doubt**-2)
            pull = -np.einsum("kni,kn->ki", A, e) - x / doubt**2
            step = np.linalg.solve(normal, pull[..., None])[..., 0]
            # A turn of more than that is no small one.
            x = x + step * np.minimum(1.0, 0.3 / np.maximum(np.abs(step[:, 3:]).max(axis=1), 1e-12))[:, None]
            turn = np.array([exp(w) for w in x[:, 3:]])
            R = turn @ self.R
            p = pivot + x[:, :3] + np.einsum("kij,kj->ki", turn, start - pivot)
        return type(self)(p=p, R=R)
