"""Where the workable surface ends."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from surface.shapes import box, sheet

from burnish.errors import InputError
from burnish.surface import Border, Mould

SLOPE = np.deg2rad(40)
RNG = np.random.default_rng(23)


def test_border_of_a_box_is_its_outline() -> None:
    border = Border.of(Mould.of("box", box(0.12, 0.08, 0.03)), SLOPE)
    points = RNG.uniform([-0.09, -0.07], [0.09, 0.07], (2000, 2))
    outside = np.abs(points) - [0.06, 0.04]
    exact = np.abs(np.linalg.norm(np.maximum(outside, 0), axis=1) + np.minimum(outside.max(axis=1), 0))
    np.testing.assert_allclose(border.distance(points), exact, atol=1e-12)


def test_heights_do_not_count() -> None:
    border = Border.of(Mould.of("box", box(0.12, 0.08, 0.03)), SLOPE)
    points = RNG.uniform(-0.03, 0.03, (50, 3))
    np.testing.assert_array_equal(border.distance(points), border.distance(points[:, :2]))


def test_rim_of_an_open_sheet_is_a_border() -> None:
    x = np.linspace(-0.05, 0.05, 11)
    border = Border.of(Mould.of("sheet", sheet(x, x, np.zeros((11, 11)))), SLOPE)
    np.testing.assert_allclose(border.distance(np.array([[0.0, 0.0], [0.03, 0.01]])), [0.05, 0.02], atol=1e-12)


def roof(height: float) -> Mould:
    """Two slopes that meet along y in the middle, at ``height`` above the eaves, 100 mm wide."""
    x = np.array([-0.05, 0.0, 0.05])
    return Mould.of("roof", sheet(x, x, np.array([[0.0] * 3, [height] * 3, [0.0] * 3])))


@pytest.mark.parametrize(
    ("height", "distance"),
    [
        pytest.param(0.05 * np.tan(np.deg2rad(9.5)), 0.04, id="a ridge of 19° is a facetted curve"),
        pytest.param(0.05 * np.tan(np.deg2rad(10.5)), 0.01, id="a ridge of 21° is an edge"),
        pytest.param(-0.05 * np.tan(np.deg2rad(30.0)), 0.04, id="a valley keeps the tool out by itself"),
    ],
)
def test_only_sharp_convex_edges_are_borders(height: float, distance: float) -> None:
    assert Border.of(roof(height), SLOPE).distance(np.array([[0.01, 0.0]]))[0] == pytest.approx(distance)


def test_smooth_closed_part_has_no_border() -> None:
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.04)
    border = Border.of(Mould.of("ball", ball.triangles), SLOPE)
    assert np.isinf(border.distance(np.zeros((3, 2)))).all()


@pytest.mark.parametrize("slope", [0.0, 2.0, float("nan")])
def test_slope_that_is_no_slope_is_refused(slope: float) -> None:
    with pytest.raises(InputError, match="max_slope"):
        Border.of(roof(0.01), slope)
