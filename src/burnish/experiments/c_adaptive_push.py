"""The blog's demonstration: a push that nobody announced, learnt while the arm holds its pose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from burnish.control import Adaptive, OperationalSpace
from burnish.core import Array
from burnish.experiments.c_masks import KP, KV
from burnish.sim import arms
from burnish.sim.arms import Arm
from burnish.trajectory import HoldPose
from burnish.trials.experiment import Experiment, Finding, Trial, nominal, steady
from burnish.trials.record import Record

PUSH = np.array([5.0, -3.0, 4.0, 0.0, 0.0, 0.0])
"""The wrench [N, N·m]; a choice, because the blog prints no figure."""
FROM = 1.0
"""When it begins [s]."""
DURATION = 6.0


def push(t: float) -> Array:
    """Nothing, then the push."""
    return PUSH if t >= FROM else np.zeros(6)


def trials() -> Sequence[Trial]:
    """The blog's law with and without learning, on both arms."""
    return [_trial(arm, learns=learns) for arm in (arms.ideal(0), arms.honest(0)) for learns in (False, True)]


def _trial(arm: Arm, *, learns: bool) -> Trial:
    where = "ideal" if arm.friction is None else "honest"
    law = OperationalSpace(kp=KP, kd=0.0, joint_damping=float(KV))
    return Trial(
        name=f"{'learning' if learns else 'without learning'}, {where}",
        law=learning(law) if learns else law,
        source=HoldPose(),
        duration=DURATION,
        arm=arm,
        model=nominal(arm),
        push=push,
        ours=learns,
    )


def learning(law: OperationalSpace) -> Adaptive:
    """The same law, and a constant push learnt on top of it; a weight would look alike and is not learnt."""
    return Adaptive(law=law, mass_rate=0.0, moment_rate=0.0, push_rate=300.0, push_moment_rate=20.0)


def judge(records: Mapping[str, Record]) -> Sequence[Finding]:
    """How far the push moves the tool, and what learning makes of it."""
    return [
        Finding(
            claim=f"On the {where} arm learning takes the steady error of the push below {limit:g} mm.",
            measured=f"{_steady(records[f'without learning, {where}']):.2f} mm without, "
            f"{_steady(records[f'learning, {where}']):.3f} mm with; at most "
            f"{_peak(records[f'without learning, {where}']):.1f} and {_peak(records[f'learning, {where}']):.1f} mm.",
            holds=_steady(records[f"learning, {where}"]) < limit,
        )
        for where, limit in (("ideal", 0.1), ("honest", 2.0))
    ]


def _steady(record: Record) -> float:
    return 1e3 * steady(record.position_error, record.time)


def _peak(record: Record) -> float:
    return 1e3 * float(record.position_error.max())


EXPERIMENT = Experiment(
    title="An unknown push, with and without learning",
    source="Blog, release of the arm's interface and its adaptive demonstration",
    about="""The arm holds its pose when something begins to push its hand with 7 N. Without learning it gives way as
    its gains say; around the same law `Adaptive` learns the push. The blog mentions its demonstration without a
    law or a figure; here it is the adaptive law of Slotine and Li. The gains are the blog's for six degrees of
    freedom.""",
    trials=trials,
    judge=judge,
)
