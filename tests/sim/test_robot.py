from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from itertools import pairwise
from pathlib import Path

import mujoco
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from burnish.control.joint import ComputedTorque
from burnish.control.wrench import ContactSense, JointSense, WristSense
from burnish.core import Array, Dynamics, JointReference, State, Torque
from burnish.errors import InputError, SimulationError
from burnish.model.friction import Friction
from burnish.model.model import Model
from burnish.model.tool import PolishingTool
from burnish.sim import arms
from burnish.sim.plant import ENCODER_COUNTS, Plant
from burnish.sim.robot import HOME, SimRobot
from burnish.sim.scene import Workpiece
from burnish.surface import DistanceGrid

TOOL = PolishingTool()
MODEL = TOOL.on(Model.jaco2())
IDEAL = Plant.ideal()


def at_home(dq: Array | None = None) -> Dynamics:
    return MODEL.at(State(t=0.0, q=HOME, dq=np.zeros(6) if dq is None else dq))


WEIGHT = at_home().g
PUSH = np.array([0.3, -0.4, 0.3, 0.05, -0.05, 0.02])
"""A torque that moves the arm by some degrees within a tenth of a second."""


def run(robot: SimRobot, tau: Array, cycles: int) -> list[State]:
    """States under a constant torque, the first before it acts."""
    states = [robot.read()]
    for _ in range(cycles):
        robot.write(Torque(tau))
        states.append(robot.read())
    return states


def hold(robot: SimRobot, cycles: int, sense: ContactSense | None = None) -> list[Dynamics]:
    """Hold the arm stiffly where it is; the model at every cycle, with what is felt."""
    law = ComputedTorque.at_frequency(40.0, ki=4000.0)
    wanted = JointReference(q=HOME, dq=np.zeros(6), ddq=np.zeros(6))
    seen = []
    for i in range(cycles):
        state = robot.read()
        arm = MODEL.at(state)
        if i == 0:
            law.reset(arm)
        robot.write(Torque(law.torque(arm, wanted)))
        seen.append(arm if sense is None else sense.feel(arm, state))
    return seen


def plane(depth: float) -> Workpiece:
    """A plane across the tool's axis, with the apex of the tip ``depth`` inside it at home."""
    arm = at_home()
    nodes = np.moveaxis(np.mgrid[0:31, 0:31, 0:31], 0, -1) * 2e-3 - 0.03
    grid = DistanceGrid(origin=np.full(3, -0.03), spacing=2e-3, values=nodes[..., 2])
    # z of the mould is −z of the tool: half a turn about x.
    R = arm.R @ np.diag([1.0, -1.0, -1.0])
    return Workpiece(grid=grid, p=arm.p + depth * R[:, 2], R=R)


# The ideal arm is the model.


def test_ideal_arm_moves_as_the_integrated_model() -> None:
    tau = WEIGHT + PUSH

    def rate(t: float, x: Array) -> Array:
        arm = MODEL.at(State(t=t, q=x[:6], dq=x[6:]))
        return np.concatenate([x[6:], np.linalg.solve(arm.M, tau - arm.h - arm.g)])

    truth = solve_ivp(rate, (0.0, 0.1), np.concatenate([HOME, np.zeros(6)]), rtol=1e-9, atol=1e-9).y[:, -1]
    state = run(SimRobot(tool=TOOL), tau, 100)[-1]
    assert np.abs(truth[:6] - HOME).max() > 0.04
    # The tip hangs on its spring by 40 µm, and the engine's steps of 0.5 ms are of first order: half a step at the
    # speeds that are reached, up to 1 rad/s, is 0.25 mrad.
    assert_allclose(state.q, truth[:6], atol=5e-4)
    assert_allclose(state.dq, truth[6:], atol=1e-3)


def test_ideal_arm_under_its_weight_stays() -> None:
    state = run(SimRobot(tool=TOOL), WEIGHT, 100)[-1]
    # What is left is the tip that settles on its spring.
    assert_allclose(state.q, HOME, atol=1e-4)


def test_arm_rests_before_the_first_command() -> None:
    robot = SimRobot(tool=TOOL)
    states = [robot.read() for _ in range(100)]
    assert_allclose(states[-1].q, HOME, atol=1e-4)


def test_last_command_goes_on_acting_without_another() -> None:
    one, two = SimRobot(tool=TOOL), SimRobot(tool=TOOL)
    states = run(one, WEIGHT + PUSH, 20)
    two.read()
    two.write(Torque(WEIGHT + PUSH))
    for _ in range(20):
        last = two.read()
    assert_allclose(last.q, states[-1].q, atol=0.0)


# Time.


@pytest.mark.parametrize("rate", [100.0, 500.0, 1000.0])
def test_states_are_a_period_apart(rate: float) -> None:
    states = run(SimRobot(tool=TOOL, rate=rate), WEIGHT, 20)
    assert_allclose(np.diff([state.t for state in states]), np.full(20, 1.0 / rate), atol=1e-12)


def test_jitter_of_the_period_stays_within_its_bound() -> None:
    robot = SimRobot(tool=TOOL, rate=100.0, plant=replace(IDEAL, period_jitter=0.1))
    periods = np.diff([state.t for state in run(robot, WEIGHT, 100)])
    assert np.abs(periods / 0.01 - 1.0).max() <= 0.1 + 1e-9
    assert periods.std() > 0.02 * 0.01


@pytest.mark.parametrize(("delay", "still"), [(0.0, 0), (0.5, 0), (1.0, 1), (1.5, 1), (2.0, 2)])
def test_command_acts_after_the_delay(delay: float, still: int) -> None:
    pushed, left = (SimRobot(tool=TOOL, rate=100.0, plant=replace(IDEAL, delay=delay)) for _ in range(2))
    left.read()
    for i, state in enumerate(run(pushed, WEIGHT + PUSH, 3)[1:]):
        untouched = np.array_equal(state.q, left.read().q)
        assert untouched == (i < still)


def test_command_that_acts_half_a_period_late_has_half_the_effect() -> None:
    speed = [
        run(SimRobot(tool=TOOL, rate=100.0, plant=replace(IDEAL, delay=delay)), WEIGHT + PUSH, 1)[-1].dq[0]
        for delay in (0.0, 0.5)
    ]
    # The arm is all but still within 10 ms, so its acceleration is all but constant.
    assert speed[1] / speed[0] == pytest.approx(0.5, abs=0.02)


def test_commands_act_in_the_order_in_which_they_were_sent() -> None:
    # A late command must not be overtaken for good by one that was sent before.
    robot = SimRobot(tool=TOOL, plant=replace(IDEAL, delay=1.0, jitter=0.2))
    for i in range(50):
        robot.read()
        robot.write(Torque(WEIGHT if i >= 10 else WEIGHT + PUSH))
    late = [robot.read() for _ in range(10)]
    arm = MODEL.at(late[-1])
    # Under its weight alone the arm coasts: its speed changes by Coriolis torque only, far below PUSH.
    acceleration = (late[-1].dq - late[0].dq) / (late[-1].t - late[0].t)
    assert np.abs(arm.M @ acceleration).max() < 0.5 * np.abs(PUSH).max()


# Sensors.


def test_encoders_count() -> None:
    robot = SimRobot(tool=TOOL, plant=replace(IDEAL, encoder_counts=ENCODER_COUNTS))
    for state in run(robot, WEIGHT + PUSH, 50):
        counts = state.q * ENCODER_COUNTS / (2.0 * np.pi)
        assert_allclose(counts, np.round(counts), atol=1e-6)


def test_encoders_are_off_by_half_a_count_at_most() -> None:
    counts = np.full(6, 1000.0)
    coarse = run(SimRobot(tool=TOOL, plant=replace(IDEAL, encoder_counts=counts)), WEIGHT + PUSH, 50)
    exact = run(SimRobot(tool=TOOL), WEIGHT + PUSH, 50)
    error = np.array([a.q - b.q for a, b in zip(coarse, exact, strict=True)])
    assert np.abs(error).max() <= np.pi / 1000.0 + 1e-12
    assert np.abs(error).max() > 0.5 * np.pi / 1000.0


def test_speed_from_encoders_is_the_difference_of_their_positions() -> None:
    states = run(SimRobot(tool=TOOL, plant=replace(IDEAL, encoder_counts=ENCODER_COUNTS)), WEIGHT + PUSH, 50)
    for before, after in pairwise(states):
        assert_allclose(after.dq, (after.q - before.q) / (after.t - before.t), atol=1e-12)


def test_wrist_sensor_reads_the_weight_of_the_tool() -> None:
    arm = hold(SimRobot(tool=TOOL), 300)[-1]
    robot = SimRobot(tool=TOOL)
    for _ in range(300):
        state = robot.read()
        robot.write(Torque(WEIGHT))
    force = arm.R.T @ [0.0, 0.0, -9.81 * TOOL.mass]
    assert state.F is not None
    # The tip hangs on its spring: a ringing of some mN is left.
    assert_allclose(state.F[:3], force, atol=0.02)
    assert_allclose(state.F[3:], np.cross([0.0, 0.0, TOOL.com], force), atol=2e-3)


def wrist() -> WristSense:
    return WristSense(mass=TOOL.mass, com=TOOL.com, offset=TOOL.length)


@pytest.mark.parametrize("sense", [wrist, JointSense], ids=["wrist", "joint"])
def test_sensors_feel_the_surface_push_the_tool_out(sense: Callable[[], ContactSense]) -> None:
    robot = SimRobot(tool=TOOL, workpiece=plane(0.5e-3))
    arm = hold(robot, 1000, sense())[-1]
    pushed = float(np.mean(robot.truth.force()[1][-40:]))
    # 0.5 mm on the tip's spring and the felt, one behind the other, is 5 N; the arm gives way to some of it.
    assert pushed > 2.0
    assert arm.F is not None
    # Out of the surface is back along the tool; the arm is at rest but for a ringing of some hundredths of a newton.
    assert_allclose(arm.F[:3], -pushed * arm.R[:, 2], atol=0.1)


def test_in_the_air_there_is_no_contact_force() -> None:
    robot = SimRobot(tool=TOOL, workpiece=plane(-5e-3))
    hold(robot, 50)
    assert not np.any(robot.truth.force()[1])


def test_torque_sensors_are_behind_the_friction() -> None:
    # Less than the joints' friction is added to the weight: the arm stays, and what holds it is its weight.
    friction = Friction(coulomb=np.repeat([1.0, 0.4], 3), viscous=np.zeros(6))
    armature = np.repeat([0.8, 0.15], 3)
    robot = SimRobot(tool=TOOL, plant=replace(IDEAL, friction=friction, armature=armature))
    state = run(robot, WEIGHT + 0.5 * friction.coulomb, 300)[-1]
    # The engine's friction is soft: joints creep, by less than a tenth of a degree in 0.3 s.
    assert_allclose(state.q, HOME, atol=2e-3)
    assert_allclose(state.tau, WEIGHT, atol=0.01)


def test_torque_sensors_are_behind_the_rotors() -> None:
    armature = np.repeat([0.8, 0.15], 3)
    tau = WEIGHT + np.array([4.0, -4.0, 4.0, 1.0, -1.0, 1.0])
    state = run(SimRobot(tool=TOOL, plant=replace(IDEAL, armature=armature)), tau, 100)[-1]
    arm = MODEL.at(state)
    ddq = np.linalg.solve(arm.M + np.diag(armature), tau - arm.h - arm.g)
    # The rotors take most of the torque; what is left of it, and of the weight, passes the sensors.
    assert np.abs(armature * ddq).max() > 2.0
    assert_allclose(state.tau, arm.M @ ddq + arm.h + arm.g, atol=0.03)


def test_biases_are_added_to_the_readings() -> None:
    torque_bias, wrench_bias = np.arange(1.0, 7.0), np.arange(2.0, 8.0)
    plain = SimRobot(tool=TOOL).read()
    biased = SimRobot(tool=TOOL, plant=replace(IDEAL, torque_bias=torque_bias, wrench_bias=wrench_bias)).read()
    assert plain.tau is not None
    assert plain.F is not None
    assert_allclose(biased.tau, plain.tau + torque_bias, atol=1e-12)
    assert_allclose(biased.F, plain.F + wrench_bias, atol=1e-12)


def test_noise_has_the_size_of_the_plant() -> None:
    robot = SimRobot(tool=TOOL, plant=replace(IDEAL, torque_noise=0.02, wrench_noise=np.full(6, 0.05)))
    states = run(robot, WEIGHT, 1000)[500:]
    # 500 readings tell a standard deviation to 3 %; after half a second the tip is quiet.
    assert np.std([state.tau for state in states], axis=0) == pytest.approx(np.full(6, 0.02), rel=0.15)
    assert np.std([state.F for state in states], axis=0) == pytest.approx(np.full(6, 0.05), rel=0.15)


# Chance.


def honest_run(seed: int) -> list[State]:
    arm = arms.honest(seed)
    return run(SimRobot(tool=TOOL, rate=arm.rate, plant=arm.plant), WEIGHT, 20)


def test_same_seed_is_the_same_run() -> None:
    for one, two in zip(honest_run(3), honest_run(3), strict=True):
        for field in fields(State):
            assert np.array_equal(getattr(one, field.name), getattr(two, field.name))


@pytest.mark.parametrize("name", ["t", "q", "tau", "F"])
def test_other_seed_is_another_run(name: str) -> None:
    one, two = (getattr(honest_run(seed)[-1], name) for seed in (3, 4))
    assert not np.array_equal(one, two)


# What the robot tells.


def test_state_holds_what_can_be_measured_and_no_more() -> None:
    assert {field.name for field in fields(State)} == {"t", "q", "dq", "tau", "F"}


def test_in_the_air_a_state_does_not_tell_where_the_mould_is() -> None:
    moved = replace(IDEAL, mould_shift=np.array([2e-3, -1e-3, 1e-3]), mould_turn=np.array([0.02, -0.01, 0.0]))
    here, there = (
        run(SimRobot(tool=TOOL, plant=plant, workpiece=plane(-5e-3)), WEIGHT, 50)[-1] for plant in (IDEAL, moved)
    )
    # The engine computes in the mould's frame; only rounding differs.
    for name in ("q", "dq", "tau", "F"):
        assert_allclose(getattr(here, name), getattr(there, name), atol=1e-6, err_msg=name)


# The protocol.


def test_write_returns_the_torque_that_is_applied() -> None:
    robot = SimRobot(tool=TOOL)
    robot.read()
    applied = robot.write(Torque(np.array([99.0, -99.0, 1.0, 99.0, -99.0, 1.0])))
    assert_allclose(applied, [30.5, -30.5, 1.0, 6.8, -6.8, 1.0])


def test_robot_can_be_entered_read_written_and_left() -> None:
    with SimRobot(tool=TOOL) as robot:
        first = robot.read()
        robot.write(Torque(WEIGHT))
        second = robot.read()
    assert first.t < second.t
    assert first.q.shape == second.q.shape == (6,)


def test_command_that_is_not_a_number_is_refused() -> None:
    robot = SimRobot(tool=TOOL)
    robot.read()
    with pytest.raises(InputError, match="not finite"):
        robot.write(Torque(np.array([0.0, 0.0, np.nan, 0.0, 0.0, 0.0])))


def test_infinite_command_is_refused() -> None:
    robot = SimRobot(tool=TOOL)
    robot.read()
    with pytest.raises(InputError, match="not finite"):
        robot.write(Torque(np.array([np.inf, -np.inf, 0.0, 0.0, 0.0, 0.0])))


@pytest.mark.parametrize("rate", [0.0, 19.9, 2000.1, np.nan])
def test_rate_that_the_physics_cannot_keep_is_refused(rate: float) -> None:
    with pytest.raises(InputError, match="20 to 2000 Hz"):
        SimRobot(tool=TOOL, rate=rate)


def test_physics_that_diverges_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    robot = SimRobot(tool=TOOL)
    robot.read()
    step = mujoco.mj_step2

    def explode(model: object, data: mujoco.MjData) -> None:
        step(model, data)
        data.qvel[0] = np.nan

    monkeypatch.setattr(mujoco, "mj_step2", explode)
    with pytest.raises(SimulationError, match=r"diverged at t = 0\.001 s"):
        robot.read()


def test_arm_that_is_driven_wildly_diverges_with_an_error_and_not_with_a_number(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    # The engine writes a log where it is.
    monkeypatch.chdir(tmp_path)
    # A light wrist under full torque without end: 6.8 N·m on 1e-4 kg·m².
    robot = SimRobot(tool=TOOL, rate=100.0)
    with pytest.raises(SimulationError):
        run(robot, np.array([30.5, 30.5, 30.5, 6.8, 6.8, 6.8]), 3000)


def test_bare_arm_is_the_model_itself_and_has_no_wrist_sensor() -> None:
    model = Model.jaco2()
    state = SimRobot().read()
    assert state.F is None
    assert_allclose(state.tau, model.at(state).g, atol=1e-13)


def test_payload_hangs_at_the_tool_frame() -> None:
    state = SimRobot(plant=replace(IDEAL, payload=0.7)).read()
    assert_allclose(state.tau, Model.jaco2().with_payload(0.7).at(state).g, atol=1e-5)


def test_push_accelerates_the_arm_as_a_wrench_about_the_tool_frame() -> None:
    F = np.array([3.0, -2.0, 5.0, 0.1, 0.2, -0.3])
    robot, model = SimRobot(rate=2000.0), Model.jaco2()
    arm = model.at(robot.read())
    robot.push(F)
    robot.write(Torque(arm.g))
    after = robot.read()
    # One step of 0.5 ms from rest; the arm has hardly moved.
    assert_allclose(after.dq * 2000.0, np.linalg.solve(arm.M, arm.J.T @ F), rtol=5e-3, atol=1e-2)


def test_mould_without_a_tool_is_refused() -> None:
    with pytest.raises(InputError, match="nothing would touch it"):
        SimRobot(workpiece=plane(0.5e-3))
