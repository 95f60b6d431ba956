"""A leaning tool: to the side that was named, all over the part."""

from __future__ import annotations

import numpy as np
import pytest

from burnish.core import Array
from burnish.errors import PlanError
from burnish.paths.tilt import Tilt, tool_axes
from burnish.rotation import exp


def normals_up_to_40_degrees(seed: int = 3, count: int = 40) -> Array:
    rng = np.random.default_rng(seed)
    angle, turn = rng.uniform(0, 0.7, count), rng.uniform(0, 2 * np.pi, count)
    return np.column_stack((np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), np.cos(angle)))


@pytest.mark.parametrize("heading_deg", [-180, -90, 0, 37, 90, 180])
@pytest.mark.parametrize("angle_deg", [0, 5, 15, 25])
def test_axis_is_a_unit_vector_that_leans_by_the_angle_everywhere(angle_deg: float, heading_deg: float) -> None:
    n = normals_up_to_40_degrees()
    z = tool_axes(n, Tilt(angle=np.deg2rad(angle_deg), heading=np.deg2rad(heading_deg)))
    np.testing.assert_allclose(np.linalg.norm(z, axis=1), 1.0, atol=1e-12)
    lean = np.arccos(np.clip(-np.einsum("ij,ij->i", z, n), -1, 1))
    np.testing.assert_allclose(np.rad2deg(lean), angle_deg, atol=1e-5)


@pytest.mark.parametrize(
    ("heading_deg", "body"), [(0, [1, 0, 0]), (180, [-1, 0, 0]), (90, [0, 1, 0]), (-90, [0, -1, 0])]
)
def test_body_leans_to_the_side_that_was_named(heading_deg: float, body: list[float]) -> None:
    axis = tool_axes(np.array([[0.0, 0.0, 1.0]]), Tilt(angle=0.3, heading=np.deg2rad(heading_deg)))[0]
    np.testing.assert_allclose(-axis[:2], np.sin(0.3) * np.array(body[:2]), atol=1e-12)


def test_leaning_to_x_is_a_turn_about_the_line_of_the_surface_across_x() -> None:
    n = normals_up_to_40_degrees(5)
    for normal, axis in zip(n, tool_axes(n, Tilt(angle=0.25)), strict=True):
        across = np.cross(normal, [1.0, 0.0, 0.0])
        np.testing.assert_allclose(axis, exp(0.25 * across / np.linalg.norm(across)) @ -normal, atol=1e-12)


def test_upright_tool_points_along_the_normal() -> None:
    n = normals_up_to_40_degrees()
    np.testing.assert_array_equal(tool_axes(n, Tilt(heading=1.0)), -n)


@pytest.mark.parametrize("angle_deg", [-5, 1, 26, np.nan])
def test_angle_that_no_tool_works_at_is_refused(angle_deg: float) -> None:
    with pytest.raises(PlanError, match="expected 0, or 5° to 25°"):
        Tilt(angle=np.deg2rad(angle_deg))


@pytest.mark.parametrize("heading", [4.0, np.nan])
def test_heading_beyond_a_half_turn_is_refused(heading: float) -> None:
    with pytest.raises(PlanError, match="-180° to 180°"):
        Tilt(heading=heading)


def test_leaning_where_the_surface_faces_along_x_is_refused() -> None:
    with pytest.raises(PlanError, match="expected a heading over it"):
        tool_axes(np.array([[1.0, 0.0, 0.0]]), Tilt(angle=0.2))
