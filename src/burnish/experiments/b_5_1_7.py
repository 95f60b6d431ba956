"""Thesis B, 5.1.7: the hybrid law with null space, in simulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from burnish.experiments import ours
from burnish.experiments.simulated import TOOL_MOTION, judge_ours, judge_stable
from burnish.experiments.thesis_b import TABLE_5_7, enhanced, hybrid_null_space, operated
from burnish.sim.arms import ideal
from burnish.trials.experiment import Experiment, Finding, Trial, links_only, nominal
from burnish.trials.record import Record


def trials() -> Sequence[Trial]:
    """The thesis's gains with the true model and with the enlarged hand; ours."""
    arm = ideal(0)
    return [
        operated("thesis, true hand", hybrid_null_space(TABLE_5_7), arm, links_only()),
        operated("thesis, enlarged hand", hybrid_null_space(TABLE_5_7), arm, enhanced()),
        operated("ours", ours.hybrid_null_space(arm), arm, nominal(arm), ours=True),
    ]


def judge(records: Mapping[str, Record]) -> Sequence[Finding]:
    """What the enlarged hand does."""
    return [
        judge_stable(records["thesis, true hand"], "Stable with M of the links alone."),
        judge_stable(records["thesis, enlarged hand"], "Stable with the thesis's enlarged hand in M."),
        judge_ours(records["ours"]),
    ]


EXPERIMENT = Experiment(
    title="Hybrid with null space, simulated",
    source="Thesis B, 5.1.7, table 5.7, figure 5.7",
    about=f"""The position is moved without the orientation's help or hindrance. The enlarged hand is that of 5.1.6.
    {TOOL_MOTION}""",
    trials=trials,
    judge=judge,
)
