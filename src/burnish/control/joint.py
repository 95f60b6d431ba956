"""Joint-space laws: computed torque, and gravity compensation alone."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from burnish.core import Array, Dynamics, JointReference
from burnish.errors import InputError
from burnish.model.friction import Friction


@dataclass(kw_only=True)
class ComputedTorque:
    """Computed torque in joint space: ``τ = M (q̈_d + K_p e + K_d ė + K_i ∫e) + h + g`` with e = q_d − q.

    Gravity is included. Source: thesis B, eq. 4.5–4.7 (its eq. 4.6 misprints ė); thesis A, eq. 4.17–4.18 without
    the integral.
    """

    kp: float | Array
    """K_p [1/s²], (n,) or one number."""
    kd: float | Array
    """K_d [1/s], (n,) or one number."""
    ki: float | Array = 0.0
    """K_i [1/s³], (n,) or one number."""
    integral: float = 20.0
    """Bound of K_i ∫e [rad/s²]."""
    friction: Friction | None = None
    """Joint friction to compensate at the desired speed; None compensates nothing."""
    friction_share: float = 0.8
    """Share of it that is compensated."""
    _integral: Array = field(default_factory=lambda: np.zeros(0), init=False, repr=False)
    _t: float = field(default=0.0, init=False, repr=False)

    def __post_init__(self) -> None:
        for name in ("kp", "kd", "ki"):
            values = np.asarray(getattr(self, name), dtype=float)
            if not (np.all(np.isfinite(values)) and np.all(values >= 0.0)):
                raise InputError(f"ComputedTorque: {name} = {getattr(self, name)}; expected finite numbers ≥ 0")

    @classmethod
    def at_frequency(cls, omega: float, damping_ratio: float = 1.0, **others: object) -> ComputedTorque:
        """Gains by natural frequency ω [rad/s]: K_p = ω², K_d = 2 ζ ω (thesis B, eq. 4.7)."""
        return cls(kp=omega**2, kd=2.0 * damping_ratio * omega, **others)  # type: ignore[arg-type]

    def reset(self, arm: Dynamics) -> None:
        """Clear the integral."""
        self._integral, self._t = np.zeros(len(arm.q)), arm.t

    def torque(self, arm: Dynamics, reference: JointReference) -> Array:
        """Joint torques [N·m], (n,), gravity included."""
        dt, self._t = arm.t - self._t, arm.t
        e, de = reference.q - arm.q, reference.dq - arm.dq
        grown = self._integral + dt * self.ki * e
        self._integral = np.clip(grown, -self.integral, self.integral)
        tau = arm.M @ (reference.ddq + self.kp * e + self.kd * de + self._integral) + arm.h + arm.g
        if self.friction is not None:
            tau += self.friction_share * self.friction.torque(reference.dq)
        return np.asarray(tau)


@dataclass(kw_only=True)
class GravityCompensation:
    """Hold the arm's own weight and nothing else: ``τ = g − D q̇``.

    Source: the blog; the small damping is ours, it keeps a weightless arm from drifting.
    """

    damping: float | Array = 0.0
    """D [N·m·s/rad], (n,) or one number."""

    def reset(self, arm: Dynamics) -> None:
        """No memory."""

    def torque(self, arm: Dynamics, reference: object) -> Array:
        """Joint torques [N·m], (n,); the reference is not used."""
        return np.asarray(arm.g - self.damping * arm.dq)
