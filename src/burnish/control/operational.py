"""`OperationalSpace`: Khatib's law for any of the six degrees of freedom, with tasks in their null space."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from burnish.control.checks import need_tool_reference
from burnish.control.error import OrientationError, pose_error
from burnish.control.gains import Gain, above_zero, by_frequency, fit, one, six
from burnish.control.integral import Integral
from burnish.control.secondary import JointTask, total_acceleration
from burnish.core import SINGULAR_MOBILITY, Array, Dynamics, ToolReference
from burnish.errors import InputError
from burnish.inverse import damped_spd_inverse, task_torque
from burnish.model.friction import Friction
from burnish.rotation import continuous_error


@dataclass(kw_only=True)
class OperationalSpace:
    """Operational-space control of a subset of position and orientation, and of the posture with what is left.

        a = a_d + K_p e + K_d (v_d − v) + K_i ∫e,                 e = [p_d − p; θu]
        τ = Jᵀ Λ (a − J̇q̇) + (I − Jᵀ J̄ᵀ) M α − k_v M q̇ + h + g + τ_friction(q̇_d)

    with the rows of J, a and J̇q̇ that ``mask`` leaves, and Λ, J̄ of that J: stripping rows of the full Λ would be
    another, heavier law. α is the acceleration that the tasks in ``null_space`` ask for; its torque accelerates nothing
    that the mask controls. Next to a singularity Λ is damped as in `Dynamics`. Friction, where it is known, is
    compensated at the **planned** joint speed q̇_d = J̄ v_d, which neither noise nor stiction disturbs.

    Gravity is included. Source: the blog (Khatib 1987). It damps in joint space, −k_v M q̇, which is ``kd=0`` with
    ``joint_damping=k_v``, and drops h and J̇q̇; the integral and the friction are ours.
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
    mask: Sequence[bool] = (True,) * 6
    """Which of x, y, z, about x, about y, about z (base axes) are controlled."""
    joint_damping: float = 0.0
    """k_v [1/s], against every joint motion, wanted or not."""
    null_space: Sequence[JointTask] = ()
    """What the joints shall do with the freedom that is left: `Posture`, `LimitAvoidance`."""
    orientation_error: OrientationError = continuous_error
    """θu of the errors; another of `burnish.rotation` in its place."""
    friction: Friction | None = None
    """Nominal joint friction to compensate; None compensates nothing."""
    friction_share: float = 0.8
    """Share of it that is compensated: less than 1, because too much drives the joints by itself."""
    _kp: Array = field(init=False, repr=False)
    _kd: Array = field(init=False, repr=False)
    _integral: Integral = field(init=False, repr=False)
    _rows: NDArray[np.intp] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        rows = np.asarray(self.mask)
        if rows.shape != (6,) or rows.dtype != np.bool_ or not rows.any():
            raise InputError(f"OperationalSpace: mask = {self.mask}; expected six booleans, at least one of them True")
        self._rows = np.flatnonzero(rows)
        self._kp, self._kd = (six(self, name, getattr(self, name))[self._rows] for name in ("kp", "kd"))
        self._integral = Integral(
            six(self, "ki", self.ki)[self._rows],
            six(self, "integral", self.integral)[self._rows],
            above_zero(self, "window", self.window, infinite=True),
        )
        for name in ("joint_damping", "friction_share"):
            one(self, name, getattr(self, name))

    @classmethod
    def at_frequency(cls, omega: Gain, damping_ratio: float = 1.0, **others: Any) -> OperationalSpace:
        """Gains by natural frequency ω [rad/s] (one, two or six): K_p = ω², K_d = 2 ζ ω (thesis B, eq. 4.7)."""
        kp, kd = by_frequency(omega, damping_ratio)
        return cls(kp=kp, kd=kd, **others)

    def reset(self, arm: Dynamics) -> None:
        """Clear the integral.

        Raises:
            InputError: if the arm has fewer joints than the mask has degrees of freedom, or a task or the friction does
                not fit it.
        """
        if len(self._rows) > len(arm.q):
            raise InputError(f"OperationalSpace: {len(self._rows)} degrees of freedom asked of {len(arm.q)} joints")
        if self.friction is not None:
            fit(self, arm, friction=self.friction.coulomb)
        for task in self.null_space:
            task.reset(arm)
        self._integral.reset(arm.t, len(self._rows))

    def torque(self, arm: Dynamics, reference: ToolReference) -> Array:
        """Joint torques [N·m], (n,), gravity included."""
        need_tool_reference(self, reference)
        J, e = arm.J, pose_error(arm, reference, self.orientation_error)
        slip, a = reference.v - J.dot(arm.dq), reference.a - arm.dJdq
        if len(self._rows) < 6:
            J, e, slip, a = J[self._rows], e[self._rows], slip[self._rows], a[self._rows]
        a = a + self._kp * e + self._kd * slip
        if self._integral.active:
            a += self._integral.add(e, arm.t)
        if self.null_space:
            # (I − Jᵀ J̄ᵀ) M α is M α − Jᵀ Λ J α.
            alpha = total_acceleration(self.null_space, arm)
            tau = task_torque(J, arm.M, a - J @ alpha, SINGULAR_MOBILITY) + arm.M @ alpha
        else:
            tau = task_torque(J, arm.M, a, SINGULAR_MOBILITY)
        if self.joint_damping > 0.0:
            tau -= self.joint_damping * (arm.M @ arm.dq)
        if self.friction is not None:
            tau += self.friction_share * self._planned_friction(self.friction, arm, reference)
        return np.asarray(tau + arm.h + arm.g)

    def _planned_friction(self, friction: Friction, arm: Dynamics, reference: ToolReference) -> Array:
        """τ_friction at J̄ v_d [N·m], (n,)."""
        Minv_JT = arm.Minv_JT[:, self._rows]
        Lambda = damped_spd_inverse(arm.J[self._rows].dot(Minv_JT), SINGULAR_MOBILITY)
        # Next to a singularity J̄ v_d is a speed that no joint will have, and its friction not to be compensated.
        close = SINGULAR_MOBILITY * sqrt(float(np.vdot(Lambda, Lambda)))
        return friction.torque(Minv_JT.dot(Lambda.dot(reference.v[self._rows]))) / (1.0 + close**8)
