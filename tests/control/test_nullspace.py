from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from closed_loop import ARMS, HOME, JACO2, arm_at, moving, pose, run
from numpy.testing import assert_allclose

from burnish.control import DynamicNullSpace, GeometricNullSpace, JacobianTranspose
from burnish.core import Array, Dynamics
from burnish.rotation import continuous_error

GAINS: dict[str, Any] = {"stiffness": (300.0, 20.0), "damping": (20.0, 2.0)}


def orientation_part(law_type: Any, arm: Dynamics) -> Array:
    """What the law adds to hold an orientation, on top of the same law without an orientation error."""
    law = law_type(**GAINS)
    law.reset(arm)
    still = arm_at(JACO2 if len(arm.q) == 6 else ARMS["seven"][0], arm.q)
    return np.asarray(law.torque(still, pose(still, turn=(0.3, -0.2, 0.4))) - law.torque(still, pose(still)))


@pytest.mark.parametrize("arm_name", ARMS)
def test_dynamic_null_space_torque_does_not_accelerate_the_tool_point(arm_name: str) -> None:
    model, q = ARMS[arm_name]
    for seed in range(5):
        arm = moving(model, q, seed)
        tau = orientation_part(DynamicNullSpace, arm)
        assert np.abs(tau).max() > 0.1
        assert_allclose(arm.J[:3] @ np.linalg.solve(arm.M, tau), np.zeros(3), atol=1e-9)


@pytest.mark.parametrize("arm_name", ARMS)
def test_geometric_null_space_torque_holds_no_force_but_accelerates_the_tool_point(arm_name: str) -> None:
    model, q = ARMS[arm_name]
    for seed in range(5):
        arm = moving(model, q, seed)
        tau = orientation_part(GeometricNullSpace, arm)
        # Least squares of Jvᵀ f = τ: the force that the torque exerts at the point.
        assert_allclose(np.linalg.lstsq(arm.J[:3].T, tau, rcond=None)[0], np.zeros(3), atol=1e-9)
        assert np.abs(arm.J[:3] @ np.linalg.solve(arm.M, tau)).max() > 0.1


@pytest.mark.parametrize("law_type", [GeometricNullSpace, DynamicNullSpace])
def test_position_part_is_that_of_the_jacobian_transpose(law_type: Any) -> None:
    arm = arm_at(JACO2, HOME)
    taus = []
    for law in (law_type(**GAINS), JacobianTranspose(**GAINS)):
        law.reset(arm)
        taus.append(law.torque(arm, pose(arm, dp=(0.02, 0.01, -0.03))))
    assert_allclose(taus[0], taus[1], atol=1e-12)


def test_priority_of_the_position_lowers_its_disturbance_by_an_orientation_command() -> None:
    start = arm_at(JACO2, HOME)
    wanted = pose(start, turn=(0.2, -0.1, 0.2))
    worst = {}
    for law_type in (JacobianTranspose, GeometricNullSpace, DynamicNullSpace):
        seen = run(JACO2, HOME, law_type(stiffness=(400.0, 20.0), damping=(60.0, 4.0)), wanted, 1.0)
        worst[law_type] = max(np.linalg.norm(arm.p - start.p) for arm in seen)
        assert np.linalg.norm(continuous_error(seen[-1].R, wanted.R)) < 0.25
    assert worst[DynamicNullSpace] < 0.2 * worst[JacobianTranspose]
    assert worst[DynamicNullSpace] < worst[GeometricNullSpace]
