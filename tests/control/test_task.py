from __future__ import annotations

import numpy as np
import pytest
from closed_loop import ARMS, BENT, HOME, JACO2, SEVEN, arm_at, moving, off, pose, run, tool_acceleration
from numpy.testing import assert_allclose

from burnish.control import CartesianVelocity, JacobianTranspose, OperationalSpace, PostureReference, TaskComputedTorque
from burnish.core import ToolReference
from burnish.rotation import continuous_error, rotation_vector_error


def test_jacobian_transpose_presses_like_springs() -> None:
    # A motion of 10 mm and 0.1 rad against springs: the torque does the work of the springs' force.
    arm = arm_at(JACO2, HOME)
    law = JacobianTranspose(stiffness=(500.0, 30.0), damping=(9.0, 2.0))
    law.reset(arm)
    tau = law.torque(arm, pose(arm, (0.01, 0.0, -0.02), (0.0, 0.1, 0.0), v=np.arange(6.0)))
    force = [5.0, 9.0, -10.0 + 18.0, 6.0, 3.0 + 8.0, 10.0]
    assert_allclose(np.linalg.solve(arm.J.T, tau - arm.g), force, atol=1e-9)


def test_jacobian_transpose_leaves_coriolis_torques_alone() -> None:
    arm = moving(JACO2, HOME, 1)
    law = JacobianTranspose(stiffness=0.0, damping=0.0)
    law.reset(arm)
    assert_allclose(law.torque(arm, pose(arm)), arm.g, atol=1e-12)


def test_integral_of_jacobian_transpose_is_of_the_rotation_vector_too() -> None:
    arm = arm_at(JACO2, HOME)
    law = JacobianTranspose(stiffness=0.0, damping=0.0, integral_stiffness=(10.0, 4.0), integral=(0.15, 9.0))
    law.reset(arm)
    wanted = pose(arm, (0.1, 0.0, 0.0), (0.0, 0.0, 0.5))
    for i in range(1, 11):
        tau = law.torque(arm_at(JACO2, HOME, t=0.1 * i), wanted)
    # 10 · 0.1 m · 1 s is beyond the bound of 0.15 N; 4 · 0.5 rad · 1 s is within.
    assert_allclose(np.linalg.solve(arm.J.T, tau - arm.g), [0.15, 0.0, 0.0, 0.0, 0.0, 2.0], atol=1e-9)


def test_task_computed_torque_makes_the_tool_accelerate_as_asked() -> None:
    law = TaskComputedTorque(kp=(90.0, 70.0), kd=(15.0, 12.0))
    kp, kd = np.repeat([90.0, 70.0], 3), np.repeat([15.0, 12.0], 3)
    for seed in range(10):
        arm = moving(JACO2, HOME, seed)
        wanted = off(arm, seed)
        law.reset(arm)
        e = np.concatenate([wanted.p - arm.p, rotation_vector_error(arm.R, wanted.R)])
        expected = wanted.a + kp * e + kd * (wanted.v - arm.v)
        assert_allclose(tool_acceleration(arm, law.torque(arm, wanted)), expected, atol=1e-9)


def test_with_six_joints_task_computed_torque_and_operational_space_are_one_law() -> None:
    inverse, operational = (law(kp=90.0, kd=15.0) for law in (TaskComputedTorque, OperationalSpace))
    arm = moving(JACO2, HOME, 3)
    for law in (inverse, operational):
        law.reset(arm)
    assert_allclose(inverse.torque(arm, off(arm, 3)), operational.torque(arm, off(arm, 3)), atol=1e-9)


def test_steady_state_of_task_computed_torque_is_below_half_a_millimetre() -> None:
    start = arm_at(JACO2, HOME)
    wanted = pose(start, (0.05, -0.03, 0.04), (0.2, -0.1, 0.15))
    end = run(JACO2, HOME, TaskComputedTorque.at_frequency(10.0), wanted, 2.0)[-1]
    assert np.linalg.norm(end.p - wanted.p) < 1e-5
    assert np.linalg.norm(continuous_error(end.R, wanted.R)) < 1e-4


# Laws that follow joint speeds.


@pytest.mark.parametrize("arm_name", ARMS)
def test_commanded_twist_is_reached_with_the_time_constant_of_the_loop(arm_name: str) -> None:
    model, q = ARMS[arm_name]
    v = 0.2 * np.array([0.02, -0.03, 0.04, 0.05, 0.1, -0.05])
    law = CartesianVelocity(speed_gain=20.0)
    seen = run(model, q, law, pose(arm_at(model, q), v=v), 0.5)
    t = np.array([arm.t for arm in seen])
    expected = v * (1.0 - np.exp(-20.0 * t))[:, None]
    # 1 % of Euler's step, and J# turns while the arm moves by up to 0.02 rad.
    assert_allclose([arm.v for arm in seen], expected, atol=0.02 * np.abs(v).max())


def test_of_all_motions_of_a_redundant_arm_the_one_with_least_joint_speed_is_commanded() -> None:
    arm, v = arm_at(SEVEN, BENT), np.arange(1.0, 7.0) * 0.01
    law = CartesianVelocity(speed_gain=20.0)
    law.reset(arm)
    ddq = np.linalg.solve(arm.M, law.torque(arm, pose(arm, v=v)) - arm.g)
    assert_allclose(ddq, 20.0 * np.linalg.pinv(arm.J) @ v, atol=1e-9)


def test_joints_do_not_race_where_a_singularity_stops_the_tool() -> None:
    # The stretched arm is asked to go on outwards.
    q = np.array([0.0, np.pi / 2 + 0.3, np.pi + 0.2, 0.5, 1.5, 0.0])
    start = arm_at(JACO2, q)
    outwards = start.p - JACO2.link_poses(q)["link_2"][:3, 3]
    v = np.concatenate([0.1 * outwards / np.linalg.norm(outwards), np.zeros(3)])
    seen = run(JACO2, q, CartesianVelocity(speed_gain=20.0), pose(start, v=v), 1.0)
    assert max(np.abs(arm.dq).max() for arm in seen) < 0.1 / 0.05 * 1.3


def test_integral_of_the_speed_loop_takes_away_what_a_push_leaves() -> None:
    start, push = arm_at(JACO2, HOME), np.array([4.0, 0.0, -4.0, 0.0, 0.0, 0.0])
    speeds = [
        np.linalg.norm(run(JACO2, HOME, law, pose(start), 1.0, push=push)[-1].dq)
        for law in (CartesianVelocity(speed_gain=20.0), CartesianVelocity(speed_gain=20.0, integral_gain=200.0))
    ]
    assert speeds[1] < 0.05 * speeds[0]


def test_posture_reference_lets_the_orientation_disturb_no_position() -> None:
    law = PostureReference(speed_gain=30.0, position_kp=4.0, orientation_kp=3.0)
    for model, q in ARMS.values():
        arm = arm_at(model, q)
        law.reset(arm)
        turned, moved = (
            np.linalg.solve(arm.M, law.torque(arm, wanted) - arm.g) / 30.0
            for wanted in (pose(arm, turn=(0.3, -0.2, 0.4)), pose(arm, dp=(0.01, 0.02, -0.03)))
        )
        assert np.linalg.norm(turned) > 0.1
        assert_allclose(arm.J[:3] @ turned, np.zeros(3), atol=1e-9)
        assert_allclose(arm.J[:3] @ moved, 4.0 * np.array([0.01, 0.02, -0.03]), atol=1e-9)


@pytest.mark.parametrize("arm_name", ARMS)
def test_posture_reference_arrives(arm_name: str) -> None:
    model, q = ARMS[arm_name]
    wanted = pose(arm_at(model, q), (0.03, -0.02, 0.02), (0.1, 0.1, -0.1))
    # The orientation is slower than its gain: the projector takes a good part of the speeds that it asks for.
    law = PostureReference(speed_gain=60.0, position_kp=8.0, orientation_kp=30.0)
    end = run(model, q, law, wanted, 2.0)[-1]
    assert np.linalg.norm(end.p - wanted.p) < 1e-4
    assert np.linalg.norm(continuous_error(end.R, wanted.R)) < 0.15 * np.linalg.norm([0.1, 0.1, -0.1])


def test_reference_of_a_law_is_not_kept() -> None:
    arm = arm_at(JACO2, HOME)
    law = TaskComputedTorque(kp=1.0, kd=1.0)
    law.reset(arm)
    first = law.torque(arm, pose(arm))
    law.torque(arm, off(arm, 1))
    assert_allclose(law.torque(arm, ToolReference(p=arm.p, R=arm.R, v=np.zeros(6), a=np.zeros(6))), first, atol=0.0)
