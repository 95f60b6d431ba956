"""`Brake`: the joints to rest from whatever speed they have, and held there."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from burnish.core import Array, Dynamics, JointReference

STOPPING = 0.12
"""Time in which the reference comes to rest [s]; with what the arm is late, less than 0.3 s."""
AT_REST = np.deg2rad(1.0)
"""Joint speed below which the arm is at rest [rad/s]."""


@dataclass(kw_only=True)
class Brake:
    """From the joint speeds at `reset` to rest with a constant deceleration: ``q = q₀ + q̇₀ (t − t²/2T)`` up to T."""

    duration: float = STOPPING
    """T [s]."""
    _q0: Array = field(default_factory=lambda: np.zeros(0), init=False, repr=False)
    _dq0: Array = field(default_factory=lambda: np.zeros(0), init=False, repr=False)
    _t0: float = field(default=0.0, init=False, repr=False)
    _still: int = field(default=0, init=False, repr=False)

    def reset(self, arm: Dynamics) -> None:
        """Start from this instant."""
        self._q0, self._dq0, self._t0, self._still = arm.q, arm.dq, arm.t, 0

    def at(self, arm: Dynamics) -> JointReference:
        """The reference at the instant of ``arm``."""
        T, t = self.duration, min(arm.t - self._t0, self.duration)
        left = 1.0 - t / T
        ddq = -self._dq0 / T if left > 0.0 else np.zeros(len(self._q0))
        return JointReference(q=self._q0 + self._dq0 * (t - 0.5 * t * t / T), dq=left * self._dq0, ddq=ddq)

    def stopped(self, arm: Dynamics) -> bool:
        """Whether the reference stands and the arm with it, two samples in a row; to be asked once a cycle."""
        stands = arm.t - self._t0 >= self.duration and float(np.abs(arm.dq).max()) < AT_REST
        self._still = self._still + 1 if stands else 0
        return self._still >= 2
