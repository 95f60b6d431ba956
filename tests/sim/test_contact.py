from __future__ import annotations

from collections.abc import Callable
from math import sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.core import Array
from burnish.model.tool import PolishingTool
from burnish.sim.contact import DAMPING, SLIP_SPEED, STIFFNESS, SphereOnSurface, SpinningSphere, Touch, contact_of
from burnish.surface import DistanceGrid

RADIUS = 0.02
FRICTION = 0.3
STILL = (0.0, 0.0, 0.0)
SPACING = 2e-3


def at_rest() -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """A tip that neither moves nor turns."""
    return STILL, STILL


def grid_of(distance: Callable[[Array], Array]) -> DistanceGrid:
    """A distance that is known everywhere, at the nodes of a grid of 60 × 60 × 60 mm about the origin."""
    origin = np.full(3, -0.03)
    nodes = np.moveaxis(np.mgrid[0:31, 0:31, 0:31], 0, -1) * SPACING + origin
    return DistanceGrid(origin=origin, spacing=SPACING, values=distance(nodes))


SLOPE = np.array([0.2, -0.1, 1.0]) / np.linalg.norm([0.2, -0.1, 1.0])
"""Normal of the tilted plane."""
plane = SphereOnSurface(grid_of(lambda x: x[..., 2]), RADIUS, FRICTION)
tilted = SphereOnSurface(grid_of(lambda x: x @ SLOPE), RADIUS, FRICTION)
# A ball of 50 mm whose top is the origin: a surface that bends.
ball = SphereOnSurface(grid_of(lambda x: np.linalg.norm(x - [0.0, 0.0, -0.05], axis=-1) - 0.05), RADIUS, FRICTION)


def press(surface: SphereOnSurface, depth: float, velocity: Array | None = None, spin: Array | None = None) -> Touch:
    """The sphere pressed ``depth`` into the surface above the origin of the tilted plane."""
    centre = (RADIUS - depth) * (SLOPE if surface is tilted else np.array([0.0, 0.0, 1.0]))
    v, w = (STILL if x is None else tuple(x.tolist()) for x in (velocity, spin))
    touch = surface.touch(tuple(centre.tolist()), lambda: (v, w))
    assert touch is not None
    return touch


# Distance.


def test_distance_of_a_plane_is_exact() -> None:
    # Trilinear interpolation reproduces what is linear.
    for x in np.random.default_rng(1).uniform(-0.029, 0.029, (50, 3)):
        phi, *gradient = tilted.distance(*x.tolist()) or ()
        assert phi == pytest.approx(x @ SLOPE, abs=1e-15)
        assert_allclose(gradient, SLOPE, atol=1e-12)


def test_distance_is_that_of_the_grid_itself() -> None:
    grid = grid_of(lambda x: np.linalg.norm(x - [0.0, 0.0, -0.05], axis=-1) - 0.05)
    points = np.random.default_rng(2).uniform(-0.029, 0.029, (50, 3))
    for x, phi in zip(points, grid.at(points)[0], strict=True):
        found = ball.distance(*x.tolist())
        assert found is not None
        assert found[0] == pytest.approx(phi, abs=1e-15)


def test_gradient_is_the_finite_difference_of_the_distance() -> None:
    h = 1e-7
    rng = np.random.default_rng(3)
    for _ in range(50):
        # Inside a cell, where the interpolation is smooth.
        x = np.floor(rng.uniform(2, 28, 3)) * SPACING - 0.03 + rng.uniform(0.1, 0.9, 3) * SPACING
        found = ball.distance(*x.tolist())
        assert found is not None
        for i in range(3):
            step = h * np.eye(3)[i]
            ahead, behind = ball.distance(*(x + step).tolist()), ball.distance(*(x - step).tolist())
            assert ahead is not None
            assert behind is not None
            # Rounding of 1e-17 m over 2e-7 m.
            assert found[1 + i] == pytest.approx((ahead[0] - behind[0]) / (2.0 * h), abs=1e-8)


def test_distance_is_continuous_across_cells() -> None:
    rng = np.random.default_rng(4)
    for axis in range(3):
        for _ in range(30):
            x = rng.uniform(-0.028, 0.028, 3)
            x[axis] = rng.integers(1, 29) * SPACING - 0.03
            step = 1e-12 * np.eye(3)[axis]
            before, after = ball.distance(*(x - step).tolist()), ball.distance(*(x + step).tolist())
            assert before is not None
            assert after is not None
            assert before[0] == pytest.approx(after[0], abs=1e-11)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_there_is_no_distance_outside_the_grid(axis: int, side: float) -> None:
    x = np.zeros(3)
    x[axis] = side * 0.0301
    assert ball.distance(*x.tolist()) is None


# Force.


@pytest.mark.parametrize("surface", [plane, tilted, ball], ids=["plane", "tilted", "ball"])
@pytest.mark.parametrize("depth", [1e-6, 1e-4, 2e-4])
def test_pressing_gives_the_force_of_the_spring(surface: SphereOnSurface, depth: float) -> None:
    touch = press(surface, depth)
    # On the ball trilinear interpolation is off by up to h²/(8 · 70 mm) = 7 µm off its nodes, here on one.
    assert touch.normal_force == pytest.approx(STIFFNESS * depth, rel=1e-9)
    assert np.linalg.norm(touch.force) == pytest.approx(STIFFNESS * depth, rel=1e-9)


@pytest.mark.parametrize(("surface", "normal"), [(plane, [0.0, 0.0, 1.0]), (tilted, SLOPE)], ids=["plane", "tilted"])
def test_force_is_along_the_outward_normal(surface: SphereOnSurface, normal: Array) -> None:
    touch = press(surface, 1e-4)
    assert_allclose(touch.normal, normal, atol=1e-12)
    assert_allclose(np.array(touch.force) / touch.normal_force, normal, atol=1e-12)


def test_normal_of_the_ball_points_from_its_centre() -> None:
    rng = np.random.default_rng(5)
    for _ in range(20):
        centre = rng.uniform([-0.02, -0.02, 0.0], [0.02, 0.02, 0.01])
        touch = ball.touch(tuple(centre.tolist()), at_rest)
        assert touch is not None
        ray = centre - [0.0, 0.0, -0.05]
        # A cell of 2 mm turns the normal by up to half a cell over the distance from the centre, 1 mm over 50 mm.
        assert_allclose(touch.normal, ray / np.linalg.norm(ray), atol=0.02)


def test_point_of_contact_lies_on_the_surface() -> None:
    assert_allclose(press(tilted, 1e-4).point, np.zeros(3), atol=1e-15)


@pytest.mark.parametrize("gap", [0.0, 1e-9, 1e-3])
def test_there_is_no_force_in_the_air(gap: float) -> None:
    assert plane.touch((0.0, 0.0, RADIUS + gap + 1e-15), at_rest) is None


def test_there_is_no_force_outside_the_grid() -> None:
    assert plane.touch((0.0, 0.0, -0.5), at_rest) is None


def test_force_sets_in_without_a_jump() -> None:
    assert press(plane, 1e-12).normal_force == pytest.approx(0.0, abs=1e-6)


def test_approach_adds_damping_and_departure_takes_it() -> None:
    force = {v: press(plane, 1e-4, np.array([0.0, 0.0, v])).normal_force for v in (-0.05, 0.0, 0.05)}
    assert force[-0.05] - force[0.0] == pytest.approx(0.05 * DAMPING)
    assert force[0.0] - force[0.05] == pytest.approx(0.05 * DAMPING)


def test_surface_never_pulls() -> None:
    touch = press(plane, 1e-4, np.array([0.1, 0.0, 10.0]))
    assert touch.normal_force == 0.0
    assert_allclose(touch.force, np.zeros(3), atol=0.0)


@pytest.mark.parametrize("surface", [plane, tilted, ball], ids=["plane", "tilted", "ball"])
def test_friction_opposes_the_slip(surface: SphereOnSurface) -> None:
    rng = np.random.default_rng(6)
    for _ in range(20):
        velocity = rng.normal(size=3) * 0.05
        touch = press(surface, 2e-4, velocity)
        n, force = np.array(touch.normal), np.array(touch.force)
        slip, drag = velocity - n * (n @ velocity), force - n * (n @ force)
        assert drag @ slip == pytest.approx(-np.linalg.norm(drag) * np.linalg.norm(slip), rel=1e-9)


@pytest.mark.parametrize("slip", [0.0, 0.1 * SLIP_SPEED, SLIP_SPEED, 0.02, 0.5])
def test_friction_grows_to_coulombs(slip: float) -> None:
    touch = press(plane, 2e-4, np.array([slip, 0.0, 0.0]))
    expected = FRICTION * touch.normal_force * slip / sqrt(slip**2 + SLIP_SPEED**2)
    assert touch.force[0] == pytest.approx(-expected, rel=1e-12)
    assert touch.slip == pytest.approx(slip)


def test_spinning_tip_slips_where_it_touches() -> None:
    # About y, seen from above, the lowest point of the sphere runs along −x: friction drives the sphere along +x.
    touch = press(plane, 1e-4, spin=np.array([0.0, 1.0, 0.0]))
    assert touch.slip == pytest.approx(RADIUS - 1e-4)
    assert touch.force[0] > 0.0


def test_rolling_tip_does_not_slip() -> None:
    arm = RADIUS - 1e-4
    touch = press(plane, 1e-4, velocity=np.array([0.3 * arm, 0.0, 0.0]), spin=np.array([0.0, 0.3, 0.0]))
    assert touch.slip == pytest.approx(0.0, abs=1e-15)


def test_spin_about_the_normal_gives_no_force() -> None:
    touch = press(plane, 1e-4, spin=np.array([0.0, 0.0, 5.0]))
    assert_allclose(touch.force[:2], np.zeros(2), atol=1e-12)


def test_force_does_not_jump_on_the_way_over_a_bend() -> None:
    # 0.1 mm a step on a grid of 2 mm: the force on the ball follows the distance, which has no jump.
    xs = np.arange(-0.02, 0.02, 1e-4)
    heights = np.sqrt(0.07**2 - xs**2) - 0.05 - 2e-4
    touches = [ball.touch((float(x), 3e-4, float(z)), at_rest) for x, z in zip(xs, heights, strict=True)]
    force = np.array([0.0 if touch is None else touch.normal_force for touch in touches])
    # 0.1 mm of way within the facets, which bend by 2 mm/70 mm at an edge, is 3 µm of depth, 0.3 N.
    assert np.abs(np.diff(force)).max() < 0.5
    assert force.min() > 0.0


# Spindle.


def spinning_on(tilt: float, spindle: float) -> SphereOnSurface:
    """The tip over the plane, its axis leaning from straight down towards x."""
    grid = grid_of(lambda x: x[..., 2])
    axis = np.array([np.sin(tilt), 0.0, -np.cos(tilt)])
    return contact_of(grid, PolishingTool(tip_radius=RADIUS, friction=FRICTION, spindle=spindle), axis)


def test_tool_without_a_spindle_touches_as_a_sphere_that_only_slides() -> None:
    assert type(spinning_on(0.0, 0.0)) is SphereOnSurface
    velocity, spin = np.array([0.02, -0.01, -0.003]), np.array([0.1, 0.2, 0.3])
    assert press(spinning_on(0.3, 0.0), 1e-4, velocity, spin) == press(plane, 1e-4, velocity, spin)


def test_slow_spindle_leaves_the_friction_of_the_slide() -> None:
    surface = spinning_on(0.0, 1e-9)
    assert isinstance(surface, SpinningSphere)
    velocity, spin = np.array([0.02, -0.01, -0.003]), np.array([0.1, 0.2, 0.3])
    touch, plain_touch = press(surface, 1e-4, velocity, spin), press(plane, 1e-4, velocity, spin)
    assert_allclose(touch.force, plain_touch.force, rtol=1e-9)
    assert touch.slip == plain_touch.slip


def test_spinning_tip_is_turned_against_its_spindle() -> None:
    # 10 N, an axis that points down, so a spin against z: the drag turns it about +z, (3π/16) µ F a in size.
    touch = press(spinning_on(0.0, 200.0), 1e-4)
    a = (0.75 * touch.normal_force * RADIUS / PolishingTool().modulus) ** (1.0 / 3.0)
    assert touch.moment[2] == pytest.approx(3.0 * np.pi / 16.0 * FRICTION * touch.normal_force * a, rel=1e-4)
    assert_allclose(touch.force[:2], np.zeros(2), atol=1e-12)


def test_tilted_spinning_tip_is_pulled_sideways() -> None:
    # Leaning towards x the rim below runs along Ω z × (−r n), to +y for a positive spindle: it is pulled to −y.
    touch = press(spinning_on(0.3, 200.0), 1e-4)
    assert touch.force[1] < -0.5 * FRICTION * touch.normal_force
    assert touch.force[0] == pytest.approx(0.0, abs=1e-9)
    assert touch.slip == pytest.approx(0.0, abs=1e-12)
