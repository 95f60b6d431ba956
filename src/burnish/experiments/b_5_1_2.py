"""Thesis B, 5.1.2: computed torque in task space, in simulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from burnish.experiments import ours
from burnish.experiments.operator import following
from burnish.experiments.simulated import TOOL_MOTION, in_words, judge_ours
from burnish.experiments.thesis_b import TABLE_5_2, operated, task_computed_torque
from burnish.sim.arms import ideal
from burnish.trials.experiment import Experiment, Finding, Trial, links_only, nominal
from burnish.trials.record import Record


def trials() -> Sequence[Trial]:
    """The thesis's gains and ours."""
    arm = ideal(0)
    return [
        operated("thesis", task_computed_torque(TABLE_5_2), arm, links_only()),
        operated("ours", ours.task_computed_torque(arm), arm, nominal(arm), ours=True),
    ]


def judge(records: Mapping[str, Record]) -> Sequence[Finding]:
    """The steady state."""
    thesis = records["thesis"]
    return [
        Finding(
            claim="The thesis's gains: steady state ≤ 0.5 mm.",
            measured=in_words(thesis),
            holds=thesis.stopped is None and following(thesis).steady_mm <= 0.5,
        ),
        judge_ours(records["ours"]),
    ]


EXPERIMENT = Experiment(
    title="Computed torque in task space, simulated",
    source="Thesis B, 5.1.2, table 5.2, figure 5.2",
    about=f"""The thesis damps the whole speed, ours only what differs from the reference. {TOOL_MOTION}""",
    trials=trials,
    judge=judge,
)
