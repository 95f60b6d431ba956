"""The smooth motion after a hand: whatever is asked, it stays finite and within its bounds."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from ruckig import RuckigError, Synchronization

from burnish.core import Array
from burnish.teleop.smooth import EASED, Moved, Smooth

ACCELERATION = np.array([2.0] * 3 + [8.0] * 3 + [10.0])
JERK = np.array([40.0] * 3 + [160.0] * 3 + [200.0])
N = len(JERK)


def smooth() -> Smooth:
    return Smooth(ACCELERATION.tolist(), JERK.tolist())


def rough_target(rng: np.random.Generator, before: Array) -> Array:
    """Now and then another: large, small, none, or the same on all axes, which is where phases are alike."""
    if rng.random() > 0.3:
        return before
    size = rng.choice([1.0, 0.1, 1e-3, 0.0])
    target = rng.uniform(-1.0, 1.0, N)
    return np.asarray(size * (np.sign(target) if rng.random() < 0.2 else target))


@pytest.mark.parametrize("seed", range(30))
def test_no_order_of_targets_shares_and_steps_leaves_the_bounds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    motion, target = smooth(), np.zeros(N)
    for _ in range(300):
        target = rough_target(rng, target)
        if rng.random() < 0.05:
            motion.go_on_with(motion.v * rng.uniform(-1.0, 1.0, N), motion.a * rng.uniform(-2.0, 2.0, N))
        v, a = motion.v, motion.a
        dt = float(rng.choice([0.0, 1e-9, 0.002, 0.01, 0.012, 0.05, 0.5]))
        # Many of these are below what the axes are accelerated with.
        moved = motion.step(target, dt, float(rng.choice([1.0, 0.5, 0.1, 0.01, 0.0, rng.random()])))
        assert np.isfinite(np.concatenate(moved)).all()
        assert (np.abs(moved.a) <= np.maximum(ACCELERATION, np.abs(a)) + 1e-12).all()
        assert (np.abs(moved.a - a) <= JERK * dt + 1e-12).all()
        assert (np.abs(moved.v - v) <= np.maximum(np.abs(a), ACCELERATION) * dt + 1e-12).all()
        assert (np.abs(moved.way) <= (np.maximum(np.abs(v), np.abs(moved.v)) + JERK * dt * dt / 8.0) * dt + 1e-12).all()


@pytest.mark.parametrize("share", [0.5, 0.1, EASED, 0.0])
def test_a_share_below_the_acceleration_there_is_takes_it_back_by_the_jerk_all_axes_in_proportion(share: float) -> None:
    motion, target = smooth(), np.linspace(-1.0, 1.0, N)
    for _ in range(3):
        motion.step(target, 0.01)
    before = motion.a
    moved = motion.step(target, 0.005, share)
    least = max(share, EASED) * ACCELERATION
    # Some axis changes as fast as it may, or all are where the share wants them.
    change = np.abs(moved.a - before) / (JERK * 0.005)
    assert change.max() == pytest.approx(1.0) or (np.abs(moved.a) <= least + 1e-12).all()
    nonzero = before != 0.0
    assert np.ptp(moved.a[nonzero] / before[nonzero]) < 1e-9
    # The trapezium rule is exact for a straight line.
    assert_allclose(moved.v - motion_v(before, target), 0.5 * (before + moved.a) * 0.005, atol=1e-9)
    for _ in range(5):
        moved = motion.step(target, 0.01, share)
    assert (np.abs(moved.a) <= least + 1e-9).all()


def motion_v(a: Array, target: Array) -> Array:
    """The velocity of the motion above before its share fell."""
    motion = smooth()
    for _ in range(3):
        motion.step(target, 0.01)
    assert_allclose(motion.a, a)
    return motion.v


def test_steps_of_any_length_come_to_the_same_place() -> None:
    target, ends = np.linspace(-0.2, 0.2, N), []
    for parts in (1, 7, 50):
        motion, way = smooth(), np.zeros(N)
        for _ in range(parts):
            way = way + motion.step(target, 0.5 / parts).way
        ends.append(np.concatenate([way, motion.v, motion.a]))
    assert_allclose(ends, [ends[0]] * 3, atol=1e-9)
    assert_allclose(motion.v, target, atol=1e-9)


@pytest.mark.parametrize("target", [np.nan, np.inf, 1e300, 1e6])
@pytest.mark.parametrize("dt", [0.01, np.nan, np.inf, 1e9, -1.0])
@pytest.mark.parametrize("ease", [1.0, np.nan, np.inf, -1.0])
def test_what_is_no_number_or_out_of_all_range_does_not_stop_the_motion(target: float, dt: float, ease: float) -> None:
    motion = smooth()
    motion.step(np.ones(N), 0.01)
    moved = motion.step(np.full(N, target), dt, ease)
    assert np.isfinite(np.concatenate(moved)).all()
    for _ in range(400):
        moved = motion.step(np.zeros(N), 0.05)
    assert_allclose(moved.v, 0.0, atol=1e-9)


class Refusing:
    """A generator that finds no common duration, as ruckig does about once in 10⁵ new profiles."""

    def __init__(self, motion: Smooth) -> None:
        self._real = motion._generator
        self.delta_time = 0.0

    def update(self, given: object, out: object) -> None:
        if given.synchronization is Synchronization.Phase:  # type: ignore[attr-defined]
            raise RuckigError("error in step 2")
        self._real.delta_time = self.delta_time
        self._real.update(given, out)  # type: ignore[arg-type]


def test_axes_without_a_common_duration_come_to_rest_each_by_itself_within_the_same_bounds() -> None:
    motion = smooth()
    motion._generator = Refusing(motion)  # type: ignore[assignment]
    moved, rows = motion.step(np.ones(N), 0.0), list[Moved]()
    for k in range(200):
        rows.append(moved := motion.step(np.ones(N) if k < 50 else np.zeros(N), 0.01))
    a = np.array([row.a for row in rows])
    # The slow ones are still on their way.
    assert_allclose(rows[49].v[3:], 1.0, atol=1e-9)
    assert (rows[49].v[:3] > 0.8).all()
    assert (np.abs(a) <= ACCELERATION + 1e-12).all()
    assert (np.abs(np.diff(a, axis=0)) <= JERK * 0.01 + 1e-12).all()
    assert_allclose(moved.v, 0.0, atol=1e-12)
