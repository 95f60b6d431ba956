"""The operator is slowed down before the arm's limits, in proportion to what is left, and leaves them freely."""

from __future__ import annotations

import numpy as np
import pytest

from burnish.core import Array, Dynamics, State
from burnish.errors import InputError
from burnish.model.model import Model
from burnish.teleop.limits import (
    ASIDE,
    BRAKING,
    FASTER,
    JOINT_SPEED,
    LENGTH,
    SINGULAR,
    SLOWER,
    Bounds,
    Mobility,
    Slowed,
    jacobian_rate,
)

MODEL = Model.jaco2()
READY = np.array([4.532, 3.254, 1.369, 5.85, 1.492, 1.3233])
FREE = np.full(6, np.inf)


def at(q: Array) -> Dynamics:
    return MODEL.at(State(t=0.0, q=q, dq=np.zeros(6)))


def bounds(lower: Array = -FREE, upper: Array = FREE, speed: Array = FREE, **box: Array) -> Bounds:
    return Bounds(lower=lower, upper=upper, speed=speed, **box)


def twist_of(arm: Dynamics, dq: Array) -> Array:
    return np.asarray(arm.J @ dq)


def slow(of: Bounds, arm: Dynamics, twist: Array) -> Slowed:
    return of.slowed(arm, Mobility(arm.J), twist)


def singular_value(J: Array, twist: Array) -> tuple[float, float, Array]:
    here = Mobility(J)
    dq = here.joint_speeds(twist)
    return here.smallest, here.smallest_rate(dq), dq


def somewhere(rng: np.random.Generator) -> Array:
    return rng.uniform([0, 1.0, 0.5, 0, 0, 0], [6.2, 5.2, 5.7, 6.2, 6.2, 6.2])


def test_jacobian_rate_is_the_difference_of_jacobians() -> None:
    rng = np.random.default_rng(1)
    for _ in range(30):
        q, dq, h = somewhere(rng), rng.normal(size=6), 1e-6
        ahead, behind = (MODEL.kinematics(q + s * h * dq)[2] for s in (1, -1))
        np.testing.assert_allclose(
            jacobian_rate(MODEL.kinematics(q)[2], dq), (ahead - behind) / (2 * h), atol=1e-7
        )  # second differences of O(1) numbers: h² and 1e-16/h


def test_rate_of_the_singular_value_is_the_difference_of_singular_values() -> None:
    rng = np.random.default_rng(2)

    def sigma(q: Array) -> float:
        J = MODEL.kinematics(q)[2]
        return float(np.linalg.svd(np.vstack([J[:3] / LENGTH, J[3:]]), compute_uv=False)[-1])

    for _ in range(30):
        q, h = somewhere(rng), 1e-6
        found, rate, dq = singular_value(MODEL.kinematics(q)[2], rng.normal(size=6) * 0.1)
        assert found == pytest.approx(sigma(q), abs=1e-12)
        assert rate == pytest.approx((sigma(q + h * dq) - sigma(q - h * dq)) / (2 * h), abs=1e-5)


def test_joint_speeds_are_those_of_the_twist() -> None:
    arm = at(READY)
    dq = np.array([0.1, -0.2, 0.3, 0.1, 0.2, -0.1])
    # Damping takes (0.001/0.35)² of the worst direction.
    np.testing.assert_allclose(singular_value(arm.J, twist_of(arm, dq))[2], dq, rtol=1e-4)


@pytest.mark.parametrize("joint", range(6))
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_joint_closes_the_way_to_its_limit_no_faster_than_in_its_braking_time(joint: int, sign: float) -> None:
    arm, left, dq = at(READY), 0.05, np.zeros(6)
    dq[joint] = sign * 0.4
    lower, upper = -FREE.copy(), FREE.copy()
    (upper if sign > 0 else lower)[joint] = READY[joint] + sign * left
    slowed = slow(bounds(lower, upper), arm, twist_of(arm, dq))
    assert slowed.share * 0.4 == pytest.approx(left / BRAKING, rel=6e-3)  # what may be closed aside
    assert slowed.cause == f"limit of joint {joint + 1}"
    assert slow(bounds(lower, upper), arm, twist_of(arm, -dq)).share == 1.0


def test_beyond_a_limit_nothing_leads_further_and_everything_leads_back() -> None:
    arm = at(READY)
    beyond = bounds(upper=READY - 0.1)
    dq = np.array([0.0, 0.2, 0.0, 0.0, 0.0, 0.0])
    assert slow(beyond, arm, twist_of(arm, dq)).share == 0.0
    assert slow(beyond, arm, twist_of(arm, -dq)).share == 1.0


def test_no_joint_is_asked_for_more_than_its_share_of_speed() -> None:
    rng = np.random.default_rng(3)
    limit = np.full(6, 0.6)
    for _ in range(200):
        arm = at(somewhere(rng))
        twist = rng.normal(size=6) * [0.1, 0.1, 0.1, 0.5, 0.5, 0.5]
        share = slow(bounds(speed=limit), arm, twist).share
        assert np.abs(share * singular_value(arm.J, twist)[2]).max() <= 0.65 * 0.6 + 1e-9


def test_far_from_everything_the_operator_is_not_slowed() -> None:
    assert slow(bounds(), at(READY), np.array([0.1, 0, 0, 0, 0, 0])) == (1.0, "")


def test_towards_a_singularity_the_share_falls_to_nothing_and_away_from_it_is_free() -> None:
    # The wrist's singularity: joint 5 makes the axes of joints 4 and 6 parallel.
    directions = []
    for q5 in np.linspace(0.02, np.pi - 0.02, 40):
        q = READY.copy()
        q[4] = q5
        arm = at(q)
        sigma, rate, _ = singular_value(arm.J, twist_of(arm, np.array([0, 0, 0, 0, 0.3, 0])))
        towards = twist_of(arm, np.array([0, 0, 0, 0, -0.3 * np.sign(rate), 0]))
        share = slow(bounds(), arm, towards).share
        if sigma <= SINGULAR and rate != 0.0:
            assert share == 0.0
        directions.append((sigma, share))
    assert min(directions)[0] < SINGULAR < max(directions)[0]
    assert any(0.0 < share < 1.0 for _, share in directions)


def test_the_share_is_the_least_that_any_limit_leaves() -> None:
    rng = np.random.default_rng(9)
    causes = set()
    for _ in range(2000):
        arm, speed = at(somewhere(rng)), rng.uniform(0.3, 1.0, 6)
        lower, upper = arm.q - rng.exponential(0.3, 6), arm.q + rng.exponential(0.3, 6)
        box_low, box_high = arm.p - rng.exponential(0.3, 3), arm.p + rng.exponential(0.3, 3)
        twist = rng.normal(size=6) * rng.choice([0.0, 0.03, 0.3])
        of = bounds(lower, upper, speed, box_low=box_low, box_high=box_high)
        # All limits at once, as vectors, both ways.
        sigma, rate, dq = singular_value(arm.J, twist)
        aside = ASIDE * np.abs(dq).max()
        closing = np.concatenate([dq - aside, -dq - aside, [-rate - aside], twist[:3], -twist[:3]])
        left = np.concatenate([upper - arm.q, arm.q - lower, [sigma - SINGULAR], box_high - arm.p, arm.p - box_low])
        shares = [1.0, *(JOINT_SPEED * speed / np.maximum(np.abs(dq), 1e-12))]
        shares += [max(d, 0.0) / (BRAKING * c) for d, c in zip(left, closing, strict=True) if c > 0.0]
        found = slow(of, arm, twist)
        assert found.share == pytest.approx(min(shares), abs=1e-12)
        causes.add(found.cause.rstrip(" 123456"))
    assert causes == {"", "speed of joint", "limit of joint", "singularity", "edge of the work space"}


def test_a_joint_that_starts_while_all_together_slow_down_is_accelerated_no_more_than_others() -> None:
    arm, most = at(READY), np.repeat([2.0, 8.0], 3)
    before, after = twist_of(arm, np.array([0.6, 0, 0, 0, 0, 0])), twist_of(arm, np.array([0, 0, 0.4, 0, 0, 0]))
    duration = (np.abs(after - before) / most).max()
    share = Mobility(arm.J).ease(before, after, most)
    assert share == pytest.approx(min(1.0, FASTER * duration / 0.4), rel=1e-3)
    assert share < 1.0


def test_edges_of_the_work_space_slow_the_tool_down() -> None:
    arm, left = at(READY), 0.02
    box = bounds(box_high=arm.p + [left, np.inf, np.inf])
    out = np.array([0.2, 0, 0, 0, 0, 0])
    assert slow(box, arm, out).share == pytest.approx(left / (BRAKING * 0.2))
    assert slow(box, arm, out).cause == "edge of the work space"
    assert slow(box, arm, -out).share == 1.0


@pytest.mark.parametrize(
    "bad", [{"upper": -FREE}, {"speed": np.zeros(6)}, {"speed": np.ones(5)}, {"lower": np.ones(6), "upper": np.ones(6)}]
)
def test_bounds_that_are_none_are_refused(bad: dict[str, Array]) -> None:
    with pytest.raises(InputError, match="Bounds"):
        bounds(**bad)


def test_accelerations_ask_no_joint_for_more_than_it_may_give() -> None:
    rng = np.random.default_rng(8)
    most = np.repeat([2.0, 8.0], 3)
    eased = []
    for _ in range(200):
        arm, change = at(somewhere(rng)), rng.normal(size=6) * [0.1, 0.1, 0.1, 0.5, 0.5, 0.5]
        if Mobility(arm.J).smallest < SINGULAR:
            continue  # nobody gets there
        share = Mobility(arm.J).ease(np.zeros(6), change, most)
        # All axes together, each within its own, so the slowest sets the time.
        acceleration = share * change / (np.abs(change) / most).max()
        assert np.abs(np.linalg.solve(arm.J, acceleration)).max() <= FASTER * 1.01
        eased.append(share)
        braked = Mobility(arm.J).ease(change, np.zeros(6), most)
        assert braked == pytest.approx(min(1.0, share * SLOWER / FASTER)) or share == 1.0
    assert min(eased) < 0.5
    assert Mobility(at(READY).J).ease(np.zeros(6), np.zeros(6), most) == 1.0
