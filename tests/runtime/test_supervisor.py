from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.core import Array, Dynamics, State
from burnish.errors import InputError
from burnish.model.model import Model
from burnish.runtime.machine import Mode
from burnish.runtime.supervisor import ABRUPT, GENTLY, SHAKY, STEADY, Limits, Supervisor

MODEL = Model.jaco2()
LIMITS = Limits.of(MODEL)
HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
LOOSE = replace(LIMITS, speed=np.full(6, 1e9))
"""Without a speed limit the torques themselves can be looked at, however fast they would make the arm."""
STRONG = np.array([20.0, 20.0, 20.0, 5.0, 5.0, 5.0])
"""A torque that moves the arm, and is within its torque limits."""


def arm_at(t: float = 0.0, **changes: Any) -> Dynamics:
    """The arm at rest at home, with changes."""
    return replace(MODEL.at(State(t=t, q=HOME, dq=np.zeros(6))), **changes)


def one(values: Array, index: int, value: float) -> Array:
    """A copy with one number changed."""
    changed = values.copy()
    changed[index] = value
    return changed


def broken(cause: str) -> tuple[Dynamics, Array]:
    """An arm or a torque that must trip the supervisor."""
    arm = arm_at()
    push = np.array([0.0, 0.0, 25.1, 0.0, 0.0, 0.0])
    cases: dict[str, tuple[Dynamics, Array]] = {
        "position": (replace(arm, q=one(arm.q, 3, np.nan)), arm.g),
        "velocity": (replace(arm, dq=one(arm.dq, 2, np.inf)), arm.g),
        "speed": (replace(arm, dq=one(arm.dq, 4, -1.01 * LIMITS.speed[4])), arm.g),
        "force": (replace(arm, F=push), arm.g),
        "wrench": (replace(arm, F=one(push, 0, np.nan)), arm.g),
        "torque": (arm, one(arm.g, 5, np.nan)),
    }
    return cases[cause]


CAUSES = {
    "position": "state is not finite",
    "velocity": "state is not finite",
    "speed": r"joint 5 moved at 0\.85 rad/s; the limit is 0\.84",
    "force": r"tool force reached 25\.1 N; the limit is 25 N",
    "wrench": "tool force reached nan N",
    "torque": "torque that is not finite",
}


# What passes.


def test_torque_within_limits_passes_untouched() -> None:
    supervisor = Supervisor(limits=LOOSE)
    assert_allclose(supervisor.filter(arm_at(), STRONG), STRONG, atol=0.0)
    assert not supervisor.tripped
    assert supervisor.clamped == 0


@pytest.mark.parametrize("share", [0.999, 1.0])
def test_speed_up_to_its_limit_passes(share: float) -> None:
    supervisor = Supervisor(limits=LIMITS)
    arm = arm_at(dq=share * LIMITS.speed)
    supervisor.filter(arm, arm.g + arm.h)
    assert not supervisor.tripped


def test_tool_force_up_to_its_limit_passes() -> None:
    supervisor = Supervisor(limits=LOOSE)
    supervisor.filter(arm_at(F=np.array([0.0, 0.0, 25.0, 9.0, 9.0, 9.0])), STRONG)
    assert not supervisor.tripped


# The guards.


@pytest.mark.parametrize("cause", CAUSES)
def test_guard_fires_and_says_what_it_found(cause: str) -> None:
    supervisor = Supervisor(limits=LIMITS)
    supervisor.filter(*broken(cause))
    assert supervisor.event is not None
    with pytest.raises(AssertionError, match=CAUSES[cause]):
        raise AssertionError(supervisor.event.cause)


@pytest.mark.parametrize("cause", CAUSES)
def test_torque_of_a_guard_that_fires_is_finite_and_within_limits(cause: str) -> None:
    supervisor = Supervisor(limits=LIMITS)
    sent = supervisor.filter(*broken(cause))
    assert np.all(np.abs(sent) <= LIMITS.torque)


@pytest.mark.parametrize("cause", CAUSES)
def test_trip_latches(cause: str) -> None:
    supervisor = Supervisor(limits=LIMITS)
    supervisor.filter(*broken(cause))
    first = supervisor.event
    for i in range(1, 200):
        sent = supervisor.filter(arm_at(t=0.01 * i), STRONG)
    assert supervisor.event is first
    assert np.abs(sent - STRONG).max() > 1.0


@pytest.mark.parametrize("cause", ["speed", "torque"])
def test_after_a_trip_the_arm_is_held_softly_where_it_was(cause: str) -> None:
    supervisor = Supervisor(limits=LIMITS)
    supervisor.filter(*broken(cause))
    off, dq = np.full(6, 0.02), np.full(6, -0.1)
    # A second later the rate clamp has let go.
    supervisor.filter(MODEL.at(State(t=1.0, q=HOME + off - 0.01 * dq, dq=dq)), STRONG)
    # The speed is that of the positions, whatever is reported.
    arm = MODEL.at(State(t=1.01, q=HOME + off, dq=10.0 * dq))
    expected = arm.g - LIMITS.damping * dq - LIMITS.stiffness * off
    assert_allclose(supervisor.filter(arm, STRONG), expected, atol=1e-12)


@pytest.mark.parametrize("cause", ["position", "velocity"])
def test_after_a_broken_reading_the_arm_is_held_where_it_was_last_seen(cause: str) -> None:
    supervisor = Supervisor(limits=LIMITS)
    supervisor.filter(arm_at(), arm_at().g)
    supervisor.filter(replace(broken(cause)[0], t=0.01), arm_at().g)
    arm = arm_at(t=1.0)
    assert_allclose(supervisor.filter(arm, STRONG), arm.g, atol=1e-12)


def test_broken_reading_leaves_the_weight_of_where_the_arm_was_last_seen() -> None:
    supervisor = Supervisor(limits=LOOSE)
    supervisor.filter(arm_at(), STRONG)
    sent = supervisor.filter(replace(broken("position")[0], t=1.0), STRONG)
    assert_allclose(sent, arm_at().g, atol=1e-12)


def test_joint_whose_reading_is_broken_is_left_to_its_weight_and_the_others_are_held() -> None:
    supervisor = Supervisor(limits=LIMITS)
    supervisor.filter(arm_at(), arm_at().g)
    off = np.full(6, 0.02)
    jump = one(np.zeros(6), 2, 1.5)
    bad = arm_at(t=1.0, q=HOME + off + jump)
    # No step is believed to have taken longer than half a second.
    slowed = LIMITS.damping * off / 0.5
    held = np.arange(6) != 2
    moved = supervisor.filter(bad, bad.g) - arm_at().g
    assert_allclose(moved[~held], 0.0, atol=1e-12)
    # Where the others are when it trips is what is held from then on.
    assert_allclose(moved[held], -slowed[held], atol=1e-12)
    moved = supervisor.filter(replace(bad, t=2.0, q=HOME + 2.0 * off + jump), bad.g) - arm_at().g
    assert_allclose(moved[~held], 0.0, atol=1e-12)
    assert_allclose(moved[held], -(LIMITS.stiffness * off + slowed)[held], atol=1e-12)


def test_reading_that_moves_unnoticed_in_a_hold_damps_no_harder_than_the_arm_can_have_sped_up() -> None:
    supervisor = Supervisor(limits=LIMITS, period=0.01)
    supervisor.filter(arm_at(), arm_at().g)
    supervisor.filter(arm_at(t=0.01), np.full(6, np.nan))
    # Less than what counts as a jump, and 2.8 rad/s if it were a motion.
    step = one(np.zeros(6), 3, 0.028)
    moved = supervisor.filter(arm_at(t=0.02, q=HOME + step), STRONG) - arm_at().g
    assert_allclose(moved, -LIMITS.stiffness * step - LIMITS.damping * (step > 0.0) * ABRUPT * 0.01, atol=1e-12)
    moved = supervisor.filter(arm_at(t=0.03, q=HOME + step), STRONG) - arm_at().g
    assert_allclose(moved, -LIMITS.stiffness * step, atol=1e-12)


def test_joint_that_has_jumped_is_believed_again_when_it_jumps_back() -> None:
    supervisor = Supervisor(limits=LIMITS)
    supervisor.filter(arm_at(), arm_at().g)
    supervisor.filter(arm_at(t=0.01, q=HOME + one(np.zeros(6), 2, 1.5)), STRONG)
    assert supervisor.acknowledge() is not None
    off = one(np.zeros(6), 2, 0.002)
    supervisor.filter(arm_at(t=0.02, q=HOME + off), STRONG)
    moved = supervisor.filter(arm_at(t=0.03, q=HOME + off), STRONG) - arm_at().g
    assert_allclose(moved[2], -LIMITS.stiffness[2] * 0.002, atol=1e-12)


def test_joint_that_stays_where_it_jumped_to_is_a_fault() -> None:
    supervisor = Supervisor(limits=LIMITS)
    supervisor.filter(arm_at(), arm_at().g)
    for k in range(1, 4):
        supervisor.filter(arm_at(t=0.01 * k, q=HOME + one(np.zeros(6), 2, 1.5)), STRONG)
    assert supervisor.mode is Mode.FAULT
    assert supervisor.event is not None
    assert "joint 3 reads 85.9° off since it jumped" in supervisor.event.cause


def test_broken_first_reading_sends_no_torque() -> None:
    assert_allclose(Supervisor(limits=LIMITS).filter(*broken("position")), np.zeros(6), atol=0.0)


def test_after_too_much_force_the_tool_retreats_along_it() -> None:
    supervisor = Supervisor(limits=LIMITS)
    push = np.array([10.0, -20.0, 20.0, 0.0, 0.0, 0.0])
    arm = arm_at(F=push)
    # The hold pulls to q₀ with a known stiffness, which tells q₀.
    hold = HOME + (supervisor.filter(arm, arm.g) - arm.g) / LIMITS.stiffness
    moved = MODEL.kinematics(hold)[0] - arm.p
    # Along the force, up to 20 mm; the arm's curvature bends a step of 20 mm by about 2 mm.
    way = float(moved @ push[:3] / 30.0)
    assert 0.01 < way <= 0.0201
    assert_allclose(moved, way * push[:3] / 30.0, atol=2.5e-3)
    # No joint is asked for more speed than is gentle: the hold brings it up to K/D of its way.
    share = np.abs(hold - HOME) * LIMITS.stiffness / LIMITS.damping / LIMITS.speed
    assert share.max() <= GENTLY + 1e-12


def test_too_much_force_is_told_from_the_moment() -> None:
    supervisor = Supervisor(limits=LOOSE)
    supervisor.filter(arm_at(F=np.array([0.0, 0.0, 0.0, 99.0, 0.0, 0.0])), STRONG)
    assert not supervisor.tripped


# The clamps.


def test_torque_beyond_its_limit_is_clamped() -> None:
    supervisor = Supervisor(limits=LOOSE)
    sent = supervisor.filter(arm_at(), np.array([99.0, -99.0, 1.0, 99.0, -99.0, 1.0]))
    assert_allclose(sent, [30.5, -30.5, 1.0, 6.8, -6.8, 1.0])


def test_torque_changes_no_faster_than_its_rate() -> None:
    supervisor = Supervisor(limits=LOOSE)
    supervisor.filter(arm_at(), np.zeros(6))
    for i in range(1, 4):
        sent = supervisor.filter(arm_at(t=0.01 * i), STRONG)
        assert_allclose(sent, np.minimum(STRONG, 300.0 * 0.01 * i), atol=1e-12)


def test_late_cycle_allows_no_more_than_a_usual_one_does() -> None:
    supervisor = Supervisor(limits=LOOSE, period=0.01)
    supervisor.filter(arm_at(), np.zeros(6))
    sent = supervisor.filter(arm_at(t=0.03), STRONG)
    assert_allclose(sent, np.full(6, 300.0 * STEADY * 0.01), atol=1e-12)


@pytest.mark.parametrize("leap", [0.06, 1.0, 3600.0])
def test_clock_that_leaps_allows_no_more_than_the_shortest_cycle_does(leap: float) -> None:
    supervisor = Supervisor(limits=LOOSE, period=0.01)
    supervisor.filter(arm_at(), np.zeros(6))
    # Whatever the clock says, the cycle may have been one of an arm with uneven periods.
    sent = supervisor.filter(arm_at(t=leap), STRONG)
    assert_allclose(sent, np.full(6, 300.0 * SHAKY * 0.01), atol=1e-12)


def test_after_a_cycle_without_a_time_of_its_own_little_is_allowed() -> None:
    supervisor = Supervisor(limits=LOOSE, period=0.01)
    supervisor.filter(arm_at(), np.zeros(6))
    before = supervisor.filter(arm_at(), STRONG)
    sent = supervisor.filter(arm_at(t=0.02), STRONG)
    assert_allclose(sent - before, np.full(6, 300.0 * SHAKY * 0.01), atol=1e-12)


def test_torque_falls_no_faster_than_its_rate() -> None:
    supervisor = Supervisor(limits=LOOSE)
    supervisor.filter(arm_at(), np.zeros(6))
    assert_allclose(supervisor.filter(arm_at(t=0.01), -STRONG), np.maximum(-STRONG, -3.0), atol=1e-12)


def test_trip_changes_the_torque_no_faster_than_its_rate() -> None:
    supervisor = Supervisor(limits=LOOSE)
    supervisor.filter(arm_at(), STRONG)
    sent = supervisor.filter(arm_at(t=0.01), np.full(6, np.nan))
    assert np.abs(sent - STRONG).max() <= 3.0 + 1e-12


def test_clamped_cycles_are_counted() -> None:
    supervisor = Supervisor(limits=LOOSE)
    for i, torque in enumerate([STRONG, STRONG, 9.0 * STRONG, STRONG, STRONG]):
        supervisor.filter(arm_at(t=0.01 * i), torque)
    # The way up is cut once; from a clamp of 3 N·m the way back is free.
    assert supervisor.clamped == 1


# Whatever comes.


def garbage(rng: np.random.Generator, t: float) -> tuple[Dynamics, Array]:
    """Numbers of any size, some of them none, in the places that a broken arm or law can reach."""

    def numbers() -> Array:
        values = rng.normal(size=6) * 10.0 ** rng.uniform(-3.0, 8.0)
        bad = rng.choice([np.nan, np.inf, -np.inf], 6)
        return np.where(rng.uniform(size=6) < 0.1, bad, values)

    arm = arm_at(t=t)
    changes = {name: numbers() for name in ("q", "dq", "g", "F") if rng.uniform() < 0.3}
    return replace(arm, **changes), numbers() if rng.uniform() < 0.5 else arm.g


@pytest.mark.parametrize("seed", range(20))
def test_whatever_comes_the_torque_is_finite_and_within_limits(seed: int) -> None:
    rng = np.random.default_rng(seed)
    supervisor = Supervisor(limits=LIMITS)
    last, t = None, 0.0
    for _ in range(50):
        # Time may stand still, too.
        dt = rng.choice([0.0, 1e-3, 1e-2])
        t += dt
        with np.errstate(all="ignore"):
            sent = supervisor.filter(*garbage(rng, t))
        assert np.all(np.abs(sent) <= LIMITS.torque)
        if last is not None:
            assert np.abs(sent - last).max() <= 300.0 * max(dt, 1e-4) + 1e-9
        last = sent


def test_clock_that_is_no_number_does_not_reach_the_torque() -> None:
    supervisor = Supervisor(limits=LIMITS)
    supervisor.filter(arm_at(), STRONG)
    assert np.all(np.abs(supervisor.filter(arm_at(t=np.nan), STRONG)) <= LIMITS.torque)


# Limits.


def test_limits_of_a_model_are_those_of_its_description() -> None:
    assert_allclose(LIMITS.torque, MODEL.effort_limit)
    assert_allclose(LIMITS.speed, MODEL.velocity_limit)


EACH_JOINT = ("torque", "speed", "stiffness", "damping", "deviation", "lower", "upper")
SIGNED = ("lower", "upper", "box_low", "box_high")
ABSENT = ("deviation", "tool_speed", "free_speed", "impact_force", "energy", *SIGNED)
TABLES = ("axes", "capsules", "pairs")
"""Tested where they are used, in test_clearance.py."""


def no_limit(name: str, value: float) -> bool:
    """Whether the value is none that this limit can have."""
    return np.isnan(value) or (name not in SIGNED and value <= 0.0) or (value == np.inf and name not in ABSENT)


NAMES = [f.name for f in fields(Limits) if f.name not in TABLES]
BAD_VALUES = [(name, v) for name in NAMES for v in (0.0, -1.0, np.nan, np.inf) if no_limit(name, v)]


@pytest.mark.parametrize(("name", "value"), BAD_VALUES)
def test_limit_that_is_none_is_refused_by_name(name: str, value: float) -> None:
    bad: Any = one(np.ones(6), 2, value) if name in EACH_JOINT else value
    bad = np.full(3, value) if name.startswith("box") else bad
    with pytest.raises(InputError, match=f"limits: {name} ="):
        replace(LIMITS, **{name: bad})


def test_limits_cannot_be_written() -> None:
    with pytest.raises(ValueError, match="read-only"):
        LIMITS.torque[0] = 1e9


def test_whoever_watches_can_have_the_arm_held_from_the_next_cycle_on() -> None:
    supervisor = Supervisor(limits=LIMITS)
    supervisor.filter(arm_at(0.0), MODEL.at(State(t=0.0, q=HOME, dq=np.zeros(6))).g)
    supervisor.stop("nobody commands the arm any more")
    assert not supervisor.tripped
    held = supervisor.filter(arm_at(0.01), STRONG)
    assert supervisor.mode is Mode.HOLD
    assert supervisor.event is not None
    assert supervisor.event.cause == "nobody commands the arm any more"
    assert_allclose(held, arm_at().g, atol=1e-9)
    # It is said once, and not a cause that stays.
    for k in range(2, 130):
        supervisor.filter(arm_at(0.01 * k), STRONG)
    assert supervisor.acknowledge() is None
