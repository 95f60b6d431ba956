"""`FaultyRobot`: a robot whose readings and commands go wrong in chosen ways at chosen times."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
from typing_extensions import Self

from burnish.core import Array, Command, Robot, State

GARBAGE = (np.nan, np.inf, -np.inf, -1.07e8)
"""What broken readings look like; the last is what a vendor's library returned with a code that said all was well."""


class Fault(Protocol):
    """One thing that goes wrong."""

    def read(self, robot: Robot, state: State) -> State:
        """What the controller gets instead of ``state``."""

    def write(self, command: Command) -> Command:
        """What the robot gets instead of ``command``."""


@dataclass(kw_only=True)
class Spell:
    """From when to when [s]; a fault that does nothing, for the others to build on."""

    start: float
    """First time of the fault [s]."""
    end: float = np.inf
    """Its end [s]."""
    _now: float = field(default=-np.inf, init=False, repr=False)

    def read(self, robot: Robot, state: State) -> State:
        """The state, unless the fault is on."""
        self._now = state.t
        return self.spoilt(robot, state) if self.on else state

    def write(self, command: Command) -> Command:
        """The command, as it is."""
        return command

    def spoilt(self, robot: Robot, state: State) -> State:
        """What is read while the fault is on."""
        return state

    @property
    def on(self) -> bool:
        """Whether the fault is on."""
        return self.start <= self._now < self.end


@dataclass(kw_only=True)
class Off(Spell):
    """No new measurement comes: the last one is read again and again."""

    _last: State | None = field(default=None, init=False, repr=False)

    def read(self, robot: Robot, state: State) -> State:
        """The last state before the fault, while it is on."""
        self._now = state.t
        if not self.on or self._last is None:
            self._last = state
        return self._last


@dataclass(kw_only=True)
class Stuck(Spell):
    """One number of a reading no longer changes; the clock runs on."""

    signal: str
    """``q``, ``dq``, ``tau`` or ``F``."""
    index: int
    """Joint, or component."""
    _value: float | None = field(default=None, init=False, repr=False)

    def spoilt(self, robot: Robot, state: State) -> State:
        """With the value that it had when the fault came."""
        values = np.array(getattr(state, self.signal))
        self._value = float(values[self.index]) if self._value is None else self._value
        values[self.index] = self._value
        return _with(state, self.signal, values)


@dataclass(kw_only=True)
class Garbage(Spell):
    """One number of a reading is none, or absurd."""

    signal: str
    """``q``, ``dq``, ``tau`` or ``F``."""
    index: int
    """Joint, or component."""
    value: float = np.nan
    """What is read; see `GARBAGE`."""

    def spoilt(self, robot: Robot, state: State) -> State:
        """With that value."""
        values = np.array(getattr(state, self.signal))
        values[self.index] = self.value
        return _with(state, self.signal, values)


@dataclass(kw_only=True)
class Offset(Spell):
    """One number of a reading is off by a constant."""

    signal: str
    """``q``, ``dq``, ``tau`` or ``F``."""
    index: int
    """Joint, or component."""
    by: float
    """How much, in the unit of the reading."""

    def spoilt(self, robot: Robot, state: State) -> State:
        """With the offset."""
        values = np.array(getattr(state, self.signal))
        values[self.index] += self.by
        return _with(state, self.signal, values)


@dataclass(kw_only=True)
class Scaled(Spell):
    """All numbers of a reading are in another unit, such as degrees for radians."""

    signal: str
    """``q``, ``dq``, ``tau`` or ``F``."""
    factor: float
    """Of that unit."""

    def spoilt(self, robot: Robot, state: State) -> State:
        """With every number of it multiplied."""
        return _with(state, self.signal, self.factor * np.array(getattr(state, self.signal)))


@dataclass(kw_only=True)
class Clock(Spell):
    """The robot's clock is wrong."""

    by: float
    """By how much [s]; NaN is no time at all."""

    def spoilt(self, robot: Robot, state: State) -> State:
        """With that time."""
        return replace(state, t=state.t + self.by)


@dataclass(kw_only=True)
class Hang(Spell):
    """The controller does nothing for a while, once: measurements pass, and nothing is sent."""

    lost: int
    """Measurements that pass."""
    _done: bool = field(default=False, init=False, repr=False)

    def spoilt(self, robot: Robot, state: State) -> State:
        """The measurement after the pause."""
        if not self._done:
            self._done = True
            for _ in range(self.lost):
                state = robot.read()
        return state


@dataclass(kw_only=True)
class Slow(Spell):
    """Measurements are lost: of so many only the last one arrives."""

    lost: int
    """Measurements that are lost for each that arrives."""

    def spoilt(self, robot: Robot, state: State) -> State:
        """The measurement after those that are lost."""
        for _ in range(self.lost):
            state = robot.read()
        return state


@dataclass(kw_only=True)
class Intermittent(Spell):
    """Now and then a measurement is lost."""

    share: float
    """Share of the measurements that is lost."""
    seed: int = 0
    """Of the draws."""

    def __post_init__(self) -> None:
        self._rng = np.random.default_rng(self.seed)

    def spoilt(self, robot: Robot, state: State) -> State:
        """The next one that arrives."""
        while self._rng.uniform() < self.share:
            state = robot.read()
        return state


@dataclass(kw_only=True)
class Delayed(Spell):
    """Readings come late, under the time at which they come: nobody can tell from one of them alone."""

    cycles: int
    """How late."""
    _past: deque[State] = field(default_factory=deque, init=False, repr=False)

    def read(self, robot: Robot, state: State) -> State:
        """What was measured some cycles ago, with the time of now."""
        self._now = state.t
        self._past.append(state)
        while len(self._past) > self.cycles + 1:
            self._past.popleft()
        return replace(self._past[0], t=state.t) if self.on else state


def _with(state: State, signal: str, values: Array) -> State:
    """The state with another reading."""
    changed: dict[str, Any] = {signal: values}
    return replace(state, **changed)


@dataclass(kw_only=True)
class FaultyRobot:
    """A robot with faults between it and its controller; they act in their order."""

    robot: Robot
    """What is driven."""
    faults: list[Fault]
    """What goes wrong."""

    def __enter__(self) -> Self:
        self.robot.__enter__()
        return self

    def __exit__(self, *exception: object) -> None:
        self.robot.__exit__(*exception)

    def read(self) -> State:
        """What is left of the robot's measurement."""
        state = self.robot.read()
        for fault in self.faults:
            state = fault.read(self.robot, state)
        return state

    def write(self, command: Command) -> Array:
        """What is left of the command; returns what the robot applied."""
        for fault in self.faults:
            command = fault.write(command)
        return self.robot.write(command)
