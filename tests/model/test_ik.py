from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from model.arms import ARMS, DATA, arm, random_q
from numpy.testing import assert_allclose

from burnish.core import Array
from burnish.errors import InputError, PlanError
from burnish.model.ik import POSITION_TOLERANCE, ROTATION_TOLERANCE, inverse_kinematics, random_seeds, solve
from burnish.model.model import Model
from burnish.rotation import exp, log

HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
every_arm = pytest.mark.parametrize("name", ARMS)


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


def middle(model: Model) -> Array:
    """Somewhere within the limits, the same whatever is asked for."""
    return np.clip(np.full(model.n, 0.3), model.lower + 0.05, model.upper - 0.05)


@every_arm
def test_reachable_poses_are_reached_within_the_limits(name: str) -> None:
    model = arm(name)
    for wanted in random_q(model, 1, 40):
        p, R, _ = model.kinematics(wanted)
        q = inverse_kinematics(model, p, R, middle(model))
        assert_there(model, q, p, R)
        assert np.all(model.limit_distance(q) >= 0.0)


@every_arm
def test_pose_that_is_reached_only_on_a_limit_is_reached(name: str) -> None:
    # Each joint that has limits at one of them: the corner of what the arm can do.
    model = arm(name)
    rng = np.random.default_rng(2)
    for _ in range(5):
        corner = np.where(rng.random(model.n) < 0.5, model.lower, model.upper)
        wanted = np.where(np.isfinite(corner), corner, 0.4)
        p, R, _ = model.kinematics(wanted)
        q = inverse_kinematics(model, p, R, wanted + 0.05 * rng.normal(size=model.n))
        assert_there(model, q, p, R)
        assert np.all(model.limit_distance(q) >= 0.0)


@every_arm
def test_nearby_pose_is_reached_nearby(name: str) -> None:
    model = arm(name)
    rng = np.random.default_rng(3)
    for near in random_q(model, 3, 20):
        wanted = np.clip(near + rng.uniform(-0.02, 0.02, model.n), model.lower, model.upper)
        p, R, _ = model.kinematics(wanted)
        q = inverse_kinematics(model, p, R, near)
        assert_there(model, q, p, R)
        # Next to a singularity more than what was asked for may move; another branch is radians away.
        assert np.abs(q - near).max() < 0.7


@every_arm
def test_continuous_joints_come_back_on_the_nearest_turn(name: str) -> None:
    model = arm(name)
    continuous = np.isinf(model.upper)
    for wanted in random_q(model, 4, 10):
        p, R, _ = model.kinematics(wanted)
        near = np.where(continuous, wanted + 40.0, middle(model))
        q = inverse_kinematics(model, p, R, near)
        assert_there(model, q, p, R)
        assert np.all(np.abs(q - near)[continuous] <= np.pi + 1e-9)


def test_joint_whose_limits_are_two_turns_apart_comes_back_on_the_nearer_one() -> None:
    # The lift and two wrists of this arm go from −6.28 to 6.28: most places are reached twice.
    model = arm("ur5e_like")
    two_turns = np.array([False, True, False, True, True, False])
    for wanted in random_q(model, 5, 20):
        p, R, _ = model.kinematics(wanted)
        near = np.array([0.0, 3.0, 0.5, -3.0, 3.0, 0.0])
        q = inverse_kinematics(model, p, R, near)
        for other in (q - 2.0 * np.pi, q + 2.0 * np.pi):
            permitted = two_turns & (model.limit_distance(other) >= 0.0)
            assert np.all(np.abs(other - near)[permitted] >= np.abs(q - near)[permitted])


def test_slide_without_limits_is_never_turned(tmp_path: Any) -> None:
    text = (DATA / "seven_dof.xml").read_text()
    assert 'name="joint_1" range="-2.9 2.9"' in text
    path = tmp_path / "slide.xml"
    path.write_text(text.replace('name="joint_1" range="-2.9 2.9"', 'name="joint_1" type="slide"'))
    model = Model.from_mjcf(path, "tool0")
    assert model.prismatic.tolist() == [True] + [False] * 6
    wanted = np.array([8.0, 0.4, 0.2, 0.5, -0.3, 0.6, 0.1])
    p, R, _ = model.kinematics(wanted)
    # From 7 m away the first start leads there, 2π m off would be another place.
    q = inverse_kinematics(model, p, R, wanted - [7.0, 0, 0, 0, 0, 0, 0])
    assert_there(model, q, p, R)


def test_answer_is_the_same_in_every_call(jaco2: Model) -> None:
    p, R, _ = jaco2.kinematics(np.array([1.0, 2.0, 4.0, -1.0, 0.5, 2.0]))
    one, two = (inverse_kinematics(jaco2, p, R, HOME) for _ in range(2))
    assert np.array_equal(one, two)


def test_guess_that_leads_there_is_used(jaco2: Model) -> None:
    p, R, _ = jaco2.kinematics(HOME)
    assert np.array_equal(inverse_kinematics(jaco2, p, R, HOME, tries=0), HOME)


def test_guess_outside_the_limits_is_brought_inside(jaco2: Model) -> None:
    p, R, _ = jaco2.kinematics(HOME)
    q = inverse_kinematics(jaco2, p, R, HOME + [0.0, 9.0, -9.0, 0.0, 0.0, 0.0])
    assert_there(jaco2, q, p, R)
    assert np.all(jaco2.limit_distance(q) >= 0.0)


def test_more_starts_reach_what_one_does_not(jaco2: Model) -> None:
    stuck = 0
    for wanted in random_q(jaco2, 6, 20):
        p, R, _ = jaco2.kinematics(wanted)
        try:
            inverse_kinematics(jaco2, p, R, HOME, tries=0)
        except PlanError:
            stuck += 1
            assert_there(jaco2, inverse_kinematics(jaco2, p, R, HOME), p, R)
    assert stuck > 2  # else the seeds are of no use


@every_arm
def test_pose_out_of_reach_is_refused_with_what_is_missing(name: str) -> None:
    model = arm(name)
    p, R = np.array([20.0, 0.0, 0.3]), np.eye(3)
    with pytest.raises(PlanError, match=r"\(20\.000, 0\.000, 0\.300\) m") as refusal:
        inverse_kinematics(model, p, R, middle(model), tries=4)
    nearest = re.search(r"nearest that 5 starts came is ([\d.]+) mm and ([\d.]+)°", str(refusal.value))
    assert nearest is not None
    # None of these arms is longer than 1.5 m.
    assert 18_000.0 <= float(nearest[1]) <= 22_000.0
    assert str(refusal.value).endswith("Move what it works on nearer to the base, or turn it")


def test_nearest_approach_is_the_reach_that_is_missing(jaco2: Model) -> None:
    with pytest.raises(PlanError) as refusal:
        inverse_kinematics(jaco2, np.array([2.0, 0.0, 0.3]), np.eye(3), HOME)
    nearest = re.search(r"came is ([\d.]+) mm", str(refusal.value))
    assert nearest is not None
    # The stretched arm reaches 0.91 m from its axis: from 2 m away 1.09 m is missing, and somewhat more with the
    # wanted direction in mind.
    assert 1090.0 <= float(nearest[1]) < 1400.0


def test_joint_that_stands_in_the_way_is_named() -> None:
    # The stroke of this arm ends 0.18 m below; 0.3 m further down only a longer stroke would lead.
    model = arm("prismatic")
    q = np.array([0.2, 0.3, 0.18, 0.1])
    p, R, J = model.kinematics(q)
    with pytest.raises(PlanError, match=r"with .*stroke.* on the limit"):
        inverse_kinematics(model, p + 0.3 * J[:3, 2], R, q)


def test_direction_that_the_arm_does_not_have_is_refused_with_its_angle() -> None:
    # Four joints: the tool of this arm cannot lie down.
    model = arm("prismatic")
    p, R, _ = model.kinematics(middle(model))
    with pytest.raises(PlanError, match=r"and [\d.]+°") as refusal:
        inverse_kinematics(model, p, R @ exp(np.array([1.2, 0.0, 0.0])), middle(model))
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("change", "found"),
    [
        ({"p": np.zeros(2)}, "expected three"),
        ({"p": np.array([np.nan, 0, 0])}, "expected three"),
        ({"R": 2.0 * np.eye(3)}, "orthonormal"),
        ({"R": np.diag((1.0, 1.0, -1.0))}, "reflection"),
        ({"near": np.zeros(7)}, "expected 6 finite"),
        ({"near": np.full(6, np.nan)}, "expected 6 finite"),
    ],
)
def test_what_is_no_pose_is_refused(change: dict[str, Array], found: str, jaco2: Model) -> None:
    good = {"p": np.zeros(3), "R": np.eye(3), "near": HOME}
    with pytest.raises(InputError, match=found):
        inverse_kinematics(jaco2, **{**good, **change})


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


@every_arm
def test_random_seeds_lie_within_limits_one_turn_and_a_metre(name: str) -> None:
    model = arm(name)
    seeds = np.array(random_seeds(model, 200, np.random.default_rng(5)))
    assert np.all(seeds >= np.where(np.isfinite(model.lower), model.lower, -np.pi))
    assert np.all(seeds <= np.where(np.isfinite(model.upper), model.upper, np.pi))
    span = np.where(np.isfinite(model.upper), model.upper - model.lower, 2.0 * np.pi)
    assert_allclose(np.ptp(seeds, axis=0), span, rtol=0.1)  # they do not huddle


def test_random_seeds_are_those_of_their_generator(jaco2: Model) -> None:
    one, two = (random_seeds(jaco2, 3, np.random.default_rng(6)) for _ in range(2))
    assert np.array_equal(one, two)
