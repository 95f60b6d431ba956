"""A straight descent at constant speed, for a guarded approach."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from burnish.core import Array, Dynamics, ToolReference


@dataclass(kw_only=True)
class Descend:
    """From where the tool is at `reset`, along ``direction`` at ``speed``, for as long as it is asked."""

    direction: Array
    """Unit vector of the motion, base axes, (3,)."""
    R: Array
    """Tool rotation held on the way, base ← tool, (3, 3)."""
    speed: float
    """Speed [m/s]."""
    _p0: Array = field(default_factory=lambda: np.zeros(3), init=False, repr=False)
    _t0: float = field(default=0.0, init=False, repr=False)

    def reset(self, arm: Dynamics) -> None:
        """Start from this instant and this tool position."""
        self._p0, self._t0 = arm.p, arm.t

    def at(self, arm: Dynamics) -> ToolReference:
        """The reference at the instant of ``arm``."""
        v = np.concatenate([self.speed * self.direction, np.zeros(3)])
        return ToolReference(p=self._p0 + self.depth(arm) * self.direction, R=self.R, v=v, a=np.zeros(6))

    def depth(self, arm: Dynamics) -> float:
        """How far the reference has come [m]."""
        return self.speed * (arm.t - self._t0)
