"""`RosLink`: a `Link` whose period is that of the driver's joint states."""

from __future__ import annotations

from burnish.hardware.clock import Clock
from burnish.hardware.link import Link
from burnish.hardware.ros1_driver import CONNECTED, Driver
from burnish.hardware.ros1_node import DriverError
from burnish.model.model import Model

POLL = 1e-3
"""From one look for a joint state to the next [s]."""
FIRST = 1.0
"""Taken for the period until it has been measured [s]; a driver that nobody has told sends ten a second."""
COUNTED = 5
"""Joint states after the first by which their rate is measured."""
PATIENCE = 2.0
"""Periods after which a joint state is missing; the third that is missing in a row stops the arm."""
ASLEEP = 0.5
"""Share of a period that is slept through, because one that was late may be followed soon."""
LATE = 1.5
"""Periods after which it is late."""


class RosLink(Link):
    """A link that waits for the next joint state, whatever the rate at which they come."""

    def __init__(self, driver: Driver, model: Model, clock: Clock) -> None:
        """A link that begins with `connect`."""
        super().__init__(driver, model, clock)
        self._driver = driver
        self._came = clock.now()
        self._measured = False
        self.interval = FIRST
        """Mean time between two joint states [s], as `connect` measured it."""

    def connect(self) -> None:
        """Wait for the driver, and measure how often it sends.

        Raises:
            DriverError: if it sends nothing, or does not listen.
        """
        self.begin()
        first = self._came
        for _ in range(COUNTED):
            self.begin()
        self._measured = True
        self.interval = (self._came - first) / COUNTED
        until = self.clock.now() + CONNECTED
        while not self._driver.is_heard:
            if self.clock.now() > until:
                raise DriverError("in/joint_torque", "the driver does not listen to its topics; is it kinova-ros?")
            self.clock.wait(self.clock.now() + POLL)
        self.late_cycles = 0

    def begin(self) -> None:
        """Forget what was read, and start at rest at the angles of the next joint state."""
        self.pace()
        super().begin()

    def zero_time(self) -> None:
        """Let the next reading be at about t = 0."""
        self.pace()
        self._zero = self.clock.now() + self.interval
        super().begin()

    def pace(self) -> None:
        """Wait for the next joint state, but not without end."""
        until = self.clock.now() + PATIENCE * self.interval
        if self._measured:
            self.clock.wait(self._came + ASLEEP * self.interval)
        while not self._driver.has_news and self.clock.now() < until:
            self.clock.wait(self.clock.now() + POLL)
        now = self.clock.now()
        self.late_cycles += now - self._came > LATE * self.interval
        self._came = now
