"""Every term of the JACO2 by three routes, against numbers that two engines computed outside this repository."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from model.arms import MUJOCO_3
from numpy.testing import assert_allclose

from burnish.core import Array, State
from burnish.model.lagrange import jaco2_lagrange
from burnish.model.model import JACO2_URDF, Model

ORACLE: dict[str, Any] = json.loads((Path(__file__).parent / "data" / "jaco2_oracle.json").read_text())
TERMS = ("T", "J", "Jdot_qd", "M", "g", "Cqd", "tau", "C")
TOLERANCE = 1e-9
"""What is asked for; all three routes are within 1e-13. Torques are below 20 N·m, lengths below 1 m."""


def coriolis_matrix(h: Callable[[Array], Array], dq: Array) -> Array:
    """C(q, q̇) of Christoffel symbols from the torque h(q̇) = C(q, q̇) q̇ alone, exactly, (n, n).

    h is a quadratic form Γ(q̇, q̇), and C e = Γ(q̇, e) its symmetric bilinear one, ½ [h(q̇ + e) − h(q̇) − h(e)].
    """
    return np.column_stack([0.5 * (h(dq + e) - h(dq) - h(e)) for e in np.eye(len(dq))])


def by_model(model: Any, q: Array, dq: Array, ddq: Array) -> dict[str, Array]:
    """The terms from whatever has `Model.at`."""
    arm = model.at(State(t=0.0, q=q, dq=dq))
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = arm.R, arm.p
    C = coriolis_matrix(lambda v: model.at(State(t=0.0, q=q, dq=v)).h, dq)
    tau = arm.M @ ddq + arm.h + arm.g
    return {"T": T, "J": arm.J, "Jdot_qd": arm.dJdq, "M": arm.M, "g": arm.g, "Cqd": arm.h, "tau": tau, "C": C}


def by_pinocchio(q: Array, dq: Array, ddq: Array) -> dict[str, Array]:
    return by_model(Model.jaco2(), q, dq, ddq)


def by_lagrange(q: Array, dq: Array, ddq: Array) -> dict[str, Array]:
    """DH and Lagrange, no engine; C from the derivatives of M."""
    lagrange = jaco2_lagrange()
    return by_model(lagrange, q, dq, ddq) | {"C": lagrange.coriolis_matrix(q, dq)}


def mujoco_model() -> Any:
    """MuJoCo's own reading of the packaged description, without the limits and contacts that it would add."""
    spec = mujoco.MjSpec.from_file(str(JACO2_URDF))
    spec.compiler.fusestatic = False
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT | mujoco.mjtDisableBit.mjDSBL_CONTACT
    return spec.compile()


MUJOCO = mujoco_model()


def by_mujoco(q: Array, dq: Array, ddq: Array) -> dict[str, Array]:
    """J̇ from ``mj_jacDot``, tau from ``mj_inverse``: every term has a route of its own in this engine but C."""
    model, data = MUJOCO, mujoco.MjData(MUJOCO)
    tool = model.body("end_effector").id

    def bias(v: Array) -> Array:
        data.qpos[:], data.qvel[:], data.qacc[:] = q, v, 0.0
        mujoco.mj_inverse(model, data)
        return np.array(data.qfrc_inverse)

    g = bias(np.zeros_like(dq))
    C = coriolis_matrix(lambda v: bias(v) - g, dq)
    data.qpos[:], data.qvel[:], data.qacc[:] = q, dq, ddq
    mujoco.mj_inverse(model, data)
    T, J, J_dot, M = np.eye(4), *np.zeros((2, 6, model.nv)), np.zeros((model.nv, model.nv))
    T[:3, :3], T[:3, 3] = data.xmat[tool].reshape(3, 3), data.xpos[tool]
    mujoco.mj_jac(model, data, J[:3], J[3:], data.xpos[tool], tool)
    mujoco.mj_jacDot(model, data, J_dot[:3], J_dot[3:], data.xpos[tool], tool)
    mujoco.mj_fullM(model, *((M, data.qM) if MUJOCO_3 else (data, M)))
    h = data.qfrc_bias - g
    return {"T": T, "J": J, "Jdot_qd": J_dot @ dq, "M": M, "g": g, "Cqd": h, "tau": data.qfrc_inverse, "C": C}


ROUTES = {"Pinocchio": by_pinocchio, "DH and Lagrange": by_lagrange, "MuJoCo": by_mujoco}


def test_oracle_has_the_states_that_are_asked_for() -> None:
    assert len(ORACLE["samples"]) == 25
    assert len(ORACLE["named"]) == 8


@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize("sample", ORACLE["samples"], ids=range(len(ORACLE["samples"])))
def test_every_term_is_that_of_the_oracle(route: str, sample: dict[str, Any]) -> None:
    found = ROUTES[route](*(np.array(sample[key]) for key in ("q", "qd", "qdd")))
    assert set(found) == set(TERMS)
    for name in TERMS:
        assert_allclose(found[name], sample[name], rtol=0.0, atol=TOLERANCE, err_msg=name)


@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize("name", ORACLE["named"])
def test_named_pose_is_that_of_the_oracle(route: str, name: str) -> None:
    pose = ORACLE["named"][name]
    found = ROUTES[route](np.array(pose["q"]), *np.zeros((2, 6)))
    for term in ("T", "J", "M", "g"):
        assert_allclose(found[term], pose[term], rtol=0.0, atol=TOLERANCE, err_msg=term)
    assert_allclose(found["tau"], pose["g"], rtol=0.0, atol=TOLERANCE)  # at rest nothing else is left


@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize("term", TERMS)
def test_disagreement_is_noticed(route: str, term: str) -> None:
    # The guard of the two tests above: a term that is off by a part in a million is not that of the oracle.
    sample = ORACLE["samples"][0]
    found = ROUTES[route](*(np.array(sample[key]) for key in ("q", "qd", "qdd")))
    with pytest.raises(AssertionError):
        assert_allclose(found[term] * (1.0 + 1e-6), sample[term], rtol=0.0, atol=TOLERANCE)
