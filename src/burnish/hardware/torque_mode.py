"""Into torque mode and out of it: the theses' set-up, the checks before, and the proof after.

The order is the documented one: a pose away from the joint limits, at rest, the measured torques as the model says, the
set-up in position mode, the weight as the first command, the switch, **the mode read back**, and a second of standing
still. What each of the checks asks is in `arming`. Whatever fails, the arm ends in position mode.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from burnish.core import Array, State, read_only
from burnish.errors import HardwareError, InputError
from burnish.hardware.arming import READ_BACK, SETTLED, WATCHED, drifting, moving, near_limit, other_weight
from burnish.hardware.kinova import Kinova
from burnish.hardware.kinova_codes import NackError
from burnish.hardware.kinova_types import ControlMode, Inactivity
from burnish.model.model import Model

logger = logging.getLogger(__name__)

OPTIMAL_Z = 16
"""Numbers of the base's identified gravity parameters for six joints."""


class TorqueEntryError(HardwareError):
    """The arm was not let into torque mode; it is in position mode."""


class ModeError(HardwareError):
    """The arm is in another mode than it was told to be in."""


@dataclass(frozen=True, kw_only=True)
class TorqueSetup:
    """How the arm's base and actuators are set up for torque commands; they forget it when switched off."""

    optimal_z: Array = field(default_factory=lambda: np.zeros(OPTIMAL_Z))
    """The base's identified gravity parameters, (16,). All zero: the base adds no torque of its own."""
    payload: float = 0.0
    """Mass in the hand that the base compensates [kg]; the model of the arm has to carry the same."""
    payload_com: Array = field(default_factory=lambda: np.zeros(3))
    """Its centre of mass in the tool frame [m], (3,)."""
    actuator_gain: float = 0.0
    """Feedback gain of the actuators' own torque loops, 0 to 4."""
    actuator_damping: float = 0.0
    """Damping of the actuators' own torque loops."""
    safety_factor: float = 1.0
    """Share of the largest speed at which the base falls back to position mode, 0 to 1; 1 is never."""
    vibration: float = 1.0
    """Strength of the base's vibration observer, 0 to 1."""

    def __post_init__(self) -> None:
        for name, length in (("optimal_z", OPTIMAL_Z), ("payload_com", 3)):
            values = read_only(getattr(self, name))
            object.__setattr__(self, name, values)
            if values.shape != (length,) or not np.isfinite(values).all():
                raise InputError(f"TorqueSetup: {name} {values}; expected {length} finite numbers")
        for name, most in (
            ("payload", 3.0),
            ("actuator_gain", 4.0),
            ("actuator_damping", 4.0),
            ("safety_factor", 1.0),
            ("vibration", 1.0),
        ):
            if not 0.0 <= getattr(self, name) <= most:
                raise InputError(f"TorqueSetup: {name} = {getattr(self, name)}; expected 0 to {most:g}")

    @classmethod
    def thesis_a(cls) -> TorqueSetup:
        """No gravity compensation, feedback gain or damping: the torque is ours alone. Source: thesis A, table 5.1."""
        return cls()

    @classmethod
    def thesis_b(cls, optimal_z: ArrayLike, payload: float = 0.0) -> TorqueSetup:
        """The base compensates gravity with what its own identification found, (16,). Source: thesis B, section 5.2."""
        return cls(optimal_z=np.asarray(optimal_z, np.float64), payload=payload)

    @property
    def base_holds_weight(self) -> bool:
        """Whether the base adds the torque of gravity to every command."""
        return bool(np.any(self.optimal_z != 0.0))

    def apply(self, kinova: Kinova, effort: Array) -> None:
        """Tell the arm, which has to be in position mode; ``effort`` are the largest torques [N·m], (6,)."""
        kinova.set_direct_torque()
        kinova.set_gravity(self.optimal_z, self.payload, self.payload_com)
        kinova.set_actuators(self.actuator_gain, self.actuator_damping)
        kinova.set_safety_factor(self.safety_factor)
        kinova.set_vibration_controller(self.vibration)
        kinova.set_torque_limits(effort)
        kinova.set_inactivity(Inactivity.HOLD_POSITION)

    def send(self, kinova: Kinova, tau: Array) -> None:
        """Send a torque that includes gravity [N·m], (6,): the only place that knows what the base adds."""
        kinova.send_torque(tau - kinova.gravity_estimate() if self.base_holds_weight else tau)


@dataclass(frozen=True, kw_only=True)
class TorqueEntry:
    """The way into torque mode."""

    kinova: Kinova
    model: Model
    """The arm with all that it carries."""
    setup: TorqueSetup
    measure: Callable[[], State]
    """The next reading, one control period after the last."""

    def enter(self) -> None:
        """Check, set up, switch, read back, stand still.

        Raises:
            TorqueEntryError: if any of it fails; the arm is then in position mode.
            ModeError: if it failed and the arm does not confirm position mode either.
        """
        self.check_at_rest()
        self.setup.apply(self.kinova, self.model.effort_limit)
        try:
            self._switch()
            self._settle()
        except BaseException:
            to_position_mode(self.kinova, self.measure)
            raise

    def check_at_rest(self) -> None:
        """Pose, speed and torques for half a second.

        Raises:
            TorqueEntryError: if one of them is not what it has to be.
        """
        residuals = []
        for _ in range(WATCHED):
            state = self.measure()
            problem = moving(state.dq) or near_limit(self.model.limit_distance(state.q))
            if problem is not None:
                raise TorqueEntryError(f"torque mode refused: {problem}")
            assert state.tau is not None
            residuals.append(state.tau - self.model.at(state).g)
        problem = other_weight(np.mean(residuals, axis=0))
        if problem is not None:
            raise TorqueEntryError(f"torque mode refused: {problem}")

    def _switch(self) -> None:
        """Send the weight, ask for torque mode, and read it back."""
        try:
            self._hold()
        except NackError:
            # Whether every firmware takes a torque while in position mode is not documented; the next one comes after.
            logger.info("the arm refused a torque in position mode")
        self.kinova.switch(ControlMode.TORQUE)
        for _ in range(READ_BACK):
            self._hold()
            if self.kinova.mode() is ControlMode.TORQUE:
                return
        raise TorqueEntryError(
            "torque mode refused: the arm took the switch without an error and stayed in position mode; zero the "
            "torques in a candle pose, check what the hand carries, or restart the arm"
        )

    def _settle(self) -> None:
        """A second under the weight's torque alone."""
        start = self._hold().q
        for _ in range(SETTLED):
            problem = drifting(self._hold().q - start)
            if problem is not None:
                raise TorqueEntryError(f"torque mode left again: {problem}")
        if self.kinova.mode() is not ControlMode.TORQUE:
            raise TorqueEntryError("torque mode was left by the arm itself within a second; look at its lamps")

    def _hold(self) -> State:
        """One cycle in which the arm is sent the torque that holds it."""
        state = self.measure()
        self.setup.send(self.kinova, self.model.at(state).g)
        return state


def to_position_mode(kinova: Kinova, pace: Callable[[], object], attempts: int = 10) -> None:
    """Empty the queue and go to position mode, read back.

    Raises:
        ModeError: if the arm does not report position mode after that many control periods.
    """
    cause = "it stayed in torque mode"
    for _ in range(attempts):
        try:
            kinova.erase()
            kinova.switch(ControlMode.POSITION)
            pace()
            if kinova.mode() is ControlMode.POSITION:
                return
        except HardwareError as error:
            cause = str(error)
    raise ModeError(
        f"the arm does not confirm position mode: {cause}. Without commands it should hold by itself after 250 ms; "
        "keep away and press the emergency stop if it does not"
    )
