"""Whether the arm can follow a tool path: reach, joint limits and joint speed, before anything moves."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor

import numpy as np

from burnish.core import Array
from burnish.errors import PlanError
from burnish.model.ik import AT_LIMIT, POSITION_TOLERANCE, ROTATION_TOLERANCE, inverse_kinematics, solve
from burnish.model.model import Model
from burnish.polish.cell import READY
from burnish.rotation import interpolate
from burnish.trajectory.path import TimedPath

SPEED_SHARE = 0.9
"""Share of a joint's speed limit that a plan may use."""
LIMIT_MARGIN = np.deg2rad(5.0)
"""Distance that a plan keeps from a joint limit [rad]."""
CHECK_EVERY = 0.25
"""Time between the poses that are checked [s]: 5 mm at 20 mm/s."""
JUMP = 0.5
"""Joint motion between two checked poses that is another solution of the arm, not the next pose [rad]."""


@dataclass(frozen=True, kw_only=True)
class JointPath:
    """The joint side of a tool path."""

    q: Array
    """Joint positions at the checked poses [rad], (K, n)."""
    speed_share: float
    """Largest joint speed on the path, in shares of the joints' limits."""


def follow(model: Model, path: TimedPath, q0: Array = READY) -> JointPath:
    """Follow a path in joint space from the solution nearest to ``q0``.

    Raises:
        PlanError: if a pose is out of reach or within 5° of a joint limit, if the arm would have to jump to another
            solution, or if a joint would be faster than 90 % of its limit.
    """
    q = inverse_kinematics(model, path.p[0], path.R[0], q0)
    joints, worst = [], 0.0
    for k in range(0, len(path.p), max(1, round(CHECK_EVERY / path.dt))):
        near, position, rotation = solve(model, path.p[k], path.R[k], q)
        if position > POSITION_TOLERANCE or rotation > ROTATION_TOLERANCE or np.abs(near - q).max() > JUMP:
            x, y, z = path.p[k]
            raise PlanError(
                f"the arm cannot follow the path at ({x:.3f}, {y:.3f}, {z:.3f}) m: what is left is "
                f"{1e3 * position:.1f} mm and {np.rad2deg(rotation):.1f}°. Use a smaller mould or one less steep"
            )
        q = near
        _limits(model, q)
        share = np.abs(np.linalg.solve(model.kinematics(q)[2], path.v[k])) / model.velocity_limit
        worst = max(worst, float(share.max()))
        joints.append(q)
    if worst > SPEED_SHARE:
        raise PlanError(
            f"the path needs {100 * worst:.1f} % of a joint's speed; expected at most {100 * SPEED_SHARE:.0f} %. "
            f"Lower the feed to {floor(100 * SPEED_SHARE / worst)} % of its value"
        )
    return JointPath(q=np.array(joints), speed_share=worst)


def travel_time(model: Model, q: Array, p: Array, R: Array, share: float = 0.5) -> float:
    """Time for a cubic motion from joint positions ``q`` straight to a pose, at ``share`` of joint speed [s].

    Raises:
        PlanError: if the way leaves the arm's reach.
    """
    pieces = 12
    p0, R0, _ = model.kinematics(q)
    worst = 0.0
    for k in range(1, pieces + 1):
        way = k / pieces
        near, position, rotation = solve(model, p0 + way * (p - p0), interpolate(R0, R, way), q)
        if position > POSITION_TOLERANCE or rotation > ROTATION_TOLERANCE:
            raise PlanError(
                f"the arm cannot move straight to ({p[0]:.3f}, {p[1]:.3f}, {p[2]:.3f}) m: "
                f"{1e3 * position:.1f} mm and {np.rad2deg(rotation):.1f}° are left on the way"
            )
        worst = max(worst, float((np.abs(near - q) / model.velocity_limit).max()))
        q = near
    # A cubic is 1.5 times as fast in the middle as on the mean.
    return 1.5 * pieces * worst / share


def joint_travel_time(model: Model, q: Array, target: Array, tool_speed: float) -> float:
    """Time for a cubic motion between joint positions, at half of the joint speeds and at most ``tool_speed`` [s]."""
    way = target - q
    tool = max(float(np.linalg.norm(model.kinematics(q + s * way)[2][:3] @ way)) for s in np.linspace(0.0, 1.0, 13))
    # A cubic is 1.5 times as fast in the middle as on the mean.
    return 1.5 * max(float((np.abs(way) / model.velocity_limit).max()) / 0.5, tool / tool_speed)


def _limits(model: Model, q: Array) -> None:
    short = np.minimum(q - model.lower, model.upper - q)
    i = int(np.argmin(short))
    if short[i] < LIMIT_MARGIN:
        raise PlanError(
            f"the path brings joint {i + 1} within {np.rad2deg(short[i]):.1f}° of its limit; "
            f"expected {np.rad2deg(LIMIT_MARGIN):.0f}°. Use a smaller mould"
        )


@dataclass(frozen=True, kw_only=True)
class Track:
    """Joint positions along poses, as far as the arm can follow them."""

    q: Array
    """Joint positions at the poses that were reached [rad], (K, n)."""
    failure: str | None
    """Why the next pose cannot be reached, or None when all were."""


def track(model: Model, p: Array, R: Array, q: Array) -> Track:
    """Follow poses, base frame [m], (K, 3), (K, 3, 3), from joint positions ``q`` near the first one.

    Each pose begins at the solution of the one before, so the arm never changes its configuration on the way.
    """
    joints: list[Array] = []
    for position, rotation in zip(p, R, strict=True):
        near, left, turn = solve(model, position, rotation, q)
        short = model.limit_distance(near)
        on = int(np.argmin(short))
        if left > POSITION_TOLERANCE or turn > ROTATION_TOLERANCE:
            why = f"joint {on + 1} stands on its limit" if short[on] < AT_LIMIT else "it is out of the arm's reach"
            failure = f"{why}: {1e3 * left:.1f} mm and {np.rad2deg(turn):.1f}° are left"
            return Track(q=np.array(joints).reshape(-1, model.n), failure=failure)
        if joints and np.abs(near - q).max() > JUMP:
            jump = int(np.argmax(np.abs(near - q)))
            failure = f"joint {jump + 1} would have to jump by {np.rad2deg(abs(near - q)[jump]):.0f}°"
            return Track(q=np.array(joints), failure=failure)
        q = near
        joints.append(q)
    return Track(q=np.array(joints), failure=None)
