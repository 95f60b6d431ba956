"""The distance of tracks from the bend of the surface."""

from __future__ import annotations

import numpy as np
import pytest
from surface.shapes import grid, mould

from burnish.paths.hertz import contact_radius, recommended_step
from burnish.paths.reach import Reach
from burnish.paths.spacing import Even, Hertzian, across_curvature, spacing_for
from burnish.surface import bundled

TIP = 0.02


def reach(name: str) -> Reach:
    return Reach.of(mould(name), grid(name), tip_radius=TIP, margin=3e-3)


@pytest.mark.parametrize("angle", [0.0, 0.7, np.pi / 2])
def test_curvature_of_the_dome_is_one_over_its_radius_in_every_direction(angle: float) -> None:
    xy = np.random.default_rng(0).uniform(-0.04, 0.04, (300, 2))
    across = np.tile([np.cos(angle), np.sin(angle)], (300, 1))
    found = across_curvature(reach("dome"), xy, across)
    assert np.median(found) == pytest.approx(1 / bundled.DOME_RADIUS, rel=0.03)
    assert np.abs(found - 1 / bundled.DOME_RADIUS).max() < 1.5  # against 50 of the tip


def test_curvature_of_the_wave_is_that_of_the_cosine_along_x_and_none_along_y() -> None:
    x = np.linspace(-0.045, 0.045, 181)
    xy = np.column_stack((x, np.zeros_like(x)))
    k = 2 * np.pi / bundled.WAVE_LENGTH
    slope, bend = -bundled.WAVE_AMPLITUDE * k * np.sin(k * x), bundled.WAVE_AMPLITUDE * k**2 * np.cos(k * x)
    true = bend / (1 + slope**2) ** 1.5
    along = across_curvature(reach("wave"), xy, np.tile([1.0, 0.0], (181, 1)))
    assert np.abs(along - true).max() < 0.12 * np.abs(true).max()  # a mean over 3 mm, and facets of 1 mm
    assert np.abs(across_curvature(reach("wave"), xy, np.tile([0.0, 1.0], (181, 1)))).max() < 0.5


def test_spacing_is_a_fixed_share_of_the_contact_under_the_force_that_goes_with_it() -> None:
    rule = Hertzian.of(reach("plate"), 10.0, np.array([0.0, 0.0, 3.0]))
    for kappa in (-15.0, 0.0, 10.0, 60.0, 100.0):
        step = float(rule.at(np.array(kappa)))
        force = 10.0 * step / rule.typical
        radius = contact_radius(force, TIP, kappa, 2e6)
        assert step == pytest.approx(0.3 * 2 * float(radius), rel=1e-9)


def test_most_of_the_surface_gets_the_whole_force() -> None:
    rule = spacing_for(reach("plate"), None, 10.0, np.array([6.0, 6.0, 6.0, 90.0, -20.0]))
    assert rule.typical == pytest.approx(recommended_step(10.0, TIP, 6.0, 2e6))
    assert float(rule.at(np.array(6.0))) == pytest.approx(rule.typical)


def test_spacing_stays_within_bounds_on_ridges_and_in_hollows_as_round_as_the_tip() -> None:
    rule = Hertzian.of(reach("plate"), 10.0, np.zeros(3))
    assert float(rule.at(np.array(1e6))) == pytest.approx(0.5 * rule.typical)
    assert float(rule.at(np.array(-1e6))) == pytest.approx(1.25 * rule.typical)


def test_chosen_step_is_kept_everywhere() -> None:
    rule = spacing_for(reach("plate"), 1.7e-3, 10.0, np.array([80.0]))
    assert isinstance(rule, Even)
    np.testing.assert_array_equal(rule.at(np.array([-30.0, 0.0, 80.0])), 1.7e-3)
