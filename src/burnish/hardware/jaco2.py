"""`Jaco2`: the real arm behind the `Robot` protocol."""

from __future__ import annotations

import logging
from collections.abc import Callable
from math import isfinite
from pathlib import Path
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike
from typing_extensions import Self

from burnish.core import Array, Command, JointPosition, State, Torque
from burnish.errors import HardwareError, InputError
from burnish.hardware import calibration
from burnish.hardware.clock import Clock, MonotonicClock
from burnish.hardware.kinova import JOINTS, Kinova
from burnish.hardware.kinova_library import Library, find
from burnish.hardware.kinova_types import ControlMode
from burnish.hardware.link import PERIOD, ArmFaultError, Link
from burnish.hardware.network import Network
from burnish.hardware.torque_mode import ModeError, TorqueEntry, TorqueSetup, to_position_mode
from burnish.model.model import Model

logger = logging.getLogger(__name__)

MODE_CHECKED = 5
"""Cycles from one look at the mode to the next."""
ARRIVED, STILL = np.deg2rad(0.5), np.deg2rad(0.5)
"""Distance [rad] and speed [rad/s] at which a motion of the arm's own is over."""
RESTING = 50
"""Cycles for which it has to be over."""


class Jaco2:
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
        """An arm that is connected by ``with``.

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
        if model.n != JOINTS:
            raise InputError(f"Jaco2 has {JOINTS} joints; the model {model.name} has {model.n}")
        self._model, self._serial, self._setup = model, serial, torque
        self._path, self._network = library, network
        self._clock: Clock = clock if clock is not None else MonotonicClock()
        self._limit = model.effort_limit.tolist()
        self._torque: TorqueSetup | None = None
        self._cycle = 0
        self._velocity_due = 0.0

    def __enter__(self) -> Self:
        """Connect to the arm with our serial number, go to position mode, then to torque mode if that was asked for.

        Raises:
            LibraryMissingError: if there is no library of Kinova's.
            HardwareError: if there is no such arm, it does not answer, or it may not go into torque mode.
        """
        self._kinova = Kinova(Library(find(self._path)), self._network)
        self._link = Link(self._kinova, self._model, self._clock)
        try:
            self._connect()
            if self._setup is not None:
                self.start_torque(self._setup)
        except BaseException:
            self._leave()
            raise
        self._link.zero_time()
        return self

    def __exit__(self, kind: type[BaseException] | None, *rest: object) -> None:
        """Leave the arm in position mode.

        Raises:
            ModeError: if it does not confirm that, unless another error is on its way already.
        """
        problem = self._leave()
        if problem is not None and kind is None:
            raise problem

    @property
    def late_cycles(self) -> int:
        """Cycles that began after their time."""
        return self._link.late_cycles

    @property
    def bad_readings(self) -> int:
        """Readings that failed or were not believed; up to two in a row are bridged."""
        return self._link.bad_readings

    # The cycle.

    def read(self) -> State:
        """Wait for the next hundredth of a second; the state then, with t = 0 at the first.

        Raises:
            ArmFaultError: at the third bad reading in a row; the arm was sent to position mode.
            ModeError: if the arm has left torque mode by itself.
        """
        try:
            return self._link.read(self._check_mode)
        except ArmFaultError as error:
            self._stop(error)

    def write(self, command: Command) -> Array:
        """Send a command of the kind that the mode takes; returns it after the driver's last clamp, (6,).

        Raises:
            InputError: if it is of the other kind, not finite, or beyond a joint limit.
            ArmFaultError: if the arm did not take the third command in a row; it was sent to position mode.
        """
        if isinstance(command, Torque):
            return self._write_torque(command.tau)
        self._need_position_mode(type(command).__name__)
        if isinstance(command, JointPosition):
            return self._write_position(_joints(command.q, "JointPosition"))
        return self._write_velocity(_joints(command.dq, "JointVelocity"))

    # Modes.

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

    # Motions of the arm's own, in position mode.

    def home(self) -> None:
        """Go to the home pose that the arm holds, and wait until it stands there."""
        self._need_position_mode("home")
        self._link.send(self._kinova.home)
        self._until(lambda state: True, "it did not come home", patience=30.0)

    def go_to(self, q: ArrayLike) -> None:
        """Go to a joint position [rad], (6,), and wait until the arm stands there.

        Raises:
            InputError: if it is beyond a joint limit.
            ArmFaultError: if the arm does not arrive.
        """
        goal = _joints(np.asarray(q, np.float64), "go_to")
        way = np.abs(goal - self.read().q) / self._model.velocity_limit
        self.write(JointPosition(goal))

        def there(state: State) -> bool:
            return bool(np.all(np.abs(state.q - goal) < ARRIVED))

        # The arm starts and brakes softly: four times what it would take at full speed is ample.
        self._until(there, "it did not arrive", patience=5.0 + 4.0 * float(way.max()))

    def fingers(self) -> Array:
        """Angles of the finger joints, 0 when open [rad], (3,)."""
        return self._kinova.fingers()

    def move_fingers(self, angles: ArrayLike) -> None:
        """Send the finger joints to these angles [rad], (3,), 0 to 1.396; does not wait."""
        self._need_position_mode("move_fingers")
        self._kinova.send_fingers(np.clip(angles, 0.0, calibration.FINGERS_CLOSED))

    # Calibration, in position mode.

    def zero_torques(self) -> None:
        """Take the torques that the sensors read now for zero: only in a pose in which gravity turns no joint.

        Raises:
            InputError: in any other pose, or if the arm moves.
            HardwareError: if the sensors do not read zero afterwards.
        """
        self._need_position_mode("zero_torques")
        calibration.zero_torques(self._kinova, self._model, self._link.measure)

    def zero_joints(self) -> None:
        """Take the angles of joints 2 to 6 for those of the calibration pose: only within 5° of it.

        Raises:
            InputError: in any other pose, or if the arm moves.
            HardwareError: if the joints do not read the pose afterwards.
        """
        self._need_position_mode("zero_joints")
        calibration.zero_joints(self._kinova, self._link.measure, self._link.begin)

    # What holds it together.

    def _connect(self) -> None:
        self._kinova.choose(self._serial)
        self._kinova.start()
        # A program that was killed may have left it in torque mode.
        self.stop_torque()
        self._link.begin()

    def _leave(self) -> HardwareError | None:
        """Position mode, then the end of the connection; what went wrong."""
        problem: HardwareError | None = None
        for step in (self.stop_torque, self._kinova.close):
            try:
                step()
            except HardwareError as error:
                logger.error("%s", error)
                problem = problem or error
        return problem

    def _write_torque(self, tau: Array) -> Array:
        setup = self._torque
        if setup is None:
            raise InputError("Torque while the arm is in position mode; give Jaco2 a TorqueSetup or call start_torque")
        asked = tau.tolist()
        if len(asked) != JOINTS or not all(map(isfinite, asked)):
            raise InputError(f"torque command {tau}; expected {JOINTS} finite numbers, the driver does not send it")
        sent = np.array([max(-most, min(most, a)) for a, most in zip(asked, self._limit, strict=True)])
        self._send(lambda: setup.send(self._kinova, sent))
        return sent

    def _write_position(self, q: Array) -> Array:
        if np.any(self._model.limit_distance(q) < 0.0):
            raise InputError(f"JointPosition {np.rad2deg(q).round(1)}° is beyond a joint limit; expected a pose within")
        self._send(self._kinova.erase)
        self._send(lambda: self._kinova.send_position(q - self._link.shift))
        return q

    def _write_velocity(self, dq: Array) -> Array:
        sent = np.clip(dq, -self._model.velocity_limit, self._model.velocity_limit)
        # One point every 10 ms in the mean, or they queue up.
        self._clock.wait(self._velocity_due)
        self._velocity_due = max(self._velocity_due, self._clock.now() - PERIOD) + PERIOD
        self._send(lambda: self._kinova.send_velocity(sent))
        return sent

    def _send(self, call: Callable[[], None]) -> None:
        try:
            self._link.send(call)
        except ArmFaultError as error:
            self._stop(error)

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

    def _stop(self, cause: ArmFaultError) -> NoReturn:
        """Send the arm to position mode and give up."""
        end = "the arm is in position mode"
        try:
            self.stop_torque()
        except HardwareError as error:
            end = str(error)
        raise ArmFaultError(f"{cause}. Stopped: {end}") from cause

    def _until(self, there: Callable[[State], bool], failure: str, patience: float) -> None:
        """Wait until the arm has come to rest where it shall be."""
        begun, resting = self._clock.now(), 0
        while resting < RESTING:
            state = self.read()
            resting = resting + 1 if np.all(np.abs(state.dq) < STILL) and there(state) else 0
            if self._clock.now() - begun > patience:
                self._kinova.erase()
                raise ArmFaultError(f"{failure} within {patience:.0f} s and was stopped; look for what is in its way")

    def _need_position_mode(self, name: str) -> None:
        if self._torque is not None:
            raise InputError(f"{name} while the arm is in torque mode; stop_torque comes first")


def _joints(values: Array, name: str) -> Array:
    """Six finite numbers."""
    if np.shape(values) != (JOINTS,) or not np.isfinite(values).all():
        raise InputError(f"{name} {values}; expected {JOINTS} finite numbers")
    return np.array(values, np.float64)
