"""Into torque mode over ROS, where the mode cannot be read back: refused, the arm has not been in torque mode."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hardware.ros_driver_node import Switches
from hardware.ros_graph import RosClock, set_parameter
from hardware.standin import StandIn

from burnish.errors import InputError
from burnish.hardware.ros1 import RosJaco2
from burnish.hardware.ros1_torque import RosTorqueSetup
from burnish.hardware.torque_mode import ModeError, TorqueEntryError
from burnish.model.model import Model
from burnish.sim.robot import HOME

TORQUE = RosTorqueSetup()
STANDS = np.deg2rad(0.05)
"""What the arm may move while it is refused."""
Make = Callable[..., RosJaco2]


def moved(standin: StandIn) -> float:
    """How far a joint was at most from where it began [rad]."""
    _, q, _ = standin.trace()
    return float(np.abs(q - q[0]).max())


def refused(standin: StandIn, arm: RosJaco2, match: str) -> None:
    with pytest.raises(TorqueEntryError, match=match), arm:
        pass
    standin.advance(0.5)
    assert set(standin.trace()[2]) == {0.0}


@pytest.mark.slow
def test_torque_mode_is_seen_by_a_turn_of_the_last_joint_that_ends_by_itself(standin: StandIn, ros_jaco2: Make) -> None:
    with ros_jaco2(torque=TORQUE):
        _, q, _ = standin.trace()
        turned = np.abs(q - q[0]).max(axis=0)
    assert np.deg2rad(0.3) < turned[5] < np.deg2rad(2.0)
    assert turned[:5].max() < np.deg2rad(0.3)


def test_a_switch_that_the_arm_refuses_in_silence_is_seen(standin: StandIn, ros_jaco2: Make) -> None:
    standin.memory.refuse_torque_mode = 1
    refused(standin, ros_jaco2(torque=TORQUE), "joint 6 does not turn under 4 N·m, so the arm stayed in position mode")
    assert moved(standin) < STANDS


def test_an_answer_that_says_no_is_not_believed_either(standin: StandIn, node: Switches, ros_jaco2: Make) -> None:
    node.wordless = 1
    with ros_jaco2(torque=TORQUE):
        assert standin.memory.mode == 1
    assert standin.memory.mode == 0


@pytest.mark.slow
@pytest.mark.parametrize("carried", [1.0, 0.0])
def test_a_payload_that_is_a_kilogram_wrong_is_refused(standin: StandIn, ros_jaco2: Make, carried: float) -> None:
    standin.reset(payload=carried)
    declared = Model.jaco2() if carried else Model.jaco2().with_payload(1.0)
    refused(standin, ros_jaco2(model=declared, torque=TORQUE), r"joint \d measures [+-]\d\.\d+ N·m beside the model")
    assert moved(standin) < np.deg2rad(0.2)


@pytest.mark.slow
def test_the_right_payload_is_let_in_if_the_base_is_told_too(standin: StandIn, ros_jaco2: Make) -> None:
    standin.reset(payload=1.0)
    with ros_jaco2(model=Model.jaco2().with_payload(1.0), torque=RosTorqueSetup(payload=1.0)):
        assert standin.memory.mode == 1
    assert moved(standin) < np.deg2rad(2.0)


def test_a_payload_that_only_the_model_knows_ends_in_position_mode(standin: StandIn, ros_jaco2: Make) -> None:
    standin.reset(payload=1.0)
    with pytest.raises(TorqueEntryError, match="drifted by"):
        ros_jaco2(model=Model.jaco2().with_payload(1.0), torque=TORQUE).__enter__()
    assert standin.memory.mode == 0
    assert moved(standin) < np.deg2rad(8.0)


def test_a_base_that_does_not_hold_the_weight_is_refused(standin: StandIn, node: Switches, ros_jaco2: Make) -> None:
    set_parameter("torque_parameters/com_parameters", [0.0] * 16)
    refused(standin, ros_jaco2(torque=TORQUE), "com_parameters are zero")
    assert moved(standin) < STANDS


def test_a_moving_arm_is_refused(standin: StandIn, ros_jaco2: Make) -> None:
    standin.memory.joystick = 0.2
    standin.advance(0.3)
    with pytest.raises(ModeError, match="does not stand in position mode: it goes on moving"):
        ros_jaco2(torque=TORQUE).__enter__()
    assert set(standin.trace()[2]) == {0.0}


@pytest.mark.slow
def test_an_arm_that_begins_to_move_is_refused(standin: StandIn, ros_jaco2: Make, ros_clock: RosClock) -> None:
    with ros_jaco2() as arm:
        stop = arm.stop_torque

        def stop_and_be_pushed() -> None:
            stop()
            standin.memory.joystick = 0.2
            ros_clock.wait(ros_clock.now() + 0.3)

        arm.stop_torque = stop_and_be_pushed  # type: ignore[method-assign]
        with pytest.raises(TorqueEntryError, match=r"joint 1 moves at \d+\.\d°/s; wait until the arm is at rest"):
            arm.start_torque(TORQUE)
        arm.stop_torque = stop  # type: ignore[method-assign]
        standin.memory.joystick = 0.0
    assert set(standin.trace()[2]) == {0.0}


@pytest.mark.slow
@pytest.mark.parametrize(("joint", "angle_deg"), [(1, 60.0), (2, 330.0)])
def test_a_pose_next_to_a_limit_is_refused(standin: StandIn, ros_jaco2: Make, joint: int, angle_deg: float) -> None:
    q = HOME.copy()
    q[joint] = np.deg2rad(angle_deg)
    standin.reset(q=q)
    refused(standin, ros_jaco2(torque=TORQUE), rf"joint {joint + 1} is 1[13]\.\d° from its limit; move it at least 15°")
    assert moved(standin) < STANDS


def test_the_drivers_usual_ten_states_a_second_are_too_few(standin: StandIn, node: Switches, ros_jaco2: Make) -> None:
    node.interval = 0.1
    refused(standin, ros_jaco2(torque=TORQUE), r"joint states come at 10 Hz; start the driver with status_interval_sec")


def test_set_ups_that_cannot_be_are_refused() -> None:
    for wrong in ({"safety_factor": 1.5}, {"payload": -1.0}, {"payload_com": np.zeros(2)}):
        with pytest.raises(InputError, match="RosTorqueSetup"):
            RosTorqueSetup(**wrong)  # type: ignore[arg-type]
