"""The hybrid laws of thesis B: an impedance for the position, joint speeds for the orientation."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import exp

import numpy as np

from burnish.control.checks import need_tool_reference
from burnish.control.error import OrientationError
from burnish.control.gains import Gain, fit, joints, one, three
from burnish.core import SINGULAR_MOBILITY, Array, Dynamics, ToolReference
from burnish.inverse import damped_spd_inverse, dynamically_consistent_inverse
from burnish.rotation import continuous_error


class Derivative:
    """The rate of a measured vector through a first-order low pass; 0 until two samples are known."""

    def __init__(self, time_constant: float) -> None:
        """Of the low pass [s]; 0 is the plain difference quotient."""
        self._time_constant = time_constant
        self._last: Array | None = None
        self._rate: Array = np.zeros(0)
        self._t = 0.0

    def reset(self, size: int) -> None:
        """Forget."""
        self._last, self._rate = None, np.zeros(size)

    def add(self, x: Array, t: float) -> Array:
        """Take x at the time t [s]; returns its rate, the last one where no time has passed."""
        dt = t - self._t
        if self._last is not None and dt > 0.0:
            share = 1.0 - exp(-dt / self._time_constant) if self._time_constant > 0.0 else 1.0
            self._rate = self._rate + share * ((x - self._last) / dt - self._rate)
        if self._last is None or dt > 0.0:
            self._last, self._t = x, t
        return self._rate


@dataclass(kw_only=True)
class HybridGains:
    """The two parts of a hybrid law.

    The position's is the torque τ_p = Jvᵀ (w_p + Λ_p a_p) with w_p = K e_p + D (ṗ_d − ṗ); the orientation's the joint
    acceleration α = K_v Δq̇ + K_a dΔq̇/dt with Δq̇ = K_1 J̄ω e_o − q̇.
    """

    stiffness: Gain
    """K of the position [N/m]: one number or three."""
    damping: Gain
    """D of the position [N·s/m]: one number or three."""
    turn_rate: Gain
    """K_1 [1/s], (n,) or one number: joint speed per joint angle that the orientation is off."""
    speed_gain: Gain
    """K_v [1/s], (n,) or one number, of the joint speeds; thesis B's K_p."""
    speed_rate_gain: Gain = 0.0
    """K_a, dimensionless, (n,) or one number, of their rate; thesis B's K_d."""
    derivative_time: float = 0.01
    """Time constant of the low pass on dΔq̇/dt [s]; a choice, thesis B does not say. 0 is none."""
    orientation_error: OrientationError = continuous_error
    """e_o of the errors of `burnish.rotation`."""
    _K: Array = field(init=False, repr=False)
    _D: Array = field(init=False, repr=False)
    _K_1: Array = field(init=False, repr=False)
    _K_v: Array = field(init=False, repr=False)
    _K_a: Array = field(init=False, repr=False)
    _rate: Derivative = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._K, self._D = three(self, "stiffness", self.stiffness), three(self, "damping", self.damping)
        self._K_1 = joints(self, "turn_rate", self.turn_rate)
        self._K_v = joints(self, "speed_gain", self.speed_gain)
        self._K_a = joints(self, "speed_rate_gain", self.speed_rate_gain)
        self._rate = Derivative(one(self, "derivative_time", self.derivative_time))

    def reset(self, arm: Dynamics) -> None:
        """Clear the derivative.

        Raises:
            InputError: if a joint gain does not fit the arm.
        """
        fit(self, arm, turn_rate=self._K_1, speed_gain=self._K_v, speed_rate_gain=self._K_a)
        self._rate.reset(len(arm.q))

    def position_torque(self, arm: Dynamics, reference: ToolReference) -> Array:
        """τ_p [N·m], (n,)."""
        need_tool_reference(self, reference)
        Jv = arm.J[:3]
        Lambda_p = damped_spd_inverse(Jv @ arm.Minv_JT[:, :3], SINGULAR_MOBILITY)
        w_p = self._K * (reference.p - arm.p) + self._D * (reference.v[:3] - arm.v[:3])
        return np.asarray(Jv.T @ (w_p + Lambda_p @ reference.a[:3]))

    def orientation_acceleration(self, arm: Dynamics, reference: ToolReference, Jw_bar: Array) -> Array:
        """α [rad/s²], (n,)."""
        dq_error = self._K_1 * (Jw_bar @ self.orientation_error(arm.R, reference.R)) - arm.dq
        return np.asarray(self._K_v * dq_error + self._K_a * self._rate.add(dq_error, arm.t))


@dataclass(kw_only=True)
class Hybrid(HybridGains):
    """Position by an impedance, orientation by joint speeds, added: ``τ = τ_p + M α + h + g``.

    τ_p and α are those of `HybridGains`. Each part disturbs the other: −K_v q̇ in α brakes the position as well. Gravity
    is included. Source: thesis B, eq. 4.42–4.55; it drops h.
    """

    def torque(self, arm: Dynamics, reference: ToolReference) -> Array:
        """Joint torques [N·m], (n,), gravity included."""
        tau_p = self.position_torque(arm, reference)
        Jw_bar = dynamically_consistent_inverse(arm.J[3:], arm.M, SINGULAR_MOBILITY)
        return np.asarray(tau_p + arm.M @ self.orientation_acceleration(arm, reference, Jw_bar) + arm.h + arm.g)


@dataclass(kw_only=True)
class HybridNullSpace(HybridGains):
    """The hybrid law with the orientation in the null space of the position.

        τ = τ_p + (Jω N_p)ᵀ J̄ωᵀ (M α − τ_p) + h + g,   N_p = I − J̄v Jv

    What turns the tool does not accelerate its point. With J̄ω in the place of the inverse of Jω N_p nothing blows up
    where position and orientation are in conflict; the orientation then follows less exactly. The self-motion of a
    redundant arm is in neither part, so it is not damped. Gravity is included. Source: thesis B, eq. 4.71–4.74; it
    drops h.
    """

    joint_damping: Gain = 0.0
    """D_q [N·m·s/rad], (n,) or one number, of an added −D_q q̇: what calms the self-motion of a redundant arm."""
    _D_q: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._D_q = joints(self, "joint_damping", self.joint_damping)

    def reset(self, arm: Dynamics) -> None:
        """Clear the derivative.

        Raises:
            InputError: if a joint gain does not fit the arm.
        """
        fit(self, arm, joint_damping=self._D_q)
        super().reset(arm)

    def torque(self, arm: Dynamics, reference: ToolReference) -> Array:
        """Joint torques [N·m], (n,), gravity included."""
        Jv, Jw = arm.J[:3], arm.J[3:]
        Jv_bar, Jw_bar = (dynamically_consistent_inverse(rows, arm.M, SINGULAR_MOBILITY) for rows in (Jv, Jw))
        tau_p = self.position_torque(arm, reference)
        beta = self.orientation_acceleration(arm, reference, Jw_bar)
        mu = Jw_bar.T @ (arm.M @ beta - tau_p)
        # (Jω N_p)ᵀ μ = Jωᵀ μ − Jvᵀ J̄vᵀ Jωᵀ μ.
        tau_o = Jw.T @ mu
        return np.asarray(tau_p + tau_o - Jv.T @ (Jv_bar.T @ tau_o) - self._D_q * arm.dq + arm.h + arm.g)
