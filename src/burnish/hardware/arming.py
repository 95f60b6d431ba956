"""What has to be true before an arm is left to torques: one function a guard, each of measured things alone.

Each says what stands against it, and what to do, or nothing. A comparison with NaN is written so that it fails.
"""

from __future__ import annotations

import numpy as np

from burnish.core import Array

FRESH = 50
"""Readings without a bad one before anything is believed: half a second."""
REST = np.deg2rad(2.0)
"""Joint speed below which the arm is at rest [rad/s]."""
FROM_LIMIT = np.deg2rad(15.0)
"""Least distance from a joint limit [rad]."""
RESIDUAL = np.repeat([1.5, 0.8], 3)
"""Largest difference of measured and modelled torque at rest [N·m]: sensors off by 0.4, and links by a tenth."""
WATCHED = 50
"""Cycles at rest: half a second."""
READ_BACK = 10
"""Cycles in which the arm has to report the mode: 100 ms."""
SETTLED = 100
"""Cycles that the arm has to stand under its weight's torque alone: a second."""
DRIFT = np.deg2rad(2.0)
"""Furthest that a joint may move in that second [rad]."""


def moving(dq: Array) -> str | None:
    """Whether a joint moves; speeds [rad/s], (n,)."""
    if np.all(np.abs(dq) <= REST):
        return None
    joint = int(np.argmax(np.abs(dq)))
    return f"joint {joint + 1} moves at {np.rad2deg(dq[joint]):.1f}°/s; wait until the arm is at rest"


def near_limit(distance: Array) -> str | None:
    """Whether a joint is near a limit of its own; distances as `Model.limit_distance` gives them [rad], (n,)."""
    if np.all(distance >= FROM_LIMIT):
        return None
    joint = int(np.argmin(distance))
    return (
        f"joint {joint + 1} is {np.rad2deg(distance[joint]):.1f}° from its limit; "
        f"move it at least {np.rad2deg(FROM_LIMIT):.0f}° away, for instance home"
    )


def other_weight(off: Array) -> str | None:
    """Whether the arm weighs something else than its model; mean of measured less modelled torques [N·m], (6,)."""
    if np.all(np.abs(off) <= RESIDUAL):
        return None
    joint = int(np.argmax(np.abs(off) / RESIDUAL))
    return (
        f"joint {joint + 1} measures {off[joint]:+.2f} N·m beside the model, "
        f"{RESIDUAL[joint]} at most; declare what the hand carries, or zero the torques in a candle pose"
    )


def drifting(drift: Array) -> str | None:
    """Whether the arm does not stand under its weight's torque; way since the switch [rad], (n,)."""
    if np.all(np.abs(drift) <= DRIFT):
        return None
    joint = int(np.argmax(np.abs(drift)))
    return (
        f"under its weight's torque joint {joint + 1} drifted by {np.rad2deg(drift[joint]):.1f}°; "
        "check the payload and the gravity set-up"
    )
