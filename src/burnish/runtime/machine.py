"""`Machine`: the states of an arm between switched on and stopped, and what may lead from one to the next.

```
IDLE ──connected──▶ POSITION ──arming──▶ ARMING ──armed──▶ TORQUE
                       ▲  ▲                 │                 │ a cause
                       │  └────in_position──┘                 ▼
                       └───────in_position, once it stands── HOLD ──acknowledge──▶ TORQUE
 any ──a cause that is a fault, or the third hold in a minute──▶ FAULT ──reset──▶ IDLE
```

No clock, no arm: it is told what was measured. What arming asks of the arm is in `burnish.hardware.arming`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from math import inf, isfinite, radians
from typing import NamedTuple

from burnish.core import Array
from burnish.errors import InputError

CLEAR_FOR = 1.0
"""Time without a cause after which a hold may be acknowledged [s]."""
TOO_OFTEN, WITHIN = 3, 60.0
"""Holds within this time [s] that make a fault."""
STANDS, STANDS_FOR = radians(1.0), 0.2
"""Joint speed below which a held arm stands [rad/s], and for how long it has to [s], before it is left to itself."""
BLIND = 3
"""Cycles in a row without a reading that can be believed, after which torques cannot hold an arm."""


class Mode(Enum):
    """What an arm is in, and what is let through."""

    IDLE = "idle"
    """Nothing is known of the arm."""
    POSITION = "position"
    """The arm holds by itself; no torque is sent."""
    ARMING = "arming"
    """The arm is taken into torque mode; its weight is all that is sent."""
    TORQUE = "torque"
    """The law's torque, softened and clamped."""
    HOLD = "hold"
    """The safe torque, until somebody acknowledges."""
    FAULT = "fault"
    """The safe torque, until somebody has read the cause and resets."""


class Cause(NamedTuple):
    """Why the arm has to stop."""

    text: str
    """What was found, and the limit."""
    fault: bool = False
    """Whether nobody may simply go on."""


@dataclass(frozen=True, kw_only=True)
class Event:
    """Why and when the arm was stopped."""

    t: float
    """Time [s]."""
    cause: str
    """What was found, and the limit."""
    fault: bool = False
    """Whether it was a fault."""


@dataclass(kw_only=True)
class Machine:
    """One arm's state, and its transitions; what a state does not allow changes nothing."""

    start: Mode = Mode.TORQUE
    """Where it begins, and begins anew after a fault: `Mode.TORQUE` for an arm that takes torques from the first cycle
    on, as the simulated one, `Mode.IDLE` for one that has a position mode."""
    mode: Mode = field(init=False)
    """The state."""
    event: Event | None = field(default=None, init=False)
    """What stopped the arm, until somebody has acknowledged it; or None."""
    _now: float = field(default=0.0, init=False, repr=False)
    """Time that has passed; a clock that goes back does not turn it back [s]."""
    _told: float = field(default=-inf, init=False, repr=False)
    """The last time that was a number [s]."""
    _clear_since: float = field(default=inf, init=False, repr=False)
    _stands_since: float = field(default=inf, init=False, repr=False)
    _blind: int = field(default=0, init=False, repr=False)
    _holds: list[float] = field(default_factory=list, init=False, repr=False)

    def __post_init__(self) -> None:
        if self.start not in (Mode.IDLE, Mode.TORQUE):
            raise InputError(
                f"start = {self.start}; expected Mode.TORQUE, or Mode.IDLE for an arm with a position mode"
            )
        self.mode = self.start

    @property
    def tripped(self) -> bool:
        """Whether the arm was stopped, and nobody has acknowledged it."""
        return self.event is not None

    # What the driver says.

    def connected(self) -> None:
        """The arm answers, it is the right one, and it is in position mode."""
        if self.mode is Mode.IDLE:
            self.mode = Mode.POSITION

    def arming(self) -> str | None:
        """Somebody wants torque mode; says what stands against it, or None."""
        if self.mode is not Mode.POSITION:
            return f"the arm is in the state {self.mode.value}; torque mode is entered from position mode"
        if self.event is not None:
            return f"the arm was stopped: {self.event.cause}; acknowledge that first"
        self.mode = Mode.ARMING
        return None

    def armed(self) -> None:
        """The arm reports torque mode and has stood under its weight's torque."""
        if self.mode is Mode.ARMING:
            self.mode = Mode.TORQUE

    def in_position(self) -> None:
        """The arm reports position mode."""
        if self.mode in (Mode.ARMING, Mode.TORQUE, Mode.HOLD):
            self.mode = Mode.POSITION

    @property
    def leaves_torque(self) -> bool:
        """Whether an arm that has a position mode is to be taken there now: it stands, or nobody sees it."""
        stands = self._now - self._stands_since >= STANDS_FOR
        return self.mode in (Mode.HOLD, Mode.FAULT) and (stands or self._blind >= BLIND)

    # What a cycle finds.

    def note(self, t: float, dq: Array, cause: Cause | None, seen: bool) -> bool:
        """A cycle that is not the law's: what stops the arm, whether it stands; true if it is stopped just now.

        Args:
            t: time [s].
            dq: measured joint speeds [rad/s], (n,).
            cause: what is wrong, or None.
            seen: whether the measurement can be believed.
        """
        self.passed(t)
        stopped = cause is not None and self._stop(t, cause)
        if cause is not None:
            self._clear_since = inf
        elif self._clear_since == inf:
            self._clear_since = self._now
        if stopped or not seen or not all(abs(speed) < STANDS for speed in dq.tolist()):
            self._stands_since = inf
        elif self._stands_since == inf:
            self._stands_since = self._now
        self._blind = 0 if seen else self._blind + 1
        return stopped

    def passed(self, t: float) -> None:
        """The time goes on; a clock that stands or goes back does not turn it back."""
        if isfinite(t):
            self._now += max(t - self._told, 0.0) if isfinite(self._told) else 0.0
            self._told = t

    def _stop(self, t: float, cause: Cause) -> bool:
        """Hold or fault; true if the arm was free until now."""
        free = self.mode in (Mode.ARMING, Mode.TORQUE)
        if free:
            self._holds = [then for then in self._holds if self._now - then < WITHIN] + [self._now]
            fault = cause.fault or len(self._holds) >= TOO_OFTEN
        else:
            fault = cause.fault and self.mode is not Mode.FAULT
        if free or fault:
            self.mode = Mode.FAULT if fault else Mode.HOLD
            self.event = Event(t=t, cause=cause.text, fault=fault)
        return free

    # What an operator says.

    def acknowledge(self) -> str | None:
        """Somebody has seen why the arm is held; says what stands against going on, or None.

        An arm that was left to its position mode stays there until it is armed again.
        """
        if self.mode is Mode.FAULT:
            return "this is a fault: read its cause and reset"
        if self.event is not None and not self._now - self._clear_since >= CLEAR_FOR:
            return f"the cause has not been clear for {CLEAR_FOR:g} s"
        self.event = None
        if self.mode is Mode.HOLD:
            self.mode = Mode.TORQUE
        return None

    def reset(self, seen: Event) -> None:
        """Somebody has read ``seen``, the very event that is shown: out of a fault the machine is as new."""
        if self.mode is Mode.FAULT and seen is self.event:
            self.mode, self.event = self.start, None
            self._holds, self._clear_since, self._stands_since, self._blind = [], inf, inf, 0
