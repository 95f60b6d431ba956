"""`Supervisor`: the last word on every torque; it clamps, and once it has tripped it stays tripped."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf, isfinite, sqrt

import numpy as np

from burnish.core import Array, Dynamics, read_only
from burnish.errors import InputError
from burnish.inverse import damped_spd_inverse
from burnish.model.model import Model

SHORTEST = 1e-4
"""Shortest time step that the rate clamp believes in [s]."""
SINGULAR = 1e-3
"""Smallest eigenvalue of J Jᵀ below which the way back is damped."""


@dataclass(frozen=True, kw_only=True)
class Limits:
    """What no command and no state may exceed."""

    torque: Array
    """Largest joint torque [N·m], (n,)."""
    torque_rate: float = 300.0
    """Largest change of a joint torque [N·m/s]."""
    speed: Array
    """Joint speed at which the arm is stopped [rad/s], (n,)."""
    tool_force: float = 25.0
    """Contact force at which the tool retreats [N]."""
    stiffness: Array
    """Of the hold after a trip [N·m/rad], (n,)."""
    damping: Array
    """Of the hold after a trip [N·m·s/rad], (n,)."""
    retreat: float = 0.02
    """Distance by which the tool retreats along the contact force after too much of it [m]."""

    def __post_init__(self) -> None:
        for name in ("torque", "speed", "stiffness", "damping"):
            object.__setattr__(self, name, read_only(getattr(self, name)))
        for name, value in vars(self).items():
            if not (np.all(np.isfinite(value)) and np.all(np.asarray(value) > 0.0)):
                raise InputError(f"limits: {name} = {value}; expected finite numbers more than 0")

    @classmethod
    def of(cls, model: Model) -> Limits:
        """The description's torque and speed limits, and a soft hold scaled to the joints' torque.

        The hold is 120/25 N·m/rad and 12/3 N·m·s/rad on the JACO2: stiff enough to carry an unknown kilogram
        within 50 mm, soft enough to give way to a hand.
        """
        strong = model.effort_limit > 0.5 * model.effort_limit.max()
        return cls(
            torque=model.effort_limit,
            speed=model.velocity_limit,
            stiffness=np.where(strong, 120.0, 25.0),
            damping=np.where(strong, 12.0, 3.0),
        )


@dataclass(frozen=True, kw_only=True)
class Event:
    """Why and when the supervisor tripped."""

    t: float
    """Time [s]."""
    cause: str
    """What was found, and the limit."""


@dataclass(kw_only=True)
class Supervisor:
    """Checks every state and every torque between the law and the robot.

    Order: finite state and clock → joint speed → tool force → finite torque → absolute clamp → rate clamp.

    A trip latches: from then on every torque is the safe one, ``g − D q̇ + K (q₀ − q)`` about the joint positions of
    that instant; after too much tool force q₀ lies a little way back along the force. No exception leaves it, nothing
    resets it. Joint by joint in plain floats: for six numbers that is faster than arrays.
    """

    limits: Limits
    event: Event | None = field(default=None, init=False)
    """The trip, or None."""
    clamped: int = field(default=0, init=False)
    """Cycles in which a torque was clamped."""
    _hold: Array = field(default_factory=lambda: np.zeros(0), init=False, repr=False)
    _seen: Array | None = field(default=None, init=False, repr=False)
    _last: list[float] | None = field(default=None, init=False, repr=False)
    _t: float = field(default=-inf, init=False, repr=False)

    @property
    def tripped(self) -> bool:
        """Whether the supervisor has stopped the arm."""
        return self.event is not None

    def filter(self, arm: Dynamics, torque: Array) -> Array:
        """The torque that may be sent [N·m], (n,)."""
        if self.event is None:
            cause = self._cause(arm, torque)
            if cause is None:
                self._seen = arm.q
            else:
                self._trip(arm, cause)
        if self.event is not None:
            torque = self._safe(arm)
        return self._clamp(arm, torque)

    def _cause(self, arm: Dynamics, torque: Array) -> str | None:
        limits = self.limits
        if not (isfinite(arm.t) and _finite(arm.q) and _finite(arm.dq)):
            return "the measured state is not finite"
        for speed, limit in zip(arm.dq.tolist(), limits.speed.tolist(), strict=True):
            if not -limit <= speed <= limit:
                joint = 1 + int(np.argmax(np.abs(arm.dq) / limits.speed))
                return f"joint {joint} moved at {abs(speed):.2f} rad/s; the limit is {limit:.2f} rad/s"
        if arm.F is not None:
            fx, fy, fz, *_ = arm.F.tolist()
            force = sqrt(fx * fx + fy * fy + fz * fz)
            if not force <= limits.tool_force:
                return f"the tool force reached {force:.1f} N; the limit is {limits.tool_force:.0f} N"
        if torque.shape != limits.torque.shape:
            return f"the control law gave a torque of shape {torque.shape}; expected {limits.torque.shape}"
        if not _finite(torque):
            return "the control law gave a torque that is not finite"
        return None

    def _trip(self, arm: Dynamics, cause: str) -> None:
        self.event = Event(t=arm.t, cause=cause)
        if _finite(arm.q):
            self._hold = arm.q + self._way_back(arm)
        elif self._seen is not None:
            self._hold = self._seen

    def _way_back(self, arm: Dynamics) -> Array:
        """Joint motion that takes the tool off along too large a contact force [rad], (n,); else none."""
        if arm.F is None or not _finite(arm.F) or not _finite(arm.J.ravel()):
            return np.zeros(len(arm.q))
        force = arm.F[:3]
        size = sqrt(float(force @ force))
        if size <= self.limits.tool_force:
            return np.zeros(len(arm.q))
        back = np.concatenate([self.limits.retreat * force / size, np.zeros(3)])
        # Not by Λ: this must work with whatever mass matrix there is.
        return np.asarray(arm.J.T @ (damped_spd_inverse(arm.J @ arm.J.T, SINGULAR) @ back))

    def _safe(self, arm: Dynamics) -> Array:
        limits = self.limits
        if len(self._hold) != len(arm.q) and _finite(arm.q):
            # Tripped before anything was seen: hold the first position that can be believed.
            self._hold = arm.q
        if len(self._hold) == len(arm.q):
            safe = arm.g - limits.damping * arm.dq + limits.stiffness * (self._hold - arm.q)
            if _finite(safe):
                return np.asarray(safe)
        # The state itself is broken: the last torque that was sent is the best guess of the arm's weight.
        return np.zeros(len(limits.torque)) if self._last is None else np.array(self._last)

    def _clamp(self, arm: Dynamics, torque: Array) -> Array:
        limits = self.limits
        asked = torque.tolist()
        sent = [_between(tau, -most, most) for tau, most in zip(asked, limits.torque.tolist(), strict=True)]
        if self._last is not None:
            # A clock that stands, or is no number, allows what the shortest period would.
            period = arm.t - self._t if isfinite(arm.t) and isfinite(self._t) else 0.0
            step = limits.torque_rate * max(period, SHORTEST)
            sent = [_between(tau, old - step, old + step) for tau, old in zip(sent, self._last, strict=True)]
        if sent != asked:
            self.clamped += 1
        self._last = sent
        if isfinite(arm.t):
            self._t = arm.t
        return np.array(sent)


def _finite(values: Array) -> bool:
    """Whether all values are finite."""
    return all(map(isfinite, values.tolist()))


def _between(value: float, low: float, high: float) -> float:
    """The value, or the bound that it is beyond."""
    return low if value < low else high if value > high else value
