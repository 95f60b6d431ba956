"""Thesis B's laws with its robot's gains on the honest arm, beside ours."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from burnish.core import Controller
from burnish.experiments import ours
from burnish.experiments.operator import following
from burnish.experiments.simulated import TOOL_MOTION, in_words
from burnish.experiments.thesis_b import enhanced, operated
from burnish.sim.arms import Arm, honest
from burnish.trials.experiment import Experiment, Finding, Trial, nominal
from burnish.trials.record import Record

SEED = 1
"""Of the honest arm; the comparison judges on three."""


def robot_experiment(
    *,
    title: str,
    source: str,
    about: str,
    claim: str,
    theirs: Callable[[], Controller[Any]],
    same: Callable[[Arm], Controller[Any]],
) -> Experiment:
    """A law with the thesis's gains and model, the same law with ours, and the law that we would take."""

    def trials() -> Sequence[Trial]:
        arm = honest(SEED)
        return [
            operated("thesis", theirs(), arm, enhanced()),
            operated("same law, our gains", same(arm), arm, nominal(arm), ours=True),
            operated("ours", ours.operational_space(arm), arm, nominal(arm), ours=True),
        ]

    def judge(records: Mapping[str, Record]) -> Sequence[Finding]:
        thesis, better, best = (records[name] for name in ("thesis", "same law, our gains", "ours"))
        third = best.stopped is None and following(best).position_mm <= following(thesis).position_mm / 3.0
        return [
            Finding(claim="Stable with the thesis's gains.", measured=in_words(thesis), holds=thesis.stopped is None),
            Finding(claim=claim, measured=in_words(thesis), holds=None),
            Finding(claim="The same law with our gains.", measured=in_words(better), holds=None),
            Finding(
                claim="OperationalSpace with rotors in Λ, friction fed forward and an integral: at most a third of the "
                "thesis's position RMSE.",
                measured=in_words(best),
                holds=third,
            ),
        ]

    return Experiment(
        title=title,
        source=source,
        about=f"""{about} The thesis's law knows the links with an enlarged hand, the arm has rotors, friction, late
        commands and masses that are up to 10 % off (seed {SEED}). Only one arm is behind these figures, and its
        friction is an estimate. {TOOL_MOTION}""",
        trials=trials,
        judge=judge,
    )
