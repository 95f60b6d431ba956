"""A sphere rests where geometry says that it does."""

from __future__ import annotations

import numpy as np
import pytest
from surface.shapes import angle_deg, dome_centre, grid, wave_normal

from burnish.errors import InputError
from burnish.surface import DistanceGrid, bundled, laid, lowered, top, touching, unobstructed
from burnish.surface.touch import OBSTRUCTED

RNG = np.random.default_rng(29)


@pytest.mark.parametrize("radius", [0.005, 0.015, 0.025])
def test_sphere_on_the_plate_rests_a_radius_above_it(radius: float) -> None:
    touch = lowered(grid("plate"), RNG.uniform(-0.09, 0.09, (200, 2)), radius)
    np.testing.assert_allclose(touch.centre[:, 2], 0.02 + radius, atol=1e-9)
    np.testing.assert_allclose(touch.contact[:, 2], 0.02, atol=1e-9)


def test_sphere_rolls_over_the_edge_of_the_plate() -> None:
    radius, beyond = 0.015, np.linspace(0.001, 0.010, 30)
    touch = lowered(grid("plate"), np.column_stack((0.1 + beyond, 0.01 + 0 * beyond)), radius)
    np.testing.assert_allclose(touch.centre[:, 2], 0.02 + np.sqrt(radius**2 - beyond**2), atol=40e-6)
    np.testing.assert_allclose(touch.contact[:, 0], 0.1, atol=0.1e-3)


def test_sphere_on_the_dome_rests_on_the_larger_sphere() -> None:
    radius, xy = 0.015, RNG.uniform(-0.045, 0.045, (2000, 2))
    touch = lowered(grid("dome"), xy, radius)
    away = np.linalg.norm(touch.centre - dome_centre(), axis=1)
    np.testing.assert_allclose(away, bundled.DOME_RADIUS + radius, atol=10e-6)


@pytest.mark.parametrize("radius", [0.015, 0.025])
def test_sphere_touches_the_wave_where_it_is_told_to(radius: float) -> None:
    xy = RNG.uniform([-0.055, -0.035], [0.055, 0.035], (3000, 2))
    touch = touching(grid("wave"), xy, radius)
    np.testing.assert_allclose(touch.contact[:, :2], xy, atol=70e-6)  # 0.15° of 25 mm
    np.testing.assert_allclose(touch.contact[:, 2], bundled.wave_height(*xy.T), atol=20e-6)
    assert angle_deg(touch.normal, wave_normal(xy[:, 0])).max() < 0.3


@pytest.mark.parametrize("name", bundled.NAMES)
def test_sphere_at_rest_never_cuts_in(name: str) -> None:
    xy = RNG.uniform(-0.06, 0.06, (3000, 2))
    centre = lowered(grid(name), xy, 0.015).centre
    centre = centre[~np.isnan(centre[:, 2])]
    assert grid(name).at(centre)[0].min() > 0.015 - 1e-9


def test_sphere_larger_than_the_hole_rests_on_its_rim_and_a_small_one_falls_through() -> None:
    axis = np.array([[0.035, 0.0125]])
    angle = np.linspace(0, 2 * np.pi, 60)
    around = axis + 0.0072 * np.column_stack((np.cos(angle), np.sin(angle)))
    highest = top(grid("mould"), around)[:, 2].max()
    above = lowered(grid("mould"), axis, 0.015).centre[0, 2] - highest - np.sqrt(0.015**2 - 0.007**2)
    assert -0.05e-3 < above < 0.5e-3  # on the axis both sides are equally near, and the grid rounds that off
    assert np.isnan(lowered(grid("mould"), axis, 0.005).centre).all()


def test_floor_of_the_pocket_is_within_reach_only_away_from_the_wall() -> None:
    # A tip of 15 mm that touches the floor, 3 mm deep, meets the rim √(15² − 12²) = 9 mm from it.
    rim_x = -0.021875 + 0.024
    inwards = np.array([0.0075, 0.0105])
    xy = np.column_stack((rim_x - inwards, [0.005, 0.005]))
    spheres = laid(grid("mould"), xy, 0.015)
    cut = 0.015 - grid("mould").at(spheres.centre)[0]
    assert unobstructed(grid("mould"), spheres.centre, 0.015).tolist() == [False, True]
    assert cut[0] > OBSTRUCTED > cut[1]


def test_nothing_to_touch_is_not_a_number() -> None:
    outside = np.array([[0.105, 0.0], [0.5, 0.0]])
    assert np.isnan(top(grid("plate"), outside)).all()
    assert np.isnan(touching(grid("plate"), outside, 0.015).centre).all()
    assert not unobstructed(grid("plate"), laid(grid("plate"), outside, 0.015).centre, 0.015).any()


@pytest.mark.parametrize("radius", [0.001, 0.05, float("nan")])
def test_radius_that_the_grid_cannot_serve_is_refused(radius: float) -> None:
    with pytest.raises(InputError, match="serves radii"):
        lowered(grid("plate"), np.zeros((1, 2)), radius)


def test_no_places_give_no_spheres() -> None:
    field: DistanceGrid = grid("plate")
    assert touching(field, np.empty((0, 2)), 0.015).centre.shape == (0, 3)
