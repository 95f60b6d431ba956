"""What is written of a result: plain values, tables and a page."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np

from burnish.control import Adaptive, DampingRatio, Impedance, OperationalSpace
from burnish.experiments.thesis_a import with_rotors
from burnish.rotation import quaternion_error
from burnish.sim import arms
from burnish.trajectory import HoldPose
from burnish.trials.experiment import Experiment, Finding, Trial, nominal
from burnish.trials.outcome import arm_name, gains, outcome
from burnish.trials.plots import errors_svg
from burnish.trials.report import reproduction_html
from burnish.trials.run import run
from burnish.trials.tables import as_markdown, score

LAW = OperationalSpace.at_frequency(15.0)
HOLD = Trial(
    name="holds & <waits>",
    law=LAW,
    source=HoldPose(),
    duration=0.2,
    arm=arms.honest(0),
    model=nominal(arms.honest(0)),
)
TRIALS = (HOLD, replace(HOLD, name="ours", ours=True))
EXPERIMENT = Experiment(
    title="A <b>title</b>",
    source="Nobody, table 1",
    about="Words.",
    trials=lambda: TRIALS,
    judge=lambda records: [
        Finding(claim="holds", measured="1 mm", holds=True),
        Finding(claim="fails", measured="9 mm", holds=False),
        Finding(claim="says", measured="2 mm", holds=None),
    ],
)
RECORDS = {trial.name: run(trial) for trial in TRIALS}


def test_gains_are_the_fields_that_are_not_at_their_defaults() -> None:
    law = Impedance(stiffness=(400.0, 20.0), damping=DampingRatio(0.7), orientation_error=quaternion_error)
    assert gains(law) == {
        "stiffness": [400.0, 20.0],
        "damping": {"law": "DampingRatio", "ratio": 0.7},
        "orientation_error": "quaternion_error",
    }
    assert gains(Adaptive(law=LAW, mass=1.5)) == {
        "law": {"law": "OperationalSpace", "kp": 225.0, "kd": 30.0},
        "mass": 1.5,
    }


def test_arms_have_names_a_person_knows() -> None:
    ideal = arms.ideal(0)
    assert [arm_name(arm) for arm in (ideal, with_rotors(ideal), arms.honest(0))] == [
        "ideal",
        "ideal, with rotors",
        "honest",
    ]


def test_an_outcome_is_plain_json_without_what_is_not_finite() -> None:
    records = dict(RECORDS)
    broken = records["ours"].__class__.__new__(records["ours"].__class__)
    broken.__dict__.update(records["ours"].__getstate__(), p=np.full((len(records["ours"].t), 3), np.nan))
    text = json.dumps(outcome("x", EXPERIMENT, TRIALS, records | {"ours": broken}).as_json(), allow_nan=False)
    assert json.loads(text)["trials"][1]["metrics"]["position_rmse_mm"] is None


def test_an_experiment_with_missing_trials_is_not_judged() -> None:
    half = outcome("x", EXPERIMENT, TRIALS, {HOLD.name: RECORDS[HOLD.name]})
    assert [trial.name for trial in half.trials] == [HOLD.name]
    assert half.findings == ()
    assert "Not judged" in reproduction_html([half], {})


def test_the_page_escapes_what_it_is_given_and_shows_every_finding() -> None:
    whole = outcome("x", EXPERIMENT, TRIALS, RECORDS)
    page = reproduction_html([whole], {"x": errors_svg("x", TRIALS, RECORDS)})
    assert "<b>title" not in page
    assert "<waits>" not in page
    assert all(word in page for word in (">met<", ">not met<", ">shown<", "<svg", 'href="#x"', 'id="x"'))
    assert score(whole.findings) == "1 of 2"


def test_the_table_of_text_keeps_nothing_that_depends_on_the_machine() -> None:
    text = as_markdown([outcome("x", EXPERIMENT, TRIALS, RECORDS)], "burnish reproduce x")
    assert "µs" not in text
    assert "**not met**: fails 9 mm" in text
    assert "settling" in text
