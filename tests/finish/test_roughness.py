"""Roughness by the exponential approach to what a grit leaves, and the interval around it."""

from __future__ import annotations

import numpy as np
import pytest

from burnish.errors import InputError
from burnish.finish.roughness import Grit, Guess, approach

SURE = Grit(asymptote=Guess(value=0.2e-6, factor=1.0), depth=Guess(value=2e-6, factor=1.0), preston=1.0)
BEFORE = Guess(value=1.6e-6, factor=1.0)


def test_nothing_removed_leaves_the_roughness_as_it_was() -> None:
    found = SURE.after(BEFORE, 0.0)
    assert (found.low, found.value, found.high) == pytest.approx((1.6e-6,) * 3)


def test_much_removed_leaves_the_roughness_of_the_grit() -> None:
    assert SURE.after(BEFORE, 1e-3).value == pytest.approx(0.2e-6)


def test_roughness_falls_as_the_differential_law_says() -> None:
    h = np.linspace(0.0, 6e-6, 400)
    ra = approach(1.6e-6, 0.2e-6, h, 2e-6)
    np.testing.assert_allclose(np.gradient(ra, h)[1:-1], -(ra - 0.2e-6)[1:-1] / 2e-6, rtol=1e-3)


def test_coarse_grit_spoils_a_fine_surface() -> None:
    assert SURE.after(Guess(value=0.05e-6, factor=1.0), 1e-6).value > 0.05e-6


def test_interval_is_that_of_a_log_normal_where_only_one_constant_is_unknown() -> None:
    found = SURE.after(Guess(value=1.6e-6, factor=1.5), 0.0)
    # 1.96 standard deviations of the logarithm; the ends of 4096 draws stand within about 2.5 %.
    assert found.low == pytest.approx(1.6e-6 / 1.5**1.96, rel=0.025)
    assert found.high == pytest.approx(1.6e-6 * 1.5**1.96, rel=0.025)


def test_interval_for_small_doubt_is_that_of_linear_propagation() -> None:
    grit = Grit(asymptote=Guess(value=0.2e-6, factor=1.02), depth=Guess(value=2e-6, factor=1.03), preston=1.04)
    found = grit.after(Guess(value=1.6e-6, factor=1.01), 2e-6)
    e, fall = np.exp(-1.0), 1.4e-6 * np.exp(-1.0)
    parts = [
        1.6e-6 * e * np.log(1.01), 0.2e-6 * (1 - e) * np.log(1.02), fall * np.log(1.03), fall * np.log(1.04)
    ]  # fmt: skip
    assert 0.5 * (found.high - found.low) == pytest.approx(1.96 * np.linalg.norm(parts), rel=0.05)


def test_unknown_preston_coefficient_widens_the_interval_most_in_the_middle() -> None:
    grit = Grit(asymptote=SURE.asymptote, depth=SURE.depth, preston=2.0)
    widths = [grit.after(BEFORE, h).high - grit.after(BEFORE, h).low for h in (0.0, 2e-6, 200e-6)]
    assert widths[1] > 0.5e-6
    assert widths[0] == pytest.approx(0.0, abs=1e-12)
    assert widths[2] < 0.01e-6


@pytest.mark.parametrize("depth", [-1e-9, np.nan, np.inf])
def test_depth_that_is_none_is_refused(depth: float) -> None:
    with pytest.raises(InputError, match="removal"):
        SURE.after(BEFORE, depth)


@pytest.mark.parametrize(("value", "factor"), [(0.0, 1.1), (1e-6, 0.9), (np.nan, 2.0)])
def test_guess_without_meaning_is_refused(value: float, factor: float) -> None:
    with pytest.raises(InputError, match="expected"):
        Guess(value=value, factor=factor)
