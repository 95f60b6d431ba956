from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from burnish.experiments import comparison
from burnish.experiments.contenders import BETTER, CONTENDERS, HYBRIDS, PLAIN
from burnish.experiments.operator import DURATION, FIRST, LEG
from burnish.model.model import Model
from burnish.trials.record import Record
from burnish.trials.run import run

MODEL = Model.jaco2()
TRIALS = {trial.name: trial for trial in comparison.trials()}
NAMES = list(TRIALS)


def following_with(position: float, coupling: float) -> Record:
    """Off by a standing error [m], and moved and turned by a coupling [m, rad] in every excursion, at 20 Hz."""
    t = np.arange(0.0, DURATION, 0.05)
    swing = np.sin(2.0 * np.pi * np.mod(t - FIRST, LEG) / LEG)
    off = np.zeros((len(t), 3))
    off[:, 0], off[:, 1] = position, coupling * swing
    record = Record(model=MODEL)
    record.t, record.p_d, record.p = t.tolist(), [np.zeros(3)] * len(t), list(-off)
    record.turn, record.tau = list(np.column_stack([0.0 * t, 0.0 * t, coupling * swing])), [np.zeros(6)] * len(t)
    record.step_us = [20.0] * len(t)
    return record


def records(ours: float, hybrids: float, plain: float) -> dict[str, Record]:
    sizes = {
        name: ours if name.startswith(BETTER) else hybrids if name.startswith("Hybrid") else plain for name in NAMES
    }
    return {name: following_with(size, size) for name, size in sizes.items()}


def test_hybrids_that_couple_less_and_a_law_that_is_three_times_better_are_found() -> None:
    findings = [f for f in comparison.judge(records(0.001, 0.004, 0.010)) if f.holds is not None]
    assert len(findings) == 5
    assert all(finding.holds for finding in findings)


def test_hybrids_that_couple_more_and_a_law_that_is_hardly_better_are_found_out() -> None:
    findings = [f for f in comparison.judge(records(0.003, 0.012, 0.008)) if f.holds is not None]
    assert not any(finding.holds for finding in findings)


def test_law_that_was_stopped_on_one_seed_is_not_among_the_best() -> None:
    made = records(0.003, 0.001, 0.010)
    for name in HYBRIDS:
        made[f"{name}, thesis, honest 2"].stopped = "it shook"
    by_claim = {finding.claim: finding for finding in comparison.judge(made)}
    assert by_claim["Hybrid, thesis, honest arm."].measured.startswith("Stopped in 1 of its trials")
    better = [finding for finding in by_claim.values() if finding.claim.startswith(f"{BETTER} with rotors")]
    assert [finding.holds for finding in better] == [True] * 3


def test_every_law_is_tried_on_every_arm() -> None:
    assert len(comparison.trials()) == len(TRIALS)
    for contender in CONTENDERS:
        if contender.ours is not None:
            assert f"{contender.name}, ours, ideal" in NAMES
        for gains in [gains for gains in ("theirs", "ours") if getattr(contender, gains) is not None]:
            label = "thesis" if gains == "theirs" else gains
            assert all(f"{contender.name}, {label}, honest {seed}" in NAMES for seed in (1, 2, 3))
    assert {c.name for c in CONTENDERS} >= {*HYBRIDS, *PLAIN, BETTER}


@pytest.mark.parametrize("law", ["ComputedTorque", "Hybrid", "OperationalSpace"])
def test_a_moment_of_a_trial_runs(law: str) -> None:
    trial = TRIALS[f"{law}, ours, honest 1"]
    record = run(replace(trial, duration=0.1))
    assert record.stopped is None
    assert len(record.t) >= 9
