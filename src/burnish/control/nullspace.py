"""Laws that give the position precedence: the orientation gets what the position leaves free."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from burnish.control.checks import need_tool_reference
from burnish.control.error import OrientationError, pose_error
from burnish.control.gains import Gain, above_zero, fit, joints, three
from burnish.control.integral import Integral
from burnish.control.task import SINGULAR_VALUE, PidWrench
from burnish.core import SINGULAR_MOBILITY, Array, Dynamics, ToolReference
from burnish.inverse import damped_inverse, dynamically_consistent_inverse
from burnish.rotation import continuous_error


@dataclass(kw_only=True)
class GeometricNullSpace(PidWrench):
    """Orientation in the null space of the position: ``τ = Jvᵀ f + (I − Jvᵀ Jv#ᵀ) Jωᵀ μ + g``.

    [f; μ] is the wrench of `PidWrench`, Jv# the inverse of Moore and Penrose. What is left of the orientation's torque
    exerts no force where the arm stands still; through M it still accelerates the tool point, which `DynamicNullSpace`
    mends. Gravity is included, h is not. Source: thesis A, eq. 4.13 with W = I.
    """

    def torque(self, arm: Dynamics, reference: ToolReference) -> Array:
        """Joint torques [N·m], (n,), gravity included."""
        return _prioritised(self, arm, reference, damped_inverse(arm.J[:3], SINGULAR_VALUE))


@dataclass(kw_only=True)
class DynamicNullSpace(PidWrench):
    """Orientation in the dynamic null space of the position: `GeometricNullSpace` with J̄v for Jv#.

    The orientation's torque does not accelerate the tool point. Gravity is included, h is not. Source: thesis A,
    eq. 4.13 with W = M.
    """

    def torque(self, arm: Dynamics, reference: ToolReference) -> Array:
        """Joint torques [N·m], (n,), gravity included."""
        return _prioritised(self, arm, reference, dynamically_consistent_inverse(arm.J[:3], arm.M, SINGULAR_MOBILITY))


def _prioritised(law: PidWrench, arm: Dynamics, reference: ToolReference, Jv_inverse: Array) -> Array:
    Jv, Jw, w = arm.J[:3], arm.J[3:], law.wrench(arm, reference)
    tau_o = Jw.T @ w[3:] - law._D_q * arm.dq
    return np.asarray(Jv.T @ w[:3] + tau_o - Jv.T @ (Jv_inverse.T @ tau_o) + arm.g)


@dataclass(kw_only=True)
class PostureReference:
    """Pose errors become joint speeds, which an inner loop follows.

        q̇_r = Jv# u_p + (I − Jv# Jv) Jω# u_o,        u = K_p e + K_i ∫e + K_d (v_d − v)
        τ   = M K (q̇_r − q̇) + h + g

    The gains of u are those of a **speed**: a posture error asks for a joint speed. Jv# and Jω# are those of Moore and
    Penrose, damped next to their singularities. Gravity is included. Source: thesis A, eq. 4.20–4.23, tables 5.4–5.5.
    """

    speed_gain: Gain
    """K of the inner loop [1/s], (n,) or one number."""
    position_kp: Gain
    """K_p of the position [1/s]: one number or three."""
    orientation_kp: Gain
    """K_p of the orientation [1/s]: one number or three."""
    position_ki: Gain = 0.0
    """K_i of the position [1/s²]."""
    orientation_ki: Gain = 0.0
    """K_i of the orientation [1/s²]."""
    position_kd: Gain = 0.0
    """K_d of the position, dimensionless."""
    orientation_kd: Gain = 0.0
    """K_d of the orientation, dimensionless."""
    integral: float = 0.5
    """Bound of K_i ∫e [m/s, rad/s]."""
    window: float = np.inf
    """Error beyond which the integral gathers nothing [m, rad]."""
    orientation_error: OrientationError = continuous_error
    """e_o of the errors of `burnish.rotation`."""
    _K: Array = field(init=False, repr=False)
    _kp: Array = field(init=False, repr=False)
    _kd: Array = field(init=False, repr=False)
    _integral: Integral = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._K = joints(self, "speed_gain", self.speed_gain)
        self._kp, ki, self._kd = (self._of_both(kind) for kind in ("kp", "ki", "kd"))
        self._integral = Integral(
            ki, three(self, "integral", self.integral)[0], above_zero(self, "window", self.window, infinite=True)
        )

    def reset(self, arm: Dynamics) -> None:
        """Clear the integral."""
        fit(self, arm, speed_gain=self._K)
        self._integral.reset(arm.t, 6)

    def torque(self, arm: Dynamics, reference: ToolReference) -> Array:
        """Joint torques [N·m], (n,), gravity included."""
        need_tool_reference(self, reference)
        e = pose_error(arm, reference, self.orientation_error)
        u = self._kp * e + self._integral.add(e, arm.t) + self._kd * (reference.v - arm.v)
        Jv = arm.J[:3]
        Jv_inverse, Jw_inverse = (damped_inverse(rows, SINGULAR_VALUE) for rows in (Jv, arm.J[3:]))
        dq_o = Jw_inverse @ u[3:]
        dq_r = Jv_inverse @ u[:3] + dq_o - Jv_inverse @ (Jv @ dq_o)
        return np.asarray(arm.M @ (self._K * (dq_r - arm.dq)) + arm.h + arm.g)

    def _of_both(self, kind: str) -> Array:
        names = (f"position_{kind}", f"orientation_{kind}")
        return np.concatenate([three(self, name, getattr(self, name)) for name in names])
