"""Distances of the arm from a mould, against another library and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from burnish.check.collision import (
    SLACK,
    Part,
    arm_parts,
    least_between,
    least_to_floor,
    least_to_obstacle,
    mould_obstacles,
    tool_parts,
)
from burnish.core import Array
from burnish.model.model import Model
from burnish.model.tool import PolishingTool
from burnish.polish.cell import READY, TURN, Placement
from burnish.runtime.limits import Limits
from burnish.surface import Mould

DOME = Mould.load("dome")
STANDS = Placement(p=np.array([0.0, -0.34, 0.2]), R=TURN)


def walk(count: int, seed: int) -> Array:
    """Both ends of a rod of 0.1 m along a random way above the dome, (K, 2, 3)."""
    rng = np.random.default_rng(seed)
    middle = np.cumsum(rng.normal(0.0, 4e-3, (count, 3)), axis=0) + [0.0, -0.34, 0.32]
    lean = np.cumsum(rng.normal(0.0, 0.02, (count, 3)), axis=0) + [0.0, 0.3, 1.0]
    lean *= 0.05 / np.linalg.norm(lean, axis=1, keepdims=True)
    return np.stack([middle - lean, middle + lean], axis=1)


@pytest.mark.parametrize("seed", [0, 1])
def test_least_distance_to_a_mould_is_that_of_another_library(seed: int) -> None:
    ball = Mould.of("ball", np.asarray(trimesh.creation.icosphere(2, 0.05).triangles))
    ends, radius = walk(60, seed) + [0.0, 0.0, 0.1], 0.02
    mesh = trimesh.Trimesh(STANDS.points(ball.vertices), ball.faces, process=False)
    along = np.linspace(0.0, 1.0, 41)[None, :, None]
    points = ends[:, None, 0] + along * (ends[:, None, 1] - ends[:, None, 0])
    _, away, _ = trimesh.proximity.closest_point(mesh, points.reshape(-1, 3))
    mould = mould_obstacles(ball, STANDS)[0]
    found = least_to_obstacle(Part(name="rod", ends=ends, radius=radius), mould, far=1.0)
    # The rod is sampled every 2.5 mm: at 20 mm and more from it that is 0.04 mm.
    assert found.distance == pytest.approx(away.min() - radius, abs=SLACK + 1e-4)
    assert not found.or_more


def test_part_that_is_far_away_is_not_measured() -> None:
    mould = mould_obstacles(DOME, STANDS)[0]
    found = least_to_obstacle(Part(name="rod", ends=walk(5, 0) + [0.0, 0.0, 1.0], radius=0.02), mould, far=0.03)
    assert found.or_more
    assert found.distance == 0.03


def test_part_through_the_mould_is_in_it() -> None:
    ends = np.array([[[0.0, -0.34, 0.3], [0.0, -0.34, 0.1]]])
    found = least_to_obstacle(Part(name="rod", ends=ends, radius=0.02), mould_obstacles(DOME, STANDS)[0], far=1.0)
    assert found.distance == pytest.approx(-0.02)


def test_sphere_above_the_stand_has_the_height_of_a_closed_form() -> None:
    stand = mould_obstacles(DOME, STANDS)[1]
    beside = np.array([0.0, -0.34, 0.2]) + TURN @ [0.065, 0.0, 0.03]
    sphere = Part(name="tip", ends=np.array([[beside, beside]]), radius=0.01)
    assert least_to_obstacle(sphere, stand, far=1.0).distance == pytest.approx(0.02, abs=1e-6)


def test_two_parts_are_as_far_apart_as_their_closest_pose() -> None:
    still = np.tile([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]], (50, 1, 1)).reshape(50, 2, 3)
    height = np.abs(np.linspace(-0.3, 0.2, 50)) + 0.05
    moving = still + np.column_stack((np.zeros(50), np.zeros(50), height))[:, None]
    found = least_between(Part(name="a", ends=still, radius=0.01), Part(name="b", ends=moving, radius=0.02), far=1.0)
    assert found.distance == pytest.approx(height.min() - 0.03, abs=SLACK)
    assert found.pose == pytest.approx(np.argmin(height), abs=1)


def test_floor_is_the_plane_of_the_base() -> None:
    ends = np.array([[[0.0, 0.0, 0.3], [0.0, 0.0, 0.2]], [[0.0, 0.0, 0.15], [0.0, 0.0, 0.2]]])
    found = least_to_floor(Part(name="rod", ends=ends, radius=0.02), far=1.0)
    assert found.distance == pytest.approx(0.13)
    assert found.pose == 1


def test_parts_of_the_arm_are_where_its_model_has_its_links() -> None:
    """The wrist's capsule begins at joint 5 and ends at joint 6, whose frames the model knows."""
    tool = PolishingTool()
    model, limits = tool.on(Model.jaco2()), Limits.jaco2()
    q = READY + np.random.default_rng(0).uniform(-0.5, 0.5, (20, 6))
    poses = [model.kinematics(one) for one in q]
    p, R = np.array([pose[0] for pose in poses]), np.array([pose[1] for pose in poses])
    zero, parts = model.link_poses(np.zeros(6)), arm_parts(limits, q, p)
    for k, one in enumerate(q):
        now = model.link_poses(one)
        for row, part in zip(limits.capsules[1:], parts[1:], strict=True):
            move = now[f"link_{int(row[0])}"] @ np.linalg.inv(zero[f"link_{int(row[0])}"])
            np.testing.assert_allclose(part.ends[k, 0], move[:3, :3] @ row[1:4] + move[:3, 3], atol=1e-9)
    np.testing.assert_allclose(parts[-1].ends[:, 1], p, atol=1e-12)
    body, tip = tool_parts(tool, p, R)
    np.testing.assert_allclose(tip.ends[:, 0] + tool.tip_radius * R[:, :, 2], p, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(body.ends[:, 0] - p, axis=1), tool.length, atol=1e-12)
