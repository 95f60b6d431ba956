from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pytest

from burnish.core import Array
from burnish.errors import InputError
from burnish.model.velocity import MultiTurn, Reading, VelocityFromPositions, VelocityFromWrappedPositions

RESOLUTION = 2 * np.pi / np.array([3_686_400, 2_534_400])
"""Counts a turn of the JACO2's large and small actuators behind their gears."""
PERIOD = 0.01


class Read(NamedTuple):
    t: float
    q: Array
    dq: Array
    """The true velocity at t."""
    fresh: bool


def sine(t: float) -> tuple[Array, Array]:
    """Two joints that swing by 20° in 8 s and 45° in 10 s, as thesis A and B have them."""
    amplitude, rate = np.deg2rad([20.0, 45.0]), 2 * np.pi / np.array([8.0, 10.0])
    return 3.0 + amplitude * np.sin(rate * t), amplitude * rate * np.cos(rate * t)


def counted(q: Array) -> Array:
    """What encoders of finite resolution show."""
    return np.asarray(np.round(q / RESOLUTION) * RESOLUTION)


def dropping(seconds: float, fresh_hz: float, jitter: float, seed: int = 1) -> Iterator[Read]:
    """Readings at 100 Hz of which only ``fresh_hz`` a second are new; the others repeat the last one."""
    random = np.random.default_rng(seed)
    shown = counted(sine(0.0)[0])
    for k in range(1, int(seconds / PERIOD)):
        t = k * PERIOD + random.uniform(-jitter, jitter)
        q, dq = sine(t)
        fresh = random.random() < fresh_hz * PERIOD
        shown = counted(q) if fresh else shown
        yield Read(t, shown, dq, fresh)


def estimator(window: float = 0.015, patience: float = 0.1) -> VelocityFromPositions:
    made = VelocityFromPositions(resolution=RESOLUTION, window=window, patience=patience)
    made.reset(0.0, counted(sine(0.0)[0]))
    return made


def errors_of(made: VelocityFromPositions, reads: Iterator[Read], skip: int = 10) -> Array:
    """Error of each estimate but the first few, (readings, 2) [rad/s]."""
    return np.array([made.update(read.t, read.q).dq - read.dq for read in reads])[skip:]


@pytest.mark.parametrize("fresh_hz", [100, 60, 50])
@pytest.mark.parametrize("jitter", [0.0, 0.003])
def test_velocity_is_right_to_a_few_percent_at_100_hz_with_drop_outs_and_jitter(fresh_hz: int, jitter: float) -> None:
    error = errors_of(estimator(), dropping(20.0, fresh_hz, jitter))
    # The lag of half a window, and up to ten periods of drop-out, times the largest acceleration, 0.31 rad/s².
    assert np.abs(error).max() < 0.31 * (0.015 + (0.02 if fresh_hz == 100 else 0.1))
    assert np.sqrt(np.mean(error**2)) < 0.02 * 0.49  # of the largest speed


def test_equations_of_thesis_a_are_off_by_as_much_as_the_speed_where_these_are_not() -> None:
    reads = list(dropping(20.0, 55, 0.0))
    before, held, plain, holding = reads[0].q, np.zeros(2), [], []
    for read in reads[1:]:
        difference = (read.q - before) / PERIOD  # eq 3.15
        plain.append(difference - read.dq)
        held = np.where(np.abs(difference) > 1e-9, difference, held)  # eq 3.16
        holding.append(held - read.dq)
        before = read.q
    ours = errors_of(estimator(), iter(reads))
    assert np.abs(plain).max() > 0.4
    assert np.abs(holding).max() > 0.4
    rms = [float(np.sqrt(np.mean(np.square(error)))) for error in (plain, holding, ours)]
    assert rms[2] < 0.1 * min(rms[:2])


def test_device_that_refreshes_on_a_clock_of_its_own_costs_a_sixth_of_the_speed() -> None:
    made, errors = estimator(), []
    for k in range(1, 2000):
        t = k * PERIOD
        shown = counted(sine(np.floor(t * 55.0) / 55.0)[0])  # refreshed at 55 Hz, and it does not tell when
        errors.append(made.update(t, shown).dq - sine(t)[1])
    assert np.abs(errors[10:]).max() < 0.18 * 0.49
    assert np.sqrt(np.mean(np.square(errors[10:]))) < 0.07 * 0.49


def test_stale_reading_is_told_from_a_standstill() -> None:
    made, speed = estimator(), np.array([0.3, -0.2])
    q = counted(sine(0.0)[0])
    for k in range(1, 20):
        q = counted(sine(0.0)[0] + speed * k * PERIOD)
        assert made.update(k * PERIOD, q).reading is Reading.FRESH
    stale = [made.update((19 + k) * PERIOD, q) for k in range(1, 10)]
    assert all(velocity.reading is Reading.STALE for velocity in stale)
    for velocity in stale:
        np.testing.assert_allclose(velocity.dq, speed, rtol=1e-3)
    standing = [made.update((29 + k) * PERIOD, q) for k in range(1, 12)]
    assert all(velocity.reading is Reading.STILL for velocity in standing)
    np.testing.assert_array_equal(standing[-1].dq, np.zeros(2))


def test_velocity_fades_to_zero_without_a_jump() -> None:
    made = estimator()
    for k in range(1, 20):
        q = counted(sine(0.0)[0] + 0.3 * k * PERIOD)
        made.update(k * PERIOD, q)
    fading = np.array([made.update(0.19 + 0.001 * k, q).dq[0] for k in range(1, 220)])
    assert (np.diff(fading) <= 1e-12).all()
    assert np.abs(np.diff(fading)).max() < 0.3 / 100 * 1.01  # patience is 100 of these steps
    assert fading[-1] == 0.0


def test_standing_arm_has_velocity_zero_from_the_first_reading_on() -> None:
    made = estimator()
    for k in range(1, 100):
        velocity = made.update(k * PERIOD, counted(sine(0.0)[0]))
        assert velocity.reading is Reading.STILL
        assert not velocity.dq.any()


def test_joint_that_stands_while_another_moves_is_seen_to_stand_at_once() -> None:
    made, q = estimator(), counted(sine(0.0)[0])
    for k in range(1, 10):
        made.update(k * PERIOD, q + 0.3 * k * PERIOD)
    stopped = q + 0.3 * 9 * PERIOD
    for k in range(10, 13):
        velocity = made.update(k * PERIOD, stopped + (0.3 * (k - 9) * PERIOD, 0.0))
        assert velocity.reading is Reading.FRESH
    np.testing.assert_allclose(velocity.dq, [0.3, 0.0], atol=1e-3)


def test_first_move_after_a_long_rest_is_not_divided_by_the_rest() -> None:
    made, q = estimator(), counted(sine(0.0)[0])
    for k in range(1, 500):
        made.update(k * PERIOD, q)
    velocity = made.update(500 * PERIOD, q + 0.2 * PERIOD)
    np.testing.assert_allclose(velocity.dq, [0.2, 0.2], rtol=1e-3)


def test_creeping_below_the_resolution_is_seen_as_creeping_or_standing_never_as_fast() -> None:
    made, speed = estimator(), RESOLUTION / 0.035  # a step every 3.5 periods
    estimates = np.array(
        [made.update(k * PERIOD, counted(sine(0.0)[0] + speed * k * PERIOD)).dq for k in range(1, 500)]
    )
    assert np.abs(estimates).max() <= 1.01 * RESOLUTION.max() / PERIOD
    assert np.abs(estimates[100:].mean(axis=0) / speed - 1).max() < 0.5


def test_time_that_stands_still_or_runs_backwards_changes_nothing() -> None:
    made, q = estimator(), counted(sine(0.0)[0])
    before = [made.update(k * PERIOD, q + 0.3 * k * PERIOD) for k in range(1, 10)][-1]
    for t in (0.09, 0.05, -1.0):
        velocity = made.update(t, q + 5.0)
        assert velocity.reading is Reading.STALE
        np.testing.assert_array_equal(velocity.dq, before.dq)


def test_late_reading_and_its_successor_right_behind_make_no_spike() -> None:
    made, q = estimator(), counted(sine(0.0)[0])
    for k in range(1, 10):
        made.update(k * PERIOD, q + 0.3 * k * PERIOD)
    late = made.update(0.1099, q + 0.3 * 0.10)
    behind = made.update(0.1100, q + 0.3 * 0.11)
    after = made.update(0.12, q + 0.3 * 0.12)
    for velocity in (late, behind, after):
        np.testing.assert_allclose(velocity.dq, [0.3, 0.3], rtol=0.55)  # a time stamp is off by a whole period
    assert behind.reading is Reading.STALE


def test_readings_that_wrap_give_the_same_velocity_as_multi_turn_ones() -> None:
    plain = estimator()
    wrapped = VelocityFromWrappedPositions(positions=VelocityFromPositions(resolution=RESOLUTION))
    q0 = counted(sine(0.0)[0])
    wrapped.reset(0.0, (q0 + np.pi) % (2 * np.pi) - np.pi)
    for k in range(1, 3000):
        q = q0 + counted(np.array([0.6, -0.8]) * k * PERIOD)  # three turns and more
        velocity = wrapped.update(k * PERIOD, (q + np.pi) % (2 * np.pi) - np.pi)
        np.testing.assert_allclose(velocity.dq, plain.update(k * PERIOD, q).dq, atol=1e-9)


def test_multi_turn_counts_turns_in_both_directions() -> None:
    turns, path = MultiTurn(), np.array([np.linspace(0, 40, 500), np.linspace(0, -33, 500)]).T
    turns.reset(path[0])
    for q in path[1:]:
        np.testing.assert_allclose(turns.update((q + np.pi) % (2 * np.pi) - np.pi), q, atol=1e-9)


def test_estimators_do_not_share_what_they_remember() -> None:
    one, other = estimator(), estimator()
    one.update(0.01, counted(sine(0.0)[0]) + 0.1)
    assert not other.update(0.01, counted(sine(0.0)[0])).dq.any()


@pytest.mark.parametrize(
    "change", [{"resolution": np.zeros(2)}, {"resolution": np.ones((2, 2))}, {"window": 0.0}, {"patience": np.inf}]
)
def test_settings_without_sense_are_refused(change: dict[str, object]) -> None:
    with pytest.raises(InputError, match="VelocityFromPositions"):
        VelocityFromPositions(**{"resolution": RESOLUTION, **change})  # type: ignore[arg-type]


def test_start_with_another_arm_or_without_numbers_is_refused() -> None:
    for t, q in ((0.0, np.zeros(3)), (0.0, np.array([0.0, np.nan])), (np.inf, np.zeros(2))):
        with pytest.raises(InputError, match="2 joints"):
            VelocityFromPositions(resolution=RESOLUTION).reset(t, q)
