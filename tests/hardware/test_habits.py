"""The bad habits of firmware, cable and clock, one a test: the documented reaction, proven by how the arm moves."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hardware.standin import StandIn, SteppedClock

from burnish.core import Array, JointPosition, JointVelocity, State, Torque
from burnish.errors import InputError
from burnish.hardware.jaco2 import Jaco2
from burnish.hardware.kinova import Kinova
from burnish.hardware.kinova_library import Library, find
from burnish.hardware.kinova_types import ControlMode, Inactivity
from burnish.hardware.link import ArmFaultError
from burnish.hardware.torque_mode import ModeError, TorqueSetup
from burnish.model.model import Model
from burnish.sim.robot import HOME

MODEL = Model.jaco2()
THESIS_A = TorqueSetup.thesis_a()
PERIOD = 0.01


def hold(arm: Jaco2, cycles: int, push: Array | float = 0.0) -> int:
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


def rests_in_position_mode(standin: StandIn, within: float = 0.05) -> bool:
    """Whether the arm is in position mode so soon, and stands still from then on."""
    standin.advance(within)
    at_once = standin.trace()[2][-1] == 0.0
    standin.advance(0.3)
    _, q, _ = standin.trace()
    return at_once and float(np.abs(q[-1] - q[-20]).max()) < 1e-4


# Bad readings.


@pytest.mark.parametrize("value", [np.nan, np.inf, -1.07e8, 1e30])
def test_two_readings_of_garbage_with_code_1_are_bridged(
    standin: StandIn, jaco2: Callable[..., Jaco2], value: float
) -> None:
    with jaco2(torque=THESIS_A) as arm:
        assert hold(arm, 20) == 20
        before = arm.read()
        arm.write(Torque(MODEL.at(before).g))
        standin.memory.garbage_value = value
        standin.memory.garbage = 4  # angles and torques of two readings
        for _ in range(2):
            state = arm.read()
            np.testing.assert_array_equal(state.q, before.q)
            np.testing.assert_array_equal(state.tau, before.tau)
            arm.write(Torque(MODEL.at(state).g))
        assert state.t == pytest.approx(before.t + 2 * PERIOD)
        assert hold(arm, 20) == 20
        assert arm.bad_readings == 2
        assert standin.memory.mode == 1
    assert tool_drift(standin, 0.0) < 2e-3


@pytest.mark.parametrize("value", [np.nan, -1.07e8])
def test_garbage_that_goes_on_stops_the_arm_in_the_third_cycle(
    standin: StandIn, jaco2: Callable[..., Jaco2], value: float
) -> None:
    def torque_mode_until_the_fault() -> None:
        with jaco2(torque=THESIS_A) as arm:
            assert hold(arm, 20) == 20
            standin.memory.garbage_value, standin.memory.garbage = value, -1
            for _ in range(2):
                arm.write(Torque(MODEL.at(arm.read()).g))
            arm.read()

    with pytest.raises(ArmFaultError, match=r"in 3 cycles in a row\. Stopped: the arm is in position mode"):
        torque_mode_until_the_fault()
    assert rests_in_position_mode(standin)
    assert tool_drift(standin, 0.0) < 2e-3


def test_an_angle_that_jumps_is_not_believed(standin: StandIn, jaco2: Callable[..., Jaco2]) -> None:
    with jaco2(torque=THESIS_A) as arm:
        hold(arm, 20)
        q = arm.read().q
        # An angle that the arm may have, but not 10 ms later.
        standin.memory.garbage_value, standin.memory.garbage = 200.0, 1
        np.testing.assert_array_equal(arm.read().q, q)
        assert arm.bad_readings == 1


def test_stale_bytes_stop_the_arm(standin: StandIn, jaco2: Callable[..., Jaco2]) -> None:
    with jaco2(torque=THESIS_A) as arm:
        assert hold(arm, 20) == 20
        standin.memory.frozen = 1
        # Two repeats are what a slow arm shows, two more are bridged: 50 ms.
        assert hold(arm, 20) == 4
        standin.memory.frozen = 0
        assert rests_in_position_mode(standin)


@pytest.mark.parametrize("call", ["GetAngularPosition", "GetAngularForce", "GetTrajectoryTorqueMode"])
@pytest.mark.parametrize("code", [2005, 1022])
def test_a_reading_that_fails_twice_is_bridged_and_thrice_stops_the_arm(
    standin: StandIn, jaco2: Callable[..., Jaco2], call: str, code: int
) -> None:
    always = call != "GetTrajectoryTorqueMode"
    with jaco2(torque=THESIS_A) as arm:
        hold(arm, 10)
        standin.fail(call, code, times=2)
        assert hold(arm, 30) == 30
        if always:
            standin.fail(call, code, times=3)
            assert hold(arm, 30) == 2
            assert rests_in_position_mode(standin)


# Commands that do not arrive.


@pytest.mark.parametrize("code", [2005, 9999, 2004])
def test_a_command_that_is_refused_twice_is_bridged_and_thrice_stops_the_arm(
    standin: StandIn, jaco2: Callable[..., Jaco2], code: int
) -> None:
    with jaco2(torque=THESIS_A) as arm:
        standin.fail("SendAngularTorqueCommand", code, times=2)
        assert hold(arm, 10) == 10
        standin.fail("SendAngularTorqueCommand", code, times=3)
        assert hold(arm, 10) == 2
        assert rests_in_position_mode(standin)
    assert tool_drift(standin, 0.0) < 2e-3


@pytest.mark.parametrize("code", [1007, 1011, 1015])
def test_unplugged_the_driver_gives_up_in_three_cycles_and_the_arm_holds_by_itself(
    standin: StandIn, jaco2: Callable[..., Jaco2], code: int
) -> None:
    def torque_mode_until_the_plug_is_out() -> None:
        with jaco2(torque=THESIS_A) as arm:
            assert hold(arm, 20) == 20
            standin.memory.unplugged = code
            for _ in range(3):
                arm.write(Torque(MODEL.at(arm.read()).g))

    with pytest.raises(ArmFaultError, match=rf"\(code {code}\); check (the )?cable.*press the emergency stop"):
        torque_mode_until_the_plug_is_out()
    last_command = standin.memory.torque_taken_at
    standin.advance(0.3)
    times, _, mode = standin.trace()
    assert mode[-1] == 0.0
    assert times[mode == 1.0][-1] <= last_command + 0.25 + 1e-6
    assert tool_drift(standin, last_command) < 0.02


# Modes.


def test_an_arm_that_drops_to_position_mode_ends_the_loop_and_stands(
    standin: StandIn, jaco2: Callable[..., Jaco2]
) -> None:
    with jaco2(torque=THESIS_A) as arm:
        assert hold(arm, 20) == 20
        standin.memory.drop_to_position = 1
        # The mode is looked at every fifth cycle, and shown a tick late.
        assert hold(arm, 20) <= 7
        assert rests_in_position_mode(standin)
        with pytest.raises(InputError, match="Torque while the arm is in position mode"):
            arm.write(Torque(np.zeros(6)))


def test_a_joint_faster_than_the_safety_factor_allows_is_stopped_by_the_base(
    standin: StandIn, jaco2: Callable[..., Jaco2]
) -> None:
    push = np.array([6.0, 0, 0, 0, 0, 0])
    with jaco2(torque=TorqueSetup(safety_factor=0.2)) as arm:
        assert hold(arm, 200, push) < 200
        # Braked from 7°/s.
        standin.advance(0.3)
        assert rests_in_position_mode(standin)


def test_silence_of_250_ms_is_a_hold_with_type_0_and_a_fall_with_the_vendors_default(
    standin: StandIn,
) -> None:
    fell = {}
    for kind in (Inactivity.HOLD_POSITION, Inactivity.ZERO_TORQUE):
        standin.reset()
        # Raw calls: the driver itself never leaves the default.
        with Kinova(Library(find())) as kinova:
            THESIS_A.apply(kinova, MODEL.effort_limit)
            kinova.set_inactivity(kind)
            standin.advance(0.05)
            kinova.send_torque(MODEL.at(State(t=0.0, q=HOME, dq=np.zeros(6))).g)
            kinova.switch(ControlMode.TORQUE)
            standin.advance(1.0)
        fell[kind] = tool_drift(standin, 0.0)
        assert standin.trace()[2][-1] == (0.0 if kind is Inactivity.HOLD_POSITION else 1.0)
    assert fell[Inactivity.HOLD_POSITION] < 0.005
    assert fell[Inactivity.ZERO_TORQUE] > 0.2


def test_no_command_gets_more_out_of_the_actuators_than_they_have(standin: StandIn) -> None:
    with Kinova(Library(find())) as kinova:
        for _ in range(150):
            kinova.send_velocity(np.full(6, 5.0))
        standin.advance(1.5)
        times, q, _ = (column[1:] for column in standin.trace())
        fastest = np.abs(np.diff(q, axis=0) / np.diff(times)[:, None]).max(axis=0)
        assert np.all(fastest < 1.02 * MODEL.velocity_limit)
        kinova.erase()
        kinova.send_position(HOME + np.array([0.0, 6.0, 6.0, 0.0, 0.0, 0.0]))
        standin.advance(12.0)
        assert np.all(MODEL.limit_distance(standin.trace()[1][-1]) > -0.01)


def test_the_torque_limits_of_the_set_up_are_kept_by_the_base(standin: StandIn) -> None:
    weight = MODEL.at(State(t=0.0, q=HOME, dq=np.zeros(6))).g
    with Kinova(Library(find())) as kinova:
        THESIS_A.apply(kinova, np.full(6, 0.5))
        kinova.send_torque(weight)
        kinova.switch(ControlMode.TORQUE)
        for _ in range(100):
            kinova.send_torque(weight)
            standin.advance(PERIOD)
    # Half a newton metre does not carry the arm: it sinks.
    assert tool_drift(standin, 0.0) > 0.1


# Queue and clock.


def test_a_burst_of_velocities_goes_on_for_seconds_and_the_driver_lets_none_queue_up(
    standin: StandIn, jaco2: Callable[..., Jaco2]
) -> None:
    with Kinova(Library(find())) as kinova:
        for _ in range(2500):
            kinova.send_velocity([0.1, 0, 0, 0, 0, 0])
        standin.advance(5.0)
        assert kinova.queued() == pytest.approx(2000 - 500, abs=2)
    assert standin.trace()[1][-1][0] - HOME[0] == pytest.approx(0.5, abs=0.01)
    standin.reset()
    with jaco2() as arm:
        arm.read()
        for _ in range(300):
            # As fast as it goes, without reading in between.
            arm.write(JointVelocity(np.array([0.1, 0, 0, 0, 0, 0])))
            assert arm._kinova.queued() <= 2
        end = standin.trace()[1][-1][0]
        # Three seconds have gone by: it was the driver that waited.
        assert end - HOME[0] == pytest.approx(0.3, abs=0.02)
    standin.advance(0.5)
    # A cycle's motion, and the braking of the base, at 0.1 rad/s.
    assert standin.trace()[1][-1][0] - end < 0.01


def test_leaving_the_block_erases_what_is_queued(standin: StandIn, jaco2: Callable[..., Jaco2]) -> None:
    with jaco2() as arm:
        arm.read()
        arm.write(JointPosition(HOME + 0.5))
        for _ in range(30):
            arm.read()
    standin.advance(0.4)
    there = standin.trace()[1][-1]
    standin.advance(1.0)
    assert 0.01 < there[0] - HOME[0] < 0.3
    np.testing.assert_allclose(standin.trace()[1][-1], there, atol=1e-3)


@pytest.mark.parametrize(("rate", "off"), [((100.0, 100.0), 0.01), ((50.0, 60.0), 0.25), ((50.0, 100.0), 0.5)])
def test_an_arm_at_50_to_60_hz_is_held_and_its_speed_is_measured(
    standin: StandIn, jaco2: Callable[..., Jaco2], rate: tuple[float, float], off: float
) -> None:
    with jaco2() as arm:
        standin.memory.slowest, standin.memory.fastest = rate
        for _ in range(60):
            arm.read()
            arm.write(JointVelocity(np.full(6, 0.3)))
        speeds = []
        for _ in range(100):
            speeds.append(arm.read().dq)
            arm.write(JointVelocity(np.full(6, 0.3)))
        # The difference over a fixed period would be 0 in one cycle and double in the next.
        np.testing.assert_allclose(speeds, 0.3, rtol=off)
        assert arm.bad_readings == 0
        arm.go_to(HOME)
        arm.start_torque(THESIS_A)
        assert hold(arm, 100) == 100
        assert arm.bad_readings == 0


def test_late_cycles_are_counted_and_not_made_up_for(
    standin: StandIn, jaco2: Callable[..., Jaco2], clock: SteppedClock
) -> None:
    with jaco2() as arm:
        t = arm.read().t
        clock.wait(clock.now() + 0.055)
        late = arm.read().t
        assert late == pytest.approx(t + 0.055)
        assert arm.read().t == pytest.approx(late + PERIOD)
        assert arm.late_cycles == 1


# Turns.


@pytest.mark.parametrize("joint", [0, 3, 4, 5])
def test_angles_reported_within_a_turn_are_unwrapped_and_commands_go_the_short_way(
    standin: StandIn, jaco2: Callable[..., Jaco2], joint: int
) -> None:
    q = HOME.copy()
    q[joint] = np.pi - 0.1
    standin.reset(q=q, wrapped=True)
    speed = np.zeros(6)
    speed[joint] = 0.3
    with jaco2() as arm:
        seen = []
        for _ in range(150):
            seen.append(arm.read())
            arm.write(JointVelocity(speed))
        # Through 180°, where the report jumps by −360°.
        turned = np.array([state.q[joint] for state in seen])
        assert standin.memory.position[joint] < 0.0
        assert np.all(np.diff(turned) >= -1e-6)
        assert turned[-1] - turned[0] == pytest.approx(0.41, abs=0.03)
        assert max(abs(state.dq[joint]) for state in seen) < 0.31
        assert arm.bad_readings == 0
        back = seen[-1].q.copy()
        back[joint] = turned[0]
        arm.go_to(back)
        reported = np.rad2deg(turned[-1]) - 360.0
        sent = standin.memory.ring[standin.memory.head - 1].value[2 + joint]
        # In the turn that the arm reports: a firmware that takes it by the letter goes the short way too.
        assert abs(sent - reported) < 180.0
    _, truth, _ = standin.trace()
    assert truth[:, joint].max() - truth[0, joint] < 0.5
    assert truth[-1, joint] - truth[0, joint] == pytest.approx(0.0, abs=0.01)


def test_turns_that_the_arm_reports_are_kept(standin: StandIn, jaco2: Callable[..., Jaco2]) -> None:
    q = HOME + np.array([4 * np.pi, 0, 0, 0, 0, -6 * np.pi])
    standin.reset(q=q)
    with jaco2() as arm:
        np.testing.assert_allclose(arm.read().q, q, atol=1e-3)


# Positions.


def test_a_position_beyond_a_limit_is_refused_before_anything_moves(
    standin: StandIn, jaco2: Callable[..., Jaco2]
) -> None:
    beyond: Array = HOME.copy()
    beyond[1] = np.deg2rad(40.0)
    with jaco2() as arm:
        arm.read()
        with pytest.raises(InputError, match="beyond a joint limit"):
            arm.go_to(beyond)
        with pytest.raises(InputError, match="expected 6 finite numbers"):
            arm.write(JointPosition(np.full(6, np.nan)))
    assert standin.calls("SendBasicTrajectory") == 0


def test_home_and_fingers(standin: StandIn, jaco2: Callable[..., Jaco2]) -> None:
    standin.reset(q=HOME + 0.2)
    with jaco2() as arm:
        arm.home()
        np.testing.assert_allclose(arm.read().q, HOME, atol=np.deg2rad(0.1))
        arm.move_fingers([0.5, 0.5, 0.5])
        for _ in range(100):
            arm.read()
        np.testing.assert_allclose(arm.fingers(), 0.5, atol=1e-3)
        np.testing.assert_allclose(arm.read().q, HOME, atol=np.deg2rad(0.1))


def test_an_arm_that_does_not_arrive_is_stopped(standin: StandIn, jaco2: Callable[..., Jaco2]) -> None:
    standin.fail("SendBasicTrajectory", 1)  # lost on its way
    with jaco2() as arm, pytest.raises(ArmFaultError, match="did not arrive within 6 s"):
        arm.go_to(HOME + 0.1)
