"""`ForceMotion`: hold a force along the surface normal while moving over the surface."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import exp, sqrt
from operator import mul

import numpy as np

from burnish.control.checks import need_tool_reference
from burnish.control.gears import LearntFriction
from burnish.control.tank import EnergyTank
from burnish.core import SINGULAR_MOBILITY, Array, Dynamics, ToolReference
from burnish.errors import InputError
from burnish.model.friction import Friction
from burnish.model.spin import SpinningTip
from burnish.rotation import continuous_error_of

STANDSTILL = 2e-3
"""Planned speed below which the friction of the tip is no longer fed forward in full [m/s]."""
Wrench = tuple[float, float, float, float, float, float]
BLEND = 1e-4
"""Way at both ends of seeking over which its friction is blended in [m]: 20 ms of it."""
SOFT_TIP = 12e3
"""Stiffness of the tip for which the gains along the normal are tuned [N/m]."""
RISE = 10.0
"""Rate of the set force from which the friction of pressing is compensated in full [N/s]."""
FELT = 100e3
"""Stiffness of felt on steel, behind every tip [N/m]."""
NOTHING: Wrench = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""No wrench [N, N·m]."""


@dataclass(kw_only=True)
class ForceMotion:
    """Operational-space motion along the surface and in orientation, force along its normal.

        a   = a_d + K_d (v_d − v) + K_p e + K_i ∫e,     e = [p_d − p; θu]
        f   = f_d + k_f (f_d − f_n) + k_i ∫(f_d − f_n)                     (pressing, along −n)
        τ   = Jᵀ [ Λ (P a − J̇q̇) − n (c f + D_n v_n) + c µ f_d v̂_t ] + h + g + τ_friction(q̇_d)

    with f_n = n·F the measured contact force, P = I − c n nᵀ on the linear part, and c in [0, 1] the confidence
    that the tool touches. It fades to 0 when the force is lost: the normal direction is then held by position like
    the others, so the tool does not lunge, and looks for the surface a few millimetres down at the speed of a guarded
    approach. Without a normal in the reference c = 0: pure motion. τ_friction is compensated at the **planned** joint
    speed q̇_d = J̄ (v_d + T a_d), which neither noise nor stiction disturbs, and as it will be when the torque acts, T
    from now: where a joint turns round its friction does so at once. A `LearntFriction` learns its size on the way, and
    keeps it over a `reset`. While f_d rises or falls v_d has a part along −n or n, because the joints have to give the
    tip its way and would stick. With `spinning` the drag of a tip that a spindle turns, at the planned motion and tilt,
    takes the place of −µ f_d v̂_t.

    A reference may ask for a share s of the stiffness, to be softer at an edge say: K_p becomes s K_p and K_d √s K_d,
    so the damping ratio stays. s above 1 wants a loop that is fast enough for it.

    Force and integrals are not passive. At the velocity against the reference, ṽ = v − v_d, they put in the power P,
    and the dampers along the surface and in orientation take D out:

        P = ṽᵀ (Λ P K_i ∫e − n c f),    D = ṽᵀ Λ P K_d ṽ,    ∫ α P dt  ≤  tank + ∫ max(D, 0) + supply dt

    at every instant, because both terms are scaled by the α of an `EnergyTank`. With Λ constant the stored energy
    ½ ṽᵀΛṽ + ½ eᵀΛK_p e so grows by no more than `tank`, `supply` and what the contact does to the tool; friction eats
    the supply, and without it would empty the tank in a pass of a quarter of an hour. Not counted is what belongs to
    the reference: a_d, seeking, and both frictions at the planned motion; learning adds a bounded energy. D_n refills
    nothing, so with D_n in full the tool lunges no farther than tank/f into what gives way, and then creeps on
    √(supply/D_n); where `normal_rate` bounds D_n, on a light arm, it goes farther. With energy left, α is 1. `reset`
    fills the tank.

    Gravity is included. Source: the operational-space law of the blog (Khatib), thesis B ch. 4 for the impedance
    along the surface; force along the normal, its fading and the friction feed-forward are ours.
    """

    position_frequency: float = 14.0
    """Natural frequency of the position along the surface [rad/s]; K_p = ω²."""
    orientation_frequency: float = 14.0
    """Natural frequency of the orientation [rad/s]."""
    damping_ratio: float = 1.0
    """Of both; K_d = 2 ζ ω."""
    position_integral: float = 2.0
    """K_i/K_p of the position [1/s]."""
    orientation_integral: float = 1.0
    """K_i/K_p of the orientation [1/s]."""
    force_gain: float = 0.1
    """k_f: proportional force feedback, dimensionless."""
    force_integral: float = 8.0
    """k_i: integral force feedback [1/s]."""
    normal_damping: float = 260.0
    """D_n [N·s/m], against motion along the normal that the path does not ask for."""
    normal_rate: float = 24.0
    """Largest D_n/m [1/s], m the mass that is felt along the normal: what acts late would drive a lighter tool."""
    integral_force: float = 6.0
    """Bound of the force integral's share [N]."""
    integral_acceleration: float = 6.0
    """Bound of the motion integrals [m/s², rad/s²]."""
    friction: Friction | LearntFriction | None = None
    """Joint friction to compensate, nominal or learnt on the way; None compensates nothing."""
    friction_share: float = 1.0
    """Share of it that is compensated."""
    friction_ahead: float = 0.0
    """T, by which the planned motion is looked ahead for its friction [s]: what a torque takes until it acts."""
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
    spinning: SpinningTip | None = None
    """The tip, if a spindle turns it; None only slides."""
    tank: float = 0.3
    """Energy that force and integrals may put in beyond what they get back [J]: 10 N over 30 mm."""
    supply: float = 2e-3
    """Power that they may put in for good [W]; with an empty tank it pushes the tool into nothing at 3 to 5 mm/s."""
    _integral: list[float] = field(default_factory=lambda: [0.0] * 6, init=False, repr=False)
    _force_integral: float = field(default=0.0, init=False, repr=False)
    _contact: float = field(default=0.0, init=False, repr=False)
    _sunk: float = field(default=0.0, init=False, repr=False)
    _wanted: float | None = field(default=None, init=False, repr=False)
    _rise: float = field(default=0.0, init=False, repr=False)
    """Rate of the set force [N/s]."""
    _t: float = field(default=0.0, init=False, repr=False)

    def __post_init__(self) -> None:
        for name in ("position_frequency", "orientation_frequency", "damping_ratio", "fade_time", "tank"):
            if not getattr(self, name) > 0.0:
                raise InputError(f"ForceMotion: {name} = {getattr(self, name)}; expected more than 0")
        self._tank = EnergyTank(capacity=self.tank)
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
        self._wanted, self._rise = None, 0.0
        self._tank.fill()
        self._t = arm.t

    def against(self, stiffness: float) -> ForceMotion:
        """This law for a tip of this stiffness [N/m]: the stiffer the contact, the less D_n, k_f and k_i.

        A stiffer contact rings faster, and there what acts late no longer damps but drives: with 21 ms of dead time
        D_n turns from brake to motor at 75 rad/s, 12 Hz, and with less of a brake the integral rings sooner. D_n and
        its rate go with the inverse of the stiffness of tip and felt in series, down from that of a tip of 12 kN/m, k_f
        with its square, k_i with its root; found by trial with tips of 30 and 100 kN/m, upright and leaning.
        """
        share = min(1.0, with_felt(SOFT_TIP) / with_felt(stiffness))
        return replace(
            self,
            normal_damping=share * self.normal_damping,
            normal_rate=share * self.normal_rate,
            force_gain=share**2 * self.force_gain,
            force_integral=sqrt(share) * self.force_integral,
        )

    @property
    def energy(self) -> float:
        """What is left in the tank [J]."""
        return self._tank.level

    def torque(self, arm: Dynamics, reference: ToolReference) -> Array:
        """Joint torques [N·m], (n,), gravity included."""
        need_tool_reference(self, reference)
        dt, self._t = arm.t - self._t, arm.t
        Lambda, lag = arm.Lambda, reference.v - arm.v
        # In plain floats: six numbers at a time they are twice as fast as arrays.
        e = [*(reference.p - arm.p).tolist(), *continuous_error_of(arm.R, reference.R)]
        slip = lag.tolist()
        kp, kd = self._kp, self._kd
        if reference.stiffness != 1.0:
            root = sqrt(reference.stiffness)
            kp, kd = [reference.stiffness * k for k in kp], [root * d for d in kd]
        most, share = self.integral_acceleration, self._tank.share
        grown = (i + dt * k * x for i, k, x in zip(self._integral, self._ki, e, strict=True))
        self._integral = [most if i > most else -most if i < -most else i for i in grown]
        gains = zip(kd, slip, self._integral, strict=True)
        counted = [d * s + share * i for d, s, i in gains]
        feedback = [k * x + y for k, x, y in zip(kp, e, counted, strict=True)]
        momentum = Lambda.dot(lag).tolist()
        energy = dt * (self.supply + sum(map(mul, momentum, counted)))
        held = NOTHING
        if reference.normal is not None and arm.F is not None:
            n = reference.normal.tolist()
            c, press = self._press(_along(n, arm.F.tolist()), reference.force, dt)
            press *= c * share
            energy -= dt * (c * _along(n, momentum) * _along(n, counted) + press * _along(n, slip))
            self._leave(n, c, feedback, dt)
            held = self._held(n, c, c * self._damping(arm, reference.normal) * _along(n, slip) - press, reference)
        self._tank.add(energy)
        self._follow(reference, dt)
        wrench = Lambda.dot(reference.a - arm.dJdq + np.array(feedback)) + held
        tau = wrench.dot(arm.J) + arm.h + arm.g
        if self.friction is not None:
            planned = arm.J_bar.dot(self._meant(reference) + self.friction_ahead * reference.a)
            # Next to a singularity J̄ v_d is a speed that no joint will have, and its friction not to be compensated.
            close = SINGULAR_MOBILITY**2 * float(np.vdot(Lambda, Lambda))
            fade = 1.0 / (1.0 + close**4)
            tau += self.friction_share * fade * self.friction.torque(planned)
            if isinstance(self.friction, LearntFriction):
                self.friction.learn(planned, fade * arm.J_bar.dot(self._behind(lag, e, reference)), arm.M, dt)
        return np.asarray(tau)

    def _damping(self, arm: Dynamics, n: Array) -> float:
        """D_n [N·s/m], or what the mass along n allows, 1/m = nᵀ J M⁻¹ Jᵀ n."""
        lightness = float(n.dot(arm.J[:3]).dot(arm.Minv_JT[:, :3].dot(n)))
        return min(self.normal_damping, self.normal_rate / lightness) if lightness > 0.0 else self.normal_damping

    def _behind(self, lag: Array, e: list[float], reference: ToolReference) -> Array:
        """s = ṽ + ω e [m/s, rad/s], without what the surface holds."""
        s = lag + self.position_frequency * np.array(e)
        if reference.normal is not None:
            s[:3] -= self._contact * reference.normal.dot(s[:3]) * reference.normal
        return s

    def _follow(self, reference: ToolReference, dt: float) -> None:
        """How fast the set force rises; after free motion it begins anew."""
        before, now = self._wanted, None if reference.normal is None else reference.force
        self._wanted = now
        self._rise = 0.0 if before is None or now is None or dt <= 0.0 else (now - before) / dt

    def _meant(self, reference: ToolReference) -> Array:
        """The planned twist, and with it what stuck joints would not do: seek a surface that was lost, and press more.

        While the force shall rise the joints have to give the tip its way, and while it shall fall to take it back.
        """
        if reference.normal is None:
            return reference.v
        sinks = (1.0 - 2.0 * self._contact) * min(1.0, self._sunk / BLEND, (self.seek_depth - self._sunk) / BLEND)
        down = max(sinks, 0.0) + self._contact * min(max(self._rise / RISE, -1.0), 1.0)
        if down == 0.0:
            return reference.v
        v = reference.v.copy()
        v[:3] -= down * self.seek_speed * reference.normal
        return v

    def _leave(self, n: list[float], c: float, feedback: list[float], dt: float) -> None:
        """Take from the feedback and its integral what the surface holds."""
        seek = self._seek(c, dt)
        # What the surface holds is not for the integral to gather: the normal turns along the path.
        gathered = c * _along(n, self._integral)
        # Along n nothing is asked by position, but for the path's own acceleration and what is left of c.
        asked = seek + c * (_along(n, feedback) - seek)
        for i in range(3):
            self._integral[i] -= gathered * n[i]
            feedback[i] -= asked * n[i]

    def _held(self, n: list[float], c: float, push: float, reference: ToolReference) -> Wrench:
        """The push along n, and against the friction of the tip at the planned motion [N, N·m]."""
        v = reference.v.tolist()
        if self.spinning is not None:
            axis = reference.R[:, 2].tolist()
            (x, y, z), (mx, my, mz) = self.spinning.drag(c * reference.force, n, axis, v)
            return push * n[0] - x, push * n[1] - y, push * n[2] - z, -mx, -my, -mz
        # Along the planned motion over the surface v_t = v − n (n·v).
        planned = _along(n, v)
        speed = sqrt(max(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] - planned * planned, 0.0) + STANDSTILL**2)
        drag = c * self.surface_friction * reference.force / speed
        push -= drag * planned
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


def with_felt(stiffness: float) -> float:
    """Stiffness of a tip and the felt one behind the other [N/m]."""
    return stiffness * FELT / (stiffness + FELT)


def _along(n: list[float], v: list[float]) -> float:
    """n · v of the first three numbers."""
    return n[0] * v[0] + n[1] * v[1] + n[2] * v[2]
