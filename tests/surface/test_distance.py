"""The distance grid is the distance: against closed forms, and against all triangles one by one."""

from __future__ import annotations

import logging

import numpy as np
import pytest
from surface.shapes import (
    angle_deg,
    box,
    box_distance,
    distance_by_brute_force,
    dome_centre,
    grid,
    mould,
    sheet,
    tray,
    wave_normal,
)

from burnish.core import Array
from burnish.errors import InputError
from burnish.surface import DistanceGrid, Mould, bundled

RNG = np.random.default_rng(17)


def nodes(field: DistanceGrid, count: int) -> tuple[Array, Array]:
    """Random nodes (N, 3) and their values (N,)."""
    index = np.stack([RNG.integers(0, size, count) for size in field.values.shape], axis=1)
    return field.origin + field.spacing * index, field.values[tuple(index.T)]


@pytest.mark.parametrize("name", bundled.NAMES)
def test_nodes_hold_the_distance_to_the_nearest_of_all_triangles(name: str) -> None:
    points, values = nodes(grid(name), 400)
    exact = distance_by_brute_force(mould(name), points)
    error = np.abs(np.abs(values) - exact)[values > -2e-3]
    # A neighbour of the nearest triangle is taken now and then; far from the work, beside the walls, it shows.
    assert error.max() < 40e-6
    assert np.percentile(error, 99) < 6e-6


@pytest.mark.parametrize("name", bundled.NAMES)
def test_grid_reaches_30_mm_above_and_3_mm_below_the_surface(name: str) -> None:
    field, part = grid(name), mould(name)
    high = field.origin + field.spacing * (np.array(field.values.shape) - 1)
    assert (high >= part.vertices.max(axis=0) + [0.01, 0.01, 0.03]).all()
    assert (field.origin[:2] <= part.vertices.min(axis=0)[:2] - 0.01).all()
    assert field.origin[2] <= part.vertices[:, 2].max() - 0.003
    assert field.values.flags.c_contiguous


def test_plate_is_the_box_in_closed_form_around_its_edges() -> None:
    points = RNG.uniform([-0.111, -0.111, 0.016], [0.111, 0.111, 0.052], (50_000, 3))
    exact = box_distance(points, 0.2, 0.2, 0.02)
    found, _ = grid("plate").at(points)
    # Between the nodes a field of curvature 1/φ errs by spacing²/8φ; at the sharp edges by about half a spacing.
    far = exact > 8e-3
    assert np.abs(found - exact)[far].max() < 2 * grid("plate").spacing ** 2 / 8 / 8e-3
    assert np.abs(found - exact).max() < 0.6 * grid("plate").spacing


def test_plate_is_exact_above_its_face() -> None:
    points = RNG.uniform([-0.09, -0.09, 0.016], [0.09, 0.09, 0.05], (20_000, 3))
    found, gradient = grid("plate").at(points)
    np.testing.assert_allclose(found, points[:, 2] - 0.02, atol=1e-9)
    np.testing.assert_allclose(gradient, np.broadcast_to([0, 0, 1], gradient.shape), atol=1e-6)


@pytest.mark.parametrize("radius_mm", [0, 2, 15, 20, 25, 30])
def test_tip_on_the_dome_feels_the_sphere_and_not_its_facets(radius_mm: float) -> None:
    xy = RNG.uniform(-0.046, 0.046, (20_000, 2))
    foot = np.column_stack((xy, bundled.dome_height(*xy.T)))
    normal = (foot - dome_centre()) / bundled.DOME_RADIUS
    found, gradient = grid("dome").at(foot + 1e-3 * radius_mm * normal)
    assert np.abs(found - 1e-3 * radius_mm).max() < 10e-6
    assert angle_deg(gradient, normal).max() < (0.3 if radius_mm == 2 else 0.1)


@pytest.mark.parametrize("radius_mm", [0, 15, 25])
def test_tip_on_the_wave_feels_the_wave(radius_mm: float) -> None:
    xy = RNG.uniform([-0.055, -0.036], [0.055, 0.036], (20_000, 2))
    foot, normal = np.column_stack((xy, bundled.wave_height(*xy.T))), wave_normal(xy[:, 0])
    found, gradient = grid("wave").at(foot + 1e-3 * radius_mm * normal)
    assert np.abs(found - 1e-3 * radius_mm).max() < 15e-6
    assert angle_deg(gradient, normal).max() < 0.3


@pytest.mark.parametrize("name", bundled.NAMES)
def test_gradient_has_length_one_above_smooth_places(name: str) -> None:
    xy = RNG.uniform(-0.02, 0.02, (3000, 2)) + ([0.0, -0.025] if name == "mould" else [0, 0])
    length = np.linalg.norm(
        grid(name).at(np.column_stack((xy, np.full(3000, mould(name).vertices[:, 2].max() + 0.015))))[1], axis=1
    )
    assert np.percentile(np.abs(length - 1), 95) < 2e-3


def test_hole_is_outside_at_every_height_and_deeper_towards_its_axis() -> None:
    z = np.linspace(0.021, 0.018, 5)
    off_axis = np.column_stack((np.full(5, 0.035 - 3e-3), np.full(5, 0.0125), z))
    np.testing.assert_allclose(grid("mould").at(off_axis)[0], 4e-3, atol=0.1e-3)  # of a radius of 7 mm


def test_pocket_corner_is_nearest_to_what_is_nearer() -> None:
    # Beside the wall of a groove with vertical walls the distance is the lesser of wall and floor.
    x = np.array([-0.05, -0.0151, -0.015, 0.015, 0.0151, 0.05])
    groove = tray(x, np.array([-0.05, 0.05]), np.tile([[0.03], [0.03], [0.02], [0.02], [0.03], [0.03]], (1, 2)))
    field = DistanceGrid.of(Mould.of("groove", groove))
    points = RNG.uniform([-0.0145, -0.03, 0.0205], [0.0145, 0.03, 0.0295], (5000, 3))
    exact = np.minimum(points[:, 2] - 0.02, 0.015 - np.abs(points[:, 0]))
    assert np.abs(field.at(points)[0] - exact).max() < 0.4 * field.spacing
    inside = np.array([[0.0, 0.0, 0.0185], [0.018, 0.0, 0.0285]])
    assert (field.at(inside)[0] < -1e-3).all()


def test_open_surface_counts_as_a_solid_with_its_border_dropped_straight_down() -> None:
    x = np.linspace(-0.03, 0.03, 31)
    height = 0.02 + 0.1 * np.subtract.outer(0.03**2, np.add.outer(x**2, x**2)).reshape(31, 31)
    closed, opened = (DistanceGrid.of(Mould.of("part", shape(x, x, height))) for shape in (tray, sheet))
    offset = height.min()  # the sheet stands on its own lowest point
    points = RNG.uniform([-0.045, -0.045, 0.017], [0.045, 0.045, 0.05], (5000, 3))
    np.testing.assert_allclose(opened.at(points - [0, 0, offset])[0], closed.at(points)[0], atol=60e-6)


def test_beyond_the_grid_the_distance_goes_on_linearly() -> None:
    field = grid("plate")
    above = np.array([[0.0, 0.0, 0.3], [0.05, -0.08, 0.2]])
    np.testing.assert_allclose(field.at(above)[0], above[:, 2] - 0.02, atol=1e-9)
    np.testing.assert_allclose(field.at(np.array([[0.01, 0.02, -0.05]]))[0], -0.07, atol=1e-9)
    beside = np.array([[0.2, 0.0, 0.018], [0.0, -0.3, 0.017]])
    np.testing.assert_allclose(field.at(beside)[0], box_distance(beside, 0.2, 0.2, 0.02), atol=1e-4)
    corner = np.array([[0.13, 0.0, 0.03]])  # off an edge it may fall short of the distance, and never exceeds it
    assert (
        0.9 * box_distance(corner, 0.2, 0.2, 0.02) < field.at(corner)[0] < box_distance(corner, 0.2, 0.2, 0.02) + 1e-5
    )


def test_grid_of_a_large_mould_is_coarser_and_says_so(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("burnish.surface.distance.MOST_NODES", 30_000)
    with caplog.at_level(logging.INFO, logger="burnish"):
        field = DistanceGrid.of(Mould.of("table", box(0.4, 0.3, 0.05)))
    assert field.values.size < 1.5 * 30_000
    assert field.spacing > 4e-3
    assert "not 1.00 mm" in caplog.text


@pytest.mark.parametrize(
    "lengths", [{"spacing": 0.0}, {"spacing": float("nan")}, {"above": -1.0}, {"below": 0.0}, {"aside": float("nan")}]
)
def test_lengths_that_are_none_are_refused(lengths: dict[str, float]) -> None:
    with pytest.raises(InputError, match="expected positive lengths"):
        DistanceGrid.of(mould("plate"), **lengths)
