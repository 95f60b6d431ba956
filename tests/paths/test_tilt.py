"""A leaning tool: its tip still touches the point, by the geometry of a sphere."""

from __future__ import annotations

import numpy as np
import pytest

from burnish.core import Array
from burnish.errors import PlanError
from burnish.paths.tilt import Tilt, tool_axes, tool_poses, travel_of
from burnish.rotation import exp

R_DOWN = np.diag([1.0, -1.0, -1.0])
RADIUS = 0.02


def surface(seed: int = 3, count: int = 40) -> tuple[Array, Array, Array]:
    """Points, normals up to 40° from the vertical, and directions of travel."""
    rng = np.random.default_rng(seed)
    angle, turn = rng.uniform(0, 0.7, count), rng.uniform(0, 2 * np.pi, count)
    n = np.column_stack((np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), np.cos(angle)))
    return rng.uniform(-0.1, 0.1, (count, 3)), n, rng.normal(size=(count, 3))


@pytest.mark.parametrize("heading_deg", [-180, -90, 0, 37, 90, 180])
@pytest.mark.parametrize("angle_deg", [0, 5, 15, 25])
def test_sphere_of_the_tip_touches_the_plane_in_the_point(angle_deg: float, heading_deg: float) -> None:
    c, n, travel = surface()
    p, R = tool_poses(c, n, travel, RADIUS, Tilt(angle=np.deg2rad(angle_deg), heading=np.deg2rad(heading_deg)), R_DOWN)
    centre = p - RADIUS * R[:, :, 2]  # the apex is a radius beyond the centre
    np.testing.assert_allclose(np.einsum("ij,ij->i", centre - c, n), RADIUS, atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(centre - c, axis=1), RADIUS, atol=1e-15)
    lean = np.arccos(np.clip(-np.einsum("ij,ij->i", R[:, :, 2], n), -1, 1))
    np.testing.assert_allclose(np.rad2deg(lean), angle_deg, atol=1e-5)


@pytest.mark.parametrize(
    ("heading_deg", "body"), [(0, [1, 0, 0]), (180, [-1, 0, 0]), (90, [0, 1, 0]), (-90, [0, -1, 0])]
)
def test_body_leans_to_the_side_that_was_named(heading_deg: float, body: list[float]) -> None:
    tilt = Tilt(angle=0.3, heading=np.deg2rad(heading_deg))
    axis = tool_axes(np.array([[0.0, 0.0, 1.0]]), np.array([[0.02, 0.0, 0.5]]), tilt)[0]
    np.testing.assert_allclose(-axis[:2], np.sin(0.3) * np.array(body[:2]), atol=1e-12)


def test_leaning_is_a_turn_about_the_axis_across_travel() -> None:
    _, n, travel = surface(5)
    axes = tool_axes(n, travel, Tilt(angle=0.25))
    for normal, way, axis in zip(n, travel, axes, strict=True):
        across = np.cross(normal, way - (way @ normal) * normal)
        turned = exp(0.25 * across / np.linalg.norm(across)) @ -normal
        np.testing.assert_allclose(axis, turned, atol=1e-12)


def test_upright_tool_stands_with_its_apex_on_the_point() -> None:
    c, n, travel = surface()
    p, R = tool_poses(c, n, 0.0 * travel, RADIUS, Tilt(), R_DOWN)
    np.testing.assert_allclose(p, c, atol=1e-15)
    np.testing.assert_allclose(R[:, :, 2], -n, atol=1e-12)


def test_poses_are_rotations() -> None:
    c, n, travel = surface()
    R = tool_poses(c, n, travel, RADIUS, Tilt(angle=0.4, heading=1.0), R_DOWN)[1]
    np.testing.assert_allclose(R @ np.swapaxes(R, 1, 2), np.tile(np.eye(3), (len(R), 1, 1)), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(R), 1.0, atol=1e-12)


def test_direction_of_travel_is_the_tangent() -> None:
    angle = np.linspace(0.0, 3.0, 300)
    tangent = travel_of(np.column_stack((np.cos(angle), np.sin(angle), 0 * angle)))
    np.testing.assert_allclose(tangent[5:-5, 0], -np.sin(angle)[5:-5], atol=1e-4)


@pytest.mark.parametrize("angle_deg", [-5, 1, 26, np.nan])
def test_angle_that_no_tool_works_at_is_refused(angle_deg: float) -> None:
    with pytest.raises(PlanError, match="expected 0, or 5° to 25°"):
        Tilt(angle=np.deg2rad(angle_deg))


@pytest.mark.parametrize("heading", [4.0, np.nan])
def test_heading_beyond_a_half_turn_is_refused(heading: float) -> None:
    with pytest.raises(PlanError, match="-180° to 180°"):
        Tilt(heading=heading)


@pytest.mark.parametrize("travel", [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
def test_leaning_without_a_direction_is_refused(travel: list[float]) -> None:
    with pytest.raises(PlanError, match="expected a direction over the surface"):
        tool_axes(np.array([[0.0, 0.0, 1.0]]), np.array([travel]), Tilt(angle=0.2))
