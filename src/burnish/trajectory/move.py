"""Moves of the tool as a hand makes them: so far along and so much about the base axes, with little jerk."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from burnish.core import Array, Dynamics, ToolReference, read_only
from burnish.errors import InputError
from burnish.rotation import exp


def minimum_jerk(s: float, duration: float) -> tuple[float, float, float]:
    """Share of the way 10 s³ − 15 s⁴ + 6 s⁵ at s = t/duration in [0, 1], with its first and second time derivative.

    Source: Flash and Hogan 1985, of a hand between two points; its speed peaks at 1.875 times the mean.
    """
    s = min(max(s, 0.0), 1.0)
    return (
        s**3 * (10.0 - 15.0 * s + 6.0 * s * s),
        30.0 * (s * (1.0 - s)) ** 2 / duration,
        60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / duration**2,
    )


@dataclass(kw_only=True)
class Move:
    """Tool poses from the one at `reset`: along a straight line and about a fixed axis, at rest at both ends.

    Unlike that of `CubicPose` the acceleration does not jump.
    """

    way: Array = field(default_factory=lambda: np.zeros(3))
    """How far, base axes [m], (3,)."""
    turn: Array = field(default_factory=lambda: np.zeros(3))
    """Rotation vector, base axes [rad], (3,)."""
    duration: float
    """Time from start to end [s]."""
    _p0: Array = field(default_factory=lambda: np.zeros(3), init=False, repr=False)
    _R0: Array = field(default_factory=lambda: np.eye(3), init=False, repr=False)
    _all: Array = field(init=False, repr=False)
    _t0: float = field(default=0.0, init=False, repr=False)

    def __post_init__(self) -> None:
        self._all = read_only(np.concatenate([self.way, self.turn]))
        if self._all.shape != (6,) or not np.isfinite(self._all).all():
            raise InputError(f"Move: way {self.way}, turn {self.turn}; expected three finite numbers each")
        if not (np.isfinite(self.duration) and self.duration > 0.0):
            raise InputError(f"Move: duration {self.duration} s must be finite and more than 0")

    def reset(self, arm: Dynamics) -> None:
        """Start from this instant and this tool pose."""
        self._p0, self._R0, self._t0 = arm.p, arm.R, arm.t

    def at(self, arm: Dynamics) -> ToolReference:
        """The reference at the instant of ``arm``; at the end it stands still."""
        s, ds, dds = minimum_jerk((arm.t - self._t0) / self.duration, self.duration)
        gone = s * self._all
        return ToolReference(p=self._p0 + gone[:3], R=exp(gone[3:]) @ self._R0, v=ds * self._all, a=dds * self._all)
