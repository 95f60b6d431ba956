"""Corners of the supervisor that no other test looks into: what is calm, what is alive, whose clock, which way back."""

from __future__ import annotations

import json
from dataclasses import replace
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.core import Array, Dynamics, State
from burnish.errors import InputError
from burnish.model.model import Model
from burnish.runtime.guards import BELIEVABLE_TORQUE, JUMP, NOTICEABLE, Guards
from burnish.runtime.limits import LARGEST_FILE, Limits
from burnish.runtime.machine import Mode
from burnish.runtime.supervisor import Supervisor

MODEL = Model.jaco2()
LIMITS = Limits.of(MODEL)
HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
T = 0.01
NARROW = replace(LIMITS, lower=np.full(6, -3.0), upper=np.full(6, 3.0), hard_margin=0.25, soft_margin=0.9)
"""Joints of six radians: the margins are a thirtieth and a tenth of that."""


def one(value: float, joint: int, others: Array | None = None) -> Array:
    values = np.zeros(6) if others is None else others.copy()
    values[joint] = value
    return values


def arm_at(t: float = 0.0, q: Array = HOME, dq: Array | None = None, tau: Array | None = None) -> Dynamics:
    return MODEL.at(State(t=t, q=q, dq=np.zeros(6) if dq is None else dq, tau=tau))


def said(guards: Guards, *arms: Dynamics) -> str:
    """What is said of the last of these states; nothing may be said of those before."""
    for arm in arms[:-1]:
        assert guards.state(arm) is None
    cause = guards.state(arms[-1])
    return "" if cause is None else cause.text


# What is calm.


@pytest.mark.parametrize(("q", "stops"), [(-2.803, True), (-2.799, False), (2.803, True), (2.799, False)])
def test_the_hard_margin_is_no_more_than_a_thirtieth_of_the_range(q: float, stops: bool) -> None:
    assert bool(said(Guards(limits=NARROW), arm_at(q=np.full(6, q)))) is stops


@pytest.mark.parametrize(("q", "calm"), [(-2.41, False), (-2.39, True), (2.41, False), (2.39, True)])
def test_the_soft_margin_is_no_more_than_a_tenth_of_the_range(q: float, calm: bool) -> None:
    guards = Guards(limits=NARROW)
    assert said(guards, arm_at(q=np.full(6, q))) == ""
    assert guards.calm is calm


@pytest.mark.parametrize(("q", "pushed"), [(-2.41, True), (-2.39, False)])
def test_a_joint_is_pushed_back_from_its_own_margin_alone(q: float, pushed: bool) -> None:
    # Another joint is fast, so that the torque is softened in any case.
    arm = arm_at(q=np.full(6, q), dq=one(0.9 * float(LIMITS.speed[5]), 5))
    sent = Supervisor(limits=NARROW).filter(arm, arm.g)
    back = np.linalg.solve(arm.M, sent - arm.g)
    assert_allclose(back[:5], 25.0 * (2.4 + q) * -1.0 if pushed else 0.0, atol=1e-9)
    assert back[5] < -0.5


def test_a_torque_that_can_be_believed_is_calm() -> None:
    guards = Guards(limits=LIMITS)
    assert said(guards, arm_at(tau=0.99 * BELIEVABLE_TORQUE * LIMITS.torque)) == ""
    assert guards.calm


def test_a_joint_that_moves_as_it_says_is_calm_and_another_is_not() -> None:
    dq = one(0.4, 4)
    for moved, calm in ((dq * T, True), (-dq * T, False), (one(0.003, 2), False)):
        guards = Guards(limits=LIMITS)
        said(guards, arm_at(10.0), arm_at(10.0 + T, HOME + moved, dq if calm or moved[4] else None))
        assert guards.calm is calm


@pytest.mark.parametrize("length", [0, 5, 7])
@pytest.mark.parametrize("name", ["tau", "dq"])
def test_one_list_of_another_length_is_a_fault(name: str, length: int) -> None:
    changes: dict[str, Any] = {"tau": np.zeros(6), name: np.zeros(length)}
    cause = Guards(limits=LIMITS).state(replace(arm_at(), **changes))
    assert cause is not None
    assert cause.fault
    assert "joints" in cause.text


# What is alive, and whose clock.


def talking(joint: int, **same: bool) -> list[Dynamics]:
    """Six states of an arm whose torques all change but for joint 1's, which moves; and a joint that may repeat."""
    arms = []
    for k in range(6):
        q, dq, tau = HOME + one(1e-4 * k, 0), one(1e-2, 0), np.full(6, 1.0 + 10.0 * NOTICEABLE * k)
        tau[0] = 1.0
        q[joint] += 0.0 if same.get("q") else 1e-4 * k
        dq[joint] = 1e-2 if same.get("dq") else 1e-2 + 1e-4 * k
        tau[joint] = 0.0 if same.get("none") else 2.0 if same.get("tau") else tau[joint]
        arms.append(arm_at(T * k, q, dq, tau))
    return arms


@pytest.mark.parametrize(
    ("same", "dead"),
    [
        (("q", "dq", "tau"), True),
        (("q", "dq"), False),
        (("q", "tau"), False),
        (("dq", "tau"), False),
        (("q",), False),
        (("q", "dq", "none"), False),
    ],
)
def test_a_joint_is_dead_where_all_that_it_says_repeats(same: tuple[str, ...], dead: bool) -> None:
    guards = Guards(limits=LIMITS)
    causes = [guards.state(arm) for arm in talking(2, **dict.fromkeys(same, True))]
    texts = [cause.text for cause in causes if cause is not None]
    assert ("joint 3 reports the same for 3 cycles" in texts) is dead
    assert bool(texts) is dead


def test_a_joint_that_repeats_itself_once_now_and_then_is_alive() -> None:
    alive, dead = talking(2), talking(2, q=True, dq=True, tau=True)
    guards = Guards(limits=LIMITS)
    for k, arm in enumerate([alive[0], alive[1], dead[2], dead[3], alive[4], alive[5]]):
        assert guards.state(arm) is None, k


def test_a_reading_that_is_a_little_old_does_not_set_the_clock_back() -> None:
    assert "stale" in said(Guards(limits=LIMITS), arm_at(1.0), arm_at(0.98), arm_at(0.99))
    assert said(Guards(limits=LIMITS), arm_at(1.0), arm_at(0.98), arm_at(1.01)) == ""


def test_clocks_are_named_in_their_units() -> None:
    assert "went back by 0.6 s" in said(Guards(limits=LIMITS), arm_at(1.0), arm_at(0.4))
    late = said(Guards(limits=LIMITS, period=0.4), arm_at(0.0), arm_at(0.9), arm_at(1.8), arm_at(2.7))
    assert late == "cycles are late: 900.0 ms; expected 400.0 ms"


def test_what_is_sound_is_said_of_the_last_state() -> None:
    supervisor = Supervisor(limits=LIMITS)
    supervisor.filter(arm_at(), arm_at().g)
    assert supervisor.sound is True
    supervisor.filter(arm_at(T, one(nan, 2, HOME)), arm_at().g)
    assert supervisor.sound is False
    supervisor.filter(arm_at(2.0 * T), arm_at().g)
    assert supervisor.sound is True


# The hold.


def test_a_force_that_is_no_number_is_held_against_at_the_place_of_the_stop() -> None:
    supervisor = Supervisor(limits=LIMITS)
    supervisor.filter(arm_at(), arm_at().g)
    supervisor.filter(replace(arm_at(T), F=np.full(6, nan)), arm_at().g)
    assert supervisor.mode is Mode.HOLD
    for k in range(2, 30):
        arm = arm_at(T * k, HOME + 0.02)
        sent = supervisor.filter(arm, arm.g)
    assert_allclose(sent - arm.g, -0.02 * LIMITS.stiffness, rtol=1e-6)


@pytest.mark.parametrize("retreat", [1e-4, 1e-3])
def test_the_way_back_from_a_force_is_as_long_as_it_shall_be(retreat: float) -> None:
    supervisor = Supervisor(limits=replace(LIMITS, retreat=retreat))
    supervisor.filter(arm_at(), arm_at().g)
    force = 30.0 * np.array([0.0, 0.6, 0.8])
    supervisor.filter(replace(arm_at(T), F=np.concatenate([force, np.zeros(3)])), arm_at().g)
    for k in range(2, 30):
        arm = arm_at(T * k)
        sent = supervisor.filter(arm, arm.g)
    way = arm.J @ ((sent - arm.g) / LIMITS.stiffness)
    # Next to a singularity the way back is damped a little.
    assert_allclose(way[:3], retreat * force / 30.0, atol=0.05 * retreat)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize(("speeds", "believed"), [(1.9, True), (2.2, False)])
def test_a_step_that_no_joint_can_make_is_left_to_its_weight(sign: float, speeds: float, believed: bool) -> None:
    supervisor = Supervisor(limits=LIMITS)
    supervisor.filter(arm_at(), arm_at().g)
    supervisor.stop("test")
    supervisor.filter(arm_at(T), arm_at().g)
    step = sign * (JUMP + speeds * float(LIMITS.speed[0]) * T)
    for k in range(2, 60):
        arm = arm_at(T * k, one(HOME[0] + step, 0, HOME))
        sent = supervisor.filter(arm, arm.g)
    assert_allclose((sent - arm.g)[0], -LIMITS.stiffness[0] * step if believed else 0.0, rtol=1e-6, atol=1e-9)


# Limits.


def test_the_hold_of_a_described_arm() -> None:
    limits = Limits.of(MODEL)
    assert_allclose(limits.stiffness, [135.0] * 3 + [28.0] * 3)
    assert_allclose(limits.damping, [12.0] * 3 + [3.0] * 3)


def test_what_is_left_out_is_no_limit() -> None:
    names = ("torque", "speed", "stiffness", "damping")
    bare = Limits(**{name: getattr(LIMITS, name) for name in names})
    assert (bare.lower == -np.inf).all()
    assert (bare.upper == np.inf).all()
    assert (bare.deviation == np.inf).all()


def test_a_file_may_be_as_large_as_it_may_be(tmp_path: Path) -> None:
    path = tmp_path / "limits.json"
    text = LIMITS.to_json()
    path.write_text(text + " " * (LARGEST_FILE - len(text.encode())))
    assert Limits.load(path).hash == LIMITS.hash
    path.write_text(path.read_text() + " ")
    with pytest.raises(InputError, match="larger than"):
        Limits.load(path)


@pytest.mark.parametrize(("count", "says"), [(64, "shape"), (65, "expected a number, a list of numbers")])
def test_a_list_in_a_file_may_be_as_long_as_it_may_be(count: int, says: str, tmp_path: Path) -> None:
    path = tmp_path / "limits.json"
    path.write_text(json.dumps(json.loads(LIMITS.to_json()) | {"speed": [1.0] * count}))
    with pytest.raises(InputError, match=says):
        Limits.load(path)


def test_distance_to_itself_is_said_in_millimetres() -> None:
    limits = replace(Limits.jaco2(), self_slow=1.0, self_stop=0.9)
    found = said(Guards(limits=limits), arm_at())
    assert found.startswith("the arm is ")
    assert found.endswith(" mm from hitting itself; expected more than 900 mm")
