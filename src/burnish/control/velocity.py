"""`CartesianVelocity`: follow a commanded twist, as an operator's device gives it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from burnish.control.checks import need_tool_reference
from burnish.control.gains import Gain, above_zero, fit, joints, one
from burnish.control.integral import Integral
from burnish.control.task import SINGULAR_VALUE
from burnish.core import Array, Dynamics, ToolReference
from burnish.inverse import damped_inverse


@dataclass(kw_only=True)
class CartesianVelocity:
    """A twist becomes joint speeds, which an inner loop follows.

        q̇_r = J# v_d
        τ   = M [K (q̇_r − q̇) + K_i ∫(q̇_r − q̇)] + h + g

    Only ``v`` of the reference is used: the tool drifts where nobody corrects it. J# is damped in the direction that
    a singularity takes, so the tool slows down there and the joints do not race. Of the motions of a redundant arm it
    takes the one with the least joint speed. Gravity is included. Source: thesis A, ch. 6, where the vendor's joint
    speed loop takes the place of the second line.
    """

    speed_gain: Gain
    """K [1/s], (n,) or one number: inverse of the time constant with which the speed is reached."""
    integral_gain: Gain = 0.0
    """K_i [1/s²], (n,) or one number."""
    integral: float = 20.0
    """Bound of K_i ∫ [rad/s²]."""
    singular_value: float = SINGULAR_VALUE
    """Singular value of J [m, rad] below which its inverse is damped."""
    _K: Array = field(init=False, repr=False)
    _K_i: Array = field(init=False, repr=False)
    _integral: Integral = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._K = joints(self, "speed_gain", self.speed_gain)
        self._K_i = joints(self, "integral_gain", self.integral_gain)
        self._integral = Integral(self._K_i, one(self, "integral", self.integral))
        above_zero(self, "singular_value", self.singular_value)

    def reset(self, arm: Dynamics) -> None:
        """Clear the integral.

        Raises:
            InputError: if a joint gain does not fit the arm.
        """
        fit(self, arm, speed_gain=self._K, integral_gain=self._K_i)
        self._integral.reset(arm.t, len(arm.q))

    def torque(self, arm: Dynamics, reference: ToolReference) -> Array:
        """Joint torques [N·m], (n,), gravity included."""
        need_tool_reference(self, reference)
        e = damped_inverse(arm.J, self.singular_value) @ reference.v - arm.dq
        return np.asarray(arm.M @ (self._K * e + self._integral.add(e, arm.t)) + arm.h + arm.g)
