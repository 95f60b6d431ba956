"""Into torque mode and out of it over ROS, where nobody can read the mode back: the arm's motion has to show it.

kinova-ros leaves the weight of the arm to its base, and so do we: without a torque for 250 ms the base commands zero
torque, and only what it adds for gravity then keeps the arm up. **Our torques include gravity, what is published does
not**; this file and no other knows.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from burnish.core import Array, State, read_only
from burnish.errors import HardwareError, InputError
from burnish.hardware.arming import REST, SETTLED, WATCHED, drifting, moving, near_limit, other_weight
from burnish.hardware.ros1_driver import Driver
from burnish.hardware.ros1_link import RosLink
from burnish.hardware.torque_mode import ModeError, TorqueEntryError
from burnish.model.model import Model

SLOWEST = 1.0 / 45.0
"""Longest time between two joint states in torque mode [s]; the arm itself refreshes at 50 Hz at its worst."""
PUSHED = 5
"""The joint that is turned a little to see whether torques reach it: the last, which lifts nothing."""
PUSH, PUSH_RATE = 4.0, 4.0
"""Most of that torque [N·m], and how fast it grows [N·m/s]; a K-58 is said to let go at 0.8 to 5.2 N·m."""
SEEN = np.deg2rad(0.3)
"""Turn of that joint that shows it [rad]."""
STUCK = np.repeat([5.0, 3.0], 3)
"""A joint that stands although the torque sent is so far beside the one measured [N·m] is held by its position loop.
Gears hold less: their breakaway is put at 3.0 and 1.7 N·m, which is an estimate."""
STUCK_SPEED = np.deg2rad(0.5)
STUCK_FOR = 30
"""Cycles in a row for which that has to be so."""
STANDS_FOR = 0.3
"""Time for which an arm has to stand in position mode [s]: longer than it goes on with the last torque."""
BRAKES_FOR = 1.5
"""Longest time until it begins to [s]."""


@dataclass(frozen=True, kw_only=True)
class RosTorqueSetup:
    """How the arm is set up for torque commands. kinova-ros passes on no more than this."""

    payload: float = 0.0
    """Mass in the hand, which the base then holds too [kg]; the model of the arm has to carry the same."""
    payload_com: Array = field(default_factory=lambda: np.zeros(3))
    """Its centre of mass in the tool frame [m], (3,)."""
    safety_factor: float = 1.0
    """Share of the largest speed at which the base falls back to position mode, 0 to 1; 1 is never."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "payload_com", read_only(self.payload_com))
        if self.payload_com.shape != (3,) or not np.isfinite(self.payload_com).all():
            raise InputError(f"RosTorqueSetup: payload_com {self.payload_com}; expected 3 finite numbers")
        for name, most in (("payload", 3.0), ("safety_factor", 1.0)):
            if not 0.0 <= getattr(self, name) <= most:
                raise InputError(f"RosTorqueSetup: {name} = {getattr(self, name)}; expected 0 to {most:g}")

    def parameters(self, effort: Array) -> dict[str, Any]:
        """The driver's parameters; ``effort`` are the largest torques [N·m], (6,)."""
        return {
            "torque_parameters/safety_factor": self.safety_factor,
            "payload": [self.payload, *self.payload_com.tolist()],
            "torque_parameters/torque_min": (-effort).tolist(),
            "torque_parameters/torque_max": effort.tolist(),
        }


def send(driver: Driver, model: Model, state: State, tau: Array) -> None:
    """Send a torque that includes gravity [N·m], (6,), to a base that adds the weight by itself.

    The base does not tell over ROS what it adds; the model's weight stands for it.
    """
    driver.send_torque(tau - model.at(state).g)


@dataclass(frozen=True, kw_only=True)
class RosTorqueEntry:
    """The way into torque mode."""

    driver: Driver
    link: RosLink
    model: Model
    """The arm with all that it carries."""
    setup: RosTorqueSetup

    def enter(self) -> None:
        """Check, set up, switch, see a joint follow a torque, stand still.

        Raises:
            TorqueEntryError: if any of it fails; the arm is then in position mode.
            ModeError: if it failed and the arm does not stand afterwards either.
        """
        self._check_gravity()
        self._check_at_rest()
        self.driver.set_torque_parameters(self.setup.parameters(self.model.effort_limit))
        try:
            self.driver.send_torque(np.zeros(6))
            self.driver.switch(torque=True)
            self._see_it_follow()
            self._settle()
        except BaseException:
            to_position_mode(self.driver, self.link)
            raise

    def _check_gravity(self) -> None:
        """That nobody has told the base to hold nothing."""
        identified = self.driver.parameter("torque_parameters/com_parameters")
        if identified is not None and not np.any(identified):
            raise TorqueEntryError(
                "torque mode refused: the driver's torque_parameters/com_parameters are zero, with which the base does "
                "not hold the arm's weight; delete them (rosparam delete), and restart the arm"
            )

    def _check_at_rest(self) -> None:
        """Rate, pose, speed and torques for 50 joint states."""
        states = [self.link.measure() for _ in range(WATCHED)]
        interval = (states[-1].t - states[0].t) / (WATCHED - 1)
        if interval > SLOWEST:
            raise TorqueEntryError(
                f"torque mode refused: joint states come at {1.0 / interval:.0f} Hz; start the driver with "
                "status_interval_seconds 0.01 for 100 Hz"
            )
        for state in states:
            problem = moving(state.dq) or near_limit(self.model.limit_distance(state.q))
            if problem is not None:
                raise TorqueEntryError(f"torque mode refused: {problem}")
        problem = other_weight(np.mean([measured_torque(state) - self.model.at(state).g for state in states], axis=0))
        if problem is not None:
            raise TorqueEntryError(f"torque mode refused: {problem}")

    def _see_it_follow(self) -> None:
        """Turn the last joint by a torque that grows until it moves."""
        begun = self._hold(0.0)
        push = 0.0
        while push < PUSH:
            state = self._hold(push)
            turned = state.q - begun.q
            problem = drifting(np.where(np.arange(6) == PUSHED, 0.0, turned))
            if problem is not None:
                raise TorqueEntryError(f"torque mode left again: {problem}")
            if abs(turned[PUSHED]) > SEEN:
                return
            push = PUSH_RATE * (state.t - begun.t)
        raise TorqueEntryError(
            f"torque mode refused: joint {PUSHED + 1} does not turn under {PUSH:g} N·m, so the arm stayed in position "
            "mode whatever the driver answered; zero the torques in a candle pose, check what the hand carries, or "
            "restart the arm"
        )

    def _settle(self) -> None:
        """A second under the weight's torque alone."""
        start = self._hold(0.0).q
        for _ in range(SETTLED):
            problem = drifting(self._hold(0.0).q - start)
            if problem is not None:
                raise TorqueEntryError(f"torque mode left again: {problem}")

    def _hold(self, push: float) -> State:
        """One cycle under the torque that holds the arm, and a push on the last joint [N·m]."""
        state = self.link.measure()
        weight = self.model.at(state).g
        send(self.driver, self.model, state, weight + push * np.eye(6)[PUSHED])
        return state


@dataclass(kw_only=True)
class Following:
    """Whether the arm still follows torques, by what it measures; made anew at each entry."""

    _cycles: int = field(default=0, init=False)

    def still(self, sent: Array, measured: Array, dq: Array) -> bool:
        """Look at one cycle: the torque sent and measured [N·m], the speed [rad/s], (6,)."""
        stuck = (np.abs(sent - measured) > STUCK) & (np.abs(dq) < STUCK_SPEED)
        self._cycles = self._cycles + 1 if np.any(stuck) else 0
        return self._cycles < STUCK_FOR


def to_position_mode(driver: Driver, link: RosLink, attempts: int = 2) -> None:
    """Ask for position mode, and see the arm stand for longer than it would go on with the last torque.

    Raises:
        ModeError: if it does not, or the driver cannot be asked.
    """
    cause = "it goes on moving"
    for _ in range(attempts):
        try:
            driver.switch(torque=False)
            driver.erase()
            if _stands(link.measure):
                return
        except HardwareError as error:
            cause = str(error)
    raise ModeError(
        f"the arm does not stand in position mode: {cause}. Without commands it should hold or float by itself after "
        "250 ms; keep away and press the emergency stop if it does not"
    )


def _stands(measure: Callable[[], State]) -> bool:
    """Whether the arm comes to rest soon, and stays so for a while."""
    state = measure()
    begun = resting = state.t
    while state.t - resting < STANDS_FOR:
        if np.any(np.abs(state.dq) > REST):
            resting = state.t
        if resting - begun > BRAKES_FOR:
            return False
        state = measure()
    return True


def measured_torque(state: State) -> Array:
    """The measured torques [N·m], (6,)."""
    assert state.tau is not None
    return state.tau
