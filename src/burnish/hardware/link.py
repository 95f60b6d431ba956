"""`Link`: readings and commands at 100 Hz, of which now and then one fails."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

import numpy as np

from burnish.core import Array, State
from burnish.errors import HardwareError
from burnish.hardware.clock import Clock
from burnish.hardware.kinova_codes import VendorError
from burnish.hardware.watch import Watch
from burnish.model.model import Model

PERIOD = 0.01
"""Of the arm's base [s]; sent more often, velocities queue up and the arm goes on after the last."""
BRIDGED = 2
"""Cycles in a row that may fail, or bring what cannot be believed, before the arm is stopped."""


class ArmFaultError(HardwareError):
    """The readings or the commands of the arm failed too often, or a motion of its own did not end."""


class Sensors(Protocol):
    """What an open arm measures; a reading that fails is a `VendorError`."""

    def positions(self) -> Array:
        """Joint angles as they are reported, multi-turn or wrapped [rad], (6,)."""

    def torques(self) -> Array:
        """Measured joint torques, gravity included [N·m], (6,)."""


class Link:
    """An open arm with a clock; states have t = 0 where `zero_time` said.

    Two bad cycles in a row are bridged with the last state that could be believed, and with the command that the arm
    has; the third is an error.
    """

    def __init__(self, sensors: Sensors, model: Model, clock: Clock) -> None:
        """A link that begins with `begin`."""
        self.sensors, self.clock = sensors, clock
        self.late_cycles = 0
        """Cycles that began after their time."""
        self.bad_readings = 0
        """Readings that failed or were not believed."""
        self._watch = Watch(speed=model.velocity_limit, effort=model.effort_limit, limited=np.isfinite(model.lower))
        self._bad = self._unsent = 0
        self._zero = 0.0
        self._next = clock.now()
        self._state = State(t=0.0, q=np.zeros(model.n), dq=np.zeros(model.n))

    @property
    def state(self) -> State:
        """The last state that could be believed."""
        return self._state

    @property
    def shift(self) -> Array:
        """Our angles minus the reported ones, whole turns [rad], (6,)."""
        return self._watch.shift

    def begin(self) -> None:
        """Forget what was read, and start at rest at the arm's present angles."""
        self._watch.begin(self.clock.now() - self._zero, self.sensors.positions())

    def zero_time(self) -> None:
        """Let the next reading be at t = 0."""
        self._zero = self._next + PERIOD
        self.begin()

    def pace(self) -> None:
        """Wait for the next control period; what is late is not made up for."""
        self._next += PERIOD
        now = self.clock.now()
        if now <= self._next:
            self.clock.wait(self._next)
        else:
            self.late_cycles += 1
            if now > self._next + PERIOD:
                self._next = now

    def read(self, check: Callable[[], None]) -> State:
        """The next reading, or the last one once more if it is bad; ``check`` is called as a part of it.

        Raises:
            ArmFaultError: at the third bad reading in a row.
        """
        self.pace()
        t = self.clock.now() - self._zero
        found = self._look(t, check)
        if isinstance(found, State):
            self._bad, self._state = 0, found
            return found
        self._bad += 1
        self.bad_readings += 1
        if self._bad > BRIDGED:
            raise ArmFaultError(f"{found}, in {BRIDGED + 1} cycles in a row")
        return replace(self._state, t=t)

    def measure(self) -> State:
        """The next reading outside the control loop, where a bad one ends what is going on.

        Raises:
            VendorError: if a call fails.
            ArmFaultError: if what it brought cannot be believed.
        """
        self.pace()
        found = self._watch.look(self.clock.now() - self._zero, self.sensors.positions(), self.sensors.torques())
        if not isinstance(found, State):
            raise ArmFaultError(f"{found}; check the cable and the load of this computer")
        self._state = found
        return found

    def send(self, call: Callable[[], None]) -> None:
        """Send a command; it may be lost twice in a row.

        Raises:
            ArmFaultError: if the third fails as well.
        """
        try:
            call()
        except VendorError as error:
            self._unsent += 1
            if self._unsent > BRIDGED:
                raise ArmFaultError(f"{error}, in {BRIDGED + 1} cycles in a row") from error
        else:
            self._unsent = 0

    def _look(self, t: float, check: Callable[[], None]) -> State | str:
        """A state that can be believed, or why there is none."""
        try:
            found = self._watch.look(t, self.sensors.positions(), self.sensors.torques())
            check()
        except VendorError as error:
            return str(error)
        return found
