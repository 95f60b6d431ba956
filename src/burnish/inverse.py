"""Inverses of matrices that come close to singular when the arm does."""

from __future__ import annotations

from functools import lru_cache
from math import sqrt
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from burnish.errors import InputError

Array: TypeAlias = NDArray[np.float64]


def damped_spd_inverse(A: Array, threshold: float) -> Array:
    """Inverse of a symmetric positive semi-definite A, damped smoothly next to a singularity.

    ``(A + mu I)⁻¹`` with ``mu = threshold (1 − s/threshold)²`` where ``s = 1/‖A⁻¹‖_F`` lies below the
    threshold, and ``mu = 0`` above it. ``s`` is a smooth bound of the smallest eigenvalue,
    ``s ≤ lambda_min ≤ √n s``, so nothing jumps when the damping sets in.

    Args:
        A: symmetric matrix (n, n).
        threshold: eigenvalue below which damping sets in, unit of A, positive.
    """
    inverse = _spd_inverse(A)
    s = 0.0 if inverse is None else 1.0 / sqrt(float(np.vdot(inverse, inverse)))
    if inverse is not None and s >= threshold:
        return inverse
    mu = threshold * (1.0 - s / threshold) ** 2
    damped = _spd_inverse(A + mu * np.eye(len(A)))
    assert damped is not None, "A + mu I is positive definite when A is positive semi-definite"
    return damped


def damped_spd_solve(A: Array, b: Array, threshold: float) -> Array:
    """``damped_spd_inverse(A, threshold) @ b`` for b (n,), in one factorisation for the control cycle.

    A X = [b I] gives the solution and, beside it, A⁻¹ for the test of how close the singularity is.
    """
    n = len(A)
    right = _beside_identity(n).copy(order="F")
    right[:, 0] = b
    _, X, info = lapack.dposv(A, right, lower=1, overwrite_b=1)
    flat = X.T.ravel()
    inverse = flat[n:]
    s = 0.0 if info != 0 else 1.0 / sqrt(float(inverse.dot(inverse)))
    if s >= threshold:
        return np.asarray(flat[:n])
    mu = threshold * (1.0 - s / threshold) ** 2
    _, x, _ = lapack.dposv(A + mu * np.eye(n), b, lower=1)
    return np.asarray(x)


def task_inertia(J: Array, M: Array, threshold: float) -> tuple[Array, Array]:
    """Λ = (J M⁻¹ Jᵀ)⁻¹, (m, m), damped next to a singularity, and beside it J̄ = M⁻¹ Jᵀ Λ, (n, m).

    Args:
        J: task Jacobian (m, n), m ≤ n.
        M: mass matrix (n, n).
        threshold: eigenvalue of J M⁻¹ Jᵀ [1/kg, 1/(kg·m²)] below which damping sets in, as in `damped_spd_inverse`.

    Raises:
        InputError: if M is found not to be positive definite; of a square J far from a singularity nobody looks.
    """
    if len(J) == len(M):
        # Of a square J they are J⁻ᵀ M J⁻¹ and J⁻¹: one factorisation instead of two.
        _, _, J_inverse, info = lapack.dgesv(J, _identity(len(J)))
        Lambda = J_inverse.T.dot(M).dot(J_inverse)
        if info == 0 and float(np.vdot(Lambda, Lambda)) * threshold**2 <= 1.0:
            return Lambda, J_inverse
    _, Minv_JT, info = lapack.dposv(M, J.T, lower=1)
    if info != 0:
        raise InputError("the mass matrix is not positive definite: the model's inertias are not physical")
    Lambda = damped_spd_inverse(J.dot(Minv_JT), threshold)
    return Lambda, Minv_JT.dot(Lambda)


def task_torque(J: Array, M: Array, a: Array, threshold: float) -> Array:
    """Jᵀ Λ a, (n,): the torque that accelerates a task by ``a``, with Λ = (J M⁻¹ Jᵀ)⁻¹ damped next to a singularity.

    Args:
        J: task Jacobian (m, n), m ≤ n.
        M: mass matrix (n, n).
        a: task acceleration (m,), less J̇q̇.
        threshold: eigenvalue of J M⁻¹ Jᵀ [1/kg, 1/(kg·m²)] below which damping sets in, as in `damped_spd_inverse`.
    """
    if len(J) == len(M):
        # Of a square J it is M J⁻¹ a. No eigenvalue of Λ is above its trace, so below 1/threshold nothing is damped.
        _, _, J_inverse, info = lapack.dgesv(J, _identity(len(J)))
        M_J_inverse_T = J_inverse.T.dot(M)
        if info == 0 and float(np.vdot(J_inverse.T, M_J_inverse_T)) * threshold <= 1.0:
            return np.asarray(a.dot(M_J_inverse_T))
    _, Minv_JT, _ = lapack.dposv(M, J.T, lower=1)
    return np.asarray(damped_spd_solve(J.dot(Minv_JT), a, threshold).dot(J))


def weighted_inverse(J: Array, W: Array, threshold: float = 1e-9) -> Array:
    """Generalised inverse J# = W⁻¹ Jᵀ (J W⁻¹ Jᵀ)⁻¹, which among all q̇ with J q̇ = v has the least q̇ᵀ W q̇.

    J# J is the W-orthogonal projector on what the task needs. W = I gives the Moore–Penrose inverse, W = M the
    dynamically consistent one. J W⁻¹ Jᵀ is inverted by `damped_spd_inverse`.

    Args:
        J: task Jacobian (m, n), m ≤ n.
        W: symmetric positive definite weight (n, n).
        threshold: eigenvalue of J W⁻¹ Jᵀ below which damping sets in; the default is next to exact.

    Returns:
        (n, m).

    Raises:
        InputError: if W is not positive definite.

    Source: thesis A, 4.1.3 and 4.3; thesis B, 4.3.3.
    """
    _, Winv_JT, info = lapack.dposv(W, J.T, lower=1)
    if info != 0:
        raise InputError("the weight of a generalised inverse is not positive definite; expected one like I or M")
    return np.asarray(Winv_JT @ damped_spd_inverse(J @ Winv_JT, threshold))


def dynamically_consistent_inverse(J: Array, M: Array, threshold: float = 1e-9) -> Array:
    """J̄ = M⁻¹ Jᵀ Λ, the weighted inverse with W = M, (n, m): a torque (I − Jᵀ J̄ᵀ) τ accelerates no part of the task.

    Args:
        J: task Jacobian (m, n), m ≤ n.
        M: mass matrix (n, n).
        threshold: eigenvalue of J M⁻¹ Jᵀ [1/kg, 1/(kg·m²)] below which damping sets in.
    """
    return weighted_inverse(J, M, threshold)


def null_space_projector(J: Array, J_inverse: Array) -> Array:
    """N = I − J# J, (n, n): N q̇ leaves the task alone; for torques with J# = J̄ it is Nᵀ τ that does."""
    return np.asarray(np.eye(J.shape[1]) - J_inverse @ J)


def damped_inverse(J: Array, threshold: float) -> Array:
    """Pseudo-inverse of J, (n, m), damped smoothly and only in the directions that are about to be lost.

    With J = Σ s u vᵀ the inverse is Σ f(s) v uᵀ, f(s) = s / (s² + λ²), λ² = threshold² (1 − s/threshold)² below the
    threshold and 0 above: f has no jump and no kink where the damping sets in, is 0 where s is 0, and is never more
    than 1.21/threshold. Directions with s above the threshold are inverted exactly.

    Args:
        J: any matrix (m, n). Its singular values mix metres and radians when J has both; scale rows to choose.
        threshold: singular value below which damping sets in, unit of J, positive.

    Source: damped least squares (Nakamura and Hanafusa 1986, Wampler 1986), a direction at a time. The blog switches
    from inverse to pseudo-inverse on det = 0, which jumps.
    """
    u, s, vt = np.linalg.svd(J, full_matrices=False)
    lost = np.maximum(threshold - s, 0.0)
    return np.asarray((vt.T * (s / (s**2 + lost**2))) @ u.T)


def manipulability(J: Array) -> float:
    """√det(J Jᵀ), the product of the singular values of J (m, n), m ≤ n; 0 in a singularity. Yoshikawa 1985."""
    return float(np.prod(np.linalg.svd(J, compute_uv=False)))


def smallest_singular_value(J: Array) -> float:
    """Least task speed per joint speed over all directions: the distance to the nearest singular matrix, unit of J."""
    return float(np.linalg.svd(J, compute_uv=False)[-1])


def _spd_inverse(A: Array) -> Array | None:
    """A⁻¹ by Cholesky, or None where A is numerically singular."""
    _, inverse, info = lapack.dposv(A, _identity(len(A)), lower=1)
    return None if info != 0 else np.asarray(inverse)


@lru_cache
def _beside_identity(n: int) -> Array:
    """[0 I], (n, n + 1): room for one right-hand side."""
    return np.eye(n, n + 1, 1)


@lru_cache
def _identity(n: int) -> Array:
    """I, (n, n), in the engine's order of columns."""
    return np.asfortranarray(np.eye(n))
