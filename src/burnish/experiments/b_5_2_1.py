"""Thesis B, 5.2.1: computed torque of the joints on the robot, with M for the first three only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from burnish.core import Array, Dynamics, JointReference
from burnish.experiments import ours
from burnish.experiments.b_5_1_1 import DURATION, joint_schedule, sine_error
from burnish.experiments.thesis_b import TABLE_5_8_KD, TABLE_5_8_KP
from burnish.sim.arms import honest
from burnish.sim.robot import HOME
from burnish.trials.experiment import Experiment, Finding, Trial, links_only, nominal
from burnish.trials.record import Record, rms

REACH = np.array([HOME[0], np.pi, np.pi / 2.0, *HOME[3:]])
"""Joint positions after the first cubic [rad] (eq. 5.6)."""
AMPLITUDE = np.pi / np.array([6.0, 20.0, 20.0, 20.0, 20.0, 6.0])
"""Of the sine [rad] (eq. 5.7)."""
BIG = 3
"""Joints that M is used for."""


@dataclass(kw_only=True)
class PartlyComputedTorque:
    """Computed torque of the first three joints, a spring and a damper on the others; g is compensated, h is not."""

    kp: Array
    """K_p of the joints: [1/s²] of the first three, [N·m/rad] of the others."""
    kd: Array
    """K_d of the joints: [1/s], [N·m·s/rad]."""

    def reset(self, arm: Dynamics) -> None:
        """No memory."""

    def torque(self, arm: Dynamics, reference: JointReference) -> Array:
        """Joint torques [N·m], (n,), gravity included."""
        tau = self.kp * (reference.q - arm.q) + self.kd * (reference.dq - arm.dq)
        tau[:BIG] = arm.M[:BIG, :BIG] @ (reference.ddq[:BIG] + tau[:BIG])
        return np.asarray(tau + arm.g)


def trials() -> Sequence[Trial]:
    """The thesis's gains and ours."""
    arm = honest(1)
    theirs = PartlyComputedTorque(kp=np.array(TABLE_5_8_KP), kd=np.array(TABLE_5_8_KD))

    def trial(name: str, law: object, model: object) -> Trial:
        source = joint_schedule(REACH, AMPLITUDE)
        return Trial(name=name, law=law, source=source, duration=DURATION, arm=arm, model=model, ours=name == "ours")  # type: ignore[arg-type]

    return [trial("thesis", theirs, links_only()), trial("ours", ours.computed_torque(arm), nominal(arm))]


def judge(records: Mapping[str, Record]) -> Sequence[Finding]:
    """The thesis says "very good tracking" and a steady error that is not significant."""
    thesis, mine = records["thesis"], records["ours"]
    return [
        Finding(
            claim="Stable with the thesis's gains, which leave M out of the last three joints.",
            measured=_in_words(thesis),
            holds=thesis.stopped is None,
        ),
        Finding(
            claim="Ours, with rotors in M, friction fed forward and an integral: at most a third of the error.",
            measured=_in_words(mine),
            holds=mine.stopped is None and rms(sine_error(mine)[0]) <= rms(sine_error(thesis)[0]) / 3.0,
        ),
    ]


def _in_words(record: Record) -> str:
    error, started = sine_error(record)
    if record.stopped is not None or not started:
        return f"Stopped after {record.time[-1]:.2f} s: {record.stopped}."
    last = np.abs(record.joint_error[-1]).max()
    return f"RMSE over the 60 s sine {1e3 * rms(error):.1f} mrad; the worst joint stands off by {1e3 * last:.1f} mrad."


EXPERIMENT = Experiment(
    title="Computed torque of the joints, honest arm",
    source="Thesis B, 5.2.1, table 5.8, figure 5.8",
    about="""Cubic, sine and cubic back, the sine of 30° on the outer joints and 9° on the others. The thesis found
    its gains too small to move the last three joints through M, which lacks their rotors, and left M out there.""",
    trials=trials,
    judge=judge,
)
