from __future__ import annotations

import numpy as np
import pytest

from burnish.core import Array, State
from burnish.errors import InputError
from burnish.inverse import (
    damped_inverse,
    damped_spd_inverse,
    damped_spd_solve,
    dynamically_consistent_inverse,
    manipulability,
    null_space_projector,
    smallest_singular_value,
    task_torque,
    weighted_inverse,
)
from burnish.model.lagrange import jaco2_lagrange

THRESHOLD = 0.05


def random_task(seed: int, m: int = 3, n: int = 7) -> tuple[Array, Array]:
    """A Jacobian and a positive definite weight."""
    random = np.random.default_rng(seed)
    root = random.normal(size=(n, n))
    return random.normal(size=(m, n)), root @ root.T + 0.1 * np.eye(n)


def near_singular(gap: float, seed: int = 5) -> Array:
    """A 6 × 6 matrix with the singular values 1.2, 1, 0.8, 0.6, 0.4 and ``gap``."""
    random = np.random.default_rng(seed)
    u, v = (np.linalg.qr(random.normal(size=(6, 6)))[0] for _ in range(2))
    return u @ np.diag([1.2, 1.0, 0.8, 0.6, 0.4, gap]) @ v.T


@pytest.mark.parametrize("seed", range(5))
def test_weighted_inverse_solves_the_task_with_the_least_weighted_motion(seed: int) -> None:
    J, W = random_task(seed)
    v, inverse = np.random.default_rng(seed).normal(size=3), weighted_inverse(J, W)
    dq = inverse @ v
    np.testing.assert_allclose(J @ dq, v, atol=1e-10)
    other = dq + null_space_projector(J, inverse) @ np.random.default_rng(seed + 9).normal(size=7)
    np.testing.assert_allclose(J @ other, v, atol=1e-10)
    assert other @ W @ other > dq @ W @ dq


def test_weighted_inverse_with_the_identity_is_that_of_moore_and_penrose() -> None:
    J, _ = random_task(1)
    np.testing.assert_allclose(weighted_inverse(J, np.eye(7)), np.linalg.pinv(J), atol=1e-12)


def test_projector_is_idempotent_and_hides_motion_from_the_task() -> None:
    for seed in range(5):
        J, W = random_task(seed)
        N = null_space_projector(J, weighted_inverse(J, W))
        np.testing.assert_allclose(N @ N, N, atol=1e-10)
        np.testing.assert_allclose(J @ N, np.zeros((3, 7)), atol=1e-10)
        assert np.trace(N) == pytest.approx(4.0)  # seven joints less three of the task


def test_only_the_dynamically_consistent_projector_hides_torques_from_the_task() -> None:
    J, M = random_task(2)
    tau = np.random.default_rng(3).normal(size=7)
    consistent = null_space_projector(J, dynamically_consistent_inverse(J, M))
    geometric = null_space_projector(J, weighted_inverse(J, np.eye(7)))
    assert np.abs(J @ np.linalg.solve(M, consistent.T @ tau)).max() < 1e-10
    assert np.abs(J @ np.linalg.solve(M, geometric.T @ tau)).max() > 1e-2


def test_dynamically_consistent_inverse_is_the_one_of_the_dynamics() -> None:
    q = np.array([4.8, 2.9, 1.0, 4.2, 1.4, 1.3])
    arm = jaco2_lagrange().at(State(t=0.0, q=q, dq=np.zeros(6)))
    np.testing.assert_allclose(dynamically_consistent_inverse(arm.J, arm.M, 0.01), arm.J_bar, atol=1e-10)


def test_weight_that_is_not_positive_definite_is_refused() -> None:
    with pytest.raises(InputError, match="positive definite"):
        weighted_inverse(np.eye(2), np.diag((1.0, -1.0)))


def test_weighted_inverse_stays_finite_where_the_task_is_lost() -> None:
    J = np.array([[1.0, 2.0, 0.5], [2.0, 4.0, 1.0]])
    assert np.isfinite(weighted_inverse(J, np.eye(3), THRESHOLD)).all()
    assert np.isfinite(weighted_inverse(J, np.eye(3))).all()


def test_damped_inverse_is_exact_away_from_singularities() -> None:
    for gap in (THRESHOLD, 2 * THRESHOLD, 0.4):
        J = near_singular(gap)
        np.testing.assert_allclose(damped_inverse(J, THRESHOLD) @ J, np.eye(6), atol=1e-12)
    wide, _ = random_task(4)
    np.testing.assert_allclose(damped_inverse(wide, THRESHOLD), np.linalg.pinv(wide), atol=1e-12)


def test_damping_sets_in_without_jump_or_kink() -> None:
    gaps = np.linspace(0.0, 2 * THRESHOLD, 2001)
    inverses = np.array([damped_inverse(near_singular(gap), THRESHOLD) for gap in gaps])
    slopes = np.diff(inverses, axis=0) / (gaps[1] - gaps[0])
    # The gain f has |f'| ≤ 1.7/threshold² and a bounded second derivative; a switch would show as 1/threshold a step.
    assert np.abs(slopes).max() < 2.0 / THRESHOLD**2
    assert np.abs(np.diff(slopes, axis=0)).max() < 15.0 / THRESHOLD**3 * (gaps[1] - gaps[0])


def test_damped_inverse_is_bounded_and_gives_up_a_lost_direction() -> None:
    for gap in (*np.logspace(-12, -1, 50), 0.0):
        assert np.linalg.norm(damped_inverse(near_singular(gap), THRESHOLD), 2) <= max(2.5, 1.21 / THRESHOLD)
    J = near_singular(0.0)
    lost = np.linalg.svd(J)[0][:, -1]
    np.testing.assert_allclose(damped_inverse(J, THRESHOLD) @ lost, np.zeros(6), atol=1e-12)
    np.testing.assert_allclose(damped_inverse(J, THRESHOLD), np.linalg.pinv(J, rcond=1e-6), atol=1e-12)


def test_only_the_lost_direction_is_damped() -> None:
    J = near_singular(0.2 * THRESHOLD)
    u, s, vt = np.linalg.svd(J)
    inverse = damped_inverse(J, THRESHOLD)
    for i in range(5):
        np.testing.assert_allclose(inverse @ u[:, i], vt[i] / s[i], atol=1e-12)
    assert np.linalg.norm(inverse @ u[:, 5]) < 0.5 / s[5]


def test_damped_spd_inverse_is_exact_above_its_threshold_and_smooth_through_it() -> None:
    root = np.linalg.qr(np.random.default_rng(6).normal(size=(4, 4)))[0]

    def matrix(least: float) -> Array:
        return root @ np.diag([3.0, 2.0, 1.0, least]) @ root.T

    np.testing.assert_allclose(damped_spd_inverse(matrix(0.2), 0.1) @ matrix(0.2), np.eye(4), atol=1e-12)
    gaps = np.linspace(0.0, 0.2, 2001)
    inverses = np.array([damped_spd_inverse(matrix(gap), 0.1) for gap in gaps])
    assert np.abs(np.diff(inverses, axis=0)).max() < 3.0 / 0.1**2 * (gaps[1] - gaps[0])
    assert np.abs(inverses).max() < 3.0 / 0.1


def test_manipulability_is_the_volume_that_unit_joint_speeds_fill() -> None:
    for seed in range(5):
        J, _ = random_task(seed)
        assert manipulability(J) == pytest.approx(np.sqrt(np.linalg.det(J @ J.T)))
    assert manipulability(near_singular(0.0)) == pytest.approx(0.0, abs=1e-15)


def test_smallest_singular_value_is_the_least_gain() -> None:
    J = near_singular(0.03)
    gains = [np.linalg.norm(J @ (dq / np.linalg.norm(dq))) for dq in np.random.default_rng(8).normal(size=(2000, 6))]
    assert smallest_singular_value(J) == pytest.approx(0.03)
    assert min(gains) >= 0.03


@pytest.mark.parametrize("gap", [1.0, 1e-2, 1e-3, 1e-6, 0.0])
def test_solving_is_inverting_and_multiplying_however_close_the_singularity(gap: float) -> None:
    A, b = near_singular(gap), np.arange(1.0, 7.0)
    A = A @ A.T
    expected = damped_spd_inverse(A, THRESHOLD) @ b
    np.testing.assert_allclose(damped_spd_solve(A, b, THRESHOLD), expected, rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize("gap", [1.0, 0.2, 1e-2, 1e-6, 0.0])
@pytest.mark.parametrize("m", [2, 6])
def test_task_torque_is_that_of_the_damped_inertia_on_both_its_ways(gap: float, m: int) -> None:
    # With as many rows as joints and far from a singularity it goes by J⁻¹, else by Λ.
    J, (_, M), a = near_singular(gap)[:m], random_task(3, n=6), np.arange(1.0, m + 1.0)
    Lambda = damped_spd_inverse(J @ np.linalg.solve(M, J.T), THRESHOLD)
    np.testing.assert_allclose(task_torque(J, M, a, THRESHOLD), J.T @ Lambda @ a, rtol=1e-6, atol=1e-7)
