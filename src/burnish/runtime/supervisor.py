"""`Supervisor`: the last word on every torque; it softens, clamps, and once it has tripped it holds the arm."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from math import inf, isfinite, sqrt

import numpy as np
from numpy.typing import NDArray

from burnish.core import Array, Dynamics
from burnish.inverse import damped_spd_inverse
from burnish.runtime.guards import BELIEVABLE_SPEED, SLOW, Cause, Guards, finite
from burnish.runtime.limits import Limits as Limits

SHORTEST = 1e-4
"""Shortest time step that the rate clamp believes in [s]."""
SINGULAR = 1e-3
"""Smallest eigenvalue of J Jᵀ below which the way back is damped."""
BRAKE = 10.0
"""Deceleration of that brake by the speed above the share [1/s]; slow against the cycles of any loop."""
PUSH_BACK = 25.0
"""Acceleration away from a joint limit by the way inside the soft margin [1/s²]."""
FAR = 0.5
"""Way from where a joint was last seen beyond which its reading is no longer believed in a hold [rad]."""
CLEAR_FOR = 1.0
"""Time without a cause after which a hold may be acknowledged [s]."""
TOO_OFTEN, WITHIN = 3, 60.0
"""Holds within this time [s] that make a fault."""


class Mode(Enum):
    """What the supervisor lets through."""

    TORQUE = "torque"
    """The law's torque, softened and clamped."""
    HOLD = "hold"
    """The safe torque, until somebody acknowledges."""
    FAULT = "fault"
    """The safe torque, until somebody has read the cause and resets."""


@dataclass(frozen=True, kw_only=True)
class Event:
    """Why and when the supervisor tripped."""

    t: float
    """Time [s]."""
    cause: str
    """What was found, and the limit."""
    fault: bool = False
    """Whether it was a fault."""


@dataclass(kw_only=True)
class Supervisor:
    """Checks every state and every torque between the law and the robot.

    Order: finite state and clock → length → freshness → plausible, joint speed → position, work space → tool force,
    tool speed, energy → finite torque → soft limits → absolute clamp → rate clamp → joint speed ahead.

    Near a limit the torque is softened first: a joint that is fast is braked, one near its limit is pushed back. A trip
    latches: from then on every torque is the safe one, ``g − D q̇ + K (q₀ − q)`` about the joint positions of that
    instant; after too much tool force q₀ lies a little way back along the force. No exception leaves it, and nothing
    but `acknowledge` or `reset` ends it.
    """

    limits: Limits
    period: float | None = None
    """Nominal time between two samples [s]; with it, cycles that come late are noticed."""
    mode: Mode = field(default=Mode.TORQUE, init=False)
    """What is let through."""
    event: Event | None = field(default=None, init=False)
    """The trip that holds the arm, or None."""
    clamped: int = field(default=0, init=False)
    """Cycles in which a torque was clamped."""
    softened: int = field(default=0, init=False)
    """Cycles in which a joint was braked or pushed back from its limit."""
    _guards: Guards = field(init=False, repr=False)
    _hold: Array = field(default_factory=lambda: np.zeros(0), init=False, repr=False)
    _seen: Array | None = field(default=None, init=False, repr=False)
    _weight: Array = field(default_factory=lambda: np.zeros(0), init=False, repr=False)
    _last: list[float] | None = field(default=None, init=False, repr=False)
    _t: float = field(default=-inf, init=False, repr=False)
    _clear_since: float = field(default=inf, init=False, repr=False)
    _holds: list[float] = field(default_factory=list, init=False, repr=False)

    def __post_init__(self) -> None:
        self._guards = Guards(limits=self.limits, period=self.period)
        low, high = self.limits.within(self.limits.soft_margin, 0.1)
        slow = SLOW * self.limits.speed
        self._most, self._off = self.limits.torque.tolist(), self.limits.deviation.tolist()
        self._free = [inf] * len(self._most)
        self._soft_rows = list(zip(low.tolist(), high.tolist(), slow.tolist(), strict=True))

    @property
    def tripped(self) -> bool:
        """Whether the supervisor has stopped the arm."""
        return self.event is not None

    def filter(self, arm: Dynamics, torque: Array) -> Array:
        """The torque that may be sent [N·m], (n,)."""
        cause = self._guards.state(arm)
        period = arm.t - self._t if isfinite(arm.t) and isfinite(self._t) else 0.0
        if cause is None and self.event is None:
            cause = self._guards.command(torque)
        if cause is None and self.event is None:
            soft = torque if self._guards.calm else self._soften(arm, torque)
            sent = self._clamp(arm, soft, period)
            tau = np.array(sent)
            cause = self._guards.ahead(arm, tau, period)
            if cause is None:
                self._seen, self._weight = arm.q, arm.g
                self._note_sent(arm, sent)
                return tau
        self._note(arm, cause)
        safe = self._safe(arm)
        sent = self._clamp(arm, safe, period)
        self._note_sent(arm, sent)
        return np.array(sent)

    def acknowledge(self) -> str | None:
        """Somebody has seen why the arm is held, and lets the law go on; says what stands against it, or None."""
        if self.mode is not Mode.HOLD:
            return None if self.mode is Mode.TORQUE else "this is a fault: read its cause and reset"
        if not self._t - self._clear_since >= CLEAR_FOR:
            return f"the cause has not been clear for {CLEAR_FOR:g} s"
        self.mode, self.event = Mode.TORQUE, None
        return None

    def reset(self, seen: Event) -> None:
        """Somebody has read ``seen``, the event that holds the arm: the supervisor is as new."""
        if seen is self.event:
            self.mode, self.event = Mode.TORQUE, None
            self._guards, self._holds = Guards(limits=self.limits, period=self.period), []

    def _note(self, arm: Dynamics, cause: Cause | None) -> None:
        """Latch a cause; while the arm is held, remember since when there is none."""
        if self.event is None and cause is not None:
            self._holds = [t for t in self._holds if self._t - t < WITHIN] + [self._t]
            fault = cause.fault or len(self._holds) >= TOO_OFTEN
            self.mode = Mode.FAULT if fault else Mode.HOLD
            self.event = Event(t=arm.t, cause=cause.text, fault=fault)
            trusted = self._trusted(arm)
            if trusted.all():
                self._hold = arm.q + self._way_back(arm)
            elif self._seen is not None:
                self._hold = np.where(trusted, arm.q, self._seen)
        elif cause is not None and cause.fault and self.mode is Mode.HOLD:
            self.mode = Mode.FAULT
            self.event = Event(t=arm.t, cause=cause.text, fault=True)
        if cause is not None:
            self._clear_since = inf
        elif self._clear_since == inf:
            self._clear_since = arm.t

    def _soften(self, arm: Dynamics, torque: Array) -> Array:
        """The torque with what brakes a fast joint, and what pushes one back from its limit."""
        soft = []
        for q, dq, (low, high, slow) in zip(arm.q.tolist(), arm.dq.tolist(), self._soft_rows, strict=True):
            over, inside = dq - between(dq, -slow, slow), q - between(q, low, high)
            soft.append(-BRAKE * over - PUSH_BACK * inside)
        if not any(soft):
            return torque
        self.softened += 1
        # As an acceleration: a spring or a damper that suits the shoulder would shake the wrist.
        return np.asarray(torque + arm.M.dot(np.array(soft)))

    def _way_back(self, arm: Dynamics) -> Array:
        """Joint motion that takes the tool off along too large a contact force [rad], (n,); else none."""
        if arm.F is None or not finite(arm.F) or not finite(arm.J.ravel()):
            return np.zeros(len(arm.q))
        force = arm.F[:3]
        size = sqrt(float(force @ force))
        if size <= self.limits.tool_force:
            return np.zeros(len(arm.q))
        back = np.concatenate([self.limits.retreat * force / size, np.zeros(3)])
        # Not by Λ: this must work with whatever mass matrix there is.
        return np.asarray(arm.J.T @ (damped_spd_inverse(arm.J @ arm.J.T, SINGULAR) @ back))

    def _safe(self, arm: Dynamics) -> Array:
        """g − D q̇ + K (q₀ − q) of the joints whose reading can be believed; of the others their last weight alone."""
        limits, trusted = self.limits, self._trusted(arm)
        whole = bool(trusted.all()) and finite(arm.g)
        if whole:
            # If it tripped before anything was seen, the first position that can be believed is held.
            self._hold, self._weight = self._hold if len(self._hold) else arm.q, arm.g
        if len(self._hold) == 0 or len(self._weight) == 0:
            return np.zeros(len(limits.torque)) if self._last is None else np.array(self._last)
        q, dq = np.where(trusted, arm.q, self._hold), np.where(trusted, arm.dq, 0.0)
        return np.asarray(self._weight - limits.damping * dq + limits.stiffness * (self._hold - q))

    def _trusted(self, arm: Dynamics) -> NDArray[np.bool_]:
        """Which joints' position and speed can be believed: new, finite, no faster and no further off than possible."""
        n = len(self.limits.torque)
        if not (self._guards.fresh and arm.q.shape == arm.dq.shape == (n,)):
            return np.zeros(n, dtype=bool)
        near = arm.q if self._seen is None else self._seen
        with np.errstate(invalid="ignore"):
            return np.asarray((np.abs(arm.dq) < BELIEVABLE_SPEED) & (np.abs(arm.q - near) < FAR))

    def _clamp(self, arm: Dynamics, wanted: Array, period: float) -> list[float]:
        """Deviation from gravity, absolute clamp and rate clamp; counts the cycles in which something was cut."""
        asked = wanted.tolist()
        # Gravity of a broken state is no centre to stay near, and without an earlier torque there is no rate.
        weight, off = (arm.g.tolist(), self._off) if finite(arm.g) else (asked, self._free)
        # A clock that stands, or is no number, allows what the shortest period would.
        step = inf if self._last is None else self.limits.torque_rate * max(period, SHORTEST)
        sent = []
        for tau, g, near, most, last in zip(asked, weight, off, self._most, self._last or asked, strict=True):
            if abs(tau - g) > near:
                tau = g + near if tau > g else g - near
            tau = -most if tau < -most else most if tau > most else tau
            sent.append(last - step if tau < last - step else last + step if tau > last + step else tau)
        self.clamped += sent != asked
        return sent

    def _note_sent(self, arm: Dynamics, sent: list[float]) -> None:
        self._last = sent
        if isfinite(arm.t):
            self._t = max(arm.t, self._t)


def between(value: float, low: float, high: float) -> float:
    """The value, or the bound that it is beyond; what is no number stays none, for whoever checks it."""
    return low if value < low else high if value > high else value
