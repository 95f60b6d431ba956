"""Laws that turn the error of the tool's pose into a torque: by Jᵀ, or by J⁻¹ and the dynamics."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from burnish.control.checks import need_inverse_of_jacobian, need_tool_reference
from burnish.control.error import OrientationError, pose_error
from burnish.control.gains import Gain, above_zero, by_frequency, fit, joints, six
from burnish.control.integral import Integral
from burnish.core import Array, Dynamics, ToolReference
from burnish.inverse import damped_inverse
from burnish.rotation import continuous_error

SINGULAR_VALUE = 0.05
"""Singular value of J, in metres and radians, below which its inverse is damped: there 0.05 m/s of the tool would
take 1 rad/s of the joints. A choice."""


@dataclass(kw_only=True)
class PidWrench:
    """A wrench from the pose error, ``w = K e + D (v_d − v) + K_i ∫e``: what three laws of thesis A share."""

    stiffness: Gain
    """K [N/m, N·m/rad]: one number, two (position, orientation) or six."""
    damping: Gain
    """D [N·s/m, N·m·s/rad]: one number, two or six."""
    integral_stiffness: Gain = 0.0
    """K_i [N/(m·s), N·m/(rad·s)]: one number, two or six."""
    integral: Gain = (20.0, 5.0)
    """Bound of K_i ∫e [N, N·m]: one number, two or six."""
    window: float = np.inf
    """Error beyond which the integral gathers nothing [m, rad]."""
    joint_damping: Gain = 0.0
    """D_q [N·m·s/rad], (n,) or one number, of an added −D_q q̇: what calms the self-motion of a redundant arm."""
    orientation_error: OrientationError = continuous_error
    """e_o of the errors of `burnish.rotation`."""
    _K: Array = field(init=False, repr=False)
    _D: Array = field(init=False, repr=False)
    _D_q: Array = field(init=False, repr=False)
    _integral: Integral = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._K, self._D = six(self, "stiffness", self.stiffness), six(self, "damping", self.damping)
        self._D_q = joints(self, "joint_damping", self.joint_damping)
        gain, bound = (six(self, name, getattr(self, name)) for name in ("integral_stiffness", "integral"))
        self._integral = Integral(gain, bound, above_zero(self, "window", self.window, infinite=True))

    def reset(self, arm: Dynamics) -> None:
        """Clear the integral."""
        fit(self, arm, joint_damping=self._D_q)
        self._integral.reset(arm.t, 6)

    def wrench(self, arm: Dynamics, reference: ToolReference) -> Array:
        """w = [f; μ] [N, N·m], (6,), base axes."""
        need_tool_reference(self, reference)
        e = pose_error(arm, reference, self.orientation_error)
        return self._K * e + self._D * (reference.v - arm.v) + self._integral.add(e, arm.t)


@dataclass(kw_only=True)
class JacobianTranspose(PidWrench):
    """Springs, dampers and integrals at the tool: ``τ = Jᵀ w + g`` with w of `PidWrench`.

    Position and orientation disturb each other through the arm's inertia, which the law does not know. Gravity is
    included, h is not. Source: thesis A, 4.1.1, table 5.2.
    """

    def torque(self, arm: Dynamics, reference: ToolReference) -> Array:
        """Joint torques [N·m], (n,), gravity included."""
        return np.asarray(arm.J.T @ self.wrench(arm, reference) + arm.g - self._D_q * arm.dq)


@dataclass(kw_only=True)
class TaskComputedTorque:
    """Computed torque in task space: ``τ = M J⁻¹ (a − J̇q̇) + h + g`` with a = a_d + K_p e + K_d (v_d − v) + K_i ∫e.

    Gravity is included. Next to a singularity J⁻¹ is damped, smoothly and only in the direction that is lost. Source:
    thesis B, eq. 4.10 and 4.13, which drops J̇q̇ and h and damps −K_d v without a feed-forward; the integral is ours.
    """

    kp: Gain
    """K_p [1/s²]: one number, two (position, orientation) or six."""
    kd: Gain
    """K_d [1/s]: one number, two or six."""
    ki: Gain = 0.0
    """K_i [1/s³]: one number, two or six."""
    integral: Gain = 6.0
    """Bound of K_i ∫e [m/s², rad/s²]: one number, two or six."""
    window: float = np.inf
    """Error beyond which the integral gathers nothing [m, rad]."""
    orientation_error: OrientationError = continuous_error
    """e_o of the errors of `burnish.rotation`."""
    _kp: Array = field(init=False, repr=False)
    _kd: Array = field(init=False, repr=False)
    _integral: Integral = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._kp, self._kd = six(self, "kp", self.kp), six(self, "kd", self.kd)
        self._integral = Integral(
            six(self, "ki", self.ki),
            six(self, "integral", self.integral),
            above_zero(self, "window", self.window, infinite=True),
        )

    @classmethod
    def at_frequency(cls, omega: Gain, damping_ratio: float = 1.0, **others: Any) -> TaskComputedTorque:
        """Gains by natural frequency ω [rad/s] (one, two or six): K_p = ω², K_d = 2 ζ ω (thesis B, eq. 4.7)."""
        kp, kd = by_frequency(omega, damping_ratio)
        return cls(kp=kp, kd=kd, **others)

    def reset(self, arm: Dynamics) -> None:
        """Clear the integral.

        Raises:
            InputError: if the arm has no J⁻¹.
        """
        need_inverse_of_jacobian(self, arm, "OperationalSpace")
        self._integral.reset(arm.t, 6)

    def torque(self, arm: Dynamics, reference: ToolReference) -> Array:
        """Joint torques [N·m], (n,), gravity included."""
        need_tool_reference(self, reference)
        e = pose_error(arm, reference, self.orientation_error)
        a = reference.a + self._kp * e + self._kd * (reference.v - arm.v) + self._integral.add(e, arm.t)
        J_inverse = damped_inverse(arm.J, SINGULAR_VALUE)
        return np.asarray(arm.M @ (J_inverse @ (a - arm.dJdq)) + arm.h + arm.g)
