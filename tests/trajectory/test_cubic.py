from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.core import Array, Dynamics, State
from burnish.errors import InputError
from burnish.model.model import Model
from burnish.rotation import exp, log
from burnish.trajectory import Cubic, CubicPose
from burnish.trajectory.cubic import cubic

HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
START = 3.5
"""When the motion begins: not at zero."""
ARM = Model.jaco2().at(State(t=START, q=HOME, dq=np.zeros(6)))
TURN = np.array([0.4, -0.7, 1.1])


def after(t: float) -> Dynamics:
    return replace(ARM, t=START + t)


@pytest.fixture
def joints() -> Cubic:
    source = Cubic(q=HOME + np.arange(6.0) - 2.0, duration=2.0)
    source.reset(ARM)
    return source


@pytest.fixture
def pose() -> CubicPose:
    source = CubicPose(p=ARM.p + [0.1, -0.2, 0.05], R=exp(TURN) @ ARM.R, duration=2.0)
    source.reset(ARM)
    return source


def test_share_is_the_cubic_from_rest_to_rest() -> None:
    # The one cubic with these four values, by its linear equations.
    T = 1.7
    rows: Array = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [1, T, T**2, T**3], [0, 1, 2 * T, 3 * T**2]], dtype=float)
    c = np.linalg.solve(rows, [0.0, 0.0, 1.0, 0.0])
    for t in np.linspace(0.01, 1.69, 20):
        share, speed, acceleration = cubic(t / T, T)
        assert share == pytest.approx(c @ [1.0, t, t**2, t**3])
        assert speed == pytest.approx(c @ [0.0, 1.0, 2 * t, 3 * t**2])
        assert acceleration == pytest.approx(c @ [0.0, 0.0, 2.0, 6 * t])


@pytest.mark.parametrize("s", [-1.0, 0.0, 1.0, 2.0])
def test_share_stands_still_outside_the_motion(s: float) -> None:
    assert cubic(s, 2.0) == (float(s >= 1.0), 0.0, 0.0)


def test_joints_go_from_where_they_are_to_the_goal(joints: Cubic) -> None:
    assert_allclose(joints.at(after(0.0)).q, HOME, atol=0.0)
    for t in (2.0, 5.0):
        assert_allclose(joints.at(after(t)).q, joints.q, atol=1e-15)
        assert not joints.at(after(t)).dq.any()


def test_joints_are_half_way_at_half_time(joints: Cubic) -> None:
    assert_allclose(joints.at(after(1.0)).q, 0.5 * (HOME + joints.q), atol=1e-14)


def test_joints_have_arrived_when_the_time_is_over(joints: Cubic) -> None:
    assert not joints.arrived(after(1.999))
    assert joints.arrived(after(2.0))


def test_tool_goes_from_where_it_is_to_the_goal(pose: CubicPose) -> None:
    first, last = pose.at(after(0.0)), pose.at(after(2.0))
    assert_allclose(first.p, ARM.p, atol=0.0)
    assert_allclose(first.R, ARM.R, atol=1e-15)
    assert_allclose(last.p, pose.p, atol=1e-15)
    assert_allclose(last.R, pose.R, atol=1e-14)


def test_tool_goes_straight_and_turns_about_one_axis(pose: CubicPose) -> None:
    way = pose.p - ARM.p
    for t in np.linspace(0.1, 1.9, 10):
        wanted = pose.at(after(t))
        share = float(way @ (wanted.p - ARM.p) / (way @ way))
        assert_allclose(wanted.p, ARM.p + share * way, atol=1e-14)
        # The same share of the turn as of the way.
        assert_allclose(log(wanted.R @ ARM.R.T), share * TURN, atol=1e-13)


def test_tool_has_arrived_when_the_time_is_over(pose: CubicPose) -> None:
    assert not pose.arrived(after(1.999))
    assert pose.arrived(after(2.0))


@pytest.mark.parametrize("duration", [0.0, -1.0, np.nan, np.inf])
def test_duration_that_is_none_is_refused(duration: float) -> None:
    with pytest.raises(InputError, match="duration"):
        Cubic(q=HOME, duration=duration)
    with pytest.raises(InputError, match="duration"):
        CubicPose(p=np.zeros(3), R=np.eye(3), duration=duration)
