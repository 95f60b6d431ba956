from __future__ import annotations

import numpy as np
import pytest
from closed_loop import (
    ARMS,
    HOME,
    JACO2,
    SEVEN,
    acceleration,
    arm_at,
    moving,
    off,
    pose,
    run,
    self_motion,
    tool_acceleration,
)
from numpy.testing import assert_allclose

from burnish.control import LimitAvoidance, OperationalSpace, Posture
from burnish.core import Array, Dynamics, ToolReference
from burnish.errors import InputError
from burnish.model.friction import Friction
from burnish.rotation import continuous_error, quaternion_error

MASKS = [
    (True,) * 6,
    (True, True, True, False, False, False),
    (False, False, False, True, True, True),
    (False, True, False, True, False, False),
    (False, False, True, False, False, False),
]
each_mask = pytest.mark.parametrize("mask", MASKS, ids=lambda mask: "".join("01"[x] for x in mask))
each_arm = pytest.mark.parametrize("arm_name", ARMS)


def asked(arm: Dynamics, reference: ToolReference, kp: float, kd: float) -> Array:
    """a_d + K_p e + K_d (v_d − v), all six."""
    e = np.concatenate([reference.p - arm.p, continuous_error(arm.R, reference.R)])
    return np.asarray(reference.a + kp * e + kd * (reference.v - arm.v))


@each_arm
@each_mask
def test_masked_degrees_of_freedom_accelerate_as_asked_whatever_the_others_do(
    mask: tuple[bool, ...], arm_name: str
) -> None:
    model, q = ARMS[arm_name]
    posture = Posture.at_frequency(q, 4.0)
    for null_space in ((), (posture,)):
        law = OperationalSpace(kp=90.0, kd=15.0, mask=mask, null_space=null_space)
        for seed in range(5):
            arm = moving(model, q, seed)
            wanted = off(arm, seed)
            law.reset(arm)
            got = tool_acceleration(arm, law.torque(arm, wanted))
            # Λ amplifies rounding by its condition, 1e3 to 1e4.
            assert_allclose(got[list(mask)], asked(arm, wanted, 90.0, 15.0)[list(mask)], atol=1e-9)


@each_arm
@each_mask
def test_null_space_torque_does_not_accelerate_the_task(mask: tuple[bool, ...], arm_name: str) -> None:
    model, q = ARMS[arm_name]
    tasks = (Posture.at_frequency(q + 1.0, 20.0), LimitAvoidance(lower=q - 0.1, upper=q + 0.4, kd=3.0))
    plain, with_tasks = (OperationalSpace(kp=90.0, kd=15.0, mask=mask, null_space=x) for x in ((), tasks))
    for seed in range(5):
        arm = moving(model, q, seed)
        wanted = off(arm, seed)
        for law in (plain, with_tasks):
            law.reset(arm)
        added = with_tasks.torque(arm, wanted) - plain.torque(arm, wanted)
        if model.n > sum(mask):
            assert np.abs(added).max() > 0.1
        assert_allclose((arm.J @ np.linalg.solve(arm.M, added))[list(mask)], 0.0, atol=1e-9)


def test_stripping_rows_of_the_full_inertia_is_another_law() -> None:
    arm = moving(JACO2, HOME, 1)
    wanted = off(arm, 1)
    law = OperationalSpace(kp=90.0, kd=15.0, mask=MASKS[1])
    law.reset(arm)
    a = asked(arm, wanted, 90.0, 15.0)[:3] - arm.dJdq[:3]
    wrong = arm.J[:3].T @ (arm.Lambda[:3, :3] @ a) + arm.h + arm.g
    got, with_wrong = (tool_acceleration(arm, tau)[:3] - arm.dJdq[:3] for tau in (law.torque(arm, wanted), wrong))
    assert_allclose(got, a, atol=1e-9)
    assert np.abs(with_wrong - a).max() > 0.1 * np.abs(a).max()


def test_damping_of_the_blog_is_in_joint_space() -> None:
    arm = moving(JACO2, HOME, 2)
    law = OperationalSpace(kp=90.0, kd=0.0, joint_damping=7.0)
    without = OperationalSpace(kp=90.0, kd=0.0)
    wanted = off(arm, 2)
    for one in (law, without):
        one.reset(arm)
    added = law.torque(arm, wanted) - without.torque(arm, wanted)
    assert_allclose(np.linalg.solve(arm.M, added), -7.0 * arm.dq, atol=1e-9)


def test_orientation_error_of_the_blog_takes_the_place_of_ours() -> None:
    arm = arm_at(JACO2, HOME)
    law = OperationalSpace(kp=90.0, kd=0.0, orientation_error=quaternion_error)
    law.reset(arm)
    wanted = pose(arm, turn=(0.4, -0.8, 0.3))
    angle = np.linalg.norm([0.4, -0.8, 0.3])
    expected = 90.0 * np.sin(0.5 * angle) * np.array([0.4, -0.8, 0.3]) / angle
    assert_allclose(tool_acceleration(arm, law.torque(arm, wanted))[3:], expected, atol=1e-9)


@pytest.mark.parametrize("mask", [(False,) * 6, (True,) * 5, (1, 1, 1, 0, 0, 0), "xyz"])
def test_mask_without_a_degree_of_freedom_or_that_is_none_is_refused(mask: object) -> None:
    with pytest.raises(InputError, match="six booleans"):
        OperationalSpace(kp=1.0, kd=1.0, mask=mask)  # type: ignore[arg-type]


def test_gains_by_frequency_are_critically_damped() -> None:
    law = OperationalSpace.at_frequency((10.0, 20.0), mask=MASKS[0], ki=3.0)
    assert_allclose(law.kp, [100.0, 400.0])
    assert_allclose(law.kd, [20.0, 40.0])
    assert law.ki == 3.0


@each_arm
@each_mask
def test_closed_loop_follows_the_solution_of_its_linear_equation(mask: tuple[bool, ...], arm_name: str) -> None:
    # From rest, critically damped: e(t) = e(0) (1 + ωt) exp(−ωt). Euler's step of 1 ms is off by about ω dt = 1 %.
    model, q = ARMS[arm_name]
    law = OperationalSpace.at_frequency(10.0, mask=mask, null_space=[Posture.at_frequency(q, 5.0)])
    start = arm_at(model, q)
    wanted = pose(start, (0.03, -0.02, 0.01), (0.1, 0.05, -0.1))
    seen = run(model, q, law, wanted, 1.0)
    e = np.array([np.concatenate([wanted.p - arm.p, continuous_error(arm.R, wanted.R)]) for arm in seen])
    t = np.array([arm.t for arm in seen])
    expected = e[0] * ((1.0 + 10.0 * t) * np.exp(-10.0 * t))[:, None]
    # Rotations do not add up like vectors: another 1 % of 0.15 rad.
    assert_allclose(e[:, list(mask)], expected[:, list(mask)], atol=2.5e-3)


def test_integral_takes_away_what_a_constant_push_leaves() -> None:
    push = np.array([3.0, -2.0, -4.0, 0.1, 0.0, 0.0])
    start = arm_at(JACO2, HOME)
    errors = []
    for ki in (0.0, 600.0):
        law = OperationalSpace.at_frequency(15.0, ki=ki)
        errors.append(np.linalg.norm(run(JACO2, HOME, law, pose(start), 3.0, push=push)[-1].p - start.p))
    assert errors[0] > 2e-3
    assert errors[1] < 1e-4


def test_redundant_arm_goes_to_its_posture_without_moving_the_tool() -> None:
    model, q = ARMS["seven"]
    aim = self_motion(model, q, 0.5)
    law = OperationalSpace.at_frequency(20.0, null_space=[Posture.at_frequency(aim, 6.0)])
    start = arm_at(model, q)
    seen = run(model, q, law, pose(start), 2.0)
    assert max(np.linalg.norm(arm.p - start.p) for arm in seen) < 1e-4
    # Critically damped at 6 rad/s: (1 + 12) exp(−12) of 0.5 rad are left after 2 s.
    assert_allclose(seen[-1].q, aim, atol=1e-3)


def test_joint_stays_off_its_limit_while_the_tool_is_where_it_should() -> None:
    model, q = ARMS["seven"]
    start, aim, joint = arm_at(model, q), self_motion(model, q, 0.8), 2
    limit = q[joint] - 0.5 * (q[joint] - aim[joint])
    lower, upper = (np.where(np.arange(7) == joint, x, y) for x, y in ((limit, -np.inf), (limit + 3.0, np.inf)))
    posture = Posture.at_frequency(aim, 4.0)
    lowest = {}
    for name, tasks in (
        ("free", [posture]),
        ("kept", [posture, LimitAvoidance(lower=lower, upper=upper, acceleration_at_limit=200.0)]),
    ):
        law = OperationalSpace.at_frequency(20.0, null_space=tasks)
        seen = run(model, q, law, pose(start), 1.5)
        assert max(np.linalg.norm(arm.p - start.p) for arm in seen) < 1e-4
        lowest[name] = min(arm.q[joint] for arm in seen)
    assert lowest["free"] < limit - 0.1
    assert lowest["kept"] > limit


def test_push_from_a_limit_grows_towards_it_and_is_none_for_a_continuous_joint() -> None:
    task = LimitAvoidance(
        lower=[-np.inf, -1.0, -1.0, -np.inf, 0.0, 0.0],
        upper=[np.inf, 1.0, np.inf, 1.0, 2.0, 2.0],
        margin=0.2,
        acceleration_at_limit=50.0,
    )
    arm = arm_at(JACO2, np.array([100.0, 0.9, -0.9, 1.0, 1.0, -0.2]))
    # Half the margin: a quarter of a. At the limit: a. Twice the margin beyond... on: linear.
    assert_allclose(task.acceleration(arm), [0.0, -12.5, 12.5, -50.0, 0.0, 100.0], atol=1e-9)
    pushes = [task.acceleration(arm_at(JACO2, np.array([0, 1.0 - d, 0, 0, 1, 1])))[1] for d in np.linspace(0.2, 0, 20)]
    assert np.all(np.diff(pushes) < 0.0)


@pytest.mark.parametrize(
    "build",
    [
        lambda: Posture(q=[np.nan] * 6, kp=1.0, kd=1.0),
        lambda: Posture(q=[0.0] * 6, kp=-1.0, kd=1.0),
        lambda: LimitAvoidance(lower=[0.0] * 6, upper=[0.0] * 6),
        lambda: LimitAvoidance(lower=[0.0] * 6, upper=[1.0] * 5),
        lambda: LimitAvoidance(lower=[0.0] * 6, upper=[1.0] * 6, margin=0.0),
        lambda: OperationalSpace(kp=1.0, kd=1.0, null_space=[Posture(q=[0.0] * 7, kp=1.0, kd=1.0)]).reset(
            arm_at(JACO2, HOME)
        ),
    ],
)
def test_null_space_task_that_makes_no_sense_is_refused_before_motion(build: object) -> None:
    with pytest.raises(InputError):
        build()  # type: ignore[operator]


def test_law_is_the_same_by_either_way_of_solving_for_it() -> None:
    # With six joints the solver takes M J⁻¹ for Jᵀ Λ; a masked law with one row less for each joint takes Λ.
    for seed in range(20):
        arm = moving(JACO2, HOME, seed)
        wanted = off(arm, seed)
        law = OperationalSpace(kp=90.0, kd=15.0)
        law.reset(arm)
        a = asked(arm, wanted, 90.0, 15.0) - arm.dJdq
        assert_allclose(law.torque(arm, wanted), arm.J.T @ (arm.Lambda @ a) + arm.h + arm.g, atol=1e-9)


def test_seven_joints_are_not_moved_by_the_tools_law_alone() -> None:
    # Without a null-space task the joint accelerations are those of least kinetic energy: J̄ a.
    arm = moving(SEVEN, ARMS["seven"][1], 3)
    wanted = off(arm, 3)
    law = OperationalSpace(kp=90.0, kd=15.0)
    law.reset(arm)
    a = asked(arm, wanted, 90.0, 15.0) - arm.dJdq
    assert_allclose(acceleration(arm, law.torque(arm, wanted)), arm.J_bar @ a, atol=1e-8)


def test_friction_is_compensated_at_the_planned_speed() -> None:
    friction = Friction(coulomb=np.ones(6), viscous=np.arange(1.0, 7.0))
    arm = moving(JACO2, HOME, 4)
    wanted = off(arm, 4)
    laws = [OperationalSpace(kp=90.0, kd=15.0, friction=f, friction_share=0.7) for f in (None, friction)]
    plain, compensated = (law.torque(arm, wanted) for law in laws)
    # Far from a singularity the fading next to one takes a share of 1e-7.
    assert_allclose(compensated - plain, 0.7 * friction.torque(np.linalg.solve(arm.J, wanted.v)), rtol=1e-6)


def test_friction_of_a_tool_that_shall_stand_is_not_compensated() -> None:
    friction = Friction(coulomb=np.ones(6), viscous=np.ones(6))
    arm = moving(JACO2, HOME, 5)
    laws = [OperationalSpace(kp=90.0, kd=15.0, friction=f) for f in (None, friction)]
    plain, compensated = (law.torque(arm, pose(arm)) for law in laws)
    assert_allclose(compensated, plain, atol=1e-12)


def test_friction_of_another_arm_is_refused_before_motion() -> None:
    law = OperationalSpace(kp=90.0, kd=15.0, friction=Friction(coulomb=np.ones(7), viscous=np.ones(7)))
    with pytest.raises(InputError, match="friction"):
        law.reset(arm_at(JACO2, HOME))
