"""Into torque mode only when everything is as it has to be; refused, the arm is in position mode and has not moved."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hardware.standin import StandIn, SteppedClock

from burnish.core import Array, JointVelocity, Torque
from burnish.errors import HardwareError, InputError
from burnish.hardware.jaco2 import Jaco2
from burnish.hardware.torque_mode import ModeError, TorqueEntryError, TorqueSetup
from burnish.model.model import Model
from burnish.sim.robot import HOME

THESIS_A = TorqueSetup.thesis_a()
IDENTIFIED = np.array([1.22, 0.05, -0.015, -1.15, -0.005, 0.56, 0.001, 0.18, -0.004, -0.002, 0, 0, 0, 0, 0, 0])
"""The shape of an identified set; the stand-in takes anything but zeros for the arm's own."""
STANDS = np.deg2rad(0.05)
"""What the arm may move while it is refused: position loops carry an unknown kilogram to within 0.1°."""


def moved(standin: StandIn) -> float:
    """How far a joint was at most from where it began [rad]."""
    _, q, _ = standin.trace()
    return float(np.abs(q - q[0]).max())


def modes(standin: StandIn) -> set[float]:
    """The modes that the arm was in."""
    return set(standin.trace()[2])


def refused(standin: StandIn, arm: Jaco2, match: str) -> None:
    with pytest.raises(TorqueEntryError, match=match), arm:
        pass
    # Whatever was asked for last is through by now, and shows.
    standin.advance(0.5)
    assert modes(standin) == {0.0}


def test_the_arm_is_in_torque_mode_inside_the_block_and_holds_afterwards(
    standin: StandIn, jaco2: Callable[..., Jaco2]
) -> None:
    with jaco2(torque=THESIS_A) as arm:
        assert standin.memory.mode == 1
        state = arm.read()
        assert state.t == pytest.approx(0.0, abs=1e-9)
    # At once, and not only after the 250 ms without a command.
    assert standin.trace()[2][-1] == 0.0
    standin.advance(1.0)
    # The drawn arm's links weigh up to a tenth more or less than its model; friction holds the rest.
    assert moved(standin) < np.deg2rad(0.5)


def test_the_set_up_of_thesis_a_leaves_the_torque_to_us(standin: StandIn, jaco2: Callable[..., Jaco2]) -> None:
    with jaco2(torque=THESIS_A):
        # The base adds nothing for gravity, and falls back to holding when we are silent.
        assert not np.any(standin.memory.gravity)
        assert standin.calls("SetTorqueInactivityType") == 1
        standin.advance(0.4)
        times, _, mode = standin.trace()
        assert times[mode == 1.0][-1] - standin.memory.torque_taken_at < 0.25 + 1e-6
        assert standin.memory.mode == 0


def test_with_the_set_up_of_thesis_b_gravity_is_not_counted_twice(
    standin: StandIn, jaco2: Callable[..., Jaco2]
) -> None:
    model = Model.jaco2()
    with jaco2(torque=TorqueSetup.thesis_b(IDENTIFIED)) as arm:
        assert np.abs(np.array(standin.memory.gravity)).max() > 4.0
        for _ in range(100):
            state = arm.read()
            applied = arm.write(Torque(model.at(state).g))
            # What is applied includes gravity, what is sent does not.
            np.testing.assert_allclose(applied, model.at(state).g)
            assert np.abs(np.array(standin.memory.torque_command)).max() < 0.1
    assert moved(standin) < np.deg2rad(0.5)


def test_gravity_twice_is_noticed_by_the_motion(standin: StandIn, jaco2: Callable[..., Jaco2]) -> None:
    # A base that goes on compensating although it was told not to: half of the calls were lost.
    standin.fail("SetGravityOptimalZParam", 1)
    with pytest.raises(TorqueEntryError, match="drifted by"), jaco2(torque=THESIS_A):
        pass
    standin.advance(0.5)
    assert standin.memory.mode == 0
    assert moved(standin) < np.deg2rad(6.0)


@pytest.mark.parametrize("carried", [1.0, 0.0])
def test_a_payload_that_is_a_kilogram_wrong_is_refused(
    standin: StandIn, jaco2: Callable[..., Jaco2], carried: float
) -> None:
    standin.reset(payload=carried)
    declared = Model.jaco2() if carried else Model.jaco2().with_payload(1.0)
    refused(standin, jaco2(model=declared, torque=THESIS_A), r"joint \d measures [+-]\d\.\d+ N·m beside the model")
    assert moved(standin) < np.deg2rad(0.2)


def test_the_right_payload_is_let_in(standin: StandIn, jaco2: Callable[..., Jaco2]) -> None:
    standin.reset(payload=1.0)
    with jaco2(model=Model.jaco2().with_payload(1.0), torque=THESIS_A):
        assert standin.memory.mode == 1


@pytest.mark.parametrize(("joint", "angle_deg"), [(1, 60.0), (1, 300.0), (2, 30.0), (2, 330.0)])
def test_a_pose_next_to_a_limit_is_refused(
    standin: StandIn, jaco2: Callable[..., Jaco2], joint: int, angle_deg: float
) -> None:
    q = HOME.copy()
    q[joint] = np.deg2rad(angle_deg)
    standin.reset(q=q)
    refused(standin, jaco2(torque=THESIS_A), rf"joint {joint + 1} is 1[13]\.\d° from its limit; move it at least 15°")
    assert moved(standin) < STANDS


def test_a_moving_arm_is_refused(standin: StandIn, jaco2: Callable[..., Jaco2]) -> None:
    standin.memory.joystick = 0.2
    standin.advance(0.3)
    refused(standin, jaco2(torque=THESIS_A), r"joint 1 moves at 11\.\d°/s; wait until the arm is at rest")


def test_a_silently_refused_switch_is_noticed(standin: StandIn, jaco2: Callable[..., Jaco2]) -> None:
    standin.memory.refuse_torque_mode = 1
    refused(standin, jaco2(torque=THESIS_A), "took the switch without an error and stayed in position mode")
    assert moved(standin) < STANDS


def test_a_firmware_that_takes_no_torque_in_position_mode_is_entered_all_the_same(
    standin: StandIn, jaco2: Callable[..., Jaco2]
) -> None:
    standin.fail("SendAngularTorqueCommand", 2005, times=1)
    with jaco2(torque=THESIS_A):
        assert standin.memory.mode == 1


@pytest.mark.parametrize("call", ["SetTorqueInactivityType", "SetTorqueSafetyFactor", "SetTorqueControlType"])
def test_a_set_up_that_fails_ends_in_position_mode(standin: StandIn, jaco2: Callable[..., Jaco2], call: str) -> None:
    standin.fail(call, 2005)
    with pytest.raises(HardwareError, match=call), jaco2(torque=THESIS_A):
        pass
    standin.advance(0.5)
    assert modes(standin) == {0.0}
    assert moved(standin) < STANDS


def test_an_arm_that_a_killed_program_left_in_torque_mode_is_taken_back(
    standin: StandIn, jaco2: Callable[..., Jaco2], clock: SteppedClock
) -> None:
    before = jaco2(torque=THESIS_A)
    before.__enter__()
    assert standin.memory.mode == 1
    with jaco2() as arm:
        arm.read()
        assert standin.memory.mode == 0


def test_another_serial_number_is_refused(standin: StandIn, jaco2: Callable[..., Jaco2]) -> None:
    standin.memory.devices = 2
    with jaco2(serial="PJ00650019161750002"):
        assert standin.memory.active == b"PJ00650019161750002"
    with pytest.raises(HardwareError, match=r"no arm has the serial number X; connected: PJ\w+1, PJ\w+2"):
        jaco2(serial="X").__enter__()


def test_commands_of_the_other_mode_are_refused(standin: StandIn, jaco2: Callable[..., Jaco2]) -> None:
    with jaco2() as arm:
        arm.read()
        with pytest.raises(InputError, match="Torque while the arm is in position mode; give Jaco2 a TorqueSetup"):
            arm.write(Torque(np.zeros(6)))
        arm.start_torque(THESIS_A)
        with pytest.raises(InputError, match="JointVelocity while the arm is in torque mode; stop_torque comes first"):
            arm.write(JointVelocity(np.zeros(6)))
        with pytest.raises(InputError, match="home while the arm is in torque mode"):
            arm.home()


@pytest.mark.parametrize("tau", [np.full(6, np.nan), np.zeros(5), np.full(6, np.inf)])
def test_a_torque_that_is_none_is_refused_and_the_arm_goes_to_position_mode(
    standin: StandIn, jaco2: Callable[..., Jaco2], tau: Array
) -> None:
    with pytest.raises(InputError, match="expected 6 finite numbers"), jaco2(torque=THESIS_A) as arm:
        arm.write(Torque(tau))
    assert standin.trace()[2][-1] == 0.0
    assert np.all(np.isfinite(standin.memory.torque_command))


def test_set_ups_that_cannot_be_are_refused() -> None:
    for wrong in ({"optimal_z": np.zeros(15)}, {"safety_factor": 1.5}, {"payload": -1.0}, {"vibration": np.nan}):
        with pytest.raises(InputError, match="TorqueSetup"):
            TorqueSetup(**wrong)  # type: ignore[arg-type]


def test_an_arm_that_does_not_leave_torque_mode_is_said_out_loud(standin: StandIn, jaco2: Callable[..., Jaco2]) -> None:
    with pytest.raises(ModeError, match="press the emergency stop"), jaco2(torque=THESIS_A):
        standin.fail("SwitchTrajectoryTorque", 2005)
    # By itself it holds all the same.
    standin.advance(0.3)
    assert standin.memory.mode == 0
