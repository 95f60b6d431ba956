"""Thesis A, table 5.2 and figure 5.1: a PID of the pose through the transposed Jacobian."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from burnish.control import JacobianTranspose
from burnish.experiments.thesis_a import OURS_HONEST, OURS_IDEAL, TABLE_5_2, UNREACHABLE, judge_pose, pose_trials
from burnish.sim.arms import Arm
from burnish.trials.experiment import Experiment, Finding, Trial
from burnish.trials.record import Record


def trials() -> Sequence[Trial]:
    """The thesis's gains and ours, on both motions."""
    return pose_trials(theirs, ours)


def theirs() -> JacobianTranspose:
    """Table 5.2."""
    return JacobianTranspose(**TABLE_5_2)


def ours(arm: Arm) -> JacobianTranspose:
    """Stiffer where the arm bears it."""
    return JacobianTranspose(**(OURS_IDEAL if arm.friction is None else OURS_HONEST))


def judge(records: Mapping[str, Record]) -> Sequence[Finding]:
    """What the thesis says of figure 5.1."""
    return judge_pose(records, displaced=(8.0, 12.0))


EXPERIMENT = Experiment(
    title="Jacobian transpose control of the pose",
    source="Thesis A, 4.1.1 and 5.2, table 5.2, figure 5.1",
    about=f"""The law knows where the tool is and how the arm is built, not how heavy it is. The thesis found small
    steady errors, a position that is disturbed while the tool turns, and an oscillation between 2.5 and 7.5 s that it
    could not explain. At about 10 s the position was displaced. {UNREACHABLE}""",
    trials=trials,
    judge=judge,
)
