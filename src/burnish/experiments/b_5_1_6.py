"""Thesis B, 5.1.6: the hybrid law, in simulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from burnish.experiments import ours
from burnish.experiments.simulated import TOOL_MOTION, judge_ours, judge_stable, judge_unstable
from burnish.experiments.thesis_b import TABLE_5_6, enhanced, hybrid, operated
from burnish.sim.arms import ideal
from burnish.trials.experiment import Experiment, Finding, Trial, links_only, nominal
from burnish.trials.record import Record


def trials() -> Sequence[Trial]:
    """The thesis's gains with the true model and with the enlarged hand; ours."""
    arm = ideal(0)
    return [
        operated("thesis, true hand", hybrid(TABLE_5_6), arm, links_only()),
        operated("thesis, enlarged hand", hybrid(TABLE_5_6), arm, enhanced()),
        operated("ours", ours.hybrid(arm), arm, nominal(arm), ours=True),
    ]


def judge(records: Mapping[str, Record]) -> Sequence[Finding]:
    """What the enlarged hand does."""
    return [
        judge_unstable(
            records["thesis, true hand"],
            "With M of the links alone the wrist does not bear the position's torque.",
        ),
        judge_stable(
            records["thesis, enlarged hand"], "With the thesis's enlarged hand in M the same gains are stable."
        ),
        judge_ours(records["ours"]),
    ]


EXPERIMENT = Experiment(
    title="Hybrid, simulated",
    source="Thesis B, 5.1.6, table 5.6, figure 5.6",
    about=f"""Here M decides how strongly the orientation is held, and that of the links alone leaves the wrist next
    to nothing. The thesis enlarged the hand's inertia in its model and does not say by how much; here it is 0.1
    kg·m². {TOOL_MOTION}""",
    trials=trials,
    judge=judge,
)
