from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from closed_loop import ARMS, BENT, HOME, JACO2, SEVEN, arm_at, moving, off, pose, run, self_motion, tool_acceleration
from numpy.testing import assert_allclose

from burnish.control import DampingRatio, Impedance, InertiaShapingImpedance, Posture, RedundantImpedance
from burnish.core import Array, Dynamics
from burnish.errors import InputError
from burnish.rotation import continuous_error

GAINS: dict[str, Any] = {"stiffness": (400.0, 20.0), "damping": (30.0, 2.0)}
K, D = np.repeat([400.0, 20.0], 3), np.repeat([30.0, 2.0], 3)
CHOSEN = np.diag([4.0, 5.0, 6.0, 0.3, 0.4, 0.5]) + 0.05
"""An inertia with coupling, unlike the arm's."""


def torque(law: Any, arm: Dynamics, reference: Any) -> Array:
    law.reset(arm)
    return np.asarray(law.torque(arm, reference))


@pytest.mark.parametrize("damping", [(30.0, 2.0), DampingRatio(0.7)], ids=["gains", "ratio"])
def test_without_inertia_shaping_the_three_impedances_are_one_law(damping: Any) -> None:
    gains = {"stiffness": (400.0, 20.0), "damping": damping}
    laws = (Impedance(**gains, feed_forward=1.0), InertiaShapingImpedance(**gains), RedundantImpedance(**gains))
    for seed in range(10):
        arm = moving(JACO2, HOME, seed)
        taus = [torque(law, arm, off(arm, seed)) for law in laws]
        assert_allclose(taus[1], taus[0], atol=1e-9)
        assert_allclose(taus[2], taus[0], atol=1e-9)


def test_plain_impedance_of_the_thesis_differs_from_them_by_its_feed_forward() -> None:
    arm = moving(JACO2, HOME, 1)
    wanted = off(arm, 1)
    missing = torque(InertiaShapingImpedance(**GAINS), arm, wanted) - torque(Impedance(**GAINS), arm, wanted)
    assert_allclose(missing, arm.J.T @ (arm.Lambda @ (wanted.a - arm.dJdq)) + arm.h, atol=1e-9)
    still = arm_at(JACO2, HOME)
    wanted = off(still, 1)
    missing = torque(RedundantImpedance(**GAINS), still, wanted) - torque(Impedance(**GAINS), still, wanted)
    assert_allclose(missing, still.J.T @ still.Lambda @ wanted.a, atol=1e-9)


def test_impedance_is_a_spring_and_a_damper() -> None:
    arm = moving(JACO2, HOME, 2)
    wanted = off(arm, 2)
    e = np.concatenate([wanted.p - arm.p, continuous_error(arm.R, wanted.R)])
    w = np.linalg.solve(arm.J.T, torque(Impedance(**GAINS), arm, wanted) - arm.g)
    assert_allclose(w, K * e + D * (wanted.v - arm.v), atol=1e-9)


@pytest.mark.parametrize("law_type", [InertiaShapingImpedance, RedundantImpedance])
def test_pushed_arm_accelerates_like_the_chosen_inertia(law_type: Any) -> None:
    law = law_type(**GAINS, inertia=CHOSEN)
    own = law_type(**GAINS)
    for seed in range(5):
        arm = moving(JACO2, HOME, seed)
        wanted = off(arm, seed)
        e = np.concatenate([wanted.p - arm.p, continuous_error(arm.R, wanted.R)])
        w = K * e + D * (wanted.v - arm.v)
        F = arm.F
        assert F is not None
        push = arm.J.T @ F
        expected = wanted.a + np.linalg.solve(CHOSEN, w + F)
        assert_allclose(tool_acceleration(arm, torque(law, arm, wanted) + push), expected, atol=1e-9)
        expected = wanted.a + np.linalg.solve(arm.Lambda, w + F)
        assert_allclose(tool_acceleration(arm, torque(own, arm, wanted) + push), expected, atol=1e-8)


def test_free_inertia_makes_another_law_and_the_same_for_both() -> None:
    arm = moving(JACO2, HOME, 3)
    wanted = off(arm, 3)
    shaped = [
        torque(law(**GAINS, inertia=CHOSEN), arm, wanted) for law in (InertiaShapingImpedance, RedundantImpedance)
    ]
    assert_allclose(shaped[0], shaped[1], atol=1e-9)
    assert np.abs(shaped[0] - torque(InertiaShapingImpedance(**GAINS), arm, wanted)).max() > 0.5


def measured_inertia(seen: list[Dynamics], start: Dynamics, push: Array, axis: int) -> float:
    """A of one axis by least squares from the response: F − D v − K x = A v̇, with x, v as they were seen."""
    v = np.array([arm.v[axis] for arm in seen])
    turn = [np.concatenate([arm.p - start.p, continuous_error(start.R, arm.R)])[axis] for arm in seen]
    a = np.gradient(v, seen[1].t - seen[0].t)
    force = push[axis] - K[axis] * np.array(turn) - D[axis] * v
    return float(a @ force / (a @ a))


@pytest.mark.parametrize("axis", [0, 2, 4], ids=["x", "z", "about y"])
@pytest.mark.parametrize("arm_name", ARMS)
def test_closed_loop_has_the_chosen_inertia(axis: int, arm_name: str) -> None:
    model, q = ARMS[arm_name]
    A = np.diag([5.5, 4.0, 8.0, 0.4, 0.3, 0.5])
    push = np.zeros(6)
    push[axis] = 5.0 if axis < 3 else 0.5
    null_space = [Posture.at_frequency(q, 5.0)]
    start = arm_at(model, q)
    chosen, own = (
        measured_inertia(run(model, q, law, pose(start), 0.4, push=push), start, push, axis)
        for law in (RedundantImpedance(**GAINS, inertia=A, null_space=null_space), Impedance(**GAINS))
    )
    assert chosen == pytest.approx(A[axis, axis], rel=0.05)
    assert own != pytest.approx(A[axis, axis], rel=0.3)


def test_pressed_impedance_gives_way_as_its_stiffness_says() -> None:
    start, push = arm_at(JACO2, HOME), np.array([4.0, -6.0, 8.0, 0.0, 0.0, 0.0])
    end = run(JACO2, HOME, Impedance.from_stiffness((400.0, 40.0)), pose(start), 2.0, push=push)[-1]
    assert_allclose(end.p - start.p, push[:3] / 400.0, rtol=0.02)


@pytest.mark.parametrize("ratio", [0.4, 1.0])
def test_impedance_by_a_damping_ratio_overshoots_as_the_ratio_says(ratio: float) -> None:
    start = arm_at(JACO2, HOME)
    wanted = pose(start, (0.01, 0.0, 0.0))
    law = RedundantImpedance.from_stiffness((400.0, 40.0), ratio)
    x = np.array([arm.p[0] - start.p[0] for arm in run(JACO2, HOME, law, wanted, 1.5)]) / 0.01
    # All modes have one ratio but not one frequency: their sum overshoots by no more than each, and not by nothing.
    single = np.exp(-np.pi * ratio / np.sqrt(1.0 - ratio**2)) if ratio < 1.0 else 0.0
    assert 0.5 * single - 5e-3 < x.max() - 1.0 < 1.05 * single + 1e-3


def test_null_space_of_the_redundant_impedance_does_not_accelerate_the_tool() -> None:
    with_task, without = (
        RedundantImpedance(**GAINS, null_space=tasks) for tasks in ([Posture.at_frequency(BENT + 1.0, 9.0)], [])
    )
    for seed in range(5):
        arm = moving(SEVEN, BENT, seed)
        added = torque(with_task, arm, off(arm, seed)) - torque(without, arm, off(arm, seed))
        assert np.abs(added).max() > 1.0
        assert_allclose(arm.J @ np.linalg.solve(arm.M, added), np.zeros(6), atol=1e-9)


def test_redundant_impedance_keeps_the_tool_while_the_elbow_moves() -> None:
    aim = self_motion(SEVEN, BENT, 0.5)
    law = RedundantImpedance.from_stiffness((900.0, 60.0), null_space=[Posture.at_frequency(aim, 6.0)])
    start = arm_at(SEVEN, BENT)
    seen = run(SEVEN, BENT, law, pose(start), 2.0)
    assert max(np.linalg.norm(arm.p - start.p) for arm in seen) < 2e-4
    assert_allclose(seen[-1].q, aim, atol=2e-3)


def test_joint_damping_calms_the_self_motion_that_an_impedance_leaves() -> None:
    n = np.linalg.svd(SEVEN.kinematics(BENT)[2])[2][-1]
    for damping, left in ((0.0, 0.5), (5.0, 0.0)):
        law = Impedance(stiffness=(400.0, 20.0), damping=(30.0, 2.0), joint_damping=damping)
        q, dq = BENT.copy(), n.copy()
        arm = arm_at(SEVEN, q, dq)
        law.reset(arm)
        wanted = pose(arm)
        for i in range(1000):
            arm = arm_at(SEVEN, q, dq, 1e-3 * i)
            dq = dq + 1e-3 * np.linalg.solve(arm.M, law.torque(arm, wanted) - arm.h - arm.g)
            q = q + 1e-3 * dq
        assert (np.linalg.norm(dq) > left) if left else (np.linalg.norm(dq) < 0.05)


def test_inertia_that_is_none_is_refused() -> None:
    with pytest.raises(InputError, match="inertia"):
        RedundantImpedance(**GAINS, inertia=np.diag([1.0, 1.0, 1.0, 1.0, 1.0, -1.0]))
