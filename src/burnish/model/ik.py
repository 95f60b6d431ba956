"""Inverse kinematics: joint positions for a tool pose, within the limits, or a clear no."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from burnish.core import Array
from burnish.errors import PlanError
from burnish.model.model import Model
from burnish.rotation import log

POSITION_TOLERANCE = 1e-5
"""A solution is this near [m]."""
ROTATION_TOLERANCE = 1e-4
"""A solution is this near [rad]."""


def solve(model: Model, p: Array, R: Array, q: Array, iterations: int = 60) -> tuple[Array, float, float]:
    """The joint positions nearest to a tool pose that a damped descent from ``q`` finds.

    Levenberg–Marquardt with a damping that shrinks with the error, joints clipped to their limits.

    Returns:
        Joint positions [rad], (n,); what is left of the position error [m] and of the rotation error [rad].
    """
    q = np.clip(q, model.lower, model.upper)
    for _ in range(iterations):
        (e, J), position, rotation = _error(model, p, R, q)
        if position < 0.1 * POSITION_TOLERANCE and rotation < 0.1 * ROTATION_TOLERANCE:
            return q, position, rotation
        damping = 1e-6 + 0.02 * float(e @ e)
        step = J.T @ np.linalg.solve(J @ J.T + damping * np.eye(6), e)
        size = float(np.abs(step).max())
        q = np.clip(q + step * min(1.0, 0.5 / max(size, 1e-12)), model.lower, model.upper)
    return q, *_error(model, p, R, q)[1:]


def _error(model: Model, p: Array, R: Array, q: Array) -> tuple[tuple[Array, Array], float, float]:
    """Pose error and Jacobian at ``q``, and how large the error is [m], [rad]."""
    p_now, R_now, J = model.kinematics(q)
    e = np.concatenate([p - p_now, log(R @ R_now.T)])
    return (e, J), float(np.linalg.norm(e[:3])), float(np.linalg.norm(e[3:]))


def inverse(model: Model, p: Array, R: Array, seeds: Iterable[Array]) -> Array:
    """Joint positions that bring the tool to (p [m], R), from the first seed that leads there.

    Args:
        model: the arm; its tool frame is what is placed.
        p: position in the base frame [m], (3,).
        R: rotation, base ← tool, (3, 3).
        seeds: joint positions to start from [rad], best guess first.

    Raises:
        PlanError: if no seed leads to the pose; says how near the best one came.
    """
    best = (np.inf, np.inf)
    for seed in seeds:
        q, position, rotation = solve(model, p, R, seed)
        if position <= POSITION_TOLERANCE and rotation <= ROTATION_TOLERANCE:
            return q
        best = min(best, (position, rotation))
    raise PlanError(
        f"the arm cannot bring its tool to ({p[0]:.3f}, {p[1]:.3f}, {p[2]:.3f}) m in the wanted direction; "
        f"the nearest it comes is {1e3 * best[0]:.1f} mm and {np.rad2deg(best[1]):.1f}°. Move the mould nearer"
    )


def random_seeds(model: Model, count: int, rng: np.random.Generator) -> list[Array]:
    """Joint positions within the limits, continuous joints within one turn [rad]."""
    lower = np.where(np.isfinite(model.lower), model.lower, -np.pi)
    upper = np.where(np.isfinite(model.upper), model.upper, np.pi)
    return [rng.uniform(lower, upper) for _ in range(count)]
