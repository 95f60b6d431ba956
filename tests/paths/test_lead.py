"""The force at the ends of a stroke."""

from __future__ import annotations

import numpy as np
import pytest

from burnish.errors import PlanError
from burnish.paths.lead import with_leads
from burnish.paths.stroke import Stroke


def stroke(length: float = 0.1) -> Stroke:
    x = np.linspace(0.0, length, 201)
    flat, up = np.zeros_like(x), np.tile([0.0, 0.0, 1.0], (201, 1))
    return Stroke(points=np.column_stack((x, flat, flat)), normals=up, feed=flat + 0.02, force=flat + 10.0)


def test_force_rises_and_falls_on_the_way() -> None:
    led = with_leads(stroke(), length=4e-3, touching=0.25)
    places = [0.0, 2e-3, 4e-3, 50e-3, 96e-3, 98e-3, 0.1]
    expected = [2.5, 6.25, 10.0, 10.0, 10.0, 6.25, 2.5]
    np.testing.assert_allclose(np.interp(places, led.arc, led.force), expected, atol=1e-9)
    np.testing.assert_array_equal(led.points, stroke().points)


def test_missing_work_is_that_of_two_triangles() -> None:
    plain, led = stroke(), with_leads(stroke(), length=4e-3, touching=0.25)
    missing = np.trapezoid(plain.force - led.force, plain.arc)
    assert missing == pytest.approx(2 * 0.5 * 7.5 * 4e-3, rel=1e-6)


def test_short_stroke_reaches_the_force_in_its_middle() -> None:
    led = with_leads(stroke(2e-3), length=4e-3)
    assert led.force.max() == pytest.approx(10.0)
    assert led.force.argmax() == 100


@pytest.mark.parametrize("bad", [{"length": 0.0}, {"length": np.nan}, {"touching": 1.1}, {"touching": -0.1}])
def test_values_out_of_range_are_refused(bad: dict[str, float]) -> None:
    with pytest.raises(PlanError, match="expected a positive length"):
        with_leads(stroke(), **bad)
