"""Thesis A, tables 5.4 and 5.5 and figure 5.5: pose errors become joint speeds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from burnish.control import PostureReference
from burnish.experiments.thesis_a import UNREACHABLE, judge_pose, pose_trials
from burnish.sim.arms import Arm
from burnish.trials.experiment import Experiment, Finding, Trial
from burnish.trials.figures import roughness
from burnish.trials.record import Record


def trials() -> Sequence[Trial]:
    """The thesis's gains and ours, on both motions."""
    return pose_trials(theirs, ours)


def theirs() -> PostureReference:
    """Tables 5.4 (speed of the joints) and 5.5 (the pose)."""
    return PostureReference(
        speed_gain=(60.5, 70.5, 87.5, 90.0, 90.0, 600.0),
        position_kp=80.0,
        position_ki=20.0,
        position_kd=5.0,
        orientation_kp=25.0,
        orientation_ki=10.0,
        orientation_kd=3.5,
    )


def ours(arm: Arm) -> PostureReference:
    """Without the damping of a speed by a speed; as fast as the loop of an arm allows."""
    if arm.friction is None:
        return PostureReference(
            speed_gain=60.0, position_kp=15.0, position_ki=20.0, orientation_kp=15.0, orientation_ki=20.0
        )
    return PostureReference(
        speed_gain=25.0,
        position_kp=5.0,
        position_ki=10.0,
        orientation_kp=10.0,
        orientation_ki=40.0,
        integral=2.0,
    )


def judge(records: Mapping[str, Record]) -> Sequence[Finding]:
    """What the thesis says of figure 5.5."""
    rough = {
        name: roughness(records[name].time, np.asarray(records[name].tau))
        for name in ("reachable, honest", "reachable, honest, ours")
    }
    theirs, mine = rough.values()
    return [
        *judge_pose(records, displaced=(15.0, 20.0)),
        Finding(
            claim="K (1 + K_d) is what damps a joint: 363 to 2700 1/s. With M of the links in front it suits 1 kHz; on "
            "the honest arm, late by 10 ms, it chatters (more than 100 times as rough as ours).",
            measured=f"Roughness {theirs:.0f} N·m/s against {mine:.1f} N·m/s.",
            holds=theirs > 100.0 * mine,
        ),
    ]


EXPERIMENT = Experiment(
    title="Joint speeds from the pose error, position first",
    source="Thesis A, 4.3 and 5.5, tables 5.4 and 5.5, figure 5.5",
    about=f"""A PID turns the pose error into the speed of the tool, the inverse Jacobian that into joint speeds, with
    the orientation in the null space of the position, and an inner loop follows them through M. The thesis found the
    position reached in time and the orientation late, and no better than with the simpler laws. {UNREACHABLE}""",
    trials=trials,
    judge=judge,
)
