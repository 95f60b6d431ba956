"""`Arm`: what every driver of the real arm does alike: the cycle, commands, motions of the arm's own, a safe end."""

from __future__ import annotations

import logging
from abc import ABC, abstractmethod
from collections.abc import Callable
from math import isfinite
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike
from typing_extensions import Self

from burnish.core import Array, Command, JointPosition, State, Torque
from burnish.errors import HardwareError, InputError
from burnish.hardware.clock import Clock, MonotonicClock
from burnish.hardware.link import PERIOD, ArmFaultError, Link
from burnish.model.model import Model

logger = logging.getLogger(__name__)

JOINTS = 6
ARRIVED, STILL = np.deg2rad(0.5), np.deg2rad(0.5)
"""Distance [rad] and speed [rad/s] at which a motion of the arm's own is over."""
RESTING = 50
"""Cycles for which it has to be over."""


class Arm(ABC):
    """A Kinova JACO2 at 100 Hz behind the `Robot` protocol; a child says through what it is reached.

    However the ``with`` block ends, the arm is left in position mode, where it holds.
    """

    _link: Link
    """Readings and commands; made when the arm is opened."""
    _patience = 4.0
    """How much longer a motion of the arm's own may take than at full speed: it starts and brakes softly."""

    def __init__(self, model: Model, clock: Clock | None) -> None:
        """An arm that is connected by ``with``; ``clock`` is the system's monotonic one if None.

        Raises:
            InputError: if the model is not one of six joints.
        """
        if model.n != JOINTS:
            raise InputError(f"{type(self).__name__} has {JOINTS} joints; the model {model.name} has {model.n}")
        self._model = model
        self._clock: Clock = clock if clock is not None else MonotonicClock()
        self._limit = model.effort_limit.tolist()
        self._velocity_due = 0.0

    def __enter__(self) -> Self:
        """Connect, go to position mode, then to torque mode if that was asked for.

        Raises:
            HardwareError: if there is no such arm, it does not answer, or it may not go into torque mode.
        """
        self._open()
        try:
            self._start()
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

    # What a child does.

    @property
    @abstractmethod
    def in_torque_mode(self) -> bool:
        """Whether the arm takes torques."""

    @abstractmethod
    def stop_torque(self) -> None:
        """Go into position mode.

        Raises:
            ModeError: if the arm does not confirm it.
        """

    @abstractmethod
    def _open(self) -> None:
        """Make what the arm is reached through; nothing needs to be closed if it fails."""

    @abstractmethod
    def _start(self) -> None:
        """Take the arm, in the mode that was asked for."""

    @abstractmethod
    def _close(self) -> None:
        """Let go of what `_open` made."""

    @abstractmethod
    def _check_mode(self) -> None:
        """A part of every reading: whether the arm is still in torque mode if it has to be."""

    @abstractmethod
    def _send_torque(self, tau: Array) -> None:
        """Send a torque that includes gravity [N·m], (6,)."""

    @abstractmethod
    def _send_position(self, q: Array) -> None:
        """Send the arm to angles as it reports them [rad], (6,), in place of where it goes."""

    @abstractmethod
    def _send_velocity(self, dq: Array) -> None:
        """Move for one period [rad/s], (6,)."""

    @abstractmethod
    def _erase(self) -> None:
        """Forget all motions that were sent."""

    # The cycle.

    def read(self) -> State:
        """Wait for the next measurement, a hundredth of a second after the last, with t = 0 at the first.

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
            return self._write_position(joints(command.q, "JointPosition"))
        return self._write_velocity(joints(command.dq, "JointVelocity"))

    # A motion of the arm's own, in position mode.

    def go_to(self, q: ArrayLike) -> None:
        """Go to a joint position [rad], (6,), and wait until the arm stands there.

        Raises:
            InputError: if it is beyond a joint limit.
            ArmFaultError: if the arm does not arrive.
        """
        goal = joints(np.asarray(q, np.float64), "go_to")
        way = np.abs(goal - self.read().q) / self._model.velocity_limit
        self.write(JointPosition(goal))

        def there(state: State) -> bool:
            return bool(np.all(np.abs(state.q - goal) < ARRIVED))

        self._until(there, "it did not arrive", patience=5.0 + self._patience * float(way.max()))

    # What holds it together.

    def _leave(self) -> HardwareError | None:
        """Position mode, then the end of the connection; what went wrong."""
        problem: HardwareError | None = None
        for step in (self.stop_torque, self._close):
            try:
                step()
            except HardwareError as error:
                logger.error("%s", error)
                problem = problem or error
        return problem

    def _write_torque(self, tau: Array) -> Array:
        if not self.in_torque_mode:
            raise InputError(
                f"Torque while the arm is in position mode; give {type(self).__name__} a TorqueSetup or call "
                "start_torque"
            )
        asked = tau.tolist()
        if len(asked) != JOINTS or not all(map(isfinite, asked)):
            raise InputError(f"torque command {tau}; expected {JOINTS} finite numbers, the driver does not send it")
        sent = np.array([max(-most, min(most, a)) for a, most in zip(asked, self._limit, strict=True)])
        self._send(lambda: self._send_torque(sent))
        return sent

    def _write_position(self, q: Array) -> Array:
        if np.any(self._model.limit_distance(q) < 0.0):
            raise InputError(f"JointPosition {np.rad2deg(q).round(1)}° is beyond a joint limit; expected a pose within")
        self._send(lambda: self._send_position(q - self._link.shift))
        return q

    def _write_velocity(self, dq: Array) -> Array:
        sent = np.clip(dq, -self._model.velocity_limit, self._model.velocity_limit)
        # One point every 10 ms in the mean, or they queue up.
        self._clock.wait(self._velocity_due)
        self._velocity_due = max(self._velocity_due, self._clock.now() - PERIOD) + PERIOD
        self._send(lambda: self._send_velocity(sent))
        return sent

    def _send(self, call: Callable[[], None]) -> None:
        try:
            self._link.send(call)
        except ArmFaultError as error:
            self._stop(error)

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
                self._erase()
                raise ArmFaultError(f"{failure} within {patience:.0f} s and was stopped; look for what is in its way")

    def _need_position_mode(self, name: str) -> None:
        if self.in_torque_mode:
            raise InputError(f"{name} while the arm is in torque mode; stop_torque comes first")


def joints(values: Array, name: str) -> Array:
    """Six finite numbers.

    Raises:
        InputError: if they are not.
    """
    if np.shape(values) != (JOINTS,) or not np.isfinite(values).all():
        raise InputError(f"{name} {values}; expected {JOINTS} finite numbers")
    return np.array(values, np.float64)
