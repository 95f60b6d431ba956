"""What the supervisor learns of accelerations that do not come, to the number; and speeds that lie."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from burnish.core import Array, Dynamics, State
from burnish.model.model import Model
from burnish.runtime.guards import LYING, LYING_FOR, UNSEEN, Guards
from burnish.runtime.limits import Limits

MODEL = Model.jaco2().with_armature([0.8, 0.8, 0.8, 0.15, 0.15, 0.15])
LIMITS = Limits.of(MODEL)
HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
T = 0.01
JOINT = 4


def one(value: float, others: Array | None = None, joint: int = JOINT) -> Array:
    values = np.zeros(6) if others is None else others.copy()
    values[joint] = value
    return values


def arm_at(t: float, q: Array = HOME, dq: Array | None = None) -> Dynamics:
    return MODEL.at(State(t=t, q=q, dq=np.zeros(6) if dq is None else dq))


def asked(guards: Guards, t: float, dq: float, ddq: float) -> str:
    """What is said when joint 5 moves at a speed and the law asks for an acceleration of it."""
    arm = arm_at(t, dq=one(dq))
    cause = guards.ahead(arm, arm.g + arm.h + arm.M @ one(ddq), T)
    return "" if cause is None else cause.text


def then(now: float, ddq: float) -> float:
    """The speed ahead: two cycles at 1.25 a, and half of the time in which the rate clamp can undo it."""
    undo = 0.5 * 1.25 / LIMITS.torque_rate * float(arm_at(0.0).M[JOINT, JOINT])
    return now + 1.25 * ddq * (2.0 * T + undo * abs(ddq))


def learnt(predicted: float, found: float, cycles: int) -> tuple[Guards, float, float]:
    """Guards after so many cycles in which an acceleration was predicted and another one came; time, and speed."""
    guards = Guards(limits=LIMITS)
    speeds = 0.1 + found * T * np.arange(cycles + 1)
    for k, dq in enumerate(speeds):
        assert asked(guards, T * k, float(dq), predicted) == ""
    return guards, T * cycles, float(speeds[-1])


@pytest.mark.parametrize(("predicted", "found"), [(6.0, 2.0), (4.0, 1.0), (2.0, 1.0)])
def test_what_is_taken_off_a_prediction(predicted: float, found: float) -> None:
    cycles = 20
    unseen = (predicted - found) * (1.0 - (1.0 - T / UNSEEN) ** cycles)
    limit = float(LIMITS.speed[JOINT])
    for off, says in ((-1e-6, ""), (1e-6, "joint 5 would reach")):
        guards, t, dq = learnt(predicted, found, cycles)
        # The last cycle is learnt from as well, and what is asked now is then too fast by next to nothing.
        last = unseen + (T / UNSEEN) * (predicted - found - unseen)
        now = dq + found * T
        low, high = 0.0, 80.0
        for _ in range(200):
            ddq = 0.5 * (low + high)
            low, high = (ddq, high) if then(now, ddq - min(last, 0.5 * ddq)) < limit + off else (low, ddq)
        assert asked(guards, t + T, now, ddq)[: len(says) or None] == says


def test_an_acceleration_that_comes_leaves_nothing_to_take_off() -> None:
    for predicted in (2.0, 3.0):
        guards, t, dq = learnt(predicted, predicted, 10)
        now, limit = dq + predicted * T, float(LIMITS.speed[JOINT])
        low, high = 0.0, 80.0
        for _ in range(200):
            ddq = 0.5 * (low + high)
            low, high = (ddq, high) if then(now, ddq) < limit else (low, ddq)
        assert asked(guards, t + T, now, 1.001 * ddq)
        guards, t, dq = learnt(predicted, predicted, 10)
        assert not asked(guards, t + T, now, 0.999 * ddq)


def test_a_small_acceleration_that_does_not_come_is_taken_off_too() -> None:
    guards = Guards(limits=replace(LIMITS, speed=np.full(6, 0.02)))
    for k in range(60):
        assert asked(guards, T * k, 0.0195, 0.015) == ""
    assert asked(guards, 0.6, 0.0195, 0.03) == ""
    assert "joint 5" in asked(Guards(limits=replace(LIMITS, speed=np.full(6, 0.02))), 0.0, 0.0195, 0.03)


def test_what_the_motion_itself_takes_is_no_acceleration() -> None:
    dq = 0.99 * LIMITS.speed * np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    arm = arm_at(0.0, dq=dq)
    # Taken for one, with whatever sign, it would make a joint too fast.
    taken = 1.25 * 2.0 * T * np.linalg.solve(arm.M, arm.h)
    assert (np.abs(dq + 2.0 * taken) > LIMITS.speed).any()
    assert Guards(limits=LIMITS).ahead(arm, arm.g + arm.h, T) is None


def lied(cycles: str, joint: int = 2, moves: float = 0.3, says: float = 0.0) -> str:
    """What is said in the end of a joint that moves at a speed and says another one in the cycles marked ``x``.

    Another joint is so fast that the others are looked at one by one.
    """
    guards = Guards(limits=LIMITS)
    other = 0 if joint else 5
    fast = float(0.9 * LIMITS.speed[other])
    said = ""
    for k, mark in enumerate(cycles):
        speeds = one(moves, one(fast, joint=other), joint)
        shown = one(says, speeds, joint) if mark == "x" else speeds
        assert said == ""
        cause = guards.state(arm_at(T * k, HOME + T * k * speeds, shown))
        said = "" if cause is None else cause.text
    return said


@pytest.mark.parametrize("joint", range(6))
def test_a_joint_whose_speed_lies_stops_the_arm(joint: int) -> None:
    # The first cycle has nothing before it.
    assert lied("." + "x" * (LYING_FOR - 1), joint) == ""
    expected = f"joint {joint + 1} reports 0 °/s, and its position moves at 17 °/s"
    assert lied("." + "x" * LYING_FOR, joint) == expected
    back = f"joint {joint + 1} reports 6 °/s, and its position moves at -17 °/s"
    assert lied("." + "x" * LYING_FOR, joint, -0.3, 0.1) == back


def test_one_true_speed_between_lies_begins_anew() -> None:
    assert lied("." + "x" * (LYING_FOR - 1) + "." + "x" * (LYING_FOR - 1)) == ""
    assert lied("." + "x" * (LYING_FOR - 1) + "." + "x" * LYING_FOR) != ""


def test_a_small_lie_is_none() -> None:
    assert lied("." + "x" * 20, says=0.3 - 0.99 * LYING) == ""
    assert lied("." + "x" * LYING_FOR, says=0.3 - 1.01 * LYING) != ""
    assert lied("." * 30) == ""


def test_joint_in_its_last_tenth_of_a_degree_is_named_with_what_is_left() -> None:
    limits = replace(LIMITS, lower=np.full(6, -8.0), upper=np.full(6, 8.0))
    for q, text in ((7.9, "joint 2 is 5.7° from its limit"), (-7.95, "joint 2 is 2.9° from its limit")):
        cause = Guards(limits=replace(limits, soft_margin=0.5, hard_margin=0.25)).state(arm_at(0.0, one(q, HOME, 1)))
        assert cause is not None
        assert cause.text == text
        assert not cause.fault


def test_joint_at_its_limit_itself_is_not_beyond_it() -> None:
    limits = replace(LIMITS, lower=np.full(6, -8.0), upper=np.full(6, 8.0))
    for q, fault in ((8.0, False), (8.001, True), (-8.0, False), (-8.001, True)):
        cause = Guards(limits=limits).state(arm_at(0.0, one(q, HOME, 1)))
        assert cause is not None
        assert cause.fault is fault
