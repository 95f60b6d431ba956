from __future__ import annotations

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.control import Impedance
from burnish.core import Array, State
from burnish.experiments import b_5_1_1, b_5_2_1, payload, pushed, thesis_b
from burnish.model.model import Model
from burnish.sim.arms import ideal
from burnish.sim.robot import HOME
from burnish.trials.experiment import Experiment, links_only
from burnish.trials.record import Record
from burnish.trials.run import run

ARM = Model.jaco2().at(State(t=0.0, q=HOME, dq=np.zeros(6)))
NAMES = [f"b_5_{part}_{n}" for part in (1, 2) for n in range(1, 8)]


def wanted(schedule: object, t: float) -> Array:
    return schedule.at(replace(ARM, t=t)).q  # type: ignore[attr-defined, no-any-return]


def test_simulated_schedule_hits_the_way_points_of_the_thesis() -> None:
    schedule = b_5_1_1.joint_schedule(b_5_1_1.CANDLE, b_5_1_1.AMPLITUDE)
    schedule.reset(ARM)
    pi = np.full(6, np.pi)
    for t, q in ((4.0, HOME), (10.0, 0.5 * (HOME + pi)), (15.0, pi), (20.0, pi), (80.0, pi), (95.0, HOME)):
        assert_allclose(wanted(schedule, t), q, atol=1e-9)
    # A quarter of a period of 10 s after 20 s.
    assert_allclose(wanted(schedule, 22.5), pi + np.pi / 4.0, atol=1e-9)
    assert_allclose(wanted(schedule, 77.5), pi - np.pi / 4.0, atol=1e-9)


def test_schedule_of_the_robot_hits_the_way_points_of_the_thesis() -> None:
    schedule = b_5_1_1.joint_schedule(b_5_2_1.REACH, b_5_2_1.AMPLITUDE)
    schedule.reset(ARM)
    there = np.array([4.8046852, np.pi, np.pi / 2.0, 4.2031852, 1.4458, 1.3233])
    assert_allclose(wanted(schedule, 20.0), there, atol=1e-9)
    assert_allclose(np.degrees(wanted(schedule, 22.5) - there), [30.0, 9.0, 9.0, 9.0, 9.0, 30.0], atol=1e-9)
    assert_allclose(wanted(schedule, 95.0), HOME, atol=1e-9)


def test_law_of_the_robots_joints_leaves_the_mass_matrix_out_of_the_wrist() -> None:
    law = b_5_2_1.PartlyComputedTorque(kp=np.full(6, 2.0), kd=np.zeros(6))
    schedule = b_5_1_1.joint_schedule(HOME, np.zeros(6))
    schedule.reset(ARM)
    off = schedule.at(ARM)
    tau = law.torque(ARM, replace(off, q=off.q + 0.1)) - ARM.g
    assert_allclose(tau[3:], 0.2)
    assert_allclose(tau[:3], ARM.M[:3, :3] @ np.full(3, 0.2))


def test_prediction_of_one_degree_of_freedom_is_the_closed_form() -> None:
    t = np.arange(0.0, pushed.DURATION, 1e-3)
    m, k, d = 2.0, 100.0, 8.0
    x = pushed.predicted(m * np.eye(6), np.full(6, k), np.full(6, d), t)
    on = (t >= pushed.FROM) & (t < pushed.TO)
    s, w, z = t[on] - t[on][0], np.sqrt(k / m), d / (2.0 * np.sqrt(k * m))
    wd = w * np.sqrt(1.0 - z**2)
    step = 1.0 - np.exp(-z * w * s) * (np.cos(wd * s) + z * w / wd * np.sin(wd * s))
    assert_allclose(x[on], np.outer(step, pushed.PUSH / k), atol=1e-9)


def test_push_that_is_answered_otherwise_than_predicted_is_noticed() -> None:
    law = thesis_b.impedance(thesis_b.TABLE_5_3)
    trial = pushed.pushed_trial("soft", law, ideal(0), links_only())
    record = run(replace(trial, duration=3.5))
    assert all(finding.holds for finding in pushed.judge_push(record, thesis_b.TABLE_5_3))
    stiffer = replace(thesis_b.TABLE_5_3, k=tuple(1.5 * k for k in thesis_b.TABLE_5_3.k))
    assert not any(finding.holds for finding in pushed.judge_push(record, stiffer))


def test_gain_of_table_5_4_is_unstable_on_links_alone_and_stable_with_a_little_rotor_inertia() -> None:
    geared = thesis_b.mended()
    law = thesis_b.force_sensing(thesis_b.TABLE_5_4)
    bare = replace(thesis_b.operated("bare", law, ideal(0), links_only()), duration=1.5)
    mended = replace(bare, arm=geared, model=links_only().with_armature(geared.armature))
    assert run(bare).stopped is not None
    assert run(mended).stopped is None


def test_sine_that_is_off_is_judged_as_off() -> None:
    record = Record(model=links_only())
    record.t = np.arange(0.0, 90.0, 1.0).tolist()
    record.joint_error = [np.full(6, 1e-3)] * 90
    assert b_5_1_1.judge_sine(record, "thesis").holds
    record.joint_error = [np.full(6, 1e-3 if t < 40.0 else 3e-3) for t in record.t]
    assert not b_5_1_1.judge_sine(record, "thesis").holds


def test_payload_that_is_not_learnt_in_time_is_judged_as_missed() -> None:
    trials = {trial.name: trial for trial in payload.trials()}
    t = np.arange(0.0, payload.DURATION, 0.01)

    def off(metres: float) -> Record:
        record = Record(model=links_only())
        record.t, record.p_d = t.tolist(), [np.zeros(3)] * len(t)
        record.p = [np.array([0.0, 0.0, metres])] * len(t)
        return record

    records = {name: off(0.001 if "adaptive" in name else 0.03) for name in trials}
    assert all(finding.holds for finding in payload.judge(records))
    records["honest 2, +1 kg, adaptive"] = off(0.003)
    assert [finding.holds for finding in payload.judge(records)] == [True, True, False, True]


@pytest.mark.parametrize("name", NAMES)
def test_trials_of_an_experiment_have_names_of_their_own_and_ours_is_among_them(name: str) -> None:
    experiment = import_module(f"burnish.experiments.{name}").EXPERIMENT
    assert isinstance(experiment, Experiment)
    trials = experiment.trials()
    assert len({trial.name for trial in trials}) == len(trials)
    assert {trial.ours for trial in trials} == {True, False}


@pytest.mark.parametrize("name", ["b_5_1_1", "b_5_2_1", "b_5_2_3", "b_5_2_6", "b_5_2_7"])
def test_a_moment_of_each_kind_of_trial_can_be_judged(name: str) -> None:
    experiment = import_module(f"burnish.experiments.{name}").EXPERIMENT
    records = {trial.name: run(replace(trial, duration=0.1)) for trial in experiment.trials()}
    assert all(record.stopped is None for record in records.values())


def test_unloaded_impedance_stands() -> None:
    trial = pushed.pushed_trial("still", Impedance(stiffness=100.0, damping=2.0), ideal(0), links_only())
    record = run(replace(trial, duration=0.3))
    assert np.abs(pushed.deflection(record)).max() < 1e-9
