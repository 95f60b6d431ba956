"""`Session`: an arm that has a position mode, taken through the states of its supervisor; a `Robot` for a `Rig`."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Protocol

import numpy as np
from typing_extensions import Self

from burnish.core import Array, Command, Robot, State
from burnish.errors import HardwareError
from burnish.hardware.arming import FRESH
from burnish.hardware.torque_mode import TorqueSetup
from burnish.runtime.machine import Mode
from burnish.runtime.supervisor import Supervisor

logger = logging.getLogger(__name__)


class ArmWithModes(Robot, Protocol):
    """A `Robot` that is in position mode until it is taken into torque mode, as `Jaco2` is."""

    @property
    def bad_readings(self) -> int:
        """Readings that failed or were not believed."""

    def start_torque(self, setup: TorqueSetup) -> None:
        """Go into torque mode with all checks; raise, and be in position mode, if one of them fails."""

    def stop_torque(self) -> None:
        """Go into position mode, read back."""


class Session:
    """Connects an arm, arms it, and leaves it to its position mode once it was stopped and stands.

    The supervisor begins with ``start=Mode.IDLE``. After a stop the arm is held by torque until it stands, or until
    nobody sees it any more, and from then on by its own position mode, where commands of the loop are dropped. The way
    back is `Supervisor.acknowledge` (or `reset` after a fault) and then `arm`.
    """

    def __init__(
        self, robot: ArmWithModes, setup: TorqueSetup, supervisor: Supervisor, beat: Callable[[bool], None]
    ) -> None:
        """A session that begins with ``with``.

        Args:
            robot: the arm, in position mode.
            setup: how it is set up for torques.
            supervisor: of the `Rig` that the session is the robot of.
            beat: told once a cycle whether the arm is in torque mode, as `Watchdog.beat` wants to be.
        """
        self._robot, self._setup, self._supervisor, self._beat = robot, setup, supervisor, beat
        self._takes_torque = False

    def __enter__(self) -> Self:
        """Connect, and go into torque mode.

        Raises:
            HardwareError: if the arm does not answer as it should, or may not go into torque mode.
        """
        self._robot.__enter__()
        try:
            self.arm()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *exception: object) -> None:
        """Leave the arm in position mode."""
        self._beat(False)
        self._takes_torque = False
        self._robot.__exit__(*(exception or (None, None, None)))

    def arm(self) -> None:
        """Into torque mode, with all checks of `burnish.hardware.arming`; it takes two seconds.

        Raises:
            HardwareError: if something stands against it; the arm is then in position mode.
        """
        supervisor = self._supervisor
        if supervisor.mode is Mode.IDLE:
            self._connect()
        problem = supervisor.arming()
        if problem is not None:
            raise HardwareError(f"torque mode refused: {problem}")
        try:
            self._robot.start_torque(self._setup)
        except BaseException:
            supervisor.in_position()
            raise
        supervisor.armed()
        self._takes_torque = True

    def read(self) -> State:
        """As the arm does."""
        return self._robot.read()

    def write(self, command: Command) -> Array:
        """Send a torque while the arm takes any; in position mode it is dropped, and zeros are what is applied."""
        if self._takes_torque and self._supervisor.leaves_torque:
            self._takes_torque = False
            self._robot.stop_torque()
            self._supervisor.in_position()
            logger.warning("the arm was left to its position mode")
        self._beat(self._takes_torque)
        return self._robot.write(command) if self._takes_torque else np.zeros(len(self._supervisor.limits.torque))

    def _connect(self) -> None:
        """Half a second of readings, all of them good."""
        before = self._robot.bad_readings
        for _ in range(FRESH):
            self._robot.read()
        bad = self._robot.bad_readings - before
        if bad:
            raise HardwareError(f"{bad} of {FRESH} readings of the arm were bad; check the cable, and what else runs")
        logger.info("limits %s", self._supervisor.limits.hash)
        self._supervisor.connected()
