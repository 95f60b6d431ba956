"""Inverse kinematics: joint positions for a tool pose, within the limits, or a clear no."""

from __future__ import annotations

import numpy as np

from burnish.core import Array
from burnish.errors import InputError, PlanError
from burnish.model.engine import placed
from burnish.model.model import Model
from burnish.rotation import log

POSITION_TOLERANCE = 1e-5
"""A solution is this near [m]."""
ROTATION_TOLERANCE = 1e-4
"""A solution is this near [rad]."""
TRIES = 32
"""Random starts unless told otherwise. Two starts of three lead there; with eight, one reachable pose in a hundred is
missed, with sixteen none of 800 was (four arms of 4 to 7 joints). The 32 take 0.2 s when there is no solution."""
AT_LIMIT = 1e-6
"""A joint this near to its limit stands on it [rad], a slide [m]."""


def inverse_kinematics(model: Model, p: Array, R: Array, near: Array, tries: int = TRIES) -> Array:
    """Joint positions within the limits that bring the tool to a pose.

    A damped descent begins at ``near``, and then at random joint positions, the same ones in every call, until one
    leads there. So the solution next to ``near`` is found where there is one, else any other branch; no promise is
    made that it is the nearest of those. Joints that turn come back on the turn nearest to ``near`` that their limits
    permit. An arm with fewer than six joints reaches few poses: ask for one that it has.

    Args:
        model: the arm; its tool frame is what is placed.
        p: position in the base frame [m], (3,).
        R: rotation, base ← tool, (3, 3).
        near: joint positions to start from, best guess first tried [rad], slides [m], (n,).
        tries: how many random starts follow.

    Returns:
        Joint positions [rad], slides [m], (n,), within `POSITION_TOLERANCE` and `ROTATION_TOLERANCE` of the pose.

    Raises:
        PlanError: if no start leads to the pose; says how near the best one came, and which joints stood on a limit.
        InputError: if p, R or near is not what it has to be.
    """
    placed(p, R)
    if np.shape(near) != (model.n,) or not np.isfinite(near).all():
        raise InputError(f"near = {near}; expected {model.n} finite joint positions, as {model.name} has joints")
    best = np.inf
    for seed in [np.asarray(near), *random_seeds(model, tries, np.random.default_rng(0))]:
        q, position, rotation = solve(model, p, R, seed)
        if position <= POSITION_TOLERANCE and rotation <= ROTATION_TOLERANCE:
            return _nearest_turn(model, q, near)
        if (miss := position / POSITION_TOLERANCE + rotation / ROTATION_TOLERANCE) < best:
            best, q_best, left = miss, q, f"{1e3 * position:.1f} mm and {np.rad2deg(rotation):.1f}°"
    raise PlanError(
        f"the arm cannot bring its tool to ({p[0]:.3f}, {p[1]:.3f}, {p[2]:.3f}) m in the wanted direction; "
        f"the nearest that {tries + 1} starts came is {left}{_on_limits(model, q_best)}. "
        "Move what it works on nearer to the base, or turn it"
    )


def solve(model: Model, p: Array, R: Array, q: Array, iterations: int = 60) -> tuple[Array, float, float]:
    """The joint positions nearest to a tool pose that a damped descent from ``q`` finds: for following a path.

    Levenberg–Marquardt with a damping that shrinks with the error; joints stop at their limits, and the others make
    up for those that stand there.

    Returns:
        Joint positions [rad], (n,); what is left of the position error [m] and of the rotation error [rad].
    """
    q = np.clip(q, model.lower, model.upper)
    for _ in range(iterations):
        (e, J), position, rotation = _error(model, p, R, q)
        if position < 0.1 * POSITION_TOLERANCE and rotation < 0.1 * ROTATION_TOLERANCE:
            return q, position, rotation
        step = _step(model, q, e, J)
        size = float(np.abs(step).max())
        q = np.clip(q + step * min(1.0, 0.5 / max(size, 1e-12)), model.lower, model.upper)
    return q, *_error(model, p, R, q)[1:]


def random_seeds(model: Model, count: int, rng: np.random.Generator) -> list[Array]:
    """Joint positions within the limits; joints without, within one turn about 0 [rad], or ± 1 m."""
    reach = np.where(model.prismatic, 1.0, np.pi)
    lower = np.where(np.isfinite(model.lower), model.lower, -reach)
    upper = np.where(np.isfinite(model.upper), model.upper, reach)
    return [rng.uniform(lower, upper) for _ in range(count)]


def _error(model: Model, p: Array, R: Array, q: Array) -> tuple[tuple[Array, Array], float, float]:
    """Pose error and Jacobian at ``q``, and how large the error is [m], [rad]."""
    p_now, R_now, J = model.kinematics(q)
    e = np.concatenate([p - p_now, log(R @ R_now.T)])
    return (e, J), float(np.linalg.norm(e[:3])), float(np.linalg.norm(e[3:]))


def _step(model: Model, q: Array, e: Array, J: Array) -> Array:
    """Jᵀ (J Jᵀ + damping I)⁻¹ e over the joints that it does not push against a limit on which they stand, (n,)."""
    damping = (1e-6 + 0.02 * float(e @ e)) * np.eye(6)
    free = np.ones(model.n, dtype=bool)
    while True:
        J_free = J * free
        step = np.asarray(J_free.T @ np.linalg.solve(J_free @ J_free.T + damping, e))
        pushed = free & (((step < 0.0) & (q <= model.lower)) | ((step > 0.0) & (q >= model.upper)))
        if not pushed.any():
            return step
        free &= ~pushed


def _nearest_turn(model: Model, q: Array, near: Array) -> Array:
    """The same pose, each joint that turns by whole turns as near to ``near`` as its limits permit."""
    turn = 2.0 * np.pi
    nearest = q + turn * np.round((near - q) / turn)
    permitted = ~model.prismatic & (nearest >= model.lower) & (nearest <= model.upper)
    return np.asarray(np.where(permitted, nearest, q))


def _on_limits(model: Model, q: Array) -> str:
    """Which joints stand on a limit, for a message."""
    on = np.flatnonzero(model.limit_distance(q) < AT_LIMIT)
    return f", with {', '.join(model.joint_names[i] for i in on)} on the limit" if len(on) else ""
