"""Every state with every event: the table is the specification, and all that is not in it changes nothing."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from math import inf, nan, radians

import numpy as np
import pytest

from burnish.core import Array
from burnish.errors import InputError
from burnish.runtime.machine import Cause, Event, Machine, Mode

STILL = np.zeros(6)
EVENT = Event(t=0.0, cause="shown")


def at(mode: Mode, start: Mode = Mode.IDLE, event: Event | None = None) -> Machine:
    machine = Machine(start=start)
    machine.mode, machine.event = mode, event
    if mode in (Mode.HOLD, Mode.FAULT):
        machine.event = event or EVENT
    return machine


def clear_for_a_second(machine: Machine) -> None:
    machine.note(10.0, STILL, None, True)
    machine.note(11.0, STILL, None, True)
    machine.acknowledge()


EVENTS: dict[str, Callable[[Machine], object]] = {
    "connected": Machine.connected,
    "arming": Machine.arming,
    "armed": Machine.armed,
    "in position": Machine.in_position,
    "cause": lambda machine: machine.note(1.0, STILL, Cause("found"), True),
    "fault": lambda machine: machine.note(1.0, STILL, Cause("found", fault=True), True),
    "acknowledged": clear_for_a_second,
    "reset": lambda machine: machine.reset(EVENT),
}
TABLE = {
    (Mode.IDLE, "connected"): Mode.POSITION,
    (Mode.POSITION, "arming"): Mode.ARMING,
    (Mode.ARMING, "armed"): Mode.TORQUE,
    (Mode.ARMING, "in position"): Mode.POSITION,
    (Mode.TORQUE, "in position"): Mode.POSITION,
    (Mode.HOLD, "in position"): Mode.POSITION,
    (Mode.ARMING, "cause"): Mode.HOLD,
    (Mode.TORQUE, "cause"): Mode.HOLD,
    (Mode.HOLD, "acknowledged"): Mode.TORQUE,
    (Mode.FAULT, "reset"): Mode.IDLE,
} | {(mode, "fault"): Mode.FAULT for mode in Mode}


@pytest.mark.parametrize(("mode", "event"), list(product(Mode, EVENTS)), ids=lambda v: getattr(v, "value", v))
def test_transition_is_that_of_the_table(mode: Mode, event: str) -> None:
    machine = at(mode)
    EVENTS[event](machine)
    assert machine.mode is TABLE.get((mode, event), mode)


@pytest.mark.parametrize("start", [Mode.IDLE, Mode.TORQUE])
def test_machine_begins_where_it_is_told_and_comes_back_there(start: Mode) -> None:
    machine = Machine(start=start)
    assert machine.mode is start
    machine.note(0.0, STILL, Cause("found", fault=True), True)
    assert machine.event is not None
    machine.reset(machine.event)
    assert machine.mode is start
    assert not machine.tripped


def test_machine_takes_torques_at_once_unless_told_otherwise() -> None:
    assert Machine().mode is Mode.TORQUE


@pytest.mark.parametrize("start", [Mode.POSITION, Mode.ARMING, Mode.HOLD, Mode.FAULT])
def test_machine_begins_nowhere_else(start: Mode) -> None:
    with pytest.raises(InputError, match=r"expected Mode\.TORQUE"):
        Machine(start=start)


# Stops.


def test_event_says_when_and_why() -> None:
    machine = at(Mode.TORQUE)
    assert machine.note(3.0, STILL, Cause("found"), True) is True
    assert machine.event == Event(t=3.0, cause="found", fault=False)
    assert machine.tripped


def test_second_cause_of_a_hold_does_not_hide_the_first() -> None:
    machine = at(Mode.TORQUE)
    machine.note(3.0, STILL, Cause("first"), True)
    assert machine.note(4.0, STILL, Cause("second"), True) is False
    assert machine.event == Event(t=3.0, cause="first")


def test_fault_in_a_hold_is_shown_instead_of_its_cause() -> None:
    machine = at(Mode.HOLD)
    assert machine.note(4.0, STILL, Cause("worse", fault=True), True) is False
    assert machine.event == Event(t=4.0, cause="worse", fault=True)


def test_second_fault_does_not_hide_the_first() -> None:
    machine = at(Mode.FAULT)
    machine.note(4.0, STILL, Cause("other", fault=True), True)
    assert machine.event is EVENT


def test_cycle_without_a_cause_stops_nothing() -> None:
    machine = at(Mode.TORQUE)
    assert machine.note(3.0, STILL, None, True) is False
    assert machine.mode is Mode.TORQUE
    assert not machine.tripped


@pytest.mark.parametrize(("times", "mode"), [((0.0, 30.0, 59.9), Mode.FAULT), ((0.0, 30.0, 60.0), Mode.HOLD)])
def test_third_hold_within_a_minute_is_a_fault(times: tuple[float, ...], mode: Mode) -> None:
    machine = Machine()
    for t in times:
        machine.mode, machine.event = Mode.TORQUE, None
        machine.note(t, STILL, Cause("found"), True)
    assert machine.mode is mode
    assert machine.event is not None
    assert machine.event.fault is (mode is Mode.FAULT)


def test_holds_before_a_reset_are_forgotten() -> None:
    machine = Machine()
    machine.note(0.0, STILL, Cause("found"), True)
    machine.mode = Mode.TORQUE
    machine.note(1.0, STILL, Cause("found", fault=True), True)
    assert machine.event is not None
    machine.reset(machine.event)
    machine.note(2.0, STILL, Cause("found"), True)
    assert machine.mode is Mode.HOLD


# Ways out.


@pytest.mark.parametrize("mode", [Mode.IDLE, Mode.ARMING, Mode.TORQUE, Mode.HOLD, Mode.FAULT])
def test_arming_says_what_state_it_wants(mode: Mode) -> None:
    refused = at(mode).arming()
    assert refused == f"the arm is in the state {mode.value}; torque mode is entered from position mode"


def test_arm_that_was_stopped_is_not_armed_before_somebody_has_seen_why() -> None:
    machine = at(Mode.POSITION, event=EVENT)
    assert machine.arming() == "the arm was stopped: shown; acknowledge that first"
    assert machine.mode is Mode.POSITION
    clear_for_a_second(machine)
    assert machine.arming() is None


@pytest.mark.parametrize("mode", [Mode.HOLD, Mode.POSITION])
@pytest.mark.parametrize(("seconds", "free"), [(0.99, False), (1.0, True)])
def test_cause_has_to_be_gone_for_a_second(mode: Mode, seconds: float, free: bool) -> None:
    machine = at(mode, event=EVENT)
    machine.note(5.0, STILL, Cause("again"), True)
    machine.note(6.0, STILL, None, True)
    machine.note(6.5, STILL, None, True)
    machine.note(6.0 + seconds, STILL, None, True)
    refused = machine.acknowledge()
    assert refused == (None if free else "the cause has not been clear for 1 s")
    assert machine.tripped is not free


def test_cause_that_comes_back_begins_the_second_anew() -> None:
    machine = at(Mode.HOLD)
    for t, cause in ((0.0, None), (0.9, Cause("again")), (1.0, None), (1.9, None)):
        machine.note(t, STILL, cause, True)
    assert machine.acknowledge() is not None


def test_acknowledging_what_is_none_changes_nothing() -> None:
    machine = at(Mode.TORQUE)
    assert machine.acknowledge() is None
    assert machine.mode is Mode.TORQUE


def test_fault_cannot_be_acknowledged() -> None:
    machine = at(Mode.FAULT)
    assert machine.acknowledge() == "this is a fault: read its cause and reset"
    assert machine.tripped


def test_hold_cannot_be_reset() -> None:
    machine = at(Mode.HOLD)
    machine.reset(EVENT)
    assert machine.mode is Mode.HOLD


def test_reset_wants_the_very_event() -> None:
    machine = at(Mode.FAULT)
    machine.reset(Event(t=0.0, cause="shown"))
    assert machine.mode is Mode.FAULT


# Leaving the arm to its position mode.

SLOW, FAST = np.full(6, radians(0.99)), np.array([0.0, 0.0, 0.0, 0.0, 0.0, -radians(1.0)])


@pytest.mark.parametrize("mode", [Mode.HOLD, Mode.FAULT])
@pytest.mark.parametrize(
    ("cycles", "leaves"),
    [
        ([(0.0, SLOW), (0.2, SLOW)], True),
        ([(0.0, SLOW), (0.1, SLOW), (0.19, SLOW)], False),
        ([(0.0, SLOW), (0.1, FAST), (0.2, SLOW), (0.3, SLOW)], False),
        ([(0.0, SLOW), (0.1, FAST), (0.2, SLOW), (0.4, SLOW)], True),
        ([(0.0, FAST), (1.0, FAST)], False),
        ([(0.0, SLOW), (0.3, FAST)], False),
    ],
)
def test_held_arm_is_left_once_it_has_stood_for_a_fifth_of_a_second(
    mode: Mode, cycles: list[tuple[float, Array]], leaves: bool
) -> None:
    machine = at(mode)
    for t, dq in cycles:
        machine.note(t, dq, None, True)
    assert machine.leaves_torque is leaves


def test_standing_before_a_stop_does_not_count() -> None:
    machine = at(Mode.ARMING)
    machine.note(0.0, STILL, None, True)
    machine.note(1.0, STILL, Cause("found"), True)
    machine.note(1.1, STILL, None, True)
    assert not machine.leaves_torque
    machine.note(1.35, STILL, None, True)
    assert machine.leaves_torque


@pytest.mark.parametrize("mode", [Mode.IDLE, Mode.POSITION, Mode.ARMING, Mode.TORQUE])
def test_arm_that_is_not_held_is_not_left(mode: Mode) -> None:
    machine = at(mode)
    for k in range(9):
        machine.note(0.1 * k, STILL, None, True)
    assert not machine.leaves_torque


def test_arm_that_nobody_sees_for_three_cycles_is_left_at_once() -> None:
    machine = at(Mode.HOLD)
    leaves = []
    for k, seen in enumerate([False, False, True, False, False, False]):
        machine.note(0.01 * k, STILL, None, seen)
        leaves.append(machine.leaves_torque)
    assert leaves == [False] * 5 + [True]


def test_arm_that_nobody_sees_does_not_stand() -> None:
    machine = at(Mode.HOLD)
    machine.note(0.0, STILL, None, True)
    machine.note(0.1, STILL, None, False)
    machine.note(0.3, STILL, None, True)
    assert not machine.leaves_torque


def test_new_life_after_a_fault_has_seen_nothing() -> None:
    machine = at(Mode.FAULT)
    for k in range(3):
        machine.note(float(k), STILL, None, False)
    machine.reset(EVENT)
    machine.mode, machine.event = Mode.HOLD, EVENT
    assert not machine.leaves_torque
    machine.note(9.0, STILL, None, True)
    assert machine.acknowledge() is not None
    assert not machine.leaves_torque


@pytest.mark.parametrize("t", [nan, inf, -inf, 0.5])
def test_clock_that_goes_wrong_does_not_turn_time_back_or_on(t: float) -> None:
    machine = at(Mode.HOLD)
    machine.note(1.0, STILL, None, True)
    machine.note(t, STILL, None, True)
    assert not machine.leaves_torque
    machine.note(1.25, STILL, None, True)
    assert machine.leaves_torque
