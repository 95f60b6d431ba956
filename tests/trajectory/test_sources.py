"""What every source of references must keep, whatever else it does."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.core import Array, Dynamics, JointReference, Source, State, ToolReference
from burnish.model.model import Model
from burnish.rotation import exp
from burnish.trajectory import Cubic, CubicPose, Descend, Hold, HoldPose, Sine, SurfacePath
from burnish.trajectory.path import time_path

HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
MODEL = Model.jaco2()
START = 2.25


def arm_at(q: Array, t: float = START) -> Dynamics:
    return MODEL.at(State(t=t, q=q, dq=np.zeros(6)))


def surface_path() -> SurfacePath:
    x = np.linspace(0.0, 0.1, 101)
    points = np.column_stack([x, 0.02 * np.sin(20.0 * x), 0.3 + 0.5 * x**2])
    normals = np.column_stack([-x, 0.0 * x, np.ones(101)])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    path = time_path(
        points, normals, np.full(101, 0.03), np.full(101, 8.0), np.diag([1.0, -1.0, -1.0]), acceleration=0.3
    )
    return SurfacePath(path=path)


JOINT_SOURCES: dict[str, Callable[[], Source[JointReference]]] = {
    "Hold": Hold,
    "Cubic": partial(Cubic, q=HOME + np.arange(6.0), duration=2.0),
    "Sine": partial(Sine, amplitude=[0.3, 0.2, 0.1, -0.1, -0.2, -0.3], period=3.0),
}
TOOL_SOURCES: dict[str, Callable[[], Source[ToolReference]]] = {
    "HoldPose": HoldPose,
    "CubicPose": partial(CubicPose, p=np.array([0.2, -0.4, 0.4]), R=exp(np.array([1.0, 0.5, -2.0])), duration=2.0),
    "Descend": partial(Descend, direction=np.array([0.0, 0.6, -0.8]), R=np.eye(3), speed=0.02),
    "SurfacePath": surface_path,
}
INSTANTS = np.linspace(0.1, 1.9, 13)
"""Within every motion; on no node of the path."""
H = 1e-5
"""Half a central difference: 1e-11 of rounding over 1e-5, and third derivatives below 100 times 1e-10."""


def references(source: Source[Any], t: float, h: float = H) -> tuple[Any, Any, Any]:
    source.reset(arm_at(HOME))
    behind, now, ahead = (source.at(arm_at(HOME, t=START + x)) for x in (t - h, t, t + h))
    return behind, now, ahead


@pytest.mark.parametrize("name", JOINT_SOURCES)
def test_joint_speed_is_the_rate_of_the_position_and_acceleration_that_of_the_speed(name: str) -> None:
    for t in INSTANTS:
        behind, now, ahead = references(JOINT_SOURCES[name](), t)
        assert_allclose(now.dq, (ahead.q - behind.q) / (2.0 * H), atol=1e-7)
        assert_allclose(now.ddq, (ahead.dq - behind.dq) / (2.0 * H), atol=1e-7)


@pytest.mark.parametrize(
    ("name", "h", "tolerance"),
    [
        ("HoldPose", H, 1e-7),
        ("CubicPose", H, 1e-7),
        ("Descend", H, 1e-7),
        # Linear between nodes 5 ms apart: over two of them a difference is the mean of the speed to a fraction of
        # the change of the speed in that time, 0.3 m/s² times 5 ms.
        ("SurfacePath", 5e-3, 5e-4),
    ],
)
def test_tool_twist_is_the_rate_of_the_pose(name: str, h: float, tolerance: float) -> None:
    for t in INSTANTS:
        behind, now, ahead = references(TOOL_SOURCES[name](), t, h)
        S = (ahead.R - behind.R) @ now.R.T / (2.0 * h)
        assert_allclose(now.v[:3], (ahead.p - behind.p) / (2.0 * h), atol=tolerance)
        assert_allclose(
            now.v[3:], 0.5 * np.array([S[2, 1] - S[1, 2], S[0, 2] - S[2, 0], S[1, 0] - S[0, 1]]), atol=4 * tolerance
        )


@pytest.mark.parametrize("name", ["HoldPose", "CubicPose", "Descend"])
def test_tool_acceleration_is_the_rate_of_the_twist(name: str) -> None:
    for t in INSTANTS:
        behind, now, ahead = references(TOOL_SOURCES[name](), t)
        assert_allclose(now.a, (ahead.v - behind.v) / (2.0 * H), atol=1e-7)


@pytest.mark.parametrize("name", TOOL_SOURCES)
def test_tool_rotation_is_a_rotation(name: str) -> None:
    for t in INSTANTS:
        _, now, _ = references(TOOL_SOURCES[name](), t)
        assert_allclose(now.R @ now.R.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(now.R) > 0.0


@pytest.mark.parametrize("name", [*JOINT_SOURCES, *TOOL_SOURCES])
def test_source_starts_afresh_at_every_reset(name: str) -> None:
    source: Any = (JOINT_SOURCES | TOOL_SOURCES)[name]()  # type: ignore[operator]
    seen = []
    for start in (0.0, 7.5):
        source.reset(arm_at(HOME, t=start))
        wanted = source.at(arm_at(HOME, t=start + 0.73))
        seen.append(wanted.q if name in JOINT_SOURCES else np.concatenate([wanted.p, wanted.R.ravel(), wanted.v]))
    assert_allclose(seen[0], seen[1], atol=1e-9)
