from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.core import Array, Dynamics, State
from burnish.experiments.joint_motion import JointMotion
from burnish.experiments.operator import (
    AXES,
    DURATION,
    FIRST,
    LEG,
    MOVE,
    REST,
    TURN,
    WAY,
    following,
    operator_motion,
)
from burnish.model.model import Model
from burnish.rotation import exp, log
from burnish.sim.robot import HOME
from burnish.trials.record import Record

MODEL = Model.jaco2()
ARM = MODEL.at(State(t=0.0, q=HOME, dq=np.zeros(6)))


def after(t: float) -> Dynamics:
    return replace(ARM, t=t)


def record(p_off: Array | None = None, turn: Array | None = None) -> Record:
    """A law that follows but for an offset of its position and its orientation, (N, 3) each, on 100 Hz."""
    made = Record(model=MODEL)
    t = np.arange(0.0, DURATION, 0.01)
    source = operator_motion()
    source.reset(ARM)
    p_d = [source.at(after(now)).p for now in t]
    none = np.zeros((len(t), 3))
    made.t, made.p_d = t.tolist(), p_d
    made.p = list(np.asarray(p_d) - (none if p_off is None else p_off))
    made.turn = list(none if turn is None else turn)
    made.tau, made.step_us = [np.zeros(6)] * len(t), [20.0] * len(t)
    return made


def leg_of(t: Array) -> Array:
    return np.asarray(np.floor((t - FIRST) / LEG))


def test_operator_goes_along_and_about_each_axis_and_comes_back() -> None:
    source = operator_motion()
    source.reset(ARM)
    for leg in range(7):
        out = source.at(after(FIRST + leg * LEG + MOVE + 0.5 * REST))
        assert_allclose(np.concatenate([out.p - ARM.p, log(out.R @ ARM.R.T)]), AXES[leg], atol=1e-12)
        assert_allclose(out.v, 0.0)
        home = source.at(after(FIRST + (leg + 1) * LEG - 0.01))
        assert_allclose(home.p, ARM.p, atol=1e-12)
        assert_allclose(home.R, ARM.R, atol=1e-12)


def test_operator_is_no_faster_than_thesis_a_lets_one_be() -> None:
    source = operator_motion()
    source.reset(ARM)
    twists = np.array([source.at(after(t)).v for t in np.arange(0.0, DURATION, 0.01)])
    assert np.linalg.norm(twists[:, :3], axis=1).max() < 0.2
    assert np.linalg.norm(twists[:, 3:], axis=1).max() < 1.0
    # The peak of least jerk is 1.875 times the mean.
    assert_allclose(np.abs(twists).max(axis=0), 1.875 / MOVE * np.repeat([WAY, TURN], 3), rtol=1e-3)


def test_joints_of_the_motion_reach_the_same_poses_with_the_same_twist() -> None:
    motion, source = JointMotion(source=operator_motion(), model=MODEL), operator_motion()
    motion.reset(ARM)
    source.reset(ARM)
    step = 0.01
    last = motion.at(after(FIRST))
    for t in FIRST + np.arange(step, MOVE, step):
        now, wanted = motion.at(after(t)), source.at(after(t))
        p, R, J = MODEL.kinematics(now.q)
        assert_allclose(p, wanted.p, atol=1e-9)
        assert_allclose(R, wanted.R, atol=1e-9)
        assert_allclose(J @ now.dq, wanted.v, atol=1e-9)
        # The trapezoidal rule is off by step³/12 times the third derivative, below 10 rad/s³.
        assert_allclose(now.dq - last.dq, 0.5 * step * (now.ddq + last.ddq), atol=1e-5)
        last = now


def test_perfect_law_has_no_error_and_no_coupling() -> None:
    f = following(record())
    assert f.position_mm == f.orientation_deg == f.steady_mm == f.moved_mm == f.turned_deg == f.settling_s == 0.0
    assert f.step_us == 20.0


def test_coupling_into_the_position_is_what_moves_while_only_turns_are_asked_for() -> None:
    t = np.arange(0.0, DURATION, 0.01)
    leg = leg_of(t)
    swing = np.sin(2.0 * np.pi * np.mod(t - FIRST, LEG) / LEG)
    # 4 mm of amplitude while it turns; a standing offset and an error elsewhere do not count.
    off = np.zeros((len(t), 3))
    off[:, 1] = 0.004 * swing * ((leg >= 3) & (leg < 6)) + 0.05 * (leg == 1) + 0.01
    f = following(record(p_off=off))
    assert f.moved_mm == pytest.approx(4.0 / np.sqrt(2.0), rel=1e-2)
    assert f.turned_deg == 0.0


def test_coupling_into_the_orientation_is_what_turns_while_only_ways_are_asked_for() -> None:
    t = np.arange(0.0, DURATION, 0.01)
    turn = np.zeros((len(t), 3))
    turn[:, 2] = 0.01 * np.sin(2.0 * np.pi * np.mod(t - FIRST, LEG) / LEG) * (leg_of(t) < 3)
    f = following(record(turn=turn))
    assert f.turned_deg == pytest.approx(np.rad2deg(0.01) / np.sqrt(2.0), rel=1e-2)
    assert f.moved_mm == 0.0


def test_settling_is_the_time_until_the_tool_stays_within_a_millimetre() -> None:
    t = np.arange(0.0, DURATION, 0.01)
    resting = np.mod(t - FIRST, 0.5 * LEG) - MOVE
    off = np.zeros((len(t), 3))
    off[:, 0] = 0.01 * np.exp(-np.maximum(resting, 0.0) / 0.1) * (resting >= 0.0) * (t >= FIRST)
    # 10 mm fall to 1 mm in 0.1 s · ln 10.
    assert following(record(p_off=off)).settling_s == pytest.approx(0.1 * np.log(10.0), abs=0.015)


def test_rotation_of_the_operator_is_about_base_axes() -> None:
    source = operator_motion()
    source.reset(ARM)
    out = source.at(after(FIRST + 3 * LEG + MOVE))
    assert_allclose(out.R, exp(np.array([TURN, 0.0, 0.0])) @ ARM.R, atol=1e-12)
