"""`ForceMotion`: hold a force along the surface normal while moving over the surface."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import exp, sqrt

import numpy as np

from burnish.control.checks import need_tool_reference
from burnish.core import SINGULAR_MOBILITY, Array, Dynamics, ToolReference
from burnish.errors import InputError
from burnish.model.friction import Friction
from burnish.rotation import continuous_error_of

STANDSTILL = 2e-3
"""Planned speed below which the friction of the tip is no longer fed forward in full [m/s]."""
NOTHING = (0.0,) * 6
"""No wrench [N, N·m]."""


@dataclass(kw_only=True)
class ForceMotion:
    """Operational-space motion along the surface and in orientation, force along its normal.

        a   = a_d + K_d (v_d − v) + K_p e + K_i ∫e,     e = [p_d − p; θu]
        f   = f_d + k_f (f_d − f_n) + k_i ∫(f_d − f_n)                     (pressing, along −n)
        τ   = Jᵀ [ Λ (P a − J̇q̇) − n (c f + D_n v_n) + µ f_d v̂_t ] + h + g + τ_friction(q̇_d)

    with f_n = n·F the measured contact force, P = I − c n nᵀ on the linear part, and c in [0, 1] the confidence
    that the tool touches. It fades to 0 when the force is lost: the normal direction is then held by position like
    the others, so the tool does not lunge, and looks for the surface a few millimetres down at the speed of a guarded
    approach. Without a normal in the reference c = 0: pure motion. τ_friction is compensated at the **planned** joint
    speed q̇_d = J̄ v_d, which neither noise nor stiction disturbs.

    Gravity is included. Source: the operational-space law of the blog (Khatib), thesis B ch. 4 for the impedance
    along the surface; force along the normal, its fading and the friction feed-forward are ours.
    """

    position_frequency: float = 14.0
    """Natural frequency of the position along the surface [rad/s]; K_p = ω²."""
    orientation_frequency: float = 14.0
    """Natural frequency of the orientation [rad/s]."""
    damping_ratio: float = 1.0
    """Of both; K_d = 2 ζ ω."""
    position_integral: float = 0.5
    """K_i/K_p of the position [1/s]."""
    orientation_integral: float = 0.5
    """K_i/K_p of the orientation [1/s]."""
    force_gain: float = 0.1
    """k_f: proportional force feedback, dimensionless."""
    force_integral: float = 8.0
    """k_i: integral force feedback [1/s]."""
    normal_damping: float = 260.0
    """D_n [N·s/m], against motion along the normal that the path does not ask for."""
    integral_force: float = 6.0
    """Bound of the force integral's share [N]."""
    integral_acceleration: float = 6.0
    """Bound of the motion integrals [m/s², rad/s²]."""
    friction: Friction | None = None
    """Nominal joint friction to compensate; None compensates nothing."""
    friction_share: float = 0.8
    """Share of it that is compensated: less than 1, because too much drives the joints by itself."""
    surface_friction: float = 0.3
    """µ of the tip on the surface, fed forward along the planned motion."""
    contact_force: float = 0.5
    """Force from which the tool counts as touching [N]; well above the noise of what feels it."""
    seek_speed: float = 5e-3
    """Speed at which a tool that lost the surface looks for it [m/s]."""
    seek_depth: float = 4e-3
    """How far below the planned surface it looks [m]."""
    fade_time: float = 0.04
    """Time constant of c [s]."""
    _integral: list[float] = field(default_factory=lambda: [0.0] * 6, init=False, repr=False)
    _force_integral: float = field(default=0.0, init=False, repr=False)
    _contact: float = field(default=0.0, init=False, repr=False)
    _sunk: float = field(default=0.0, init=False, repr=False)
    _t: float = field(default=0.0, init=False, repr=False)

    def __post_init__(self) -> None:
        for name in ("position_frequency", "orientation_frequency", "damping_ratio", "fade_time"):
            if not getattr(self, name) > 0.0:
                raise InputError(f"ForceMotion: {name} = {getattr(self, name)}; expected more than 0")
        kp = np.repeat([self.position_frequency**2, self.orientation_frequency**2], 3)
        self._kp = kp.tolist()
        self._kd = (2.0 * self.damping_ratio * np.sqrt(kp)).tolist()
        self._ki = (kp * np.repeat([self.position_integral, self.orientation_integral], 3)).tolist()

    def reset(self, arm: Dynamics) -> None:
        """Clear the integrals and the contact.

        Raises:
            InputError: if nothing has estimated the contact wrench.
        """
        if arm.F is None:
            raise InputError("ForceMotion needs a contact wrench; give the rig a WristSense or a JointSense")
        self._integral = [0.0] * 6
        self._force_integral = 0.0
        self._contact = 0.0
        self._sunk = 0.0
        self._t = arm.t

    def torque(self, arm: Dynamics, reference: ToolReference) -> Array:
        """Joint torques [N·m], (n,), gravity included."""
        need_tool_reference(self, reference)
        dt, self._t = arm.t - self._t, arm.t
        # In plain floats: six numbers at a time they are twice as fast as arrays.
        e = [*(reference.p - arm.p).tolist(), *continuous_error_of(arm.R, reference.R)]
        slip = (reference.v - arm.v).tolist()
        most = self.integral_acceleration
        grown = (i + dt * k * x for i, k, x in zip(self._integral, self._ki, e, strict=True))
        self._integral = [most if i > most else -most if i < -most else i for i in grown]
        gains = zip(self._kd, slip, self._kp, e, self._integral, strict=True)
        feedback = [d * s + k * x + i for d, s, k, x, i in gains]
        held = NOTHING
        if reference.normal is not None and arm.F is not None:
            held = self._force(arm.F.tolist(), slip, feedback, reference, dt)
        Lambda = arm.Lambda
        wrench = Lambda.dot(reference.a - arm.dJdq + np.array(feedback)) + held
        tau = wrench.dot(arm.J) + arm.h + arm.g
        if self.friction is not None:
            planned = arm.J_bar.dot(reference.v)
            # Next to a singularity J̄ v_d is a speed that no joint will have, and its friction not to be compensated.
            close = SINGULAR_MOBILITY**2 * float(np.vdot(Lambda, Lambda))
            tau += self.friction_share / (1.0 + close**4) * self.friction.torque(planned)
        return np.asarray(tau)

    def _force(
        self, F: list[float], slip: list[float], feedback: list[float], reference: ToolReference, dt: float
    ) -> tuple[float, ...]:
        """Wrench on the surface [N, N·m], (6,); takes what is then not theirs from the feedback and its integral."""
        assert reference.normal is not None, "asked only where something is pressed"
        n, v = reference.normal.tolist(), reference.v.tolist()
        c, press = self._press(_along(n, F), reference.force, dt)
        seek = self._seek(c, dt)
        # What the surface holds is not for the integral to gather: the normal turns along the path.
        gathered = c * _along(n, self._integral)
        # Along n nothing is asked by position, but for the path's own acceleration and what is left of c.
        asked = seek + c * (_along(n, feedback) - seek)
        for i in range(3):
            self._integral[i] -= gathered * n[i]
            feedback[i] -= asked * n[i]
        # The friction of the tip, along the planned motion over the surface v_t = v − n (n·v).
        planned = _along(n, v)
        speed = sqrt(max(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] - planned * planned, 0.0) + STANDSTILL**2)
        drag = c * self.surface_friction * reference.force / speed
        push = c * (self.normal_damping * _along(n, slip) - press) - drag * planned
        return push * n[0] + drag * v[0], push * n[1] + drag * v[1], push * n[2] + drag * v[2], 0.0, 0.0, 0.0

    def _press(self, measured: float, wanted: float, dt: float) -> tuple[float, float]:
        """Contact confidence c and pressing force [N]."""
        touching = measured > self.contact_force
        self._contact += (float(touching) - self._contact) * (1.0 - exp(-dt / self.fade_time))
        error = wanted - measured
        if touching:
            grown = self._force_integral + dt * self.force_integral * error
            self._force_integral = min(max(grown, -self.integral_force), self.integral_force)
        return self._contact, wanted + self.force_gain * error + self._force_integral

    def _seek(self, c: float, dt: float) -> float:
        """Acceleration towards a surface that was lost [m/s²]; it sinks while c is low and rises again with contact."""
        rate = self.seek_speed * (1.0 - 2.0 * c)
        self._sunk = min(max(self._sunk + rate * dt, 0.0), self.seek_depth)
        return self.position_frequency**2 * self._sunk


def _along(n: list[float], v: list[float]) -> float:
    """n · v of the first three numbers."""
    return n[0] * v[0] + n[1] * v[1] + n[2] * v[2]
