"""What a timed path asks of the joints: their speed and torque at every node, in shares of what they can."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from burnish.core import Array, State
from burnish.model.model import Model
from burnish.model.tool import PolishingTool
from burnish.runtime.limits import Limits
from burnish.trajectory import TimedPath

STRIDE = 4
"""Nodes of a timed path from one that is looked at to the next: 20 ms, less than its smoothing of 50 ms."""


@dataclass(frozen=True, kw_only=True)
class Demand:
    """Joint speed and torque along a path."""

    nodes: NDArray[np.int64]
    """Numbers of the nodes, (N,)."""
    speed: Array
    """Joint speed in shares of its limit, (N, n)."""
    torque: Array
    """Joint torque in shares of its limit, and of its deviation from gravity of what the supervisor allows,
    whichever is more, (N, n)."""


def demand(
    model: Model, path: TimedPath, nodes: NDArray[np.int64], q: Array, *, limits: Limits, tool: PolishingTool
) -> Demand:
    """The joints' speed and torque with the tool pressed on and rubbing.

    ``q̇ = J⁺ v``, ``q̈ = J⁺ (a − J̇ q̇)``, ``τ = M q̈ + h + g − Jᵀ F`` with F = f (n − μ v/|v|) on the tool, or with the
    drag of a tip that a spindle turns; its moment, a few N·mm, and joint friction are not in it. J⁺, M, h, g and J̇ q̇
    are interpolated between poses that are a few millimetres apart, over which they change by about one per cent; twist
    and force are those of each node.

    Args:
        model: the arm with its tool.
        path: the timed path, base frame.
        nodes: nodes at which the joint positions are known, from the first to the last, (K,).
        q: the joint positions there [rad], (K, n).
        limits: torque limits of the supervisor, which may be lower than the arm's.
        tool: the friction of its tip on the mould, and its spindle.
    """
    inverse = np.linalg.pinv(np.array([model.kinematics(joints)[2] for joints in q]))
    speeds = _times(inverse, path.v[nodes])
    arms = [model.at(State(t=0.0, q=joints, dq=dq)) for joints, dq in zip(q, speeds, strict=True)]
    fine = np.union1d(np.arange(0, len(path.p), STRIDE), nodes)
    between = np.interp(fine, nodes, np.arange(len(nodes)))
    low = np.minimum(between.astype(np.int64), max(len(nodes) - 2, 0))
    share, high = between - low, np.minimum(low + 1, len(nodes) - 1)

    def at(values: Sequence[Array] | Array) -> Array:
        stacked = np.asarray(values)
        weight = share.reshape(-1, *[1] * (stacked.ndim - 1))
        return np.asarray((1.0 - weight) * stacked[low] + weight * stacked[high])

    v, J = path.v[fine], at([arm.J for arm in arms])
    J_inv = at(inverse)
    dq = _times(J_inv, v)
    ddq = _times(J_inv, path.a[fine] - at([arm.dJdq for arm in arms]))
    F = path.force[fine, None] * path.normal[fine] + _drag(path, fine, tool)
    own = _times(at([arm.M for arm in arms]), ddq) + at([arm.h for arm in arms])
    more = own - _times(np.swapaxes(J[:, :3], 1, 2), F)
    whole = more + at([arm.g for arm in arms])
    strongest = np.minimum(model.effort_limit, limits.torque)
    torque = np.maximum(np.abs(whole) / strongest, np.abs(more) / limits.deviation)
    return Demand(nodes=fine, speed=np.abs(dq) / model.velocity_limit, torque=torque)


def _drag(path: TimedPath, nodes: NDArray[np.int64], tool: PolishingTool) -> Array:
    """Force of the mould along its surface on the tip at these nodes [N], (N, 3)."""
    v, force = path.v[nodes, :3], path.force[nodes]
    if tool.spinning is None:
        return np.asarray(-tool.friction * force[:, None] * v / np.maximum(np.linalg.norm(v, axis=1), 1e-6)[:, None])
    rows = zip(force.tolist(), path.normal[nodes].tolist(), path.R[nodes, :, 2].tolist(), v.tolist(), strict=True)
    return np.array([tool.spinning.drag(*row)[0] for row in rows])


def _times(matrices: Array, vectors: Array) -> Array:
    """Matrix times vector, row by row."""
    return np.asarray(np.einsum("kij,kj->ki", matrices, vectors))
