"""What is exactly at a limit passes, and the next number beyond it does not: each guard of a cycle at its edge."""

from __future__ import annotations

from dataclasses import replace
from math import inf, nextafter

import numpy as np
import pytest

from burnish.core import Array, Dynamics, State
from burnish.model.model import Model
from burnish.runtime.guards import BACK, BELIEVABLE_SPEED, BELIEVABLE_TORQUE, JUMP, LATE, NEARLY, SLOW, Guards
from burnish.runtime.limits import Limits

MODEL = Model.jaco2()
HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
EVEN = 2.0**-7
"""A period that floating point holds exactly [s]."""
WIDE = replace(
    Limits.of(MODEL),
    lower=np.full(6, -8.0),
    upper=np.full(6, 8.0),
    soft_margin=0.5,
    hard_margin=0.25,
    speed=np.full(6, 2.0),
    torque=np.full(6, 16.0),
)
"""Limits and margins that floating point holds exactly."""
LOW, HIGH = -7.75, 7.75
"""Where a joint stops the arm [rad]: the margin is less than a thirtieth of the range."""


def one(index: int, value: float, others: Array | None = None) -> Array:
    values = np.zeros(6) if others is None else others.copy()
    values[index] = value
    return values


def arm_at(t: float = 0.0, q: Array = HOME, dq: Array | None = None) -> Dynamics:
    return MODEL.at(State(t=t, q=q, dq=np.zeros(6) if dq is None else dq))


def found(arm: Dynamics, limits: Limits = WIDE, *, before: Dynamics | None = None, period: float | None = None) -> str:
    """What new guards say of an arm, after another one where there was one; nothing if all is well."""
    guards = Guards(limits=limits, period=period)
    if before is not None:
        assert guards.state(before) is None
    cause = guards.state(arm)
    return "" if cause is None else cause.text


@pytest.mark.parametrize("joint", range(6))
@pytest.mark.parametrize(("edge", "beyond"), [(LOW, -inf), (HIGH, inf)])
def test_joint_position(joint: int, edge: float, beyond: float) -> None:
    assert found(arm_at(q=one(joint, edge, HOME))) == ""
    assert f"joint {joint + 1} is" in found(arm_at(q=one(joint, nextafter(edge, beyond), HOME)))


@pytest.mark.parametrize("joint", range(6))
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_joint_speed(joint: int, sign: float) -> None:
    assert found(arm_at(dq=one(joint, sign * 2.0))) == ""
    assert f"joint {joint + 1} moved" in found(arm_at(dq=one(joint, sign * nextafter(2.0, inf))))


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_speed_that_no_joint_has(sign: float) -> None:
    assert "joint 4 moved" in found(arm_at(dq=one(3, sign * BELIEVABLE_SPEED)))
    assert "joint 4 reports" in found(arm_at(dq=one(3, sign * nextafter(BELIEVABLE_SPEED, inf))))


def test_speed_that_a_fast_joint_may_have_is_twice_its_limit() -> None:
    fast = replace(WIDE, speed=np.full(6, 4.0))
    assert "joint 4 moved" in found(arm_at(dq=one(3, 8.0)), fast)
    assert "joint 4 reports" in found(arm_at(dq=one(3, nextafter(8.0, inf))), fast)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_torque_that_no_sensor_shows(sign: float) -> None:
    most = BELIEVABLE_TORQUE * 16.0
    assert found(replace(arm_at(), tau=one(1, sign * most))) == ""
    assert "joint 2 reports" in found(replace(arm_at(), tau=one(1, sign * nextafter(most, inf))))


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_jump(sign: float) -> None:
    # From zero, so that the way is the number itself.
    before = arm_at(q=one(3, 0.0, HOME))
    assert found(arm_at(EVEN, q=one(3, sign * JUMP, HOME)), before=before) == ""
    assert "joint 4 jumped" in found(arm_at(EVEN, q=one(3, sign * nextafter(JUMP, inf), HOME)), before=before)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_jump_of_a_joint_that_moves_may_be_what_its_speed_explains_twice(sign: float) -> None:
    before, dq = arm_at(q=one(3, 0.0, HOME)), one(3, sign * 0.5)
    most = JUMP + 2.0 * 0.5 * EVEN
    assert found(arm_at(EVEN, q=one(3, sign * (most - 1e-12), HOME), dq=dq), before=before) == ""
    assert "jumped" in found(arm_at(EVEN, q=one(3, sign * (most + 1e-12), HOME), dq=dq), before=before)
    # The other way it is a jump long before.
    assert "jumped" in found(arm_at(EVEN, q=one(3, -sign * (JUMP + 1e-12), HOME), dq=dq), before=before)


@pytest.mark.parametrize("leap", [0.75, 3600.0])
def test_jump_in_the_cycle_in_which_the_clock_leaps(leap: float) -> None:
    # At 0.01 rad/s a joint would come far in an hour, but between two samples no hour has passed.
    before, dq = arm_at(q=one(3, 0.0, HOME)), one(3, 0.01)
    most = JUMP + 2.0 * 0.01 * 0.5
    assert found(arm_at(leap, q=one(3, most - 1e-12, HOME), dq=dq), before=before) == ""
    assert "joint 4 jumped" in found(arm_at(leap, q=one(3, most + 1e-12, HOME), dq=dq), before=before)


def test_clock_that_goes_back() -> None:
    before = arm_at(1.0)
    assert found(arm_at(1.0 - BACK + 1e-12), before=before) == ""
    assert "clock of the readings went back" in found(arm_at(1.0 - BACK - 1e-12), before=before)


def test_cycle_that_is_late() -> None:
    for gap, says in ((LATE * EVEN, ""), (nextafter(LATE * EVEN, inf), "cycles are late")):
        guards, t = Guards(limits=WIDE, period=EVEN), 0.0
        causes = []
        for _ in range(4):
            causes.append(guards.state(arm_at(t)))
            # Multiples of the gap up to four are exact where the gap is, and no less where it is not.
            t = t + gap if says == "" else nextafter(t + gap, inf)
        assert causes[:3] == [None] * 3
        assert says in ("" if causes[3] is None else causes[3].text)
        assert (causes[3] is None) is (says == "")


@pytest.mark.parametrize("axis", range(3))
def test_work_space(axis: int) -> None:
    arm = arm_at()
    low, high = np.full(3, -2.0), np.full(3, 2.0)
    for bound, name in ((low, "box_low"), (high, "box_high")):
        exact = bound.copy()
        exact[axis] = arm.p[axis]
        assert found(arm, replace(WIDE, **{name: exact})) == ""
        exact[axis] = nextafter(exact[axis], inf if name == "box_low" else -inf)
        assert "left its work space: " + "xyz"[axis] in found(arm, replace(WIDE, **{name: exact}))


def test_tool_force() -> None:
    limits = replace(WIDE, tool_force=25.0)
    assert found(replace(arm_at(), F=np.array([0.0, 15.0, 20.0, 0.0, 0.0, 9.0])), limits) == ""
    assert "tool force" in found(
        replace(arm_at(), F=np.array([0.0, 15.0, nextafter(20.0, 21.0), 0.0, 0.0, 0.0])), limits
    )


def test_tool_speed_and_energy() -> None:
    arm = arm_at(dq=one(0, 0.25))
    speed = float(np.sqrt(arm.v[0] * arm.v[0] + arm.v[1] * arm.v[1] + arm.v[2] * arm.v[2]))
    assert found(arm, replace(WIDE, tool_speed=speed)) == ""
    assert "the tool moved" in found(arm, replace(WIDE, tool_speed=nextafter(speed, 0.0)))
    energy = 0.5 * float(arm.dq.dot(arm.M.dot(arm.dq)))
    assert found(arm, replace(WIDE, energy=energy)) == ""
    assert "kinetic energy" in found(arm, replace(WIDE, energy=nextafter(energy, 0.0)))


def test_arm_next_to_itself() -> None:
    packaged = replace(Limits.jaco2(), self_slow=1.0, self_stop=0.5)
    guards = Guards(limits=packaged)
    guards.state(arm_at())
    distance = guards.distance
    assert found(arm_at(), replace(packaged, self_stop=nextafter(distance, 0.0))) == ""
    assert "from hitting itself" in found(arm_at(), replace(packaged, self_stop=distance))


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_arm_is_calm_up_to_where_it_is_softened(sign: float) -> None:
    def calm(arm: Dynamics) -> bool:
        guards = Guards(limits=WIDE)
        assert guards.state(arm) is None
        return guards.calm

    low = -8.0 + 0.5
    slow = SLOW * 2.0
    assert calm(arm_at(q=one(3, sign * low, HOME)))
    assert not calm(arm_at(q=one(3, sign * nextafter(low, -9.0), HOME)))
    assert calm(arm_at(dq=one(3, sign * slow)))
    assert not calm(arm_at(dq=one(3, sign * nextafter(slow, inf))))


def test_arm_with_a_fast_tool_or_near_itself_is_not_calm() -> None:
    arm = arm_at(dq=one(0, 0.25))
    speed = float(np.linalg.norm(arm.v[:3]))
    for share, calm in ((0.5 * (NEARLY + 1.0), False), (0.5 * NEARLY, True)):
        guards = Guards(limits=replace(WIDE, tool_speed=speed / share))
        assert guards.state(arm) is None
        assert guards.calm is calm
        assert (guards.hurry > 0.0) is not calm
    near = Guards(limits=replace(Limits.jaco2(), self_slow=1.0))
    assert near.state(arm_at()) is None
    assert not near.calm


def test_speed_ahead() -> None:
    guards = Guards(limits=replace(WIDE, speed=np.full(6, 0.5)))
    arm = arm_at()
    weight = arm.g + arm.h
    assert guards.ahead(arm, weight, 0.01) is None
    # Two cycles at 1.25 a, and half of the time in which 300 N·m/s undo it.
    joint, inertia = 4, float(arm.M[4, 4])

    def then(a: float) -> float:
        return 1.25 * a * (0.02 + 0.5 * 1.25 / 300.0 * inertia * a)

    a = 0.5 / (1.25 * 0.02)
    for _ in range(50):
        a -= (then(a) - 0.5) / (1.25 * 0.02)
    push = arm.M @ one(joint, a)
    assert guards.ahead(arm, weight + (1.0 - 1e-9) * push, 0.01) is None
    cause = guards.ahead(arm, weight + (1.0 + 1e-9) * push, 0.01)
    assert cause is not None
    assert cause.text == "joint 5 would reach 0.50 rad/s; the limit is 0.50 rad/s"
