"""`Supervisor`: the last word on every torque; it softens, clamps, and once it has tripped it holds the arm."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf, isfinite, sqrt

import numpy as np
from numpy.typing import NDArray

from burnish.core import Array, Dynamics
from burnish.inverse import damped_spd_inverse
from burnish.runtime.guards import JUMP, NEARLY, SLOW, Guards, finite, mobility
from burnish.runtime.limits import Limits as Limits
from burnish.runtime.machine import Cause, Machine, Mode
from burnish.runtime.machine import Event as Event
from burnish.runtime.swing import Swing

SHORTEST, LONGEST = 1e-4, 0.5
"""Shortest and longest time between two readings that is believed in a hold [s]."""
STEADY, SHAKY = 0.95, 0.4
"""Share of the nominal period that the rate clamp goes by at most: a period may be that short, and a clock may lie; and
after a cycle without a time of its own, or where the clock leaps: of such a cycle nobody knows how long it was."""
LEAP = 0.05
"""Time between two readings from which the clock counts as leaping [s]; never less than two periods."""
ABRUPT = 30.0
"""Acceleration up to which a joint's speed is believed in a hold [rad/s²]; more is a reading that has moved, not the
arm. The largest deviation from gravity gives the JACO2's joints 15 to 34."""
SINGULAR = 1e-3
"""Smallest eigenvalue of J Jᵀ below which the way back is damped."""
BRAKE = 10.0
"""Deceleration of a joint or the tool by the speed that is too much [1/s]; slow against the cycles of any loop."""
PUSH_BACK = 25.0
"""Acceleration away from a joint limit by the way inside the soft margin [1/s²]."""
GENTLY = 0.7
"""Share of a joint's speed limit that the way back from too much force may ask for."""


@dataclass(kw_only=True)
class Supervisor(Machine):
    """Checks every state and every torque between the law and the robot.

    Order: finite state and clock → length → freshness → plausible, joint speed → position, work space, self-collision →
    tool force, tool speed, energy → finite torque → soft limits → absolute clamp → rate clamp → joint speed ahead.

    Near a limit the torque is softened first: a joint or a tool that is fast is braked, a joint near its limit is
    pushed back. A trip latches: from then on every torque is the safe one, ``g − D q̇ + K (q₀ − q)`` about the joint
    positions of that instant; after too much tool force q₀ lies a little way back along the force. Speeds are then
    those of the positions, a joint whose reading has jumped is left to its weight, and one that swings all the more is
    held the softer. No exception leaves it, and nothing but `acknowledge` or `reset` ends it; `Machine` has the
    states that there are.
    """

    limits: Limits
    period: float | None = None
    """Nominal time between two samples [s]; with it, cycles that come late are noticed."""
    clamped: int = field(default=0, init=False)
    """Cycles in which a torque was clamped."""
    softened: int = field(default=0, init=False)
    """Cycles in which a joint or the tool was braked, or a joint pushed back from its limit."""
    _guards: Guards = field(init=False, repr=False)
    _hold: Array = field(default_factory=lambda: np.zeros(0), init=False, repr=False)
    _swing: Swing = field(init=False, repr=False)
    sound: bool = field(default=True, init=False)
    """Whether the last measurement passed its checks."""
    _wanted: Cause | None = field(default=None, init=False, repr=False)
    """Why somebody wants the arm held."""
    _read: Array | None = field(default=None, init=False, repr=False)
    """Last reading of each joint's position."""
    _speed: Array = field(init=False, repr=False)
    """The joints' speeds as they were last believed [rad/s]."""
    _jumps: Array = field(init=False, repr=False)
    """What the joints have jumped since the arm was stopped [rad]."""
    _weight: Array = field(default_factory=lambda: np.zeros(0), init=False, repr=False)
    _last: list[float] | None = field(default=None, init=False, repr=False)
    _timed: bool = field(default=True, init=False, repr=False)
    _step: float = field(default=0.0, init=False, repr=False)
    """Change of torque that this cycle allows [N·m]."""

    def __post_init__(self) -> None:
        super().__post_init__()
        self._guards = Guards(limits=self.limits, period=self.period)
        low, high = self.limits.within(self.limits.soft_margin, 0.1)
        slow = SLOW * self.limits.speed
        self._most, self._off = self.limits.torque.tolist(), self.limits.deviation.tolist()
        self._free, self._jumps = [inf] * len(self._most), np.zeros(len(self._most))
        self._none = self._speed = self._jumps
        self._longest = LONGEST if self.period is None else STEADY * self.period
        self._leap = inf if self.period is None else max(LEAP, 2.0 * self.period)
        self._shaky = SHORTEST if self.period is None else SHAKY * self.period
        self._soft_rows = list(zip(low.tolist(), high.tolist(), slow.tolist(), strict=True))

    def filter(self, arm: Dynamics, torque: Array) -> Array:
        """The torque that may be sent [N·m], (n,)."""
        guards = self._guards
        cause = guards.state(arm)
        self.sound = cause is None
        timed, self._timed = self._timed, guards.fresh
        period = arm.t - self._told if isfinite(arm.t) and isfinite(self._told) else 0.0
        # A clock that stands, or is no number, allows what the shortest period would.
        longest = self._longest if timed and period < self._leap else self._shaky
        self._step = self.limits.torque_rate * min(max(period, SHORTEST), longest)
        cause, self._wanted = cause or self._wanted, None
        if cause is None and self.mode is Mode.TORQUE:
            cause = guards.command(torque)
            if cause is None:
                soft = torque if guards.calm else self._soften(arm, torque)
                sent = self._clamp(arm, soft)
                tau = np.array(sent)
                cause = guards.ahead(arm, tau, period)
                if cause is None:
                    self._read, self._speed, self._jumps = arm.q, arm.dq, self._none
                    self._weight, self._last = arm.g, sent
                    self.passed(arm.t)
                    return tau
        self._last = self._clamp(arm, self._safe(arm, cause, period))
        return np.array(self._last)

    def stop(self, reason: str) -> None:
        """Hold the arm from the next cycle on, for what no measurement shows: whoever commands it is gone, say."""
        self._wanted = Cause(reason)

    def reset(self, seen: Event) -> None:
        """Somebody has read ``seen``, the very event that is shown: out of a fault the supervisor is as new."""
        super().reset(seen)
        if not self.tripped:
            self._guards = Guards(limits=self.limits, period=self.period)

    def _soften(self, arm: Dynamics, torque: Array) -> Array:
        """The torque with what brakes a fast joint or tool, and what pushes a joint back from its limit."""
        limits, soft = self.limits, []
        near = (limits.self_slow - self._guards.distance) / (limits.self_slow - limits.self_stop)
        near = between(near, 0.0, 1.0)
        for q, dq, (low, high, slow) in zip(arm.q.tolist(), arm.dq.tolist(), self._soft_rows, strict=True):
            over, inside = dq - between(dq, -slow, slow), q - between(q, low, high)
            soft.append(-BRAKE * (over + near * dq) - PUSH_BACK * inside)
        hurry = self._guards.hurry
        if not (hurry or any(soft)):
            return torque
        self.softened += 1
        # As an acceleration: a spring or a damper that suits the shoulder would shake the wrist.
        tau = np.asarray(torque + arm.M.dot(np.array(soft)))
        return self._slowed(arm, tau, hurry) if hurry else tau

    def _slowed(self, arm: Dynamics, tau: Array, hurry: float) -> Array:
        """The torque that speeds the tool up the less, the faster it is; not at all at what is allowed."""
        v = arm.v[:3]
        speed = sqrt(float(v.dot(v)))
        ddq, lightness = mobility(arm, v)
        if lightness <= 0.0:
            return tau
        faster = max(0.0, float(ddq.dot(tau - arm.h - arm.g)))
        less = hurry * (faster + BRAKE * (1.0 - NEARLY) * speed)
        return np.asarray(tau - v.dot(arm.J[:3]) / speed * (less / lightness))

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
        way = arm.J.T @ (damped_spd_inverse(arm.J @ arm.J.T, SINGULAR) @ back)
        # The spring and the damper of the hold bring a joint up to K/D of what it has to go.
        most = GENTLY * self.limits.speed * self.limits.damping / self.limits.stiffness
        return np.asarray(way / max(1.0, float((np.abs(way) / most).max())))

    def _safe(self, arm: Dynamics, cause: Cause | None, period: float) -> Array:
        """g − D q̇ + K (q₀ − q) of the joints whose reading can be believed; of the others their last weight alone."""
        limits = self.limits
        q, dq, trusted = self._believed(arm, period)
        seen, jumped = bool(trusted.all()), self._jumped()
        stopped = self.note(arm.t, dq, cause or jumped, seen)
        if stopped or len(self._hold) == 0:
            # What was never seen has no place to be held at, and gets its weight.
            self._hold = q + self._way_back(arm) if seen and stopped else q - self._jumps
            self._swing = Swing(share=np.ones(len(limits.torque)))
        if seen and finite(arm.g) and jumped is None:
            self._weight = arm.g
        if len(self._weight) == 0:
            return np.zeros(len(limits.torque)) if self._last is None else np.array(self._last)
        if self.mode not in (Mode.HOLD, Mode.FAULT):
            # Not in torque mode: wherever it is taken, there is nothing to pull it back to.
            return self._weight
        held = self._swing.at(dq) * (limits.stiffness * (self._hold - q) - limits.damping * dq)
        return np.asarray(self._weight + np.where(trusted & np.isfinite(held), held, 0.0))

    def _believed(self, arm: Dynamics, period: float) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Position [rad] and speed [rad/s] of each joint, and whether they can be believed, (n,).

        A step that no joint can make in the time is a jump of its reading, and until it jumps back nothing that it
        says is believed: it may as well be in degrees. A smaller one damps no harder than the arm can have sped up.
        """
        n = len(self.limits.torque)
        new = np.isfinite(arm.q) if self._guards.fresh and arm.q.shape == (n,) else np.zeros(n, dtype=bool)
        if self._read is None:
            if not new.all():
                return np.full(n, np.nan), np.zeros(n), new
            self._read = arm.q
        reading = np.where(new, arm.q, self._read) if new.any() else self._read
        step, self._read = reading - self._read, reading
        time = min(max(period, SHORTEST), LONGEST)
        jumped = np.abs(step) > JUMP + 2.0 * self.limits.speed * time
        self._jumps = self._jumps + np.where(jumped, step, 0.0)
        change = np.where(jumped, 0.0, step / time) - self._speed
        self._speed = self._speed + change.clip(-ABRUPT * time, ABRUPT * time)
        return reading, self._speed, new & (np.abs(self._jumps) <= JUMP)

    def _jumped(self) -> Cause | None:
        """A joint whose reading has jumped and not come back: nobody may simply go on."""
        off = np.abs(self._jumps)
        if not (off > JUMP).any():
            return None
        joint = int(off.argmax())
        return Cause(f"joint {joint + 1} reads {np.degrees(self._jumps[joint]):.1f}° off since it jumped", fault=True)

    def _clamp(self, arm: Dynamics, wanted: Array) -> list[float]:
        """Deviation from gravity, absolute clamp and rate clamp; counts the cycles in which something was cut."""
        asked = wanted.tolist()
        # Gravity of a broken state is no centre to stay near, and without an earlier torque there is no rate.
        weight, off = (arm.g.tolist(), self._off) if finite(arm.g) else (asked, self._free)
        step = inf if self._last is None else self._step
        sent = []
        for tau, g, near, most, last in zip(asked, weight, off, self._most, self._last or asked, strict=True):
            if abs(tau - g) > near:
                tau = g + near if tau > g else g - near
            tau = -most if tau < -most else most if tau > most else tau
            sent.append(last - step if tau < last - step else last + step if tau > last + step else tau)
        self.clamped += sent != asked
        return sent


def between(value: float, low: float, high: float) -> float:
    """The value, or the bound that it is beyond; what is no number stays none, for whoever checks it."""
    return low if value < low else high if value > high else value
