from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.core import Dynamics, State
from burnish.errors import InputError
from burnish.model.model import Model
from burnish.trajectory import Sine

HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
ARM = Model.jaco2().at(State(t=3.5, q=HOME, dq=np.zeros(6)))
AMPLITUDE = np.deg2rad([20.0, 15.0, 10.0, 5.0, -5.0, 0.0])


def after(t: float) -> Dynamics:
    return replace(ARM, t=3.5 + t)


@pytest.fixture
def sine() -> Sine:
    source = Sine(amplitude=AMPLITUDE, period=8.0)
    source.reset(ARM)
    return source


@pytest.mark.parametrize("t", [0.0, 4.0, 8.0, 80.0])
def test_sine_passes_its_start_twice_a_period(sine: Sine, t: float) -> None:
    assert_allclose(sine.at(after(t)).q, HOME, atol=1e-13)


def test_sine_reaches_its_amplitude_after_a_quarter_and_stands(sine: Sine) -> None:
    wanted = sine.at(after(2.0))
    assert_allclose(wanted.q, HOME + AMPLITUDE, atol=1e-14)
    assert_allclose(wanted.dq, np.zeros(6), atol=1e-14)


def test_sine_is_a_harmonic_motion(sine: Sine) -> None:
    # q̈ = −ω² (q − q₀), and the energy ω² x² + ẋ² is that of the amplitude.
    w = 2.0 * np.pi / 8.0
    for t in np.linspace(0.0, 8.0, 17):
        wanted = sine.at(after(t))
        x = wanted.q - HOME
        assert_allclose(wanted.ddq, -(w**2) * x, atol=1e-14)
        assert_allclose(w**2 * x**2 + wanted.dq**2, w**2 * AMPLITUDE**2, atol=1e-14)


def test_one_amplitude_is_that_of_all_joints() -> None:
    source = Sine(amplitude=0.1, period=4.0)
    source.reset(ARM)
    assert_allclose(source.at(after(1.0)).q, HOME + 0.1, atol=1e-14)


@pytest.mark.parametrize(
    ("amplitude", "period"), [(0.1, 0.0), (0.1, -1.0), (0.1, np.nan), (np.inf, 1.0), (0.1, np.inf)]
)
def test_sine_without_amplitude_or_period_is_refused(amplitude: float, period: float) -> None:
    with pytest.raises(InputError, match="Sine"):
        Sine(amplitude=amplitude, period=period)
