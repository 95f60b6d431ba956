"""Thesis B, 5.1.4: impedance with force sensing, in simulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from burnish.experiments import ours
from burnish.experiments.pushed import judge_push, pushed_trial
from burnish.experiments.simulated import TOOL_MOTION, judge_ours, judge_stable, judge_unstable
from burnish.experiments.thesis_b import TABLE_5_4, force_sensing, mended, operated
from burnish.sim.arms import ideal
from burnish.trials.experiment import Experiment, Finding, Trial, links_only, nominal
from burnish.trials.record import Record


def trials() -> Sequence[Trial]:
    """The thesis's gains on links alone and with a little rotor inertia, pushed and not; ours."""
    bare, geared = ideal(0), mended()
    return [
        operated("thesis", force_sensing(TABLE_5_4), bare, links_only()),
        operated("thesis, rotors in the wrist", force_sensing(TABLE_5_4), geared, nominal(geared)),
        pushed_trial("thesis, rotors in the wrist, pushed", force_sensing(TABLE_5_4), geared, nominal(geared)),
        operated("ours", ours.force_sensing(bare), bare, nominal(bare), ours=True),
    ]


def judge(records: Mapping[str, Record]) -> Sequence[Finding]:
    """Unstable, mended, and as predicted."""
    return [
        judge_unstable(records["thesis"], "D_o = 3 on links alone is unstable at 1 kHz: it would need D dt < 2 I."),
        judge_stable(
            records["thesis, rotors in the wrist"], "Rotors of 0.005 kg·m² in the wrist mend it, with the same gains."
        ),
        *judge_push(records["thesis, rotors in the wrist, pushed"], TABLE_5_4),
        judge_ours(records["ours"]),
    ]


EXPERIMENT = Experiment(
    title="Impedance with force sensing, A = Λ, simulated",
    source="Thesis B, 5.1.4, table 5.4, figure 5.4",
    about=f"""With A = Λ the measured wrench cancels, so none is measured. The thesis's simulator was stable with
    these gains; what made its wrist heavier than its links it does not say, and the enlarged hand of its model cannot
    be it, because M cancels from this law too. {TOOL_MOTION}""",
    trials=trials,
    judge=judge,
)
