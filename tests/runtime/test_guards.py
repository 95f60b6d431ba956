"""The checks of the supervisor one by one, and what it does near a limit; how it stops an arm is in test_stops.py."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq

from burnish.core import Array, Dynamics, State
from burnish.model.model import Model
from burnish.runtime.clearance import Clearance
from burnish.runtime.guards import allowed_speed
from burnish.runtime.machine import CLEAR_FOR, Mode
from burnish.runtime.supervisor import Event, Limits, Supervisor

MODEL = Model.jaco2().with_armature([0.8, 0.8, 0.8, 0.15, 0.15, 0.15])
LIMITS = replace(Limits.of(MODEL), energy=0.5, tool_speed=0.25)
HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
T = 0.01


def arm_at(t: float, q: Array = HOME, dq: Array | None = None, **changes: Any) -> Dynamics:
    return replace(MODEL.at(State(t=t, q=q, dq=np.zeros(6) if dq is None else dq)), **changes)


def one(values: Array, index: int, value: float) -> Array:
    changed = values.copy()
    changed[index] = value
    return changed


def running(cycles: int = 5, limits: Limits = LIMITS, period: float | None = T) -> Supervisor:
    """A supervisor that has let a still arm through for some cycles."""
    supervisor = Supervisor(limits=limits, period=period)
    for i in range(cycles):
        supervisor.filter(arm_at(T * i), arm_at(0.0).g)
    assert not supervisor.tripped
    return supervisor


def cause_of(supervisor: Supervisor) -> str:
    assert supervisor.event is not None
    return supervisor.event.cause


JOINT_2 = one(HOME, 1, MODEL.lower[1] + np.radians(4.0))
BEYOND = one(HOME, 1, MODEL.lower[1] - np.radians(1.0))

SPINNING = {"dq": one(np.zeros(6), 0, 0.6), "q": HOME + one(np.zeros(6), 0, 0.6 * T)}
TRIPS: dict[str, tuple[dict[str, Any], str]] = {
    "garbage torque with code OK": ({"tau": one(np.zeros(6), 3, -1.07e8)}, r"joint 4 reports -1.07e\+08"),
    "torque that is no number": ({"tau": one(np.zeros(6), 3, np.nan)}, "not finite"),
    "degrees for radians": ({"dq": np.full(6, 36.0)}, "expected radians"),
    "encoder jump": ({"q": one(HOME, 2, HOME[2] + 0.06)}, "joint 3 jumped by 3.4°"),
    "tool speed": (SPINNING, "the limit is 0.15 m/s"),
    "kinetic energy": (SPINNING | {"M": 10.0 * arm_at(0.0).M}, r"kinetic energy reached 1\.\d+ J; the limit is 0.50 J"),
}


@pytest.mark.parametrize("case", TRIPS)
def test_guard_says_what_it_found(case: str) -> None:
    changes, expected = TRIPS[case]
    supervisor = running(limits=replace(LIMITS, tool_speed=0.15 if case == "tool speed" else 9.0))
    state = {name: changes[name] for name in ("q", "dq") if name in changes}
    others = {name: value for name, value in changes.items() if name not in state}
    supervisor.filter(arm_at(5 * T, **state, **others), arm_at(0.0).g)
    with pytest.raises(AssertionError, match=expected):
        raise AssertionError(cause_of(supervisor))
    assert supervisor.mode is Mode.HOLD


@pytest.mark.parametrize(("q", "mode"), [(JOINT_2, Mode.HOLD), (BEYOND, Mode.FAULT)])
def test_joint_at_its_limit_stops_the_arm(q: Array, mode: Mode) -> None:
    supervisor = Supervisor(limits=LIMITS)
    supervisor.filter(arm_at(0.0, q=q), arm_at(0.0).g)
    assert "joint 2 is" in cause_of(supervisor)
    assert supervisor.mode is mode


def test_encoder_that_wraps_is_no_jump_once_unwrapped() -> None:
    supervisor = running()
    supervisor.filter(arm_at(5 * T, dq=np.full(6, 0.3), q=HOME + 0.3 * T), arm_at(0.0).g)
    assert not supervisor.tripped


def test_work_space_of_the_tool_is_kept() -> None:
    p = arm_at(0.0).p
    box = replace(LIMITS, box_low=p - 0.1, box_high=p + np.array([0.1, 0.1, -0.01]))
    supervisor = Supervisor(limits=box)
    supervisor.filter(arm_at(0.0), arm_at(0.0).g)
    assert "left its work space: z" in cause_of(supervisor)


def test_stale_state_is_forgiven_once_and_stops_the_arm_the_second_time() -> None:
    supervisor = running()
    supervisor.filter(arm_at(4 * T), arm_at(0.0).g)
    assert not supervisor.tripped
    supervisor.filter(arm_at(4 * T), arm_at(0.0).g)
    assert "stale" in cause_of(supervisor)


def test_one_stale_state_now_and_then_is_forgiven() -> None:
    supervisor = running(1, period=None)
    for i in range(1, 200):
        supervisor.filter(arm_at(T * (i - (i % 3 == 0))), arm_at(0.0).g)
    assert not supervisor.tripped


def noisy(step: int, stuck: int | None = None, size: float = 0.1) -> dict[str, Array]:
    """Readings with noise of some size about the arm at rest; one joint may say the same as ever."""
    rng = np.random.default_rng(step)
    q, dq, tau = HOME + 1e-5 * rng.normal(size=6), 1e-4 * rng.normal(size=6), 5.0 + size * rng.normal(size=6)
    for values, same in ((q, HOME), (dq, np.zeros(6)), (tau, np.full(6, 5.0))):
        if stuck is not None:
            values[stuck] = same[stuck]
    return {"q": q, "dq": dq, "tau": tau}


def test_joint_that_says_the_same_for_three_cycles_while_the_others_do_not_stops_the_arm() -> None:
    supervisor = running(1)
    for step in range(1, 4):
        assert not supervisor.tripped
        supervisor.filter(arm_at(T * step, **noisy(step, stuck=4)), arm_at(0.0).g)
    assert cause_of(supervisor) == "joint 5 reports the same for 3 cycles"


def test_joint_that_speaks_up_again_counts_from_the_beginning() -> None:
    supervisor = running(1)
    for step in range(1, 20):
        supervisor.filter(arm_at(T * step, **noisy(step, stuck=4 if step % 3 else None)), arm_at(0.0).g)
    assert not supervisor.tripped


def test_sensors_without_noise_say_the_same_of_an_arm_at_rest() -> None:
    supervisor = running(1)
    for step in range(1, 20):
        supervisor.filter(arm_at(T * step, **noisy(step, stuck=4, size=1e-4)), arm_at(0.0).g)
    assert not supervisor.tripped


@pytest.mark.parametrize("back", [0.11, 3600.0])
def test_clock_that_goes_back_stops_the_arm_at_once_and_is_then_the_clock(back: float) -> None:
    supervisor = running()
    supervisor.filter(arm_at(5 * T - back), arm_at(0.0).g)
    assert "went back by" in cause_of(supervisor)
    moved = HOME + 0.01
    sent = [supervisor.filter(arm_at((5 + k) * T - back, q=moved), arm_at(0.0).g) for k in range(1, 60)]
    # The arm is seen again: what holds it knows that it has moved.
    assert_allclose(sent[-1] - arm_at(0.0).g, -LIMITS.stiffness * 0.01, atol=0.15)


def test_reading_that_comes_a_little_late_is_no_other_clock() -> None:
    supervisor = running()
    supervisor.filter(arm_at(5 * T), arm_at(0.0).g)
    supervisor.filter(arm_at(5 * T - 0.04), arm_at(0.0).g)
    assert not supervisor.tripped


def test_three_late_cycles_in_a_row_stop_the_arm() -> None:
    supervisor, t = running(), 4 * T
    for i in range(3):
        assert not supervisor.tripped, i
        t += 1.6 * T
        supervisor.filter(arm_at(t), arm_at(0.0).g)
    assert "late: 16.0 ms" in cause_of(supervisor)


def test_five_late_cycles_of_a_hundred_stop_the_arm() -> None:
    supervisor, t, late = running(), 4 * T, 0
    for i in range(100):
        slow = i % 10 == 9
        late += slow
        t += (2.0 if slow else 1.0) * T
        supervisor.filter(arm_at(t), arm_at(0.0).g)
        assert supervisor.tripped == (late >= 5)


def test_jitter_of_a_tenth_is_not_late() -> None:
    rng, supervisor, t = np.random.default_rng(0), running(), 4 * T
    for _ in range(500):
        t += T * rng.uniform(0.9, 1.1)
        supervisor.filter(arm_at(t), arm_at(0.0).g)
    assert not supervisor.tripped


def test_three_broken_states_make_a_fault() -> None:
    supervisor = running()
    modes = []
    for i in range(3):
        supervisor.filter(arm_at((5 + i) * T, dq=one(np.zeros(6), 1, np.nan)), arm_at(0.0).g)
        modes.append(supervisor.mode)
    assert modes == [Mode.HOLD, Mode.HOLD, Mode.FAULT]


@pytest.mark.parametrize("length", [5, 7, 0])
def test_torque_of_another_length_never_gets_through(length: int) -> None:
    supervisor = running()
    sent = supervisor.filter(arm_at(5 * T), np.zeros(length))
    assert sent.shape == (6,)
    assert "shape" in cause_of(supervisor)


# Ahead.


def test_torque_that_would_make_a_joint_too_fast_stops_the_arm_before_it_is() -> None:
    supervisor, g = running(), arm_at(0.0).g
    for i in range(5, 20):
        supervisor.filter(arm_at(T * i), g + np.array([30.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
        if supervisor.tripped:
            break
    assert "joint 1 would reach" in cause_of(supervisor)


def test_torque_that_brakes_a_fast_joint_is_let_through() -> None:
    supervisor = running()
    fast = arm_at(5 * T, q=HOME + one(np.zeros(6), 0, 0.6 * T), dq=one(np.zeros(6), 0, 0.6))
    supervisor.filter(fast, fast.g - one(np.zeros(6), 0, 3.0))
    assert not supervisor.tripped


def test_contact_force_that_holds_against_the_torque_is_counted() -> None:
    # The surface takes 24 N of what the joints press with; in the air the same torque would throw the arm.
    limits = replace(LIMITS, torque_rate=1e5, speed=np.full(6, 0.05))
    free, touching = running(limits=limits), running(limits=limits)
    arm = arm_at(5 * T)
    F = np.array([-24.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    touching.filter(replace(arm, F=F), arm.g - arm.J.T @ F)
    free.filter(arm, arm.g - arm.J.T @ F)
    assert not touching.tripped
    assert free.tripped


def test_after_a_pause_nothing_is_predicted_over_it() -> None:
    supervisor = running(period=None)
    supervisor.filter(arm_at(60.0), arm_at(0.0).g + one(np.zeros(6), 0, 0.5))
    assert not supervisor.tripped


# Near a limit.


def test_fast_joint_is_braked_before_it_is_stopped() -> None:
    supervisor = running()
    dq = one(np.zeros(6), 0, 0.9 * LIMITS.speed[0])
    arm = arm_at(5 * T, q=HOME + dq * T, dq=dq)
    sent = supervisor.filter(arm, arm.g + arm.h)
    assert not supervisor.tripped
    assert supervisor.softened == 1
    slower = np.linalg.solve(arm.M, sent - arm.g - arm.h)
    assert_allclose(slower, one(np.zeros(6), 0, -10.0 * 0.1 * LIMITS.speed[0]), atol=1e-12)


def test_joint_near_its_limit_is_pushed_back() -> None:
    supervisor = Supervisor(limits=LIMITS)
    arm = arm_at(0.0, q=one(HOME, 2, MODEL.upper[2] - np.radians(10.0)))
    sent = supervisor.filter(arm, arm.g)
    assert not supervisor.tripped
    assert np.linalg.solve(arm.M, sent - arm.g)[2] == pytest.approx(-25.0 * np.radians(5.0))


def test_nothing_is_softened_in_the_middle() -> None:
    assert running(20).softened == 0


def test_torque_stays_near_gravity() -> None:
    limits = replace(LIMITS, deviation=np.full(6, 2.0), speed=np.full(6, 1e9), torque_rate=1e9)
    arm = arm_at(0.0)
    sent = Supervisor(limits=limits).filter(arm, arm.g + np.array([3.0, -3.0, 1.0, 5.0, -5.0, 0.0]))
    assert_allclose(sent - arm.g, [2.0, -2.0, 1.0, 2.0, -2.0, 0.0], atol=1e-12)


# Out of a hold.


def held() -> Supervisor:
    """After a law that gave no number."""
    supervisor = running()
    supervisor.filter(arm_at(5 * T), np.full(6, np.nan))
    assert supervisor.mode is Mode.HOLD
    return supervisor


def still(supervisor: Supervisor, start: float, duration: float) -> float:
    """The arm stands for some time; the time at its end."""
    t = start
    while t < start + duration:
        t += T
        supervisor.filter(arm_at(t), arm_at(0.0).g)
    return t


def test_hold_ends_when_it_is_acknowledged_after_the_cause_is_gone() -> None:
    supervisor = held()
    assert "not been clear" in str(supervisor.acknowledge())
    still(supervisor, 5 * T, CLEAR_FOR + 2 * T)
    assert supervisor.acknowledge() is None
    assert supervisor.mode is Mode.TORQUE
    assert not supervisor.tripped


def test_hold_does_not_end_by_itself() -> None:
    supervisor = held()
    still(supervisor, 5 * T, 3.0)
    assert supervisor.mode is Mode.HOLD


def test_hold_cannot_be_acknowledged_while_its_cause_lasts() -> None:
    supervisor = running()
    for i in range(200):
        arm = arm_at(T * (5 + i), F=np.array([0.0, 0.0, 30.0, 0.0, 0.0, 0.0]))
        supervisor.filter(arm, arm.g)
    assert supervisor.acknowledge() is not None


def test_third_hold_within_a_minute_is_a_fault() -> None:
    supervisor, t = running(), 4 * T
    for _ in range(3):
        assert supervisor.mode is Mode.TORQUE
        supervisor.filter(arm_at(t + T), np.full(6, np.nan))
        t = still(supervisor, t + T, CLEAR_FOR + 2 * T)
        refused = supervisor.acknowledge()
    assert refused is not None
    assert supervisor.mode is Mode.FAULT


def test_fault_ends_only_for_who_has_seen_its_cause() -> None:
    supervisor = Supervisor(limits=LIMITS)
    supervisor.filter(arm_at(0.0, q=BEYOND), arm_at(0.0).g)
    event = supervisor.event
    assert event is not None
    still(supervisor, 0.0, 2.0)
    assert supervisor.acknowledge() is not None
    supervisor.reset(Event(t=event.t, cause=event.cause, fault=True))
    assert supervisor.mode is Mode.FAULT, "another event, however alike, is not the one that was shown"
    supervisor.reset(event)
    assert supervisor.mode is Mode.TORQUE
    assert not supervisor.tripped


# Where the tool may meet somebody.

FREE = replace(LIMITS, tool_speed=9.0, energy=9.0, free_speed=0.15, impact_force=60.0)


def moving(speed: float, t: float = 5 * T, along: Array | None = None) -> Dynamics:
    """The arm at home, its tool in straight motion [m/s]."""
    along = np.array([0.0, 0.0, 1.0]) if along is None else along
    twist, arm = speed * np.concatenate([along, np.zeros(3)]), arm_at(0.0)
    for _ in range(5):
        # From home within a cycle, which turns J a little.
        dq = np.linalg.solve(arm.J, twist)
        arm = arm_at(t, q=HOME + dq * T, dq=dq)
    return arm


def reduced(arm: Dynamics, along: Array) -> float:
    """Mass of a blow by another route: that of the tool alone by Λ's block, and the head's."""
    felt = 1.0 / (along @ np.linalg.inv(arm.Lambda)[:3, :3] @ along)
    return felt * 4.4 / (felt + 4.4)


@pytest.mark.parametrize("seed", range(10))
def test_allowed_speed_meets_a_head_with_the_allowed_force(seed: int) -> None:
    along = np.random.default_rng(seed).normal(size=3)
    along /= np.linalg.norm(along)
    arm = moving(0.1, along=along)
    speed = allowed_speed(replace(FREE, free_speed=np.inf), arm, 3.0 * along)
    # Two masses on a spring: ½ μ v² = ½ F²/k.
    assert speed * np.sqrt(75e3 * reduced(arm, along)) == pytest.approx(60.0)


def test_nothing_is_faster_than_the_free_speed() -> None:
    up = np.array([0.0, 0.0, 1.0])
    assert allowed_speed(replace(FREE, free_speed=0.05), moving(0.1), up) == 0.05
    assert allowed_speed(replace(FREE, impact_force=np.inf), moving(0.1), up) == 0.15
    assert allowed_speed(replace(FREE, impact_force=np.inf, tool_speed=0.1), moving(0.1), up) == 0.1
    assert allowed_speed(LIMITS, moving(0.1), up) == LIMITS.tool_speed


def test_mass_matrix_that_is_none_counts_as_a_wall() -> None:
    arm = replace(moving(0.1), M=-np.eye(6))
    assert allowed_speed(FREE, arm, np.array([0.0, 0.0, 1.0])) == pytest.approx(60.0 / np.sqrt(75e3 * 4.4))


@pytest.mark.parametrize(("share", "tripped"), [(0.99, False), (1.01, True)])
def test_tool_that_is_faster_than_allowed_stops_the_arm(share: float, tripped: bool) -> None:
    heavy = replace(FREE, impact_force=30.0)
    speed = share * allowed_speed(heavy, moving(0.1), np.array([0.0, 0.0, 1.0]))
    supervisor = running(limits=heavy)
    arm = moving(speed)
    supervisor.filter(arm, arm.g + arm.h)
    assert supervisor.tripped is tripped
    if tripped:
        assert cause_of(supervisor) == f"the tool moved at {speed:.2f} m/s; the limit is {speed / share:.2f} m/s"


BRAKED = replace(FREE, impact_force=np.inf, torque_rate=1e5)


@pytest.mark.parametrize(("share", "brake"), [(0.899, 0.0), (0.95, 0.5), (0.999, 0.99)])
def test_tool_that_is_nearly_too_fast_is_kept_from_more(share: float, brake: float) -> None:
    supervisor, faster = running(limits=BRAKED), 0.3
    arm = moving(share * 0.15)
    push = arm.Lambda @ np.array([0.0, 0.0, faster, 0.0, 0.0, 0.0])
    sent = supervisor.filter(arm, arm.g + arm.h + arm.J.T @ push)
    assert not supervisor.tripped
    got = (arm.J @ np.linalg.solve(arm.M, sent - arm.g - arm.h))[2]
    # What the law adds is taken back by that share, and that much of a tenth of the speed at 10 1/s.
    assert got == pytest.approx(faster - brake * (faster + 0.1 * 10.0 * share * 0.15), abs=2e-3)
    assert supervisor.softened == (brake > 0.0)


def test_tool_that_is_braked_already_is_braked_a_little_more() -> None:
    supervisor = running(limits=BRAKED)
    arm = moving(0.95 * 0.15)
    sent = supervisor.filter(arm, arm.g + arm.h - arm.J.T @ (arm.Lambda @ np.array([0.0, 0.0, 0.3, 0.0, 0.0, 0.0])))
    got = (arm.J @ np.linalg.solve(arm.M, sent - arm.g - arm.h))[2]
    assert got == pytest.approx(-0.3 - 0.5 * 0.1 * 10.0 * 0.95 * 0.15, abs=2e-3)


def test_fast_tool_of_a_model_that_is_none_is_a_fault() -> None:
    supervisor = running(limits=FREE)
    # Next to 104 mm/s, which is what a wall would allow.
    arm = replace(moving(0.1), M=-np.eye(6))
    supervisor.filter(arm, arm.g)
    assert supervisor.mode is Mode.FAULT
    assert "mass matrix" in cause_of(supervisor)


# The arm against itself.

FOLDED = np.array([4.8, 3.2, 0.45, 4.2, 1.4, 1.3])
OF_JACO2 = replace(Limits.jaco2(), soft_margin=0.03, hard_margin=0.02)


def folded(distance: float) -> Array:
    """Joint positions in which the arm is this far from itself [m]."""
    clearance = Clearance(OF_JACO2)

    def off(angle: float) -> float:
        return clearance.measure(arm_at(0.0, q=one(FOLDED, 2, angle))) - distance

    return one(FOLDED, 2, brentq(off, 0.45, 1.0))


@pytest.mark.parametrize(("distance", "tripped"), [(0.0105, False), (0.0095, True)])
def test_arm_next_to_itself_is_stopped(distance: float, tripped: bool) -> None:
    supervisor = Supervisor(limits=OF_JACO2)
    arm = arm_at(0.0, q=folded(distance))
    supervisor.filter(arm, arm.g)
    assert supervisor.tripped is tripped
    if tripped:
        assert cause_of(supervisor) == "the arm is 10 mm from hitting itself; expected more than 10 mm"


@pytest.mark.parametrize(("distance", "share"), [(0.0205, 0.0), (0.019, 0.1), (0.015, 0.5), (0.011, 0.9)])
def test_arm_near_itself_is_braked(distance: float, share: float) -> None:
    supervisor = Supervisor(limits=OF_JACO2)
    dq = np.array([0.05, -0.05, 0.05, 0.1, -0.1, 0.1])
    arm = arm_at(0.0, q=folded(distance), dq=dq)
    sent = supervisor.filter(arm, arm.g + arm.h)
    assert not supervisor.tripped
    slower = np.linalg.solve(arm.M, sent - arm.g - arm.h)
    assert_allclose(slower, -10.0 * share * dq, rtol=1e-4, atol=1e-9)


# Not in torque mode.


@pytest.mark.parametrize("mode", [Mode.IDLE, Mode.POSITION, Mode.ARMING])
def test_arm_that_is_not_in_torque_mode_is_sent_its_weight(mode: Mode) -> None:
    supervisor = Supervisor(limits=LIMITS, start=Mode.IDLE)
    supervisor.mode = mode
    for k in range(3):
        # Wherever it is taken.
        arm = arm_at(T * k, q=HOME + 0.001 * k)
        assert_allclose(supervisor.filter(arm, arm.g + 5.0), arm.g, atol=1e-12)
    assert not supervisor.tripped


def test_law_that_is_not_asked_cannot_stop_the_arm() -> None:
    supervisor = Supervisor(limits=LIMITS, start=Mode.IDLE)
    supervisor.filter(arm_at(0.0), np.full(6, np.nan))
    assert supervisor.mode is Mode.IDLE


def test_new_life_of_the_supervisor_has_new_guards() -> None:
    supervisor = Supervisor(limits=LIMITS, start=Mode.IDLE)
    for k in range(3):
        supervisor.filter(arm_at(T * k, dq=one(np.zeros(6), 1, np.nan)), arm_at(0.0).g)
    assert supervisor.mode is Mode.FAULT
    assert supervisor.event is not None
    supervisor.reset(supervisor.event)
    supervisor.filter(arm_at(3 * T, dq=one(np.zeros(6), 1, np.nan)), arm_at(0.0).g)
    assert supervisor.mode is Mode.IDLE, "one broken reading is no fault"


# Readings that break in their own ways.


@pytest.mark.parametrize("length", [5, 7])
def test_state_of_another_arm_is_a_fault(length: int) -> None:
    supervisor = running()
    arm = replace(arm_at(5 * T), q=np.zeros(length), dq=np.zeros(length))
    sent = supervisor.filter(arm, arm.g)
    assert cause_of(supervisor) == f"the state has {length} joints; the limits have 6"
    assert supervisor.mode is Mode.FAULT
    assert sent.shape == (6,)
    assert_allclose(supervisor.filter(arm_at(6 * T), arm.g), arm_at(0.0).g)


def test_joint_too_fast_without_a_torque_sensor_is_seen() -> None:
    supervisor = running()
    arm = arm_at(5 * T, dq=one(np.zeros(6), 0, 1.1 * LIMITS.speed[0]), tau=None)
    supervisor.filter(arm, arm.g)
    assert "joint 1 moved at 0.69 rad/s" in cause_of(supervisor)


def test_readings_that_are_believed_one_after_the_other_are_broken_once_each() -> None:
    supervisor = running()
    for i in range(6):
        bad = one(np.zeros(6), 1, np.nan) if i % 2 == 0 else None
        supervisor.filter(arm_at((5 + i) * T, dq=bad), arm_at(0.0).g)
    assert supervisor.mode is Mode.HOLD


def test_fast_joint_with_a_believable_torque_passes() -> None:
    supervisor = running()
    dq = one(np.zeros(6), 0, 0.9 * LIMITS.speed[0])
    arm = arm_at(5 * T, q=HOME + dq * T, dq=dq, tau=np.ones(6))
    supervisor.filter(arm, arm.g)
    assert not supervisor.tripped


def test_late_cycles_from_the_first_on_are_counted() -> None:
    supervisor = running(1)
    for i in range(1, 4):
        assert not supervisor.tripped
        supervisor.filter(arm_at(1.6 * T * i), arm_at(0.0).g)
    assert "late" in cause_of(supervisor)


def test_causes_are_worded_as_they_are_shown() -> None:
    law, state = running(), running()
    law.filter(arm_at(5 * T), np.full(6, np.nan))
    assert cause_of(law) == "the control law gave a torque that is not finite"
    for i in range(3):
        state.filter(arm_at((5 + i) * T, dq=one(np.zeros(6), 1, np.nan)), arm_at(0.0).g)
        assert cause_of(state) == "the measured state is not finite" + (" for three cycles" if i == 2 else "")


@pytest.mark.parametrize(
    ("speed", "cause"), [(5.1, "joint 4 reports 5.1 rad/s"), (-4.9, "joint 4 moved at 4.90 rad/s")]
)
def test_speed_beyond_all_is_told_from_a_fast_joint(speed: float, cause: str) -> None:
    supervisor = running()
    supervisor.filter(arm_at(5 * T, dq=one(np.zeros(6), 3, speed)), arm_at(0.0).g)
    assert cause_of(supervisor).startswith(cause)


@pytest.mark.parametrize(("jump", "tripped"), [(0.030, False), (0.036, True), (-0.036, True)])
def test_jump_is_what_the_speed_does_not_explain(jump: float, tripped: bool) -> None:
    supervisor = running()
    supervisor.filter(arm_at(5 * T, q=one(HOME, 0, HOME[0] + jump)), arm_at(0.0).g)
    assert supervisor.tripped is tripped
    if tripped:
        assert cause_of(supervisor) == f"joint 1 jumped by {np.degrees(jump):.1f}° within 10 ms"


def test_softened_cycles_are_counted_one_by_one() -> None:
    supervisor = Supervisor(limits=LIMITS)
    for k in range(3):
        arm = arm_at(T * k, q=one(HOME, 2, MODEL.upper[2] - np.radians(10.0)))
        supervisor.filter(arm, arm.g)
    assert supervisor.softened == 3


def test_after_a_reset_late_cycles_are_noticed_again() -> None:
    supervisor = Supervisor(limits=LIMITS, period=T)
    supervisor.filter(arm_at(0.0, q=BEYOND), arm_at(0.0).g)
    assert supervisor.event is not None
    supervisor.reset(supervisor.event)
    for k in range(6):
        supervisor.filter(arm_at(2.0 * T * k), arm_at(0.0).g)
    assert "late" in cause_of(supervisor)


def test_broken_state_before_any_other_keeps_what_was_sent_last() -> None:
    supervisor = Supervisor(limits=LIMITS, start=Mode.IDLE)
    arm = arm_at(0.0)
    supervisor.filter(replace(arm, g=np.full(6, np.nan)), arm.g)
    sent = supervisor.filter(arm_at(T, dq=np.full(6, np.nan)), arm.g)
    assert np.isfinite(sent).all()


# What is predicted and does not come.


def spun(supervisor: Supervisor, speed: float, extra: float, cycles: int, start: tuple[float, float]) -> Any:
    """Joint 5 turns evenly while the law asks for ``extra`` rad/s² more; time and position at the end."""
    t, q5 = start
    for _ in range(cycles):
        t, q5 = t + T, q5 + speed * T
        arm = arm_at(t, q=one(HOME, 4, q5), dq=one(np.zeros(6), 4, speed))
        supervisor.filter(arm, arm.g + arm.h + arm.M @ one(np.zeros(6), 4, extra))
    return t, q5


BARE = Limits.of(MODEL)
"""Joint limits alone."""


def test_law_that_makes_up_for_friction_is_not_stopped_for_a_speed_that_never_comes() -> None:
    supervisor = Supervisor(limits=BARE, period=T)
    now = spun(supervisor, 0.3, 13.0, 60, (0.0, HOME[4]))
    spun(supervisor, 0.5, 14.0, 20, now)
    assert not supervisor.tripped
    unaware = Supervisor(limits=BARE, period=T)
    spun(unaware, 0.5, 14.0, 2, (0.0, HOME[4]))
    assert "joint 5 would reach" in cause_of(unaware)


def test_no_more_than_half_of_a_prediction_is_taken_off() -> None:
    supervisor = Supervisor(limits=BARE, period=T)
    now = spun(supervisor, 0.3, 13.0, 200, (0.0, HOME[4]))
    spun(supervisor, 0.7, 13.0, 1, now)
    assert "joint 5 would reach" in cause_of(supervisor)


def test_what_did_not_come_in_one_direction_is_not_taken_off_in_the_other() -> None:
    supervisor = Supervisor(limits=replace(BARE, torque_rate=1000.0), period=T)
    now = spun(supervisor, -0.3, 13.0, 60, (0.0, HOME[4]))
    spun(supervisor, -0.55, -13.0, 1, now)
    assert "joint 5 would reach" in cause_of(supervisor)


def test_after_a_pause_what_did_not_come_is_learnt_anew() -> None:
    supervisor = Supervisor(limits=BARE)
    t, q5 = spun(supervisor, 0.3, 13.0, 60, (0.0, HOME[4]))
    spun(supervisor, 0.5, 13.0, 1, (t + 1.0, q5))
    assert "joint 5 would reach" in cause_of(supervisor)


def test_joint_that_has_turned_round_still_has_the_friction_of_the_way_it_goes_again() -> None:
    supervisor = Supervisor(limits=BARE, period=T)
    now = spun(supervisor, 0.3, 13.0, 60, (0.0, HOME[4]))
    now = spun(supervisor, -0.3, -13.0, 60, now)
    spun(supervisor, 0.5, 14.0, 20, now)
    assert not supervisor.tripped


@pytest.mark.parametrize("way", [-1.0, 1.0])
def test_joint_that_stands_learns_for_the_way_that_it_is_pushed(way: float) -> None:
    supervisor = Supervisor(limits=BARE, period=T)
    now = spun(supervisor, 0.0, way * 13.0, 60, (0.0, HOME[4]))
    spun(supervisor, way * 0.5, way * 14.0, 20, now)
    assert not supervisor.tripped


def test_joint_that_stands_learns_nothing_for_the_other_way() -> None:
    supervisor = Supervisor(limits=BARE, period=T)
    now = spun(supervisor, 0.0, -13.0, 60, (0.0, HOME[4]))
    spun(supervisor, 0.5, 13.0, 2, now)
    assert "joint 5 would reach" in cause_of(supervisor)
