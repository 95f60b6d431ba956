"""The arms that every contract of a model is tested with, and MuJoCo's own reading of each."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from burnish.core import Array, State
from burnish.model.model import JACO2_URDF, Model

DATA = Path(__file__).parent.parent / "data"
ARMS = {
    "jaco2": (JACO2_URDF, "end_effector"),
    "ur5e_like": (DATA / "ur5e_like.urdf", "tool0"),
    "seven_dof.urdf": (DATA / "seven_dof.urdf", "tool0"),
    "seven_dof.xml": (DATA / "seven_dof.xml", "tool0"),
    "prismatic": (DATA / "prismatic.urdf", "tip"),
}
"""File and tool frame."""
MUJOCO_3 = int(mujoco.__version__.split(".")[0]) == 3


def load(path: Path, tool: str) -> Model:
    return (Model.from_mjcf if path.suffix == ".xml" else Model.from_urdf)(path, tool)


def arm(name: str) -> Model:
    return load(*ARMS[name])


def random_q(model: Model, seed: int, count: int) -> Array:
    """Joint positions within the limits, continuous joints over three turns, (count, n)."""
    ends = np.clip([model.lower, model.upper], -3 * np.pi, 3 * np.pi)
    return np.random.default_rng(seed).uniform(*ends, (count, model.n))


def random_states(model: Model, seed: int, count: int) -> list[State]:
    """Those, with speeds up to 2 rad/s and m/s."""
    speeds = np.random.default_rng(seed + 1000).uniform(-2.0, 2.0, (count, model.n))
    return [State(t=0.0, q=q, dq=dq) for q, dq in zip(random_q(model, seed, count), speeds, strict=True)]


def slope(f: Callable[[float], Any], step: float = 1e-6) -> Any:
    """Derivative of f at 0 by a central difference: rounding 1e-10 of f's size, curvature 1e-12."""
    return (f(step) - f(-step)) / (2.0 * step)


class MuJoCo:
    """MuJoCo's own reading of a file, no body merged into another, limits and contacts off."""

    def __init__(self, path: Path, tool: str) -> None:
        spec = mujoco.MjSpec.from_file(str(path))
        spec.compiler.fusestatic = False
        off = mujoco.mjtDisableBit
        spec.option.disableflags |= off.mjDSBL_LIMIT | off.mjDSBL_CONTACT
        spec.option.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.tool = tool

    def at(self, q: Array, dq: Array) -> dict[str, Array]:
        """What `Dynamics` holds, by its names, and the potential energy U [J]."""
        model, data = self.model, self.data
        data.qpos[:], data.qvel[:] = q, 0.0
        mujoco.mj_forward(model, data)
        g, U = np.array(data.qfrc_bias), np.array(data.energy[0])
        data.qvel[:] = dq
        mujoco.mj_forward(model, data)
        i = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, self.tool)
        if i >= 0:
            p, R, body = data.site_xpos[i], data.site_xmat[i], model.site_bodyid[i]
        else:
            body = model.body(self.tool).id
            p, R = data.xpos[body], data.xmat[body]
        J, J_dot = np.zeros((2, 6, model.nv))
        mujoco.mj_jac(model, data, J[:3], J[3:], p, body)
        mujoco.mj_jacDot(model, data, J_dot[:3], J_dot[3:], p, body)
        M = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, *((M, data.qM) if MUJOCO_3 else (data, M)))
        h = data.qfrc_bias - g
        return {"p": p, "R": R.reshape(3, 3), "J": J, "dJdq": J_dot @ dq, "M": M, "g": g, "h": h, "U": U}

    @property
    def limits(self) -> Array:
        """Lower and upper, (2, n); ±inf where there are none."""
        free = self.model.jnt_limited[:, None] == 0
        return np.asarray(np.where(free, [-np.inf, np.inf], self.model.jnt_range).T)
