"""The states of a session on the stand-in's arm: each change of mode is proven by the arm, and so is each stop."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import pytest
from hardware.standin import StandIn

from burnish.control import GravityCompensation
from burnish.core import Array, Dynamics, JointReference
from burnish.errors import HardwareError
from burnish.hardware.jaco2 import Jaco2
from burnish.hardware.torque_mode import TorqueEntryError, TorqueSetup
from burnish.model.model import Model
from burnish.runtime.limits import Limits
from burnish.runtime.loop import Rig, control
from burnish.runtime.machine import Mode
from burnish.runtime.session import Session
from burnish.runtime.supervisor import Supervisor
from burnish.trajectory import Hold

MODEL = Model.jaco2()


class Broken(GravityCompensation):
    """A law that gives no number while it is broken."""

    def __init__(self) -> None:
        super().__init__(damping=2.0)
        self.broken = False

    def torque(self, arm: Dynamics, reference: JointReference) -> Array:
        return np.full(6, np.nan) if self.broken else super().torque(arm, reference)


class Desk:
    """A session, and a loop that goes on for some time."""

    def __init__(self, arm: Jaco2) -> None:
        self.supervisor = Supervisor(limits=Limits.jaco2(), start=Mode.IDLE)
        self.beats: list[bool] = []
        self.session = Session(arm, TorqueSetup.thesis_a(), self.supervisor, self.beats.append)
        self.rig, self.law = Rig(self.session, MODEL, self.supervisor), Broken()

    def go_on(self, seconds: float) -> set[Mode]:
        """The states that were seen."""
        begun = self.rig.read().t
        over = control(self.rig, Hold(), self.law, until=lambda now: now.t - begun >= seconds)
        return {self.supervisor.mode for _ in over}


@pytest.fixture
def desk(standin: StandIn, jaco2: Callable[..., Jaco2]) -> Desk:
    return Desk(jaco2())


def test_session_goes_through_position_mode_into_torque_mode_and_leaves_in_position_mode(
    standin: StandIn, desk: Desk
) -> None:
    assert desk.supervisor.mode is Mode.IDLE
    with desk.session:
        assert standin.memory.mode == 1
        assert desk.go_on(0.3) == {Mode.TORQUE}
        assert desk.beats[-1]
    assert standin.trace()[2][-1] == 0.0
    assert not desk.beats[-1]


def test_held_arm_is_left_to_its_position_mode_once_it_stands(standin: StandIn, desk: Desk) -> None:
    with desk.session:
        desk.go_on(0.2)
        desk.law.broken = True
        assert desk.go_on(0.6) == {Mode.HOLD, Mode.POSITION}
        # The command is through after a tick of the base.
        assert standin.memory.mode == 0
        assert not desk.beats[-1]
        times, q, mode = standin.trace()
        still = q[times > times[mode == 1.0][-1] + 0.1]
        assert np.abs(still - still[0]).max() < np.deg2rad(0.1)
        assert desk.supervisor.tripped


def test_way_back_is_to_acknowledge_and_to_arm_again(standin: StandIn, desk: Desk) -> None:
    with desk.session:
        desk.law.broken = True
        desk.go_on(0.5)
        desk.law.broken = False
        with pytest.raises(HardwareError, match="not finite; acknowledge that first"):
            desk.session.arm()
        desk.go_on(1.2)
        assert desk.supervisor.acknowledge() is None
        assert desk.supervisor.mode is Mode.POSITION
        desk.session.arm()
        assert standin.memory.mode == 1
        assert desk.go_on(0.3) == {Mode.TORQUE}


def test_fault_leaves_the_arm_in_position_mode_until_it_is_reset_and_connected_anew(
    standin: StandIn, desk: Desk
) -> None:
    with desk.session:
        desk.law.broken = True
        for _ in range(3):
            desk.go_on(0.5)
            desk.law.broken = False
            desk.go_on(1.1)
            if desk.supervisor.acknowledge() is None:
                desk.session.arm()
                desk.law.broken = True
        assert desk.supervisor.mode is Mode.FAULT
        assert standin.memory.mode == 0
        event = desk.supervisor.event
        assert event is not None
        desk.supervisor.reset(event)
        assert desk.supervisor.mode is Mode.IDLE
        desk.session.arm()
        assert standin.memory.mode == 1


def test_arm_that_may_not_be_armed_stays_in_position_mode(standin: StandIn, desk: Desk) -> None:
    standin.memory.refuse_torque_mode = 1
    with pytest.raises(TorqueEntryError), desk.session:
        pass
    assert desk.supervisor.mode is Mode.POSITION
    assert standin.memory.mode == 0


def test_arm_with_bad_readings_is_not_connected(standin: StandIn, desk: Desk) -> None:
    arm = desk.session._robot
    read, count = arm.read, itertools.count(1)

    def bad_now_and_then() -> object:
        # Each time anew: it is the reading in which the call fails that counts.
        if next(count) in (10, 20, 30):
            standin.fail("GetAngularForce", 1015, times=1)
        return read()

    arm.read = bad_now_and_then  # type: ignore[method-assign,assignment]
    with pytest.raises(HardwareError, match=r"[123] of 50 readings of the arm were bad"), desk.session:
        pass
    assert desk.supervisor.mode is Mode.IDLE
