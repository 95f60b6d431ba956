"""Thesis B, 5.1.3: impedance without force sensing, in simulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from burnish.experiments import ours
from burnish.experiments.pushed import judge_push, pushed_trial
from burnish.experiments.simulated import TOOL_MOTION, judge_ours, judge_stable
from burnish.experiments.thesis_b import TABLE_5_3, impedance, operated
from burnish.sim.arms import ideal
from burnish.trials.experiment import Experiment, Finding, Trial, links_only, nominal
from burnish.trials.record import Record


def trials() -> Sequence[Trial]:
    """The thesis's gains, pushed and not; ours."""
    arm = ideal(0)
    return [
        operated("thesis", impedance(TABLE_5_3), arm, links_only()),
        pushed_trial("thesis, pushed", impedance(TABLE_5_3), arm, links_only()),
        operated("ours", ours.impedance(arm), arm, nominal(arm), ours=True),
    ]


def judge(records: Mapping[str, Record]) -> Sequence[Finding]:
    """Stable, and as predicted."""
    return [
        judge_stable(records["thesis"], "D_o = 2 on links alone is stable at 1 kHz."),
        *judge_push(records["thesis, pushed"], TABLE_5_3),
        judge_ours(records["ours"]),
    ]


EXPERIMENT = Experiment(
    title="Impedance without force sensing, simulated",
    source="Thesis B, 5.1.3, table 5.3, figure 5.3",
    about=f"""The thesis's law has no feed-forward; ours has the arm's own dynamics, and its damping from Λ, K and a
    ratio. {TOOL_MOTION}""",
    trials=trials,
    judge=judge,
)
