"""Thesis B, 5.1.1: PID computed torque of the joints in simulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from burnish.control import ComputedTorque
from burnish.core import Array, JointReference
from burnish.experiments import ours
from burnish.experiments.thesis_b import TABLE_5_1_FREQUENCY, TABLE_5_1_INTEGRAL
from burnish.sim.arms import ideal
from burnish.sim.robot import HOME
from burnish.trajectory import Cubic, Hold, Schedule, Sine
from burnish.trials.experiment import Experiment, Finding, Trial, links_only
from burnish.trials.record import Record, rms

CANDLE = np.full(6, np.pi)
"""Joint positions after the first cubic [rad] (eq. 5.1)."""
AMPLITUDE = np.full(6, np.pi / 4.0)
"""Of the sine [rad] (eq. 5.3)."""
PERIOD = 10.0
"""Of the sine [s] (eq. 5.3)."""
SINE = (20.0, 80.0)
"""When it is run [s]."""
DURATION = 97.0
"""The cubic back ends at 95 s."""


def joint_schedule(there: Array, amplitude: Array) -> Schedule[JointReference]:
    """Stand, cubic 5–15 s, stand, sine 20–80 s, stand, cubic back 85–95 s (eq. 5.1–5.4).

    The sine is about where the cubic has ended, not about q_i as eq. 5.4 says: from there it would start with a jump.
    """
    return Schedule(
        parts=[
            (5.0, Hold()),
            (10.0, Cubic(q=there, duration=10.0)),
            (5.0, Hold()),
            (SINE[1] - SINE[0], Sine(amplitude=amplitude, period=PERIOD)),
            (5.0, Hold()),
            (10.0, Cubic(q=HOME, duration=10.0)),
            (2.0, Hold()),
        ]
    )


def trials() -> Sequence[Trial]:
    """The thesis's gains and ours."""
    return [
        _trial("thesis", ComputedTorque.at_frequency(TABLE_5_1_FREQUENCY, ki=TABLE_5_1_INTEGRAL)),
        _trial("ours", ours.computed_torque(ideal(0))),
    ]


def judge(records: Mapping[str, Record]) -> Sequence[Finding]:
    """The error over the sine."""
    return [judge_sine(records[name], name) for name in ("thesis", "ours")]


def judge_sine(record: Record, name: str) -> Finding:
    """RMSE over the 60 s of the sine, all joints and the worst."""
    error, started = sine_error(record)
    worst = max(rms(joint) for joint in error.T) if started else float("nan")
    return Finding(
        claim=f"{name.capitalize()}: RMSE over the 60 s sine ≤ 2 mrad.",
        measured=f"{1e3 * rms(error):.2f} mrad over all joints, {1e3 * worst:.2f} mrad of the worst."
        if started
        else f"Stopped after {record.time[-1]:.2f} s: {record.stopped}.",
        holds=record.stopped is None and rms(error) <= 2e-3,
    )


def sine_error(record: Record) -> tuple[Array, bool]:
    """q_d − q during the sine [rad], (N, n), and whether it came to that."""
    during = (record.time >= SINE[0]) & (record.time < SINE[1])
    return np.asarray(record.joint_error)[during], bool(during.any())


def _trial(name: str, law: ComputedTorque) -> Trial:
    return Trial(
        name=name,
        law=law,
        source=joint_schedule(CANDLE, AMPLITUDE),
        duration=DURATION,
        arm=ideal(0),
        model=links_only(),
        ours=name == "ours",
    )


EXPERIMENT = Experiment(
    title="PID computed torque of the joints, simulated",
    source="Thesis B, 5.1.1, table 5.1, figure 5.1",
    about="""All joints follow a cubic to π, a sine of 45° about it for 60 s, and a cubic back, on links alone at 1
    kHz as in the thesis's simulator; h, which the thesis drops, is kept. The sine starts at full speed from rest, and
    that start is most of the error. The last 3 s of standing are left out.""",
    trials=trials,
    judge=judge,
)
