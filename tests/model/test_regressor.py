from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.core import Array, State
from burnish.model.model import Model
from burnish.model.regressor import body_regressor

ARM = Model.jaco2()


def parameters(mass: float, com: Array, inertia: Array) -> Array:
    """θ of a body with this inertia about its centre of mass: moved to the tool point by the parallel-axis theorem."""
    about_tool = inertia + mass * (com @ com * np.eye(3) - np.outer(com, com))
    return np.concatenate([[mass], mass * com, about_tool[np.triu_indices(3)]])


@pytest.mark.parametrize("seed", range(5))
def test_regressor_times_body_is_what_the_body_adds_to_the_torque_of_the_arm(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mass, com = rng.uniform(0.2, 2.0), rng.uniform(-0.1, 0.1, 3)
    root = rng.normal(size=(3, 3)) * 0.05
    # Of masses spread as root rootᵀ says; any other tensor is not a body's.
    inertia = np.trace(root @ root.T) * np.eye(3) - root @ root.T
    q, dq, ddq = rng.normal(size=(3, 6))
    state = State(t=0.0, q=q, dq=dq)
    free, laden = ARM.at(state), ARM.with_payload(mass, com, inertia).at(state)
    added = (laden.M - free.M) @ ddq + laden.h - free.h + laden.g - free.g
    Y = body_regressor(free.R, free.v[3:], free.J @ ddq + free.dJdq)
    assert_allclose(free.J.T @ Y @ parameters(mass, com, inertia), added, atol=1e-10)
