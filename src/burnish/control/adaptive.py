"""`Adaptive`: around any law, learn the load that the model does not know."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from burnish.control.error import pose_error
from burnish.control.gains import one
from burnish.core import Array, Controller, Dynamics, JointReference, ToolReference
from burnish.errors import InputError
from burnish.model.regressor import body_regressor
from burnish.rotation import continuous_error


@dataclass(kw_only=True)
class Adaptive:
    """A law, and what an unknown payload or push asks for on top of it.

        τ  = τ_law + Jᵀ Y θ̂,       θ̂' = Γ Yᵀ s,  each θ̂ within its bound
        s  = v_d − v + λ e,         Y = [Y_body(R, ω, a_d + λ (v_d − v)), −I]

    θ̂ = [m, m c, −push]: mass and first moment of a body at the tool beyond what the model carries, either sign, and a
    constant wrench in base axes. Y_body are the first columns of `body_regressor`; the body's rotational inertia is
    not learnt. At rest a weight and a push downwards are one and the same: learn one of them, by giving the other no
    bound. In joint space e is q_d − q and s goes through J.

    Gravity is included. Source: Slotine and Li 1987, in task space; the blog's adaptive demonstration. The projection
    on bounds is ours: without it noise walks θ̂ away while the arm stands.
    """

    law: Controller[Any]
    """What moves the arm; its reference is that of the whole."""
    convergence: float = 5.0
    """λ [1/s]: speed with which an error is asked to vanish."""
    mass_rate: float = 3.0
    """Γ of the mass [kg·s²/m²]: kilograms a second for each m/s that the tool lacks, times the m/s² that lift it."""
    moment_rate: float = 0.02
    """Γ of the first moment [kg·s²]."""
    push_rate: float = 0.0
    """Γ of the push's force [N/m]; 0 learns none."""
    push_moment_rate: float = 0.0
    """Γ of the push's moment [N·m/rad]; 0 learns none."""
    mass: float = 2.0
    """Bound of |m| [kg]."""
    moment: float = 0.2
    """Bound of each |m c| [kg·m]."""
    push: float = 20.0
    """Bound of each force of the push [N]."""
    push_moment: float = 4.0
    """Bound of each moment of the push [N·m]."""
    _rate: Array = field(init=False, repr=False)
    _bound: Array = field(init=False, repr=False)
    _theta: Array = field(default_factory=lambda: np.zeros(10), init=False, repr=False)
    _t: float = field(default=0.0, init=False, repr=False)

    def __post_init__(self) -> None:
        one(self, "convergence", self.convergence)
        self._rate = self._of_all("mass_rate", "moment_rate", "push_rate", "push_moment_rate")
        self._bound = self._of_all("mass", "moment", "push", "push_moment")

    @property
    def learnt_mass(self) -> float:
        """m̂ [kg], beyond what the model carries."""
        return float(self._theta[0])

    @property
    def learnt_moment(self) -> Array:
        """m̂ ĉ [kg·m], (3,), tool axes."""
        return self._theta[1:4].copy()

    @property
    def learnt_push(self) -> Array:
        """The wrench that pushes the tool [N, N·m], (6,), base axes."""
        return self._theta[4:].copy()

    def reset(self, arm: Dynamics) -> None:
        """Forget the load, and reset the law."""
        self._theta, self._t = np.zeros(10), arm.t
        self.law.reset(arm)

    def torque(self, arm: Dynamics, reference: JointReference | ToolReference) -> Array:
        """Joint torques [N·m], (n,), gravity included."""
        dt, self._t = arm.t - self._t, arm.t
        e, slip, a_d = self._tool_errors(arm, reference)
        Y = np.empty((6, 10))
        Y[:, :4] = body_regressor(arm.R, arm.v[3:], a_d + self.convergence * slip)[:, :4]
        Y[:, 4:] = -np.eye(6)
        grown = self._theta + dt * self._rate * (Y.T @ (slip + self.convergence * e))
        self._theta = np.minimum(np.maximum(grown, -self._bound), self._bound)
        return np.asarray(self.law.torque(arm, reference) + arm.J.T @ (Y @ self._theta))

    def _tool_errors(self, arm: Dynamics, reference: object) -> tuple[Array, Array, Array]:
        """e, v_d − v and a_d at the tool, (6,) each."""
        if isinstance(reference, ToolReference):
            return pose_error(arm, reference, continuous_error), reference.v - arm.v, reference.a
        if isinstance(reference, JointReference):
            a_d = arm.J @ reference.ddq + arm.dJdq
            return arm.J @ (reference.q - arm.q), arm.J @ (reference.dq - arm.dq), a_d
        raise InputError(
            f"Adaptive learns from the error of a motion and was given a {type(reference).__name__}; "
            "expected a ToolReference or a JointReference"
        )

    def _of_all(self, mass: str, moment: str, push: str, push_moment: str) -> Array:
        m, mc, f, mu = (one(self, name, getattr(self, name)) for name in (mass, moment, push, push_moment))
        return np.repeat([m, mc, f, mu], [1, 3, 3, 3])
