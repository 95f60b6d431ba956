"""The smallest closed loop: a law, the plant M q̈ + h + g = τ + JᵀF, and a clock."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from burnish.core import Array, Controller, Dynamics, State, ToolReference
from burnish.model.model import Model
from burnish.rotation import exp, log

HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
"""The JACO2 far from every singularity."""
BENT = np.array([0.3, 0.8, -0.4, -1.2, 0.5, 0.9, 0.2])
"""The arm with seven joints likewise."""
JACO2 = Model.jaco2().with_armature(0.1)
"""With some rotor inertia: the wrist of the links alone is too light for stiff gains at 1 kHz."""
SEVEN = Model.from_urdf(Path(__file__).parent / "data" / "seven_dof.urdf", tool="tool0").with_armature(0.1)
ARMS = {"jaco2": (JACO2, HOME), "seven": (SEVEN, BENT)}
DT = 1e-3


def arm_at(model: Model, q: Array, dq: Array | None = None, t: float = 0.0, F: Array | None = None) -> Dynamics:
    arm = model.at(State(t=t, q=q, dq=np.zeros(model.n) if dq is None else dq))
    return arm.feeling(np.zeros(6) if F is None else F)


def moving(model: Model, q: Array, seed: int) -> Dynamics:
    """An arm in motion near q, touched by something."""
    rng = np.random.default_rng(seed)
    return arm_at(model, q + rng.uniform(-0.2, 0.2, model.n), rng.normal(size=model.n), F=rng.normal(size=6))


def pose(arm: Dynamics, dp: Any = (0.0, 0.0, 0.0), turn: Any = (0.0, 0.0, 0.0), v: Any = 0.0, a: Any = 0.0) -> Any:
    """A reference that is off by dp [m] and a rotation vector [rad]."""
    R = exp(np.asarray(turn, dtype=float)) @ arm.R
    return ToolReference(p=arm.p + dp, R=R, v=np.zeros(6) + v, a=np.zeros(6) + a)


def off(arm: Dynamics, seed: int) -> ToolReference:
    """A reference some way off, moving and accelerating."""
    rng = np.random.default_rng(seed)
    dp, turn = rng.uniform(-0.1, 0.1, (2, 3))
    v, a = rng.normal(size=(2, 6))
    return pose(arm, dp, turn, v, a)


def self_motion(model: Model, q: Array, length: float) -> Array:
    """Where seven joints come along their self-motion, with the tool held to 1e-9; joint 2 towards lower angles."""
    p, R, _ = model.kinematics(q)
    q = q.copy()
    for _ in range(round(length / 0.01)):
        n = np.linalg.svd(model.kinematics(q)[2])[2][-1]
        q -= 0.01 * n * np.sign(n[2])
        for _ in range(5):
            p_now, R_now, J = model.kinematics(q)
            q += np.linalg.pinv(J) @ np.concatenate([p - p_now, log(R @ R_now.T)])
    return q


def acceleration(arm: Dynamics, tau: Array) -> Array:
    """q̈ of the free arm under a torque."""
    return np.linalg.solve(arm.M, tau - arm.h - arm.g)


def tool_acceleration(arm: Dynamics, tau: Array) -> Array:
    """v̇ of the tool of the free arm under a torque."""
    return arm.J @ acceleration(arm, tau) + arm.dJdq


def run(
    model: Model,
    q: Array,
    law: Controller[Any],
    reference: Callable[[Dynamics], Any] | Any,
    duration: float,
    *,
    push: Array | None = None,
    plant: Model | None = None,
    dt: float = DT,
) -> list[Dynamics]:
    """The arm under the law from rest at q, cycle by cycle; it feels ``push``, and ``plant`` is what really moves."""
    plant = model if plant is None else plant
    F = np.zeros(6) if push is None else push
    q, dq, seen = np.array(q), np.zeros(model.n), []
    arm = arm_at(model, q, dq, 0.0, F)
    law.reset(arm)
    for i in range(round(duration / dt)):
        arm = arm_at(model, q, dq, i * dt, F)
        seen.append(arm)
        tau = law.torque(arm, reference(arm) if callable(reference) else reference)
        real = arm if plant is model else plant.at(State(t=i * dt, q=q, dq=dq))
        ddq = np.linalg.solve(real.M, tau + real.J.T @ F - real.h - real.g)
        dq = dq + dt * ddq
        q = q + dt * dq
    return seen
