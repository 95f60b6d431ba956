"""Cubic motions: from rest to rest, in joint space or between tool poses."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from burnish.core import Array, Dynamics, JointReference, ToolReference
from burnish.errors import InputError
from burnish.rotation import exp, log


def cubic(s: float, duration: float) -> tuple[float, float, float]:
    """Share of the way 3 s² − 2 s³ at s = t/duration in [0, 1], with its first and second time derivative.

    Source: thesis A, eq. 5.1; thesis B, eq. 5.2.
    """
    s = min(max(s, 0.0), 1.0)
    inside = 0.0 < s < 1.0
    return (
        s * s * (3.0 - 2.0 * s),
        6.0 * s * (1.0 - s) / duration,
        6.0 * (1.0 - 2.0 * s) / duration**2 if inside else 0.0,
    )


@dataclass(kw_only=True)
class Cubic:
    """Joint positions from where the arm is at `reset` to `q`."""

    q: Array
    """Joint positions at the end [rad], (n,)."""
    duration: float
    """Time from start to end [s]."""
    _q0: Array = field(default_factory=lambda: np.zeros(0), init=False, repr=False)
    _t0: float = field(default=0.0, init=False, repr=False)

    def __post_init__(self) -> None:
        _positive(self.duration)

    def reset(self, arm: Dynamics) -> None:
        """Start from this instant and these joint positions."""
        self._q0, self._t0 = arm.q, arm.t

    def at(self, arm: Dynamics) -> JointReference:
        """The reference at the instant of ``arm``; at the end it stands still."""
        s, ds, dds = cubic((arm.t - self._t0) / self.duration, self.duration)
        way = self.q - self._q0
        return JointReference(q=self._q0 + s * way, dq=ds * way, ddq=dds * way)

    def arrived(self, arm: Dynamics) -> bool:
        """Whether the time is over."""
        return arm.t - self._t0 >= self.duration


@dataclass(kw_only=True)
class CubicPose:
    """Tool poses from where the tool is at `reset` to (p, R): a straight line and the shortest rotation."""

    p: Array
    """Position at the end, base frame [m], (3,)."""
    R: Array
    """Rotation at the end, base ← tool, (3, 3)."""
    duration: float
    """Time from start to end [s]."""
    _p0: Array = field(default_factory=lambda: np.zeros(3), init=False, repr=False)
    _R0: Array = field(default_factory=lambda: np.eye(3), init=False, repr=False)
    _turn: Array = field(default_factory=lambda: np.zeros(3), init=False, repr=False)
    _t0: float = field(default=0.0, init=False, repr=False)

    def __post_init__(self) -> None:
        _positive(self.duration)

    def reset(self, arm: Dynamics) -> None:
        """Start from this instant and this tool pose."""
        self._p0, self._R0, self._t0 = arm.p, arm.R, arm.t
        self._turn = log(self.R @ arm.R.T)

    def at(self, arm: Dynamics) -> ToolReference:
        """The reference at the instant of ``arm``; at the end it stands still."""
        s, ds, dds = cubic((arm.t - self._t0) / self.duration, self.duration)
        way = np.concatenate([self.p - self._p0, self._turn])
        return ToolReference(p=self._p0 + s * way[:3], R=exp(s * self._turn) @ self._R0, v=ds * way, a=dds * way)

    def arrived(self, arm: Dynamics) -> bool:
        """Whether the time is over."""
        return arm.t - self._t0 >= self.duration


def _positive(duration: float) -> None:
    if not (np.isfinite(duration) and duration > 0.0):
        raise InputError(f"duration {duration} s must be finite and more than 0")
