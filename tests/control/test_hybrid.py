from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from closed_loop import ARMS, BENT, HOME, JACO2, SEVEN, arm_at, moving, off, pose, run
from numpy.testing import assert_allclose

from burnish.control import Hybrid, HybridNullSpace
from burnish.control.hybrid import Derivative
from burnish.core import Array, Dynamics, ToolReference
from burnish.rotation import continuous_error

GAINS: dict[str, Any] = {"stiffness": 400.0, "damping": 30.0, "turn_rate": 6.0, "speed_gain": 12.0}


def parts(arm: Dynamics, wanted: ToolReference) -> tuple[Array, Array]:
    """τ_p and α of both laws, written out with plain inverses."""
    Minv = np.linalg.inv(arm.M)
    Jv, Jw = arm.J[:3], arm.J[3:]
    w_p = 400.0 * (wanted.p - arm.p) + 30.0 * (wanted.v - arm.v)[:3]
    Lambda_p = np.linalg.inv(Jv @ Minv @ Jv.T)
    tau_p = Jv.T @ Lambda_p @ (wanted.a[:3] + np.linalg.inv(Lambda_p) @ w_p)
    Jw_bar = Minv @ Jw.T @ np.linalg.inv(Jw @ Minv @ Jw.T)
    return tau_p, 12.0 * (6.0 * Jw_bar @ continuous_error(arm.R, wanted.R) - arm.dq)


@pytest.mark.parametrize("arm_name", ARMS)
def test_hybrid_law_is_the_equation_of_the_thesis(arm_name: str) -> None:
    model, q = ARMS[arm_name]
    for seed in range(5):
        arm = moving(model, q, seed)
        wanted = off(arm, seed)
        law = Hybrid(**GAINS)
        law.reset(arm)
        tau_p, alpha = parts(arm, wanted)
        assert_allclose(law.torque(arm, wanted), tau_p + arm.M @ alpha + arm.h + arm.g, atol=1e-9)


@pytest.mark.parametrize("arm_name", ARMS)
def test_hybrid_law_with_null_space_is_the_equation_of_the_thesis(arm_name: str) -> None:
    model, q = ARMS[arm_name]
    for seed in range(5):
        arm = moving(model, q, seed)
        wanted = off(arm, seed)
        law = HybridNullSpace(**GAINS)
        law.reset(arm)
        tau_p, beta = parts(arm, wanted)
        Minv, Jv, Jw = np.linalg.inv(arm.M), arm.J[:3], arm.J[3:]
        Jv_bar, Jw_bar = (Minv @ J.T @ np.linalg.inv(J @ Minv @ J.T) for J in (Jv, Jw))
        N_p = np.eye(model.n) - Jv_bar @ Jv
        expected = tau_p + (Jw @ N_p).T @ Jw_bar.T @ (arm.M @ beta - tau_p) + arm.h + arm.g
        assert_allclose(law.torque(arm, wanted), expected, atol=1e-9)


@pytest.mark.parametrize("arm_name", ARMS)
def test_orientation_in_the_null_space_does_not_accelerate_the_tool_point(arm_name: str) -> None:
    model, q = ARMS[arm_name]
    for law_type, disturbs in ((HybridNullSpace, False), (Hybrid, True)):
        law = law_type(**GAINS)
        arm = arm_at(model, q)
        law.reset(arm)
        added = law.torque(arm, pose(arm, turn=(0.3, -0.2, 0.4))) - law.torque(arm, pose(arm))
        moved = arm.J[:3] @ np.linalg.solve(arm.M, added)
        assert np.abs(added).max() > 0.1
        assert (np.abs(moved).max() > 0.1) if disturbs else (np.abs(moved).max() < 1e-9)


@pytest.mark.parametrize("law_type", [Hybrid, HybridNullSpace])
def test_hybrid_law_goes_to_its_target(law_type: Any) -> None:
    wanted = pose(arm_at(JACO2, HOME), (0.03, -0.02, 0.02), (0.1, 0.1, -0.1))
    end = run(JACO2, HOME, law_type(**(GAINS | {"damping": 60.0})), wanted, 3.0)[-1]
    # Neither is quick: −K_v q̇ brakes the position of the one, the projector takes most of the orientation's torque of
    # the other, and both are the thesis's laws.
    assert np.linalg.norm(end.p - wanted.p) < 0.1 * np.linalg.norm([0.03, -0.02, 0.02])
    assert np.linalg.norm(continuous_error(end.R, wanted.R)) < 0.5 * np.linalg.norm([0.1, 0.1, -0.1])


def test_null_space_lowers_the_disturbance_of_the_position_by_an_orientation_command() -> None:
    start = arm_at(JACO2, HOME)
    wanted = pose(start, turn=(0.2, -0.1, 0.2))
    worst = [
        max(np.linalg.norm(arm.p - start.p) for arm in run(JACO2, HOME, law(**GAINS), wanted, 1.0))
        for law in (Hybrid, HybridNullSpace)
    ]
    assert worst[1] < 0.2 * worst[0]


def test_joint_damping_calms_the_self_motion_that_the_null_space_law_leaves() -> None:
    n = np.linalg.svd(SEVEN.kinematics(BENT)[2])[2][-1]
    arm = arm_at(SEVEN, BENT, n)
    law = HybridNullSpace(**GAINS, joint_damping=5.0)
    law.reset(arm)
    without = HybridNullSpace(**GAINS)
    without.reset(arm)
    assert_allclose(law.torque(arm, pose(arm)) - without.torque(arm, pose(arm)), -5.0 * n, atol=1e-12)


def test_derivative_of_a_ramp_is_its_slope_and_of_a_first_sample_nothing() -> None:
    rate = Derivative(0.01)
    rate.reset(1)
    assert rate.add(np.array([5.0]), 0.0) == 0.0
    for i in range(1, 101):
        value = rate.add(np.array([5.0 + 3.0 * 1e-3 * i]), 1e-3 * i)
    assert value[0] == pytest.approx(3.0, rel=1e-3)  # exp(−10) is left
    assert rate.add(np.array([9.0]), 0.1)[0] == value[0]  # no time has passed


def test_rate_of_the_joint_speeds_acts_against_their_change() -> None:
    plain, with_rate = Hybrid(**GAINS), Hybrid(**GAINS, speed_rate_gain=0.5, derivative_time=0.0)
    first, then = arm_at(JACO2, HOME), arm_at(JACO2, HOME, np.full(6, 0.1), 0.01)
    taus = []
    for law in (plain, with_rate):
        law.reset(first)
        law.torque(first, pose(first))
        taus.append(law.torque(then, pose(first)))
    assert_allclose(taus[1] - taus[0], then.M @ np.full(6, -0.5 * 0.1 / 0.01), atol=1e-9)
