from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.control.integral import Integral


def test_integral_is_gain_times_error_times_time_however_it_is_cut() -> None:
    integral = Integral(np.array([2.0, 3.0]), 10.0)
    integral.reset(1.0, 2)
    for t in (1.1, 1.15, 1.5):
        value = integral.add(np.array([1.0, -1.0]), t)
    assert_allclose(value, [2.0 * 0.5, -3.0 * 0.5])


def test_integral_at_its_bound_leaves_it_at_once_when_the_error_turns() -> None:
    integral = Integral(np.array(1.0), 0.5)
    integral.reset(0.0, 1)
    for i in range(100):
        integral.add(np.array([1.0]), 0.1 * i)
    assert_allclose(integral.add(np.array([-1.0]), 10.0), [0.5 - 0.1])


def test_error_beyond_the_window_is_not_gathered_and_a_small_one_nearly_whole() -> None:
    integral = Integral(np.array(1.0), 9.0, window=0.1)
    integral.reset(0.0, 2)
    assert_allclose(integral.add(np.array([0.11, 0.01]), 1.0), [0.0, 0.01 * 0.99])


def test_share_that_is_gathered_falls_without_a_jump() -> None:
    rates = []
    for e in np.linspace(0.0, 0.2, 2001):
        integral = Integral(np.array(1.0), 9.0, window=0.1)
        integral.reset(0.0, 1)
        rates.append(float(integral.add(np.array([e]), 1.0)[0]))
    assert np.abs(np.diff(rates)).max() < 3e-4  # steps of 1e-4, slope at most 2


def test_reset_forgets_and_restarts_the_clock() -> None:
    integral = Integral(np.array(1.0), 9.0)
    integral.reset(0.0, 1)
    integral.add(np.array([1.0]), 5.0)
    integral.reset(7.0, 1)
    assert_allclose(integral.add(np.array([1.0]), 7.5), [0.5])


def test_integral_without_a_gain_stays_zero() -> None:
    integral = Integral(np.zeros(3), 9.0)
    integral.reset(0.0, 3)
    assert not integral.active
    assert integral.add(np.ones(3), 1.0) == pytest.approx(np.zeros(3))
