"""Bias, dead-band, chosen axes, freshness, buttons: bounds and continuity over everything a device may say."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from burnish.errors import InputError
from burnish.teleop.device import AT_REST, Axes, Reading, six
from burnish.teleop.shaping import (
    BOUNCE,
    Memory,
    Shaping,
    dead_banded,
    deflection,
    dominant,
    freshness,
    rezeroed,
    shape,
    unbiased,
)

axis = st.floats(-1.0, 1.0)
axes = st.tuples(axis, axis, axis, axis, axis, axis)
width = st.floats(0.0, 0.5)
bias = st.floats(-0.2, 0.2)
PUSHED: Axes = (0.5, -0.5, 1.0, 0.3, -0.2, -1.0)
PLAIN = Shaping(dead_band=0.0)


def reading(t: float, axes: Axes = AT_REST, *buttons: bool, age: float = 0.0, connected: bool = True) -> Reading:
    return Reading(t=t, axes=axes, buttons=buttons, age=age, connected=connected)


def shaped(*readings: Reading, shaping: Shaping = PLAIN) -> list[Reading]:
    memory, found = Memory(), []
    for one in readings:
        meant, memory = shape(one, memory, shaping)
        found.append(meant)
    return found


# Axes.


@given(axis, width)
def test_the_dead_band_keeps_sign_and_bounds_and_gives_nothing_inside(x: float, w: float) -> None:
    y = dead_banded(x, w)
    assert abs(y) <= 1.0
    assert y * x >= 0.0
    assert (y == 0.0) == (abs(x) <= w) or abs(x) - w < 1e-15


@given(axis, axis, width)
def test_the_dead_band_has_no_step(x: float, other: float, w: float) -> None:
    # Its slope is at most 1 / (1 − w), also across the edges of the band.
    assert abs(dead_banded(x, w) - dead_banded(other, w)) <= abs(x - other) / (1.0 - w) + 1e-12


@given(width, bias)
def test_the_ends_of_an_axis_stay_its_ends(w: float, b: float) -> None:
    assert dead_banded(unbiased(1.0, b), w) == 1.0
    assert dead_banded(unbiased(-1.0, b), w) == -1.0


@given(axis, axis, bias)
def test_a_bias_is_zero_and_leaves_no_step(x: float, other: float, b: float) -> None:
    assert unbiased(b, b) == 0.0
    assert abs(unbiased(x, b)) <= 1.0
    assert abs(unbiased(x, b) - unbiased(other, b)) <= abs(x - other) / (1.0 - abs(b)) + 1e-12


@given(axes)
def test_dominant_leaves_at_most_one_axis_and_its_sign(found: Axes) -> None:
    left = dominant(found)
    moved = [i for i in range(6) if left[i]]
    assert len(moved) <= 1
    assert all(abs(found[i]) == max(map(abs, found)) and (left[i] > 0.0) == (found[i] > 0.0) for i in moved)


@given(axes, axes)
def test_dominant_has_no_step_where_axes_change_places(one: Axes, other: Axes) -> None:
    # Twice the largest change of an axis: that of the largest and that of the second.
    largest = max(abs(a - b) for a, b in zip(one, other, strict=True))
    assert all(abs(a - b) <= 2.0 * largest + 1e-12 for a, b in zip(dominant(one), dominant(other), strict=True))


def test_one_axis_alone_is_dominant_in_full() -> None:
    assert dominant((0.0, 0.0, -0.8, 0.0, 0.0, 0.0)) == (0.0, 0.0, -0.8, 0.0, 0.0, 0.0)


def test_an_axis_that_is_off_does_not_count_not_even_as_the_dominant_one() -> None:
    off = Shaping(dead_band=0.0, enabled=(True, True, False, True, True, False), dominant_only=True)
    assert deflection(PUSHED, replace(off, dominant_only=False)) == (0.5, -0.5, 0.0, 0.3, -0.2, 0.0)
    assert deflection((0.0, 0.4, 1.0, 0.0, 0.0, 0.0), off) == (0.0, 0.4, 0.0, 0.0, 0.0, 0.0)


@given(axes, width, st.booleans())
def test_whatever_a_device_says_stays_within_the_full_scale(found: Axes, w: float, one: bool) -> None:
    rest, moved = shaped(reading(0.0), reading(0.1, found), shaping=Shaping(dead_band=w, dominant_only=one))
    assert rest.axes == AT_REST
    assert all(abs(x) <= 1.0 for x in moved.axes)


def test_rezeroing_takes_drift_away_and_refuses_a_pushed_cap() -> None:
    drift = (0.1, -0.15, 0.0, 0.05, 0.0, -0.12)
    assert deflection(drift, Shaping()) != AT_REST
    assert deflection(drift, rezeroed(Shaping(), reading(0.0, drift))) == AT_REST
    with pytest.raises(InputError, match="let go of the cap"):
        rezeroed(Shaping(), reading(0.0, PUSHED))


@pytest.mark.parametrize("wrong", [{"dead_band": 0.6}, {"dead_band": -0.1}, {"dead_band": float("nan")}], ids=str)
def test_a_dead_band_that_leaves_no_range_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(InputError, match="dead-band"):
        Shaping(**wrong)  # type: ignore[arg-type]


# Freshness.


@given(st.floats(0.0, 10.0), st.floats(0.0, 10.0))
def test_freshness_falls_without_a_step_from_100_ms_to_nothing_at_200_ms(one: float, other: float) -> None:
    assert freshness(min(one, other)) >= freshness(max(one, other))
    assert abs(freshness(one) - freshness(other)) <= 10.0 * abs(one - other) + 1e-12
    assert freshness(one) == 1.0 or one > 0.1
    assert freshness(one) == 0.0 or one < 0.2


def test_a_frozen_device_ramps_to_zero_within_200_ms() -> None:
    ages = [0.0, 0.05, 0.1, 0.12, 0.15, 0.18, 0.2, 0.3]
    found = shaped(reading(0.0), *(reading(1.0 + age, PUSHED, age=age) for age in ages))[1:]
    for x, name in zip(zip(*(one.axes for one in found), strict=True), "x y z rx ry rz".split(), strict=True):
        sizes = [abs(value) for value in x]
        assert all(a >= b for a, b in pairwise(sizes)), name
        assert sizes[2] > 0.0, name
        assert sizes[6:] == [0.0, 0.0], name
    assert found[4].axes == pytest.approx(six(0.5 * value for value in PUSHED))


def test_an_unplugged_device_ends_in_the_same_ramp_with_its_buttons_released() -> None:
    held = [reading(0.01 * k, AT_REST, False) for k in range(5)]
    held += [reading(0.05 + 0.01 * k, PUSHED, True) for k in range(6)]
    gone = [reading(0.1 + age, PUSHED, False, age=age, connected=False) for age in (0.01, 0.15, 0.25)]
    *_, before, first, later, last = shaped(*held, *gone)
    assert before.buttons == (True,)
    assert [one.buttons for one in (first, later, last)] == [(False,)] * 3
    assert first.axes == PUSHED
    assert later.axes == pytest.approx(six(0.5 * value for value in PUSHED))
    assert last.axes == AT_REST


def test_a_cap_that_is_pushed_at_the_start_moves_nothing_until_it_was_at_rest() -> None:
    found = shaped(reading(0.0, PUSHED), reading(1.0, PUSHED), reading(1.1), reading(1.2, PUSHED))
    assert [one.axes for one in found] == [AT_REST, AT_REST, AT_REST, PUSHED]


def test_a_device_that_came_back_moves_nothing_until_it_was_at_rest() -> None:
    gone = reading(0.2, PUSHED, age=0.02, connected=False)
    found = shaped(reading(0.0), reading(0.1, PUSHED), gone, reading(0.3, PUSHED), reading(0.4), reading(0.5, PUSHED))
    assert [one.axes for one in found][1:] == [PUSHED, PUSHED, AT_REST, AT_REST, PUSHED]


# Buttons.


def presses(pulses: list[tuple[float, bool]], step: float = 0.001) -> list[tuple[float, bool]]:
    """A button whose raw state is as in (duration, raw), sampled every ``step``: its time and what it counts as."""
    t, readings = 0.0, []
    for duration, raw in pulses:
        for _ in range(round(duration / step)):
            readings.append(reading(t, AT_REST, raw))
            t += step
    return [(one.t, one.buttons[0]) for one in shaped(*readings)]


def test_a_button_counts_30_ms_after_it_went_down_and_after_it_came_up() -> None:
    found = presses([(0.1, False), (0.1, True), (0.1, False)])
    down = next(t for t, pressed in found if pressed)
    up = next(t for t, pressed in found if t > down and not pressed)
    assert down == pytest.approx(0.1 + BOUNCE, abs=0.0015)
    assert up == pytest.approx(0.2 + BOUNCE, abs=0.0015)


def test_a_button_held_at_the_start_does_nothing_until_it_was_released() -> None:
    found = presses([(2.0, True), (0.05, False), (0.05, True)])
    assert not any(pressed for t, pressed in found if t < 2.05)
    assert found[-1][1]


@given(st.lists(st.integers(1, 29), max_size=30))
@settings(max_examples=25)
def test_pulses_under_30_ms_never_press_a_released_button(pulses: list[int]) -> None:
    alternating = [(0.001 * length, k % 2 == 0) for k, length in enumerate(pulses)]
    found = presses([(0.05, False), *alternating, (0.02, False)])
    assert not any(pressed for _, pressed in found)


@given(st.lists(st.integers(1, 29), max_size=30))
@settings(max_examples=25)
def test_pulses_under_30_ms_never_release_a_pressed_button(pulses: list[int]) -> None:
    alternating = [(0.001 * length, k % 2 == 1) for k, length in enumerate(pulses)]
    found = presses([(0.05, False), (0.05, True), *alternating, (0.02, True)])
    assert all(pressed for t, pressed in found if t >= 0.085)


@given(st.lists(st.tuples(st.floats(0.0, 0.2), st.lists(st.booleans(), max_size=4), st.booleans()), max_size=40))
def test_no_button_counts_that_was_not_seen_released_since_the_device_came(
    steps: list[tuple[float, list[bool], bool]],
) -> None:
    t, memory, released = 0.0, Memory(), [False] * 4
    for pause, raw, connected in steps:
        t += pause
        meant, memory = shape(reading(t, AT_REST, *raw, connected=connected), memory, PLAIN)
        states = [*raw, *[False] * (4 - len(raw))]
        released = [(was or not state) and connected for was, state in zip(released, states, strict=True)]
        assert all(released[i] for i, pressed in enumerate(meant.buttons) if pressed)
        assert connected or not any(meant.buttons)


def test_buttons_that_appear_later_are_not_pressed_either() -> None:
    found = shaped(reading(0.0), *(reading(0.1 * k, AT_REST, True) for k in range(1, 5)))
    assert [one.buttons for one in found[1:]] == [(False,)] * 4
