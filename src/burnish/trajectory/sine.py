"""A sine about the joint positions at the start."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from burnish.core import Array, Dynamics, JointReference
from burnish.errors import InputError


@dataclass(kw_only=True)
class Sine:
    """``q = q₀ + A sin(2π t/T)`` with q₀ the joint positions at `reset`.

    Source: thesis A, eq. 5.3 (20°, 8 s); thesis B, eq. 5.3–5.4 (π/4, 10 s).
    """

    amplitude: float | Array
    """A [rad], (n,) or one number for all joints."""
    period: float
    """T [s]."""
    _q0: Array = field(default_factory=lambda: np.zeros(0), init=False, repr=False)
    _t0: float = field(default=0.0, init=False, repr=False)

    def __post_init__(self) -> None:
        if not (np.isfinite(self.period) and self.period > 0.0 and np.all(np.isfinite(self.amplitude))):
            raise InputError(f"Sine: amplitude {self.amplitude} rad and period {self.period} s must be finite, T > 0")

    def reset(self, arm: Dynamics) -> None:
        """Start from this instant and these joint positions."""
        self._q0, self._t0 = arm.q, arm.t

    def at(self, arm: Dynamics) -> JointReference:
        """The reference at the instant of ``arm``."""
        w = 2.0 * np.pi / self.period
        phase = w * (arm.t - self._t0)
        A = np.asarray(self.amplitude, dtype=float) * np.ones(len(arm.q))
        return JointReference(q=self._q0 + A * np.sin(phase), dq=A * w * np.cos(phase), ddq=-A * w * w * np.sin(phase))
