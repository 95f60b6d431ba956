"""Joint-space laws: computed torque, and gravity compensation alone."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from burnish.control.checks import need_joint_reference
from burnish.control.gains import Gain, above_zero, by_frequency, fit, joints, one
from burnish.control.integral import Integral
from burnish.core import Array, Dynamics, JointReference
from burnish.model.friction import Friction


@dataclass(kw_only=True)
class ComputedTorque:
    """Computed torque in joint space: ``τ = M (q̈_d + K_p e + K_d ė + K_i ∫e) + h + g`` with e = q_d − q.

    Gravity is included. Source: thesis B, eq. 4.5–4.7 (its eq. 4.6 misprints ė); thesis A, eq. 4.17–4.18 without
    the integral.
    """

    kp: Gain
    """K_p [1/s²], (n,) or one number."""
    kd: Gain
    """K_d [1/s], (n,) or one number."""
    ki: Gain = 0.0
    """K_i [1/s³], (n,) or one number."""
    integral: float = 20.0
    """Bound of K_i ∫e [rad/s²]."""
    window: float = np.inf
    """Error beyond which the integral gathers nothing [rad]."""
    friction: Friction | None = None
    """Joint friction to compensate at the desired speed; None compensates nothing."""
    friction_share: float = 0.8
    """Share of it that is compensated."""
    _gains: tuple[Array, Array] = field(init=False, repr=False)
    _integral: Integral = field(init=False, repr=False)

    def __post_init__(self) -> None:
        kp, kd, ki = (joints(self, name, getattr(self, name)) for name in ("kp", "kd", "ki"))
        self._gains = kp, kd
        self._integral = Integral(
            ki, one(self, "integral", self.integral), above_zero(self, "window", self.window, infinite=True)
        )

    @classmethod
    def at_frequency(cls, omega: Gain, damping_ratio: float = 1.0, **others: Any) -> ComputedTorque:
        """Gains by natural frequency ω [rad/s], (n,) or one number: K_p = ω², K_d = 2 ζ ω (thesis B, eq. 4.7)."""
        kp, kd = by_frequency(omega, damping_ratio)
        return cls(kp=kp, kd=kd, **others)

    def reset(self, arm: Dynamics) -> None:
        """Clear the integral.

        Raises:
            InputError: if a gain does not fit the arm.
        """
        kp, kd = self._gains
        fit(self, arm, kp=kp, kd=kd, ki=np.asarray(self.ki))
        self._integral.reset(arm.t, len(arm.q))

    def torque(self, arm: Dynamics, reference: JointReference) -> Array:
        """Joint torques [N·m], (n,), gravity included."""
        need_joint_reference(self, reference)
        (kp, kd), e, de = self._gains, reference.q - arm.q, reference.dq - arm.dq
        tau = arm.M @ (reference.ddq + kp * e + kd * de + self._integral.add(e, arm.t)) + arm.h + arm.g
        if self.friction is not None:
            tau += self.friction_share * self.friction.torque(reference.dq)
        return np.asarray(tau)


@dataclass(kw_only=True)
class GravityCompensation:
    """Hold the arm's own weight and nothing else: ``τ = g − D q̇``.

    Source: the blog; the small damping is ours, it keeps a weightless arm from drifting.
    """

    damping: Gain = 0.0
    """D [N·m·s/rad], (n,) or one number."""
    _damping: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._damping = joints(self, "damping", self.damping)

    def reset(self, arm: Dynamics) -> None:
        """No memory.

        Raises:
            InputError: if the damping does not fit the arm.
        """
        fit(self, arm, damping=self._damping)

    def torque(self, arm: Dynamics, reference: object) -> Array:
        """Joint torques [N·m], (n,); the reference is not used."""
        return np.asarray(arm.g - self._damping * arm.dq)
