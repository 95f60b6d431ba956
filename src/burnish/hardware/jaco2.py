"""`Jaco2`: the real arm through its vendor's library, behind the `Robot` protocol."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from burnish.core import Array
from burnish.hardware import calibration
from burnish.hardware.arm import JOINTS, Arm
from burnish.hardware.clock import Clock
from burnish.hardware.kinova import Kinova
from burnish.hardware.kinova_library import Library, find
from burnish.hardware.kinova_types import ControlMode
from burnish.hardware.link import Link
from burnish.hardware.network import Network
from burnish.hardware.torque_mode import ModeError, TorqueEntry, TorqueSetup, to_position_mode
from burnish.model.jaco2_parts import FINGERS_CLOSED
from burnish.model.model import Model

MODE_CHECKED = 5
"""Cycles from one look at the mode to the next."""


class Jaco2(Arm):
    """A Kinova JACO2 at 100 Hz.

    With a `TorqueSetup` the arm is taken into torque mode on entry, in the pose in which it stands, and takes `Torque`;
    without one it is in position mode and takes `JointPosition` and `JointVelocity`. However the block ends, the arm is
    left in position mode, where it holds.
    """

    def __init__(
        self,
        model: Model,
        *,
        serial: str,
        torque: TorqueSetup | None = None,
        library: str | Path | None = None,
        network: Network | None = None,
        clock: Clock | None = None,
    ) -> None:
        """An arm that is connected by ``with``, which raises `LibraryMissingError` without Kinova's library.

        Args:
            model: the arm with all that it carries; its weight is compared with the measured torques.
            serial: serial number of the arm, as ``burnish devices`` prints it; another arm is refused.
            torque: how to set it up for torque commands; without it the arm stays in position mode.
            library: path of Kinova's command layer; from the environment or the vendor's places without it.
            network: addresses, for the Ethernet layer; the vendor's defaults without it.
            clock: for tests; the system's monotonic clock without it.

        Raises:
            InputError: if the model is not one of six joints.
        """
        super().__init__(model, clock)
        self._serial, self._setup = serial, torque
        self._path, self._network = library, network
        self._torque: TorqueSetup | None = None
        self._cycle = 0

    @property
    def in_torque_mode(self) -> bool:
        """Whether the arm takes torques."""
        return self._torque is not None

    def start_torque(self, setup: TorqueSetup) -> None:
        """Go into torque mode, with all checks; it takes two seconds, in which nobody may touch the arm.

        Raises:
            TorqueEntryError: if it is refused; the arm is in position mode and the text says why.
        """
        self.stop_torque()
        TorqueEntry(kinova=self._kinova, model=self._model, setup=setup, measure=self._link.measure).enter()
        self._torque = setup

    def stop_torque(self) -> None:
        """Go into position mode, read back.

        Raises:
            ModeError: if the arm does not confirm it.
        """
        self._torque = None
        to_position_mode(self._kinova, self._link.pace)

    # In position mode.

    def home(self) -> None:
        """Go to the home pose that the arm holds, and wait until it stands there."""
        self._need_position_mode("home")
        self._link.send(self._kinova.home)
        self._until(lambda state: True, "it did not come home", patience=30.0)

    def fingers(self) -> Array:
        """Angles of the finger joints, 0 when open [rad], (3,)."""
        return self._kinova.fingers()

    def move_fingers(self, angles: ArrayLike) -> None:
        """Send the finger joints to these angles [rad], (3,), 0 to 1.396; does not wait."""
        self._need_position_mode("move_fingers")
        self._kinova.send_fingers(np.clip(angles, 0.0, FINGERS_CLOSED))

    def zero_torques(self) -> None:
        """Take the torques that the sensors read now for zero: only in a pose in which gravity turns no joint.

        Raises:
            InputError: in any other pose, or if the arm moves.
            HardwareError: if the sensors do not read zero afterwards.
        """
        self._need_position_mode("zero_torques")

        def zero() -> None:
            for joint in range(JOINTS):
                self._kinova.zero_torque(joint)

        calibration.zero_torques(zero, self._model, self._link.measure)

    def zero_joints(self) -> None:
        """Take the angles of joints 2 to 6 for those of the calibration pose: only within 5° of it.

        Raises:
            InputError: in any other pose, or if the arm moves.
            HardwareError: if the joints do not read the pose afterwards.
        """
        self._need_position_mode("zero_joints")
        calibration.zero_joints(self._kinova, self._link.measure, self._link.begin)

    # What the cycle is made of.

    def _open(self) -> None:
        self._kinova = Kinova(Library(find(self._path)), self._network)
        self._link = Link(self._kinova, self._model, self._clock)

    def _start(self) -> None:
        self._kinova.choose(self._serial)
        self._kinova.start()
        # A program that was killed may have left it in torque mode.
        self.stop_torque()
        self._link.begin()
        if self._setup is not None:
            self.start_torque(self._setup)

    def _close(self) -> None:
        self._kinova.close()

    def _send_torque(self, tau: Array) -> None:
        assert self._torque is not None
        self._torque.send(self._kinova, tau)

    def _send_position(self, q: Array) -> None:
        self._kinova.erase()
        self._kinova.send_position(q)

    def _send_velocity(self, dq: Array) -> None:
        self._kinova.send_velocity(dq)

    def _erase(self) -> None:
        self._kinova.erase()

    def _check_mode(self) -> None:
        """Every few cycles: whether the arm is still in torque mode."""
        self._cycle += 1
        if self._torque is None or self._cycle % MODE_CHECKED:
            return
        if self._kinova.mode() is not ControlMode.TORQUE:
            self._torque = None
            raise ModeError(
                "the arm went to position mode by itself and holds: 250 ms without a torque, a speed beyond its safety "
                "factor, a fault, or somebody at the joystick; find the cause, then start_torque"
            )
