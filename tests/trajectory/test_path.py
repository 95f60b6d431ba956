from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.core import Array, Dynamics, State
from burnish.errors import InputError
from burnish.model.model import Model
from burnish.rotation import exp, log
from burnish.trajectory import SurfacePath, TimedPath
from burnish.trajectory.path import START_ACCELERATION, TURN_RATE, time_path, tool_rotation

DOWN = np.diag([1.0, -1.0, -1.0])
"""A tool that points along −z."""
ARM = Model.jaco2().at(State(t=3.5, q=np.full(6, 1.0), dq=np.zeros(6)))
ACCELERATION = 0.3
FEED = 0.04


def after(t: float) -> Dynamics:
    return replace(ARM, t=3.5 + t)


def over_a_ridge(radius: float, spacing: float = 1e-3) -> tuple[Array, Array]:
    """Points and normals: flat, over a half-round ridge of a radius by 60° up and down, with a bend to the side."""
    angles = np.arange(-np.pi / 3, np.pi / 3, spacing / radius)
    arc = radius * np.column_stack([np.sin(angles), 0.0 * angles, np.cos(angles) - np.cos(np.pi / 3)])
    round_normals = np.column_stack([np.sin(angles), 0.0 * angles, np.cos(angles)])
    flat = np.arange(0.06, 0.0, -spacing)
    before = np.column_stack([arc[0, 0] - flat, 0.0 * flat, 0.0 * flat])
    beyond = np.column_stack([arc[-1, 0] + flat[::-1], 8.0 * flat[::-1] ** 2, 0.0 * flat])
    up = np.tile([0.0, 0.0, 1.0], (len(flat), 1))
    return np.vstack([before, arc, beyond]), np.vstack([up, round_normals, up])


def timed(radius: float = 0.03, feed: float = FEED) -> TimedPath:
    points, normals = over_a_ridge(radius)
    return time_path(
        points,
        normals,
        np.full(len(points), feed),
        np.linspace(6.0, 9.0, len(points)),
        DOWN,
        acceleration=ACCELERATION,
    )


PATH = timed()


# The tool on the surface.


def test_tool_points_into_the_surface() -> None:
    rng = np.random.default_rng(1)
    for _ in range(50):
        normal = rng.normal(size=3) + [0.0, 0.0, 2.0]
        normal /= np.linalg.norm(normal)
        R = tool_rotation(normal, DOWN)
        assert_allclose(R[:, 2], -normal, atol=1e-14)
        assert_allclose(R @ R.T, np.eye(3), atol=1e-13)


def test_tool_turns_no_more_than_it_must() -> None:
    rng = np.random.default_rng(2)
    for _ in range(50):
        normal = rng.normal(size=3) + [0.0, 0.0, 2.0]
        normal /= np.linalg.norm(normal)
        turned = np.linalg.norm(log(tool_rotation(normal, DOWN) @ DOWN.T))
        # No turn that takes one direction to another is smaller than the angle between them.
        assert turned == pytest.approx(np.arccos(np.clip(normal[2], -1.0, 1.0)), abs=1e-9)


def test_surface_that_faces_away_is_refused() -> None:
    with pytest.raises(InputError, match="faces away"):
        tool_rotation(np.array([0.0, 0.0, -1.0]), DOWN)


# Timing.


def test_path_begins_and_ends_at_its_ends() -> None:
    points, _ = over_a_ridge(0.03)
    # Smoothing over 50 ms with the ends held pulls the first node by the way of the first 25 ms: less than 0.1 mm.
    assert_allclose(PATH.p[0], points[0], atol=1e-4)
    assert_allclose(PATH.p[-1], points[-1], atol=1e-4)


def test_path_stays_on_its_points() -> None:
    points, _ = over_a_ridge(0.03, spacing=0.1e-3)
    off = [np.linalg.norm(points - p, axis=1).min() for p in PATH.p]
    # A mean over 50 ms cuts the corner at the foot of the ridge, 60° sharp, by up to a third of the 2 mm it covers.
    assert max(off) < 0.7e-3


@pytest.mark.parametrize("radius", [0.03, 0.01, 0.005])
def test_path_is_never_faster_than_its_feed(radius: float) -> None:
    speed = np.linalg.norm(timed(radius).v[:, :3], axis=1)
    assert speed.max() <= FEED * (1.0 + 1e-9)


def test_path_reaches_its_feed_where_it_is_straight() -> None:
    assert np.linalg.norm(PATH.v[:, :3], axis=1).max() > 0.98 * FEED


@pytest.mark.parametrize("radius", [0.03, 0.01, 0.005])
def test_path_is_slow_enough_over_a_fillet_for_the_wrist(radius: float) -> None:
    path = timed(radius)
    rate = np.linalg.norm(path.v[:, 3:], axis=1)
    # On the arc itself: at its feet the normals here jump by 60° from one point to the next.
    tilt = np.arccos(path.normal[:, 2])
    inside = (tilt < np.deg2rad(45.0)) & (np.abs(path.p[:, 0]) < radius * np.sin(np.deg2rad(45.0)))
    assert inside.sum() > 20
    assert rate[inside].max() <= 1.05 * TURN_RATE


def test_path_leaves_rest_gently() -> None:
    speed = np.linalg.norm(PATH.v[:, :3], axis=1)
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(PATH.p, axis=0), axis=1))])
    near = way < 5e-3
    assert np.all(speed[near] <= 1.2e-3 + np.sqrt(2.0 * START_ACCELERATION * way[near]))


def test_path_takes_its_force_from_its_points() -> None:
    assert PATH.force[0] == pytest.approx(6.0)
    assert PATH.force[-1] == pytest.approx(9.0)
    assert np.all(np.diff(PATH.force) >= 0.0)


def test_speeds_of_the_nodes_are_the_differences_of_their_positions() -> None:
    difference = (PATH.p[2:] - PATH.p[:-2]) / (2.0 * PATH.dt)
    assert_allclose(PATH.v[1:-1, :3], difference, atol=1e-12)


def test_angular_speeds_of_the_nodes_are_those_of_their_rotations() -> None:
    # Two steps turn by less than 0.02 rad: sine and angle differ by less than 0.02³/6.
    for k in range(1, len(PATH.p) - 1):
        ahead = exp(2.0 * PATH.dt * PATH.v[k, 3:]) @ PATH.R[k - 1]
        assert_allclose(ahead, PATH.R[k + 1], atol=1.4e-6)


def test_accelerations_of_the_nodes_are_the_differences_of_their_speeds() -> None:
    difference = (PATH.v[2:] - PATH.v[:-2]) / (2.0 * PATH.dt)
    assert_allclose(PATH.a[1:-1], difference, atol=1e-10)


def test_every_node_points_into_its_surface() -> None:
    assert_allclose(PATH.R[:, :, 2], -PATH.normal, atol=1e-13)


@pytest.mark.parametrize("points", [[[0, 0, 0], [1, 0, 0]], [[0, 0, 0], [1, 0, 0], [1, 0, 0]]], ids=["two", "double"])
def test_path_of_too_few_points_is_refused(points: list[list[float]]) -> None:
    n = len(points)
    normals = np.tile([0.0, 0.0, 1.0], (n, 1))
    with pytest.raises(InputError, match="at least three points"):
        time_path(np.array(points, float), normals, np.ones(n), np.ones(n), DOWN, acceleration=1.0)


# The ramp.


def test_ramp_adds_its_time() -> None:
    assert PATH.with_ramp(0.5, 0.25).duration == pytest.approx(PATH.duration + 0.75)


def test_force_rises_in_the_ramp_holds_and_goes_on() -> None:
    ramped = PATH.with_ramp(0.5, 0.25)
    t = ramped.dt * np.arange(150)
    assert_allclose(ramped.force[:150], np.minimum(t / 0.5, 1.0) * PATH.force[0], atol=1e-9)
    assert_allclose(ramped.force[150:], PATH.force, atol=0.0)


def test_force_may_begin_with_what_a_touch_leaves() -> None:
    ramped = PATH.with_ramp(0.5, 0.25, 2.0)
    own = float(PATH.force[0])
    assert own > 2.0
    assert_allclose(ramped.force[:100], np.linspace(2.0, own, 101)[:100], atol=1e-9)
    assert_allclose(ramped.force[100:150], own, atol=0.0)


@pytest.mark.parametrize("above", [0.0, 1e-15, 1e3])
def test_path_that_begins_with_what_a_touch_leaves_does_not_stand(above: float) -> None:
    ramped = PATH.with_ramp(0.5, 0.25, (1.0 + above) * float(PATH.force[0]))
    assert ramped.duration == PATH.duration


def test_tool_stands_still_during_the_ramp() -> None:
    ramped = PATH.with_ramp(0.5, 0.25)
    assert not ramped.v[:150].any()
    assert_allclose(ramped.p[:150], np.tile(PATH.p[0], (150, 1)), atol=0.0)


# Following it.


@pytest.fixture
def source() -> SurfacePath:
    follow = SurfacePath(path=PATH)
    follow.reset(ARM)
    return follow


@pytest.mark.parametrize("k", [0, 1, 77, len(PATH.p) - 2])
def test_reference_at_a_node_is_the_node(source: SurfacePath, k: int) -> None:
    wanted = source.at(after(PATH.dt * k))
    for ours, theirs in [(wanted.p, PATH.p), (wanted.v, PATH.v), (wanted.a, PATH.a), (wanted.normal, PATH.normal)]:
        # The clock's rounding puts the instant next to the node.
        assert_allclose(ours, theirs[k], atol=1e-9)


def test_reference_between_nodes_lies_between_them(source: SurfacePath) -> None:
    wanted = source.at(after(PATH.dt * 50.25))
    assert_allclose(wanted.p, 0.75 * PATH.p[50] + 0.25 * PATH.p[51], atol=1e-12)


def test_reference_stands_still_at_the_end(source: SurfacePath) -> None:
    wanted = source.at(after(PATH.duration + 1.0))
    assert_allclose(wanted.p, PATH.p[-1], atol=0.0)
    assert not wanted.v.any()
    assert not wanted.a.any()


def test_looking_ahead_gives_early_what_comes_late(source: SurfacePath) -> None:
    early = SurfacePath(path=PATH, ahead=0.05)
    early.reset(ARM)
    assert_allclose(early.at(after(1.0)).p, source.at(after(1.05)).p, atol=1e-12)


def test_path_is_done_when_its_time_is_over(source: SurfacePath) -> None:
    assert not source.arrived(after(PATH.duration - 1e-6))
    assert source.arrived(after(PATH.duration + 1e-6))


@pytest.mark.parametrize(
    ("t", "share"), [(-1.0, 0.0), (0.0, 0.0), (0.5 * PATH.duration, 0.5), (2.0 * PATH.duration, 1.0)]
)
def test_share_runs_from_nothing_to_all(source: SurfacePath, t: float, share: float) -> None:
    assert source.share(after(t)) == pytest.approx(share)


# A tool that leans.


def leaning(angle: float, radius: float) -> tuple[TimedPath, TimedPath]:
    """The path over a round back of a tool that leans sideways by an angle, and that of an upright one."""
    turn = np.linspace(-0.3, 0.3, 121)
    normals = np.column_stack([np.sin(turn), 0.0 * turn, np.cos(turn)])
    points, level = 0.1 * normals, np.ones(len(turn))
    axes = -np.cos(angle) * normals + np.sin(angle) * np.array([0.0, 1.0, 0.0])

    def path(axes: Array | None) -> TimedPath:
        return time_path(points, normals, 0.02 * level, 8.0 * level, DOWN, acceleration=ACCELERATION, axes=axes,
                         tip_radius=radius)  # fmt: skip

    return path(axes), path(None)


def test_centre_of_a_leaning_tip_stands_a_radius_above_the_contact() -> None:
    radius, angle = 0.02, 0.3
    path, upright = leaning(angle, radius)
    centre = path.p - radius * path.R[:, :, 2]
    # Neither has to wait for the wrist, so both take the same time; an upright apex is at the contact.
    assert_allclose(centre, upright.p + radius * upright.normal, atol=1e-5)
    assert_allclose(path.normal, upright.normal, atol=1e-12)
    assert_allclose(np.sum(path.R[:, :, 2] * -path.normal, axis=1), np.cos(angle), atol=1e-4)


def test_twist_of_a_leaning_tool_is_that_of_its_poses() -> None:
    path, _ = leaning(0.3, 0.02)
    assert_allclose(path.v[1:-1, :3], (path.p[2:] - path.p[:-2]) / (2.0 * path.dt), atol=1e-9)
    for k in range(1, len(path.p) - 1, 20):
        turn = log(path.R[k + 1] @ path.R[k - 1].T) / (2.0 * path.dt)
        assert_allclose(path.v[k, 3:], turn, atol=1e-5)


def test_tool_that_swings_over_sets_the_pace() -> None:
    x = np.linspace(0.0, 0.1, 201)
    points, normals = np.column_stack([x, 0 * x, 0 * x]), np.tile([0.0, 0.0, 1.0], (201, 1))
    lean = 0.4 * np.tanh((x - 0.05) / 2e-3)
    axes = np.column_stack([np.sin(lean), 0 * x, -np.cos(lean)])
    path = time_path(points, normals, np.full(201, FEED), np.full(201, 8.0), DOWN, acceleration=ACCELERATION, axes=axes)
    # At the feed it would be 8 rad/s; the rest over the limit is from the spacing of the points.
    assert np.linalg.norm(path.v[:, 3:], axis=1).max() < 1.2 * TURN_RATE


def test_stiffness_along_the_path_reaches_the_reference() -> None:
    points, normals = over_a_ridge(0.03)
    level, share = np.ones(len(points)), np.linspace(1.0, 0.25, len(points))
    path = time_path(points, normals, FEED * level, 8.0 * level, DOWN, acceleration=ACCELERATION, stiffness=share)
    source = SurfacePath(path=path.with_ramp(0.5, 0.5))
    source.reset(ARM)
    assert source.at(after(0.3)).stiffness == 1.0
    middle = source.at(after(1.0 + 0.5 * path.duration))
    assert middle.stiffness == pytest.approx(0.625, abs=0.02)
    assert source.at(after(1.0 + path.duration)).stiffness == pytest.approx(0.25)


def test_stiffness_is_whole_where_a_path_says_nothing() -> None:
    source = SurfacePath(path=PATH)
    source.reset(ARM)
    assert source.at(after(0.5)).stiffness == 1.0
