"""The arm through a ROS driver: a real master, the stand-in's node, and the reaction proven by how the arm moves."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hardware.ros_driver_node import Switches
from hardware.ros_graph import set_parameter
from hardware.standin import StandIn

from burnish.core import Array, JointPosition, JointVelocity, Torque
from burnish.errors import InputError
from burnish.hardware import ros1_driver
from burnish.hardware.link import ArmFaultError
from burnish.hardware.ros1 import RosJaco2
from burnish.hardware.ros1_node import DriverError
from burnish.hardware.ros1_torque import RosTorqueSetup
from burnish.hardware.torque_mode import ModeError
from burnish.model.model import Model
from burnish.sim.robot import HOME

MODEL = Model.jaco2()
TORQUE = RosTorqueSetup()
Make = Callable[..., RosJaco2]


def hold(arm: RosJaco2, cycles: int, push: Array | float = 0.0) -> int:
    """Hold the arm by its weight's torque, and a push, for so many cycles; how many of them it did."""
    for cycle in range(cycles):
        try:
            arm.write(Torque(MODEL.at(arm.read()).g + push))
        except (ArmFaultError, ModeError):
            return cycle
    return cycles


def tool_drift(standin: StandIn, since: float) -> float:
    """How far the tool moved after a time [m]."""
    times, q, _ = standin.trace()
    p = np.array([MODEL.kinematics(at)[0] for at in q[times >= since - 1e-9]])
    return float(np.linalg.norm(p - p[0], axis=1).max())


# The cycle.


def test_the_arm_takes_torques_inside_the_block_and_holds_in_position_mode_afterwards(
    standin: StandIn, ros_jaco2: Make
) -> None:
    with ros_jaco2(torque=TORQUE) as arm:
        assert standin.memory.mode == 1
        first = arm.read()
        assert first.t == pytest.approx(0.0, abs=2e-3)
        assert arm.read().t == pytest.approx(first.t + 0.01, abs=2e-3)
        assert hold(arm, 50) == 50
        assert arm.bad_readings == 0
    assert standin.memory.mode == 0
    standin.advance(0.5)
    assert standin.trace()[2][-1] == 0.0
    assert tool_drift(standin, 0.0) < 2e-3


def test_gravity_is_in_our_torques_and_not_in_those_that_are_published(standin: StandIn, ros_jaco2: Make) -> None:
    with ros_jaco2(torque=TORQUE) as arm:
        assert np.abs(np.array(standin.memory.gravity)).max() > 4.0, "the base does not hold the arm"
        for _ in range(50):
            state = arm.read()
            applied = arm.write(Torque(MODEL.at(state).g))
            np.testing.assert_allclose(applied, MODEL.at(state).g)
        assert np.abs(np.array(standin.memory.torque_command)).max() < 0.1
    assert tool_drift(standin, 0.0) < 2e-3


@pytest.mark.slow
def test_measured_torques_include_gravity_even_where_the_driver_was_told_to_take_it_off(
    standin: StandIn, node: Switches, ros_jaco2: Make
) -> None:
    set_parameter("torque_parameters/publish_torque_with_gravity_compensation", True)
    with ros_jaco2(torque=TORQUE) as arm:
        state = arm.read()
        assert state.tau is not None
        np.testing.assert_allclose(state.tau, MODEL.at(state).g, atol=1.5)


def test_joints_are_told_by_their_names(standin: StandIn, node: Switches, ros_jaco2: Make) -> None:
    node.reordered = 1
    with ros_jaco2() as arm:
        np.testing.assert_allclose(arm.read().q, HOME, atol=0.01)


def test_another_robots_joints_are_refused(standin: StandIn, node: Switches, ros_jaco2: Make) -> None:
    node.renamed = 1
    with pytest.raises(DriverError, match=r"left_j2n6s300_joint_1.*expected angles and torques of j2n6s300_joint_1"):
        ros_jaco2().__enter__()


@pytest.mark.slow
@pytest.mark.parametrize("joint", [0, 5])
def test_angles_are_unwrapped_and_commands_go_the_short_way(standin: StandIn, ros_jaco2: Make, joint: int) -> None:
    q, speed = HOME.copy(), np.zeros(6)
    q[joint], speed[joint] = np.pi - 0.1, 0.3
    standin.reset(q=q, wrapped=True)
    with ros_jaco2() as arm:
        seen = []
        for _ in range(150):
            seen.append(arm.read().q[joint])
            arm.write(JointVelocity(speed))
        assert standin.memory.position[joint] < 0.0
        assert np.all(np.diff(seen) >= -1e-6)
        assert seen[-1] - seen[0] == pytest.approx(0.41, abs=0.03)
        back = arm.read().q.copy()
        back[joint] = seen[0]
        arm.go_to(back)
    truth = standin.trace()[1][:, joint]
    assert truth.max() - truth[0] < 0.5
    assert truth[-1] - truth[0] == pytest.approx(0.0, abs=0.01)


@pytest.mark.slow
def test_home_and_positions(standin: StandIn, ros_jaco2: Make) -> None:
    standin.reset(q=HOME + 0.1)
    goal = HOME + np.array([0.1, -0.1, 0.1, 0.1, 0.1, -0.1])
    beyond: Array = HOME.copy()
    beyond[1] = np.deg2rad(40.0)
    with ros_jaco2() as arm:
        arm.home()
        np.testing.assert_allclose(arm.read().q, HOME, atol=np.deg2rad(0.1))
        arm.go_to(goal)
        np.testing.assert_allclose(standin.trace()[1][-1], goal, atol=np.deg2rad(0.2))
        with pytest.raises(InputError, match="beyond a joint limit"):
            arm.write(JointPosition(beyond))


@pytest.mark.slow
def test_commands_of_the_other_mode_are_refused(standin: StandIn, ros_jaco2: Make) -> None:
    with ros_jaco2() as arm:
        with pytest.raises(InputError, match="Torque while the arm is in position mode; give RosJaco2 a TorqueSetup"):
            arm.write(Torque(np.zeros(6)))
        arm.start_torque(TORQUE)
        with pytest.raises(InputError, match="JointVelocity while the arm is in torque mode"):
            arm.write(JointVelocity(np.zeros(6)))


def test_a_torque_that_is_none_is_not_sent_and_the_arm_goes_to_position_mode(standin: StandIn, ros_jaco2: Make) -> None:
    with pytest.raises(InputError, match="expected 6 finite numbers"), ros_jaco2(torque=TORQUE) as arm:
        arm.write(Torque(np.full(6, np.nan)))
    assert standin.memory.mode == 0
    assert np.all(np.isfinite(standin.memory.torque_command))


def test_whatever_ends_the_block_the_arm_is_in_position_mode(standin: StandIn, ros_jaco2: Make) -> None:
    def interrupted(arm: RosJaco2) -> None:
        hold(arm, 20)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), ros_jaco2(torque=TORQUE) as arm:
        interrupted(arm)
    assert standin.memory.mode == 0
    assert tool_drift(standin, 0.0) < 2e-3


@pytest.mark.slow
@pytest.mark.parametrize("pose", [[180.0, 180.0, 180.0, 0.0, 0.0, 180.0], [90.0, 180.0, 180.0, 180.0, 180.0, 180.0]])
def test_torques_are_zeroed_where_gravity_turns_no_joint(standin: StandIn, ros_jaco2: Make, pose: list[float]) -> None:
    standin.reset(q=np.deg2rad(pose))
    with ros_jaco2() as arm:
        arm.zero_torques()
        measured = np.mean([arm.read().tau for _ in range(20)], axis=0)
    assert np.abs(measured).max() < 0.3


@pytest.mark.slow
def test_torques_are_not_zeroed_anywhere_else(standin: StandIn, ros_jaco2: Make) -> None:
    with ros_jaco2() as arm, pytest.raises(InputError, match="no pose for it"):
        arm.zero_torques()
    assert standin.calls("SetTorqueZero") == 0


# What goes wrong.


def test_without_joint_states_the_arm_is_stopped_in_the_third_cycle(
    standin: StandIn, node: Switches, ros_jaco2: Make
) -> None:
    def torque_mode_until_silence() -> None:
        with ros_jaco2(torque=TORQUE) as arm:
            assert hold(arm, 20) == 20
            node.silent = 1
            for _ in range(2):
                arm.write(Torque(MODEL.at(arm.read()).g))
            arm.read()

    with pytest.raises(ArmFaultError, match=r"no new joint state from /j2n6s300_driver.*in 3 cycles in a row"):
        torque_mode_until_silence()
    standin.advance(0.05)
    assert standin.trace()[2][-1] == 0.0
    assert tool_drift(standin, 0.0) < 2e-3


@pytest.mark.slow
def test_joint_states_of_a_frozen_arm_stop_it(standin: StandIn, ros_jaco2: Make) -> None:
    with ros_jaco2(torque=TORQUE) as arm:
        assert hold(arm, 20) == 20
        # The driver goes on sending, with new time stamps: nothing but the numbers shows it.
        standin.memory.frozen = 1
        assert 3 <= hold(arm, 20) <= 5
        standin.memory.frozen = 0


def test_an_arm_that_drops_to_position_mode_in_the_middle_of_a_move_is_noticed(
    standin: StandIn, ros_jaco2: Make
) -> None:
    with ros_jaco2(torque=TORQUE) as arm:
        assert hold(arm, 20) == 20
        standin.memory.drop_to_position = 1
        # Torques that would have to move it; the most that gears hold is below.
        assert 30 <= hold(arm, 60, push=np.array([6.0, 0, 0, 0, 0, 0])) < 40
        with pytest.raises(InputError, match="in position mode"):
            arm.write(Torque(np.zeros(6)))
        assert standin.memory.mode == 0


@pytest.mark.slow
def test_an_arm_that_holds_something_heavy_still_follows(standin: StandIn, ros_jaco2: Make) -> None:
    with ros_jaco2(torque=TORQUE) as arm:
        # Half of what the wrist's gears are thought to hold, and no more motion than friction allows.
        assert hold(arm, 100, push=np.array([0, 0, 0, 0.8, 0, 0])) == 100


@pytest.mark.slow
@pytest.mark.parametrize("holds", [True, False])
def test_without_torques_the_arm_stays_where_it_is(
    standin: StandIn, node: Switches, ros_jaco2: Make, holds: bool
) -> None:
    node.holds = int(holds)
    with ros_jaco2(torque=TORQUE) as arm:
        assert hold(arm, 20) == 20
        since = standin.memory.time
        standin.advance(0.8)
        # kinova-ros leaves the base's default, zero torque: then the weight that the base adds keeps it up.
        assert standin.memory.mode == (0 if holds else 1)
        drift = tool_drift(standin, since)
        print(f"{'position held' if holds else 'zero torque'} in silence: the tool drifts by {1e3 * drift:.2f} mm")
        assert drift < 20e-3


@pytest.mark.slow
def test_a_driver_that_does_not_answer_at_the_end_is_said_out_loud(
    standin: StandIn, node: Switches, ros_jaco2: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ros1_driver, "ANSWER", 0.2)
    node.holds = 1
    arm = ros_jaco2(torque=TORQUE)
    arm.__enter__()
    hold(arm, 5)
    node.hung = 1
    with pytest.raises(ModeError, match=r"did not answer within 0\.2 s.*press the emergency stop"):
        arm.__exit__(None)
    standin.advance(0.3)
    assert standin.memory.mode == 0


def test_no_driver_is_said(standin: StandIn, ros_jaco2: Make) -> None:
    with pytest.raises(DriverError, match="no new joint state from /left_driver; look whether the driver runs"):
        ros_jaco2(robot="left").__enter__()


def test_no_master_is_said(standin: StandIn, ros_jaco2: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", "http://127.0.0.1:9")
    with pytest.raises(
        DriverError, match=r"no ROS master at http://127\.0\.0\.1:9; start roscore, or set ROS_MASTER_URI"
    ):
        ros_jaco2().__enter__()


def test_names_that_are_no_robots_are_refused(standin: StandIn, ros_jaco2: Make) -> None:
    with pytest.raises(InputError, match=r"robot name '\.\./x'"):
        ros_jaco2(robot="../x").__enter__()


def test_the_drivers_usual_ten_states_a_second_do_for_position_mode_on_real_time(
    standin: StandIn, node: Switches
) -> None:
    standin.reset(realtime=True)
    node.interval = 0.1
    with RosJaco2(MODEL) as arm:
        times = [arm.read().t for _ in range(5)]
        np.testing.assert_allclose(arm.read().q, HOME, atol=0.01)
    assert np.all(np.diff(times) > 0.0)
