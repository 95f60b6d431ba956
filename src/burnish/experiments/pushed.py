"""A push on a standing tool, and what Λ, K and D predict of it."""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

from burnish.control import Impedance, InertiaShapingImpedance, RedundantImpedance
from burnish.core import Array, State, read_only
from burnish.experiments.thesis_b import TaskTable
from burnish.model.model import Model
from burnish.sim.arms import Arm
from burnish.trajectory import HoldPose
from burnish.trials.experiment import Finding, Trial
from burnish.trials.record import Record

PUSH = read_only([1.5, -1.0, 2.0, 0.1, 0.1, -0.05])
"""Wrench of the hand [N, N·m]: 10 mm on a spring of 150 N/m, small enough for Λ to stay what it was."""
FROM, TO, DURATION = 0.5, 3.0, 5.0
"""When it begins, when it ends, and the trial [s]."""


def push(t: float) -> Array:
    """The wrench at a time [N, N·m], (6,)."""
    return PUSH if FROM <= t < TO else np.zeros(6)


def pushed_trial(
    name: str, law: Impedance | InertiaShapingImpedance | RedundantImpedance, arm: Arm, model: Model
) -> Trial:
    """A law that holds its pose while somebody pushes."""
    return Trial(name=name, law=law, source=HoldPose(), duration=DURATION, arm=arm, model=model, push=push)


def predicted(inertia: Array, stiffness: Array, damping: Array, t: Array) -> Array:
    """Deflection [m, rad], (N, 6), of ``inertia`` ẍ + D ẋ + K x = F(t), F constant from one instant to the next.

    Args:
        inertia: Λ (6, 6).
        stiffness: K (6,).
        damping: D (6,).
        t: instants at equal distance [s], (N,).
    """
    system = np.zeros((18, 18))
    system[:6, 6:12] = np.eye(6)
    system[6:12] = np.linalg.solve(inertia, np.hstack([-np.diag(stiffness), -np.diag(damping), np.eye(6)]))
    step = expm(system * (t[1] - t[0]))
    x, deflection = np.zeros(18), np.zeros((len(t), 6))
    for i, now in enumerate(t):
        deflection[i] = x[:6]
        x[12:] = push(now)
        x = step @ x
    return deflection


def deflection(record: Record) -> Array:
    """How far the tool is from its reference [m, rad], (N, 6)."""
    return np.hstack([np.asarray(record.p) - np.asarray(record.p_d), -np.asarray(record.turn)])


def judge_push(record: Record, table: TaskTable) -> list[Finding]:
    """Whether the arm gives way as Λ, K and D say, to 20 %, while it is pushed and after."""
    arm = record.model.at(State(t=0.0, q=record.q[0], dq=np.zeros(record.model.n)))
    expected = predicted(arm.Lambda, table.small_angle_stiffness, np.asarray(table.d), record.time)
    measured = deflection(record)
    standing = (record.time > TO - 0.2) & (record.time < TO)
    findings = []
    for claim, when in (("Pushed, standing", standing), ("Pushed and let go, at every instant", record.time >= 0.0)):
        off = [_off(measured[when, rows], expected[when, rows]) for rows in (slice(0, 3), slice(3, 6))]
        millimetres = 1e3 * np.linalg.norm(measured[when, :3], axis=1).max()
        findings.append(
            Finding(
                claim=f"{claim}: the deflection is within 20 % of what Λ, K and D predict.",
                measured=f"{100 * off[0]:.1f} % of the position ({millimetres:.1f} mm), {100 * off[1]:.1f} % of the "
                "orientation.",
                holds=record.stopped is None and max(off) <= 0.2,
            )
        )
    return findings


def _off(measured: Array, expected: Array) -> float:
    """Largest difference over the largest deflection."""
    difference = np.linalg.norm(measured - expected, axis=1).max()
    return float(difference / np.linalg.norm(expected, axis=1).max())
