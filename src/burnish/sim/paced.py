"""`Paced`: a simulated arm that keeps to the clock on the wall, for whoever operates it."""

from __future__ import annotations

import time
from collections.abc import Callable

from typing_extensions import Self

from burnish.core import Array, Command, State
from burnish.sim.robot import SimRobot

BEHIND = 0.1
"""Lateness that is not made up for [s]: after a pause the arm does not hurry."""


class Paced:
    """A simulated arm whose `read` returns when the wall has come as far as the simulation."""

    def __init__(
        self,
        robot: SimRobot,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self.robot = robot
        self.late_cycles = 0
        """Samples that came more than a period after their time on the wall."""
        self._clock, self._sleep = clock, sleep
        self._origin: float | None = None

    @property
    def period(self) -> float:
        """Nominal time between two samples [s]."""
        return self.robot.period

    def __enter__(self) -> Self:
        self.robot.__enter__()
        return self

    def __exit__(self, *exception: object) -> None:
        self.robot.__exit__(*exception)

    def read(self) -> State:
        """The next sample, at its time."""
        state = self.robot.read()
        if self._origin is None:
            self._origin = self._clock() - state.t
        early = self._origin + state.t - self._clock()
        if early > 0.0:
            self._sleep(early)
        behind = self._clock() - self._origin - state.t
        self.late_cycles += behind > self.period
        if behind > BEHIND:
            self._origin += behind
        return state

    def write(self, command: Command) -> Array:
        """As the simulated arm does."""
        return self.robot.write(command)
