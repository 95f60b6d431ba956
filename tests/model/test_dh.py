from __future__ import annotations

import json
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from burnish.core import Array
from burnish.errors import InputError
from burnish.model.dh import DHChain, jaco2_dh, jaco2_link_frames, skew
from burnish.model.model import JACO2_URDF

ORACLE = json.loads((Path(__file__).parent.parent / "data" / "jaco2_oracle.json").read_text())
HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
X0 = np.array([0.212444, -0.257293, 0.506643, 1.65789, 1.11875, 0.113634])
"""Thesis A, eq 5.2: the tool pose that was read from the arm at home [m, rad intrinsic XYZ]."""


def random_q(seed: int, count: int) -> Array:
    return np.random.default_rng(seed).uniform(-2 * np.pi, 2 * np.pi, (count, 6))


def description_frames(q: Array) -> dict[str, Array]:
    """Frames of the JACO2's description by a reading of its own: child link → (4, 4)."""
    frames = {"link_base": np.eye(4)}
    for joint in ElementTree.parse(JACO2_URDF).getroot().findall("joint"):
        names = {tag: element.get("link") for tag in ("parent", "child") if (element := joint.find(tag)) is not None}
        origin, axis = joint.find("origin"), joint.find("axis")
        assert origin is not None
        T = np.eye(4)
        T[:3, 3] = [float(x) for x in origin.get("xyz", "0 0 0").split()]
        T[:3, :3] = Rotation.from_euler("xyz", [float(x) for x in origin.get("rpy", "0 0 0").split()]).as_matrix()
        if axis is not None and joint.get("type") != "fixed":
            along = np.array([float(x) for x in axis.get("xyz", "").split()])
            T[:3, :3] = T[:3, :3] @ Rotation.from_rotvec(along * q[len(frames) - 1]).as_matrix()
        frames[str(names["child"])] = frames[str(names["parent"])] @ T
    return frames


@pytest.mark.parametrize("sample", ORACLE["samples"])
def test_pose_jacobian_and_its_rate_equal_the_engines(sample: dict[str, Any]) -> None:
    chain, q, dq = jaco2_dh(), np.array(sample["q"]), np.array(sample["qd"])
    np.testing.assert_allclose(chain.at(q).T[-1], sample["T"], atol=1e-12)
    np.testing.assert_allclose(chain.jacobian(q), sample["J"], atol=1e-12)
    np.testing.assert_allclose(chain.J_dot_dq(q, dq), sample["Jdot_qd"], atol=1e-12)


@pytest.mark.parametrize("name", ORACLE["named"])
def test_named_poses_equal_the_engines(name: str) -> None:
    pose = ORACLE["named"][name]
    np.testing.assert_allclose(jaco2_dh().at(np.array(pose["q"])).T[-1], pose["T"], atol=1e-12)
    np.testing.assert_allclose(jaco2_dh().jacobian(np.array(pose["q"])), pose["J"], atol=1e-12)


def test_home_is_the_published_pose() -> None:
    tool = jaco2_dh().at(HOME)
    euler = Rotation.from_matrix(tool.R).as_euler("XYZ")
    np.testing.assert_allclose(tool.p, [0.212780, -0.256651, 0.506914], atol=0.5e-6)  # to the printed digit
    np.testing.assert_allclose(euler, [1.652677, 1.116417, 0.120562], atol=0.5e-6)


def test_home_is_near_the_pose_that_thesis_a_read_from_the_arm() -> None:
    tool = jaco2_dh().at(HOME)
    assert np.linalg.norm(tool.p - X0[:3]) < 1e-3
    turn = Rotation.from_euler("XYZ", X0[3:]) * Rotation.from_matrix(tool.R).inv()
    assert np.rad2deg(turn.magnitude()) < 0.3


def test_tool_is_the_end_effector_of_the_description() -> None:
    worst = max(np.abs(jaco2_dh().at(q).T[-1] - description_frames(q)["end_effector"]).max() for q in random_q(1, 1000))
    assert worst < 1e-12


def test_link_frames_of_the_description_sit_still_in_the_dh_frames() -> None:
    fixed = jaco2_link_frames()
    for q in random_q(2, 50):
        T, frames = jaco2_dh().at(q).T, description_frames(q)
        for i in range(1, 7):
            np.testing.assert_allclose(T[i] @ fixed[i - 1], frames[f"link_{i}"], atol=1e-12)


def test_reading_table_3_3_as_it_is_headed_would_put_the_tool_elsewhere() -> None:
    chain = jaco2_dh()
    craig = replace(chain, alpha=np.roll(chain.alpha, 1), a=np.roll(chain.a, 1))
    assert max(np.linalg.norm(craig.at(q).p - chain.at(q).p) for q in random_q(3, 100)) > 0.5


def test_jacobian_is_the_derivative_of_the_pose() -> None:
    chain, step = jaco2_dh(), 1e-6
    for q in random_q(4, 20):
        J = chain.jacobian(q)
        for i in range(6):
            dq = step * np.eye(6)[i]
            after, before = chain.at(q + dq), chain.at(q - dq)
            turn = Rotation.from_matrix(after.R @ before.R.T).as_rotvec()
            column = np.concatenate((after.p - before.p, turn)) / (2 * step)
            np.testing.assert_allclose(J[:, i], column, atol=1e-8)  # a central difference: step² and rounding/step


def test_mixed_jacobian_has_its_angular_rows_in_tool_axes() -> None:
    for q in random_q(5, 20):
        pose, J, mixed = jaco2_dh().at(q), jaco2_dh().jacobian(q), jaco2_dh().mixed_jacobian(q)
        np.testing.assert_array_equal(mixed[:3], J[:3])
        np.testing.assert_allclose(pose.R @ mixed[3:], J[3:], atol=1e-14)
        # The last joint turns the tool about its own z, backwards, wherever the tool points.
        np.testing.assert_allclose(mixed[3:, 5], [0, 0, -1], atol=1e-14)


@pytest.mark.parametrize("link", [1, 3, 6])
def test_jacobian_gradient_is_the_derivative_of_the_jacobian_of_a_point_on_any_link(link: int) -> None:
    chain, step = jaco2_dh(), 1e-6
    local = np.array([0.02, -0.05, 0.11, 1.0])

    def jacobian(q: Array) -> Array:
        pose = chain.at(q)
        return pose.jacobian((pose.T[link] @ local)[:3], link)

    for q in random_q(6, 10):
        pose = chain.at(q)
        gradient = pose.jacobian_gradient((pose.T[link] @ local)[:3], link)
        for j in range(6):
            dq = step * np.eye(6)[j]
            np.testing.assert_allclose(gradient[:, :, j], (jacobian(q + dq) - jacobian(q - dq)) / (2 * step), atol=1e-8)


def test_skew_is_the_cross_product() -> None:
    a, b = np.random.default_rng(7).normal(size=(2, 5, 3))
    np.testing.assert_allclose((skew(a) @ b[:, :, None])[..., 0], np.cross(a, b), atol=1e-15)


def test_table_with_a_missing_number_or_a_strange_sign_is_refused() -> None:
    chain = jaco2_dh()
    with pytest.raises(InputError, match="one length"):
        replace(chain, d=np.zeros(5))
    with pytest.raises(InputError, match="finite"):
        replace(chain, d=np.full(6, np.nan))
    with pytest.raises(InputError, match="sign"):
        replace(chain, theta_sign=np.zeros(6))
    with pytest.raises(ValueError, match="read-only"):
        DHChain(**vars(chain)).d[0] = 1.0
