"""The contact of a sphere on a surface after Hertz."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from burnish.errors import InputError, PlanError
from burnish.paths.hertz import contact_radius, contact_width, recommended_step


def test_felt_at_10_N_has_the_width_of_the_text_book() -> None:
    # a = (3 · 10 N · 15 mm / (4 · 2 MPa))^(1/3) = 3.83 mm
    assert contact_width(10.0, 0.015, 0.0, 2e6) == pytest.approx(2 * 3.832e-3, rel=1e-3)


def test_contact_approaches_as_two_springs_of_hertz() -> None:
    # The force that a Hertz contact takes to be pressed in by d is 4/3 E* √R d^1.5, and a² = R d.
    a, radius, modulus = contact_width(7.0, 0.02, 1 / 0.15, 3e6) / 2, 1 / (1 / 0.02 + 1 / 0.15), 3e6
    depth = a**2 / radius
    assert 4 / 3 * modulus * np.sqrt(radius) * depth**1.5 == pytest.approx(7.0)


def test_convex_surface_narrows_the_contact_and_hollow_one_widens_it() -> None:
    flat = contact_width(10.0, 0.015, 0.0, 2e6)
    assert contact_width(10.0, 0.015, 1 / 0.15, 2e6) < flat < contact_width(10.0, 0.015, -1 / 0.15, 2e6)


def test_pressure_of_hertz_carries_the_force() -> None:
    force, a = 10.0, float(contact_radius(10.0, 0.015, 0.0, 2e6))
    total, _ = quad(lambda s: 3 * force / (2 * np.pi * a**2) * np.sqrt(1 - s**2 / a**2) * 2 * np.pi * s, 0, a)
    assert total == pytest.approx(force)


def test_step_is_three_tenths_of_the_width() -> None:
    assert recommended_step(10.0, 0.015, 2.0, 2e6) == pytest.approx(0.3 * contact_width(10.0, 0.015, 2.0, 2e6))


def test_tip_that_does_not_fit_into_the_hollow_is_refused() -> None:
    with pytest.raises(PlanError, match="does not fit into a hollow of radius 15 mm"):
        contact_width(10.0, 0.015, -1 / 0.015, 2e6)


@pytest.mark.parametrize("values", [(-1.0, 0.015, 2e6), (np.nan, 0.015, 2e6), (10.0, 0.0, 2e6), (10.0, 0.015, np.nan)])
def test_values_that_no_contact_has_are_refused(values: tuple[float, float, float]) -> None:
    force, radius, modulus = values
    with pytest.raises(InputError, match="expected positive values"):
        contact_width(force, radius, 0.0, modulus)
