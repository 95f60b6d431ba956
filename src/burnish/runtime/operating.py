"""`operator`: whoever moves the arm by hand, held back before all that would stop it."""

from __future__ import annotations

from collections.abc import Callable

from burnish.runtime.clearance import Clearance
from burnish.runtime.guards import allowed_speed
from burnish.runtime.limits import Limits
from burnish.runtime.machine import Mode
from burnish.runtime.supervisor import Supervisor
from burnish.teleop.device import Reading
from burnish.teleop.limits import Bounds
from burnish.teleop.modes import Panel
from burnish.teleop.reference import Operator, Pace

PRESS = 0.7
"""Share of the force at which the arm is stopped that an operator may press with."""
EARLY = 0.1
"""How far before the supervisor's own braking an operator is watched for the arm hitting itself [m]: more than the
fastest part of the arm needs to slow down."""


def operator(*, read: Callable[[], Reading], panel: Panel, supervisor: Supervisor, pace: Pace) -> Operator:
    """An operator of a supervised arm: what may be approached slows them down before it trips.

    Args:
        read: the device, asked once a cycle.
        panel: modes and deadman.
        supervisor: of the arm; its limits are what holds the operator back, and while it holds, nothing is wanted.
        pace: how fast.
    """
    limits = supervisor.limits
    return Operator(
        read=read,
        panel=panel,
        bounds=bounds(limits),
        pace=pace,
        press=PRESS * limits.tool_force,
        taken=lambda: supervisor.mode is not Mode.TORQUE,
        allowed_speed=lambda arm, v: allowed_speed(limits, arm, v),
        clearance=watched(limits).closing,
    )


def watched(limits: Limits | None = None) -> Clearance:
    """The arm's distance from itself as an operator has to heed it; by the packaged limits if none are given."""
    limits = Limits.jaco2() if limits is None else limits
    return Clearance(limits, near=limits.self_slow + EARLY)


def bounds(limits: Limits) -> Bounds:
    """What the operator shall not reach: where the supervisor begins to push a joint back."""
    lower, upper = limits.within(limits.soft_margin, 0.1)
    return Bounds(lower=lower, upper=upper, speed=limits.speed, box_low=limits.box_low, box_high=limits.box_high)
