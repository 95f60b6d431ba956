"""The largest ball that fits, against hollows of known radius and walls of known distance."""

from __future__ import annotations

import numpy as np
import pytest
from surface.shapes import box, mould, tray

from burnish.errors import InputError
from burnish.surface import Access, Mould

TIP = 15e-3


def trough(radius: float) -> Mould:
    """A cylindrical hollow, 60° to either side."""
    y = radius * np.sin(np.deg2rad(np.linspace(-60, 60, 121)))
    return Mould.of("trough", tray(np.linspace(-0.03, 0.03, 31), y, np.tile(0.05 - np.sqrt(radius**2 - y**2), (31, 1))))


@pytest.mark.parametrize("radius", [8e-3, 14e-3, 16e-3, 18.5e-3])
def test_ball_in_a_trough_has_its_radius(radius: float) -> None:
    found = Access.of(trough(radius), TIP)
    x, y = found.surface.vertices[:, :2].T
    middle = (np.abs(x) < 0.02) & (np.abs(y) < 0.4 * radius)
    np.testing.assert_allclose(found.radius[middle], radius, rtol=0.02)  # facets of 1°; twice as much at 2°


@pytest.mark.parametrize(("radius", "tight", "out"), [(12e-3, 0, 1), (16e-3, 1, 0), (18e-3, 1, 0), (20e-3, 0, 0)])
def test_hollow_is_tight_below_a_tip_over_0_8_and_out_of_reach_below_the_tip(
    radius: float, tight: int, out: int
) -> None:
    found = Access.of(trough(radius), TIP)
    x, y = found.surface.vertices[:, :2].T
    middle = (np.abs(x) < 0.02) & (np.abs(y) < 0.4 * radius)
    assert found.tight[middle].mean() == tight
    assert found.out_of_reach[middle].mean() == out


def test_floor_beside_a_wall_is_out_of_reach_as_far_as_the_tip_is_round() -> None:
    step = np.concatenate((box(0.06, 0.06, 0.01), box(0.02, 0.06, 0.04) + [-0.02, 0.0, 0.0]))
    found = Access.of(Mould.of("step", step), TIP)
    x, y, z = found.surface.vertices.T
    floor = (np.abs(z - 0.01) < 1e-6) & (x > -0.009) & (np.abs(y) < 0.02)
    wall = x[floor] + 0.01  # the wall stands at x = −10 mm
    assert found.out_of_reach[floor][wall < TIP - 1.2e-3].all()
    assert not found.out_of_reach[floor][wall > TIP + 1e-6].any()


def test_what_bulges_is_all_within_reach() -> None:
    found = Access.of(mould("dome"), TIP)
    assert not found.out_of_reach.any()
    assert not found.tight.any()
    assert found.summary.startswith("of 104.0 cm² that face up a tip of 15 mm cannot reach 0.0 cm²")


def test_summary_has_the_areas_of_the_masks() -> None:
    found = Access.of(trough(16e-3), TIP)
    assert f"{1e4 * found.area(found.tight):.1f} cm² lie in hollows under 18.8 mm" in found.summary


@pytest.mark.parametrize("radius", [0.0, -1.0, np.nan, np.inf])
def test_radius_that_is_none_is_refused(radius: float) -> None:
    with pytest.raises(InputError, match="tip radius"):
        Access.of(mould("plate"), radius)
