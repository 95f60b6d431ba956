"""Every experiment has what a page needs, and its trials can be made."""

from __future__ import annotations

import pytest

from burnish.experiments.catalogue import experiment, experiments
from burnish.trials.outcome import arm_name, gains

NAMES = sorted(experiments())


def test_the_experiments_of_thesis_a_and_of_the_blog_are_found() -> None:
    assert {"a_table_5_2", "a_figures_5_2_5_3", "a_table_5_3", "a_tables_5_4_5_5"} <= set(NAMES)
    assert {"c_orientation", "c_masks", "c_position_and_orientation", "c_adaptive_push"} <= set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_the_experiment_says_what_it_is(name: str) -> None:
    found = experiment(name)
    assert found.title
    assert found.source
    assert len(found.about.split()) > 20


@pytest.mark.parametrize("name", NAMES)
def test_trials_have_names_of_their_own_and_can_be_made(name: str) -> None:
    trials = experiment(name).trials()
    assert len(trials) > 1
    assert len({trial.name for trial in trials}) == len(trials)
    for trial in trials:
        assert trial.duration > 0.0
        assert trial.arm.rate > 0.0
        assert arm_name(trial.arm)
        assert gains(trial.law)
