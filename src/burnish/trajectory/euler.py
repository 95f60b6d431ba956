"""A cubic motion between tool poses whose orientation goes by Euler angles, as a thesis printed it."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import cos, sin

import numpy as np

from burnish.core import Array, Dynamics, ToolReference, read_only
from burnish.errors import InputError
from burnish.rotation import from_euler_xyz
from burnish.trajectory.cubic import cubic


@dataclass(kw_only=True)
class EulerCubic:
    """Position and intrinsic XYZ angles, each by its own cubic: ``X = X₀ + (3 s² − 2 s³)(X_f − X₀)``.

    The tool does not turn about one axis, and what way it takes depends on the choice of the angles; `CubicPose` is
    the better motion. Source: thesis A, eq. 5.1–5.2.
    """

    start: Array
    """X₀: position [m] and angles (α, β, γ) [rad], (6,); the tool should be there."""
    end: Array
    """X_f likewise."""
    duration: float
    """Time from start to end [s]."""
    _t0: float = field(default=0.0, init=False, repr=False)

    def __post_init__(self) -> None:
        self.start, self.end = read_only(self.start), read_only(self.end)
        if self.start.shape != (6,) or self.end.shape != (6,):
            raise InputError(f"EulerCubic: start {self.start}, end {self.end}; expected six numbers each")
        if not (np.isfinite(self.duration) and self.duration > 0.0):
            raise InputError(f"duration {self.duration} s must be finite and more than 0")

    def reset(self, arm: Dynamics) -> None:
        """Start from this instant."""
        self._t0 = arm.t

    def at(self, arm: Dynamics) -> ToolReference:
        """The reference at the instant of ``arm``; at the end it stands still."""
        s, ds, dds = cubic((arm.t - self._t0) / self.duration, self.duration)
        way = self.end - self.start
        x, dx, ddx = self.start + s * way, ds * way, dds * way
        E, dE = _rates(x[3:], dx[3:])
        return ToolReference(
            p=x[:3],
            R=from_euler_xyz(x[3:]),
            v=np.concatenate([dx[:3], E @ dx[3:]]),
            a=np.concatenate([ddx[:3], E @ ddx[3:] + dE @ dx[3:]]),
        )


def _rates(angles: Array, rates: Array) -> tuple[Array, Array]:
    """E with ω = E (α̇, β̇, γ̇) in base axes, and Ė, (3, 3) each: the axes of the three turns are its columns."""
    a, b, _ = (float(x) for x in angles)
    da, db, _ = (float(x) for x in rates)
    sa, ca, sb, cb = sin(a), cos(a), sin(b), cos(b)
    E = np.array([[1.0, 0.0, sb], [0.0, ca, -sa * cb], [0.0, sa, ca * cb]])
    dE = np.array(
        [
            [0.0, 0.0, cb * db],
            [0.0, -sa * da, -ca * cb * da + sa * sb * db],
            [0.0, ca * da, -sa * cb * da - ca * sb * db],
        ]
    )
    return E, dE
