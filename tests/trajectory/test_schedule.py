from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.core import Dynamics, State
from burnish.errors import InputError
from burnish.model.model import Model
from burnish.rotation import exp, log
from burnish.trajectory import Cubic, Hold, HoldPose, Move, Schedule

HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
START = 3.5
"""When it begins: not at zero."""
ARM = Model.jaco2().at(State(t=START, q=HOME, dq=np.zeros(6)))
WAY, TURN = np.array([0.1, -0.05, 0.02]), np.array([0.3, -0.6, 0.2])
H = 1e-5
"""Half a central difference: 1e-11 of rounding over 1e-5, and third derivatives below 100 times 1e-10."""


def after(t: float) -> Dynamics:
    return replace(ARM, t=START + t)


def moves() -> Schedule:
    schedule = Schedule(
        parts=[(1.0, HoldPose()), (2.0, Move(way=WAY, turn=TURN, duration=2.0)), (1.0, Move(turn=-TURN, duration=1.0))]
    )
    schedule.reset(ARM)
    return schedule


def test_each_part_starts_where_the_reference_has_come_to() -> None:
    schedule = moves()
    assert_allclose(schedule.at(after(0.99)).p, ARM.p)
    assert_allclose(schedule.at(after(3.0)).p, ARM.p + WAY, atol=1e-12)
    assert_allclose(schedule.at(after(3.0)).R, exp(TURN) @ ARM.R, atol=1e-12)
    assert_allclose(schedule.at(after(4.0)).R, ARM.R, atol=1e-12)


def test_last_part_goes_on() -> None:
    assert_allclose(moves().at(after(100.0)).p, ARM.p + WAY, atol=1e-12)


def test_joints_are_scheduled_as_the_tool_is() -> None:
    schedule = Schedule(parts=[(1.0, Hold()), (1.0, Cubic(q=HOME + 1.0, duration=1.0)), (1.0, Hold())])
    schedule.reset(ARM)
    for t, q in ((0.5, HOME), (1.5, HOME + 0.5), (2.5, HOME + 1.0)):
        assert_allclose(schedule.at(after(t)).q, q, atol=1e-12)
    assert schedule.duration == 3.0


@pytest.mark.parametrize("t", np.linspace(0.05, 3.95, 27))
def test_twist_and_acceleration_are_the_rates_of_the_pose(t: float) -> None:
    behind, now, ahead = (moves().at(after(t + x)) for x in (-H, 0.0, H))
    assert_allclose(now.v[:3], (ahead.p - behind.p) / (2.0 * H), atol=1e-7)
    assert_allclose(now.v[3:], log(ahead.R @ behind.R.T) / (2.0 * H), atol=1e-7)
    assert_allclose(now.a, (ahead.v - behind.v) / (2.0 * H), atol=1e-7)


@pytest.mark.parametrize("joint", [1.0, 3.0, 4.0])
def test_nothing_jumps_where_two_moves_meet(joint: float) -> None:
    # 1e-6 s from rest a motion of least jerk has an acceleration of at most 60 · 0.7 · 1e-6.
    before, behind = (moves().at(after(joint + x)) for x in (-1e-6, 1e-6))
    for name in ("p", "R", "v", "a"):
        assert_allclose(getattr(before, name), getattr(behind, name), atol=1e-4)


def test_schedule_and_move_that_make_no_sense_are_refused() -> None:
    for build in (
        lambda: Schedule(parts=[]),
        lambda: Schedule(parts=[(0.0, HoldPose())]),
        lambda: Schedule(parts=[(np.inf, HoldPose())]),
        lambda: Move(duration=0.0),
        lambda: Move(way=np.array([np.nan, 0.0, 0.0]), duration=1.0),
        lambda: Move(way=np.zeros(2), duration=1.0),
    ):
        with pytest.raises(InputError):
            build()
