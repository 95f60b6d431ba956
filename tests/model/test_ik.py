from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from burnish.core import Array
from burnish.errors import PlanError
from burnish.model.ik import POSITION_TOLERANCE, ROTATION_TOLERANCE, inverse, random_seeds, solve
from burnish.model.model import Model
from burnish.rotation import exp, log

HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])


@pytest.fixture(scope="module")
def jaco2() -> Model:
    return Model.jaco2()


def misses(model: Model, q: Array, p: Array, R: Array) -> tuple[float, float]:
    """How far the tool at q is from (p [m], R [rad])."""
    p_now, R_now, _ = model.kinematics(q)
    return float(np.linalg.norm(p - p_now)), float(np.linalg.norm(log(R @ R_now.T)))


def assert_there(model: Model, q: Array, p: Array, R: Array) -> None:
    position, rotation = misses(model, q, p, R)
    assert position <= POSITION_TOLERANCE
    assert rotation <= ROTATION_TOLERANCE


def test_reachable_poses_are_reached(jaco2: Model) -> None:
    rng = np.random.default_rng(1)
    for wanted in random_seeds(jaco2, 20, rng):
        p, R, _ = jaco2.kinematics(wanted)
        assert_there(jaco2, inverse(jaco2, p, R, [HOME, *random_seeds(jaco2, 40, rng)]), p, R)


def test_nearby_pose_is_reached_nearby(jaco2: Model) -> None:
    rng = np.random.default_rng(2)
    p, R, _ = jaco2.kinematics(HOME)
    for _ in range(20):
        p_d, R_d = p + rng.uniform(-0.02, 0.02, 3), exp(rng.uniform(-0.1, 0.1, 3)) @ R
        q = inverse(jaco2, p_d, R_d, [HOME])
        assert_there(jaco2, q, p_d, R_d)
        # 35 mm and 0.17 rad need less than half a radian in mid-air; another branch is radians away.
        assert np.abs(q - HOME).max() < 0.7


def test_pose_where_the_arm_is_needs_no_step(jaco2: Model) -> None:
    p, R, _ = jaco2.kinematics(HOME)
    q, position, rotation = solve(jaco2, p, R, HOME)
    assert np.array_equal(q, HOME)
    assert (position, rotation) == pytest.approx((0.0, 0.0), abs=1e-12)


def test_errors_that_solve_returns_are_those_of_its_joints(jaco2: Model) -> None:
    p, R, _ = jaco2.kinematics(HOME)
    p, R = p + [0.03, -0.02, 0.01], exp(np.array([0.1, 0.2, -0.1])) @ R
    q, position, rotation = solve(jaco2, p, R, HOME)
    assert (position, rotation) == pytest.approx(misses(jaco2, q, p, R), abs=1e-12)


def test_solution_is_within_the_limits(jaco2: Model) -> None:
    rng = np.random.default_rng(3)
    for wanted in random_seeds(jaco2, 20, rng):
        p, R, _ = jaco2.kinematics(wanted)
        q = inverse(jaco2, p, R, [HOME, *random_seeds(jaco2, 40, rng)])
        assert np.all(q >= jaco2.lower)
        assert np.all(q <= jaco2.upper)


def test_seed_outside_the_limits_is_brought_inside(jaco2: Model) -> None:
    p, R, _ = jaco2.kinematics(HOME)
    q, _, _ = solve(jaco2, p, R, HOME + [0.0, 9.0, -9.0, 0.0, 0.0, 0.0])
    assert np.all((q >= jaco2.lower) & (q <= jaco2.upper))


def test_first_seed_that_leads_there_is_used(jaco2: Model) -> None:
    p, R, _ = jaco2.kinematics(HOME)
    lost = np.array([0.0, 1.0, 0.4, 0.0, 0.0, 0.0])
    assert np.abs(inverse(jaco2, p, R, [HOME, lost]) - HOME).max() < 1e-9


def test_seven_joint_arm_reaches_poses_as_well() -> None:
    arm = Model.from_urdf(Path(__file__).parent.parent / "data" / "seven_dof.urdf", tool="tool0")
    rng = np.random.default_rng(4)
    for wanted in random_seeds(arm, 10, rng):
        p, R, _ = arm.kinematics(wanted)
        assert_there(arm, inverse(arm, p, R, random_seeds(arm, 40, rng)), p, R)


def test_pose_out_of_reach_is_refused_with_what_is_missing(jaco2: Model) -> None:
    with pytest.raises(PlanError, match=r"\(2\.000, 0\.000, 0\.300\) m") as refusal:
        inverse(jaco2, np.array([2.0, 0.0, 0.3]), np.eye(3), [HOME])
    nearest = re.search(r"nearest it comes is ([\d.]+) mm", str(refusal.value))
    assert nearest is not None
    # The stretched arm reaches 0.91 m from its axis: from 2 m away 1.09 m is missing, and somewhat more with the
    # wanted direction in mind.
    assert 1090.0 <= float(nearest[1]) < 1400.0


def test_no_seed_is_refused(jaco2: Model) -> None:
    p, R, _ = jaco2.kinematics(HOME)
    with pytest.raises(PlanError):
        inverse(jaco2, p, R, [])


def test_random_seeds_lie_within_limits_and_one_turn(jaco2: Model) -> None:
    seeds = np.array(random_seeds(jaco2, 200, np.random.default_rng(5)))
    assert np.all(seeds >= np.maximum(jaco2.lower, -np.pi))
    assert np.all(seeds <= np.where(np.isfinite(jaco2.upper), jaco2.upper, np.pi))


def test_random_seeds_are_those_of_their_generator(jaco2: Model) -> None:
    one, two = (random_seeds(jaco2, 3, np.random.default_rng(6)) for _ in range(2))
    assert np.array_equal(one, two)
