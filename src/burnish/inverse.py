"""Inverses of matrices that come close to singular when the arm does."""

from __future__ import annotations

from functools import lru_cache
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
    s = 0.0 if inverse is None else 1.0 / float(np.sqrt(np.vdot(inverse, inverse)))
    if inverse is not None and s >= threshold:
        return inverse
    mu = threshold * (1.0 - s / threshold) ** 2
    damped = _spd_inverse(A + mu * np.eye(len(A)))
    assert damped is not None, "A + mu I is positive definite when A is positive semi-definite"
    return damped


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
    factor, info = lapack.dpotrf(A, lower=1)
    if info != 0:
        return None
    lower, info = lapack.dpotri(factor, lower=1)
    if info != 0:
        return None
    above = _above(len(A))
    lower[above] = lower.T[above]
    return np.asarray(lower)


@lru_cache
def _above(n: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Indices above the diagonal of an (n, n) matrix."""
    return np.triu_indices(n, 1)
