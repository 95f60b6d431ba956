from __future__ import annotations

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import ArrayLike

from burnish.core import SINGULAR_MOBILITY, Array, Dynamics, State, read_only
from burnish.errors import InputError
from burnish.model.model import Model

HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
STRETCHED = np.array([0.0, np.pi / 2, np.pi, 0.0, 0.0, 0.0])
"""The elbow straight: the tool cannot move outwards."""


def state(q: ArrayLike, dq: ArrayLike = 0.0) -> State:
    q = np.asarray(q, dtype=float)
    return State(t=0.0, q=q, dq=np.broadcast_to(dq, q.shape))


def random_arms(seed: int, count: int) -> list[Dynamics]:
    """The JACO2 at random states, those next to a singularity left out."""
    model, rng = Model.jaco2(), np.random.default_rng(seed)
    arms: list[Dynamics] = []
    while len(arms) < count:
        arm = model.at(state(rng.uniform(-np.pi, np.pi, 6), rng.uniform(-1.0, 1.0, 6)))
        if np.linalg.eigvalsh(arm.J @ np.linalg.solve(arm.M, arm.J.T))[0] > 3.0 * SINGULAR_MOBILITY:
            arms.append(arm)
    return arms


# Data.


def test_read_only_copies() -> None:
    mine = np.arange(3.0)
    kept = read_only(mine)
    mine[0] = 9.0
    assert kept[0] == 0.0


def test_read_only_cannot_be_written() -> None:
    with pytest.raises(ValueError, match="read-only"):
        read_only([1.0, 2.0])[0] = 3.0


@pytest.mark.parametrize("name", ["q", "dq", "tau", "F"])
def test_state_keeps_a_copy_that_nobody_can_write(name: str) -> None:
    values = {"q": np.zeros(6), "dq": np.zeros(6), "tau": np.zeros(6), "F": np.zeros(6)}
    measured = State(t=0.0, **values)
    values[name][:] = 1.0
    kept = getattr(measured, name)
    assert not kept.any()
    assert not kept.flags.writeable


def test_state_without_sensors_has_neither_torque_nor_wrench() -> None:
    measured = state(HOME)
    assert measured.tau is None
    assert measured.F is None


def test_state_cannot_be_changed() -> None:
    with pytest.raises(FrozenInstanceError):
        state(HOME).t = 1.0  # type: ignore[misc]


@pytest.mark.parametrize(("q", "dq"), [((6,), (5,)), ((6,), (6, 1)), ((2, 3), (2, 3)), ((), ())])
def test_state_of_another_shape_is_refused_by_name(q: tuple[int, ...], dq: tuple[int, ...]) -> None:
    with pytest.raises(InputError, match="two vectors of one length"):
        State(t=0.0, q=np.zeros(q), dq=np.zeros(dq))


# Dynamics.


def test_tool_twist_is_the_motion_of_the_tool() -> None:
    model, rng = Model.jaco2(), np.random.default_rng(1)
    for _ in range(10):
        q, dq = rng.uniform(-3.0, 3.0, 6), rng.uniform(-1.0, 1.0, 6)
        h = 1e-6
        ahead, behind = model.at(state(q + h * dq)), model.at(state(q - h * dq))
        v = model.at(state(q, dq)).v
        turn = (ahead.R - behind.R) @ behind.R.T / (2.0 * h)
        # Central differences over 1e-6 s: 1e-10 of rounding, 1e-12 of curvature; the rotation's are one-sided, 1e-6.
        assert_allclose(v[:3], (ahead.p - behind.p) / (2.0 * h), atol=1e-8)
        assert_allclose(v[3:], [turn[2, 1], turn[0, 2], turn[1, 0]], atol=1e-5)


def test_mass_matrix_times_its_solution_is_the_jacobian() -> None:
    for arm in random_arms(2, 10):
        assert_allclose(arm.M @ arm.Minv_JT, arm.J.T, atol=1e-13)


def test_mass_matrix_that_is_not_positive_definite_is_refused() -> None:
    arm = Model.jaco2().at(state(HOME))
    with pytest.raises(InputError, match="not positive definite"):
        _ = replace(arm, M=-arm.M).Minv_JT


def test_operational_inertia_is_the_inverse_of_the_mobility() -> None:
    for arm in random_arms(3, 20):
        mobility = arm.J @ np.linalg.inv(arm.M) @ arm.J.T
        # The condition number of M is about 1e4, and that of the mobility about as much.
        assert_allclose(arm.Lambda @ mobility, np.eye(6), atol=1e-9)


def test_operational_inertia_is_that_of_the_kinetic_energy() -> None:
    # On six joints v = J q̇ is invertible, and both coordinates see one energy.
    for arm in random_arms(4, 20):
        assert arm.v @ arm.Lambda @ arm.v == pytest.approx(arm.dq @ arm.M @ arm.dq, rel=1e-9)


def test_dynamically_consistent_inverse_is_a_right_inverse() -> None:
    for arm in random_arms(5, 20):
        assert_allclose(arm.J @ arm.J_bar, np.eye(6), atol=1e-9)


def test_dynamically_consistent_inverse_leaves_the_tool_alone_in_its_null_space(seven_joints: Model) -> None:
    rng = np.random.default_rng(6)
    for _ in range(20):
        arm = seven_joints.at(state(rng.uniform(0.4, 1.2, 7)))
        tau = (np.eye(7) - arm.J.T @ arm.J_bar.T) @ rng.normal(size=7)
        # The torque does not vanish, the acceleration of the tool does.
        assert np.linalg.norm(tau) > 1e-3
        assert_allclose(arm.J @ np.linalg.solve(arm.M, tau), np.zeros(6), atol=1e-9)


def test_force_at_the_tool_accelerates_it_by_the_inverse_inertia() -> None:
    rng = np.random.default_rng(7)
    for arm in random_arms(8, 10):
        F = rng.normal(size=6)
        assert_allclose(arm.Lambda @ (arm.J @ np.linalg.solve(arm.M, arm.J.T @ F)), F, atol=1e-8)


def test_operational_inertia_stays_finite_in_a_singularity() -> None:
    arm = Model.jaco2().at(state(STRETCHED))
    assert np.linalg.svd(arm.J)[1][-1] < 1e-9
    # (A + mu I)⁻¹ with mu = the threshold in the singularity itself.
    assert np.linalg.norm(arm.Lambda, 2) <= 1.0 / SINGULAR_MOBILITY * (1.0 + 1e-9)


def test_operational_inertia_does_not_jump_on_the_way_through_a_singularity() -> None:
    model = Model.jaco2()
    bends = np.linspace(-0.2, 0.2, 4001)
    Lambda = np.array([model.at(state(STRETCHED + [0.0, 0.1, bend, 0.3, 0.8, 0.2])).Lambda for bend in bends])
    steps = np.abs(np.diff(Lambda, axis=0)).max(axis=(1, 2))
    # A jump keeps its size when the steps are halved, a slope does not.
    coarse = np.abs(np.diff(Lambda[::2], axis=0)).max(axis=(1, 2))
    assert steps.max() < 0.55 * coarse.max()


@pytest.fixture
def seven_joints(pytestconfig: pytest.Config) -> Model:
    return Model.from_urdf(pytestconfig.rootpath / "tests" / "data" / "seven_dof.urdf", tool="tool0")


def test_read_only_keeps_numbers() -> None:
    values: Array = read_only([[1, 2], [3, 4]])
    assert values.dtype == np.float64
    assert_allclose(values, [[1.0, 2.0], [3.0, 4.0]], atol=0.0)
