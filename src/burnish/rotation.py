"""Rotations: their exponential and logarithm, quaternions, Euler angles, and the published orientation errors.

Matrices are base ← tool, (3, 3); quaternions are ``[η, ε]``, scalar first, (4,); rotation vectors ``θ u``
[rad], (3,), have θ in [0, π]. Every orientation error ``(R, R_d) → (3,)`` is in base axes and points **towards**
the target: turning the tool about it reduces it.
"""

from __future__ import annotations

from math import atan2, cos, hypot, radians, sin, sqrt
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from burnish.errors import InputError

Array: TypeAlias = NDArray[np.float64]


def skew(a: Array) -> Array:
    """The matrix S(a) with S(a) b = a × b, (3, 3)."""
    x, y, z = float(a[0]), float(a[1]), float(a[2])
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def exp(rotation_vector: Array) -> Array:
    """Rotation matrix of a rotation vector θu [rad], (3, 3): Rodrigues' formula, exact down to θ = 0."""
    x, y, z = (float(c) for c in rotation_vector)
    theta2 = x * x + y * y + z * z
    theta = sqrt(theta2)
    if theta < 1e-4:
        # Series of sin θ/θ and (1 − cos θ)/θ²: the next terms are below 1e-17 here.
        a, b = 1.0 - theta2 / 6.0, 0.5 - theta2 / 24.0
    else:
        a, b = sin(theta) / theta, (1.0 - cos(theta)) / theta2
    return np.array(
        [
            [1.0 - b * (y * y + z * z), b * x * y - a * z, b * x * z + a * y],
            [b * x * y + a * z, 1.0 - b * (x * x + z * z), b * y * z - a * x],
            [b * x * z - a * y, b * y * z + a * x, 1.0 - b * (x * x + y * y)],
        ]
    )


def log(R: Array) -> Array:
    """Rotation vector θu [rad], (3,), of a rotation matrix: through the quaternion, so exact near 0 and near π."""
    eta, x, y, z = _quaternion(R)
    s = sqrt(x * x + y * y + z * z)
    if s < 1e-8:
        # θ/sin(θ/2) → 2 with an error of θ²/12 < 1e-17.
        scale = 2.0
    else:
        scale = 2.0 * atan2(s, eta) / s
    return np.array([scale * x, scale * y, scale * z])


def quaternion(R: Array) -> Array:
    """Unit quaternion [η, ε], (4,), of a rotation matrix, η ≥ 0."""
    return np.array(_quaternion(R))


def quaternions(R: Array) -> Array:
    """Unit quaternions [η, ε], (N, 4), of rotation matrices (N, 3, 3), η ≥ 0; in one go, for whole recordings."""
    # 4 q qᵀ is linear in R; its row with the largest diagonal is the quaternion times a number far from zero.
    outer = (R.reshape(-1, 9) @ _OUTER + np.eye(4).ravel()).reshape(-1, 4, 4)
    largest = np.argmax(np.diagonal(outer, axis1=1, axis2=2), axis=1)
    rows = outer[np.arange(len(outer)), largest]
    rows /= np.sqrt(np.einsum("ij,ij->i", rows, rows))[:, None]
    return np.asarray(np.where(rows[:, :1] < 0.0, -rows, rows))


def from_quaternion(Q: Array) -> Array:
    """Rotation matrix of a unit quaternion [η, ε].

    Raises:
        InputError: if the norm is further than 1e-3 from 1.
    """
    w, x, y, z = (float(c) for c in Q)
    n = w * w + x * x + y * y + z * z
    if not abs(sqrt(n) - 1.0) <= 1e-3:
        raise InputError(f"quaternion {[w, x, y, z]} has norm {sqrt(n):.4g}; expected 1. Normalise it")
    s = 2.0 / n
    return np.array(
        [
            [1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
            [s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)],
            [s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)],
        ]
    )


def euler_xyz(R: Array) -> Array:
    """Intrinsic XYZ angles (α, β, γ) [rad], (3,), with R = Rx(α) Ry(β) Rz(γ), β in [−π/2, π/2].

    At β = ±π/2 only α ± γ is determined; γ is 0 there.

    Source: thesis A, eq. 4.4 (its R₁₂ and R₃₁ are misprinted), and the vendor's cartesian pose.
    """
    c = hypot(float(R[0, 0]), float(R[0, 1]))
    beta = atan2(float(R[0, 2]), c)
    if c < 1e-9:
        return np.array([atan2(float(R[2, 1]), float(R[1, 1])), beta, 0.0])
    return np.array([atan2(-float(R[1, 2]), float(R[2, 2])), beta, atan2(-float(R[0, 1]), float(R[0, 0]))])


def from_euler_xyz(angles: Array) -> Array:
    """Rotation matrix Rx(α) Ry(β) Rz(γ) of intrinsic XYZ angles [rad]."""
    a, b, c = (float(x) for x in angles)
    sa, ca, sb, cb, sc, cc = sin(a), cos(a), sin(b), cos(b), sin(c), cos(c)
    return np.array(
        [
            [cb * cc, -cb * sc, sb],
            [sa * sb * cc + ca * sc, -sa * sb * sc + ca * cc, -sa * cb],
            [-ca * sb * cc + sa * sc, ca * sb * sc + sa * cc, ca * cb],
        ]
    )


def interpolate(R0: Array, R1: Array, s: float) -> Array:
    """The rotation a share s of the shortest way from R0 to R1: exp(s log(R1 R0ᵀ)) R0."""
    return exp(s * log(R1 @ R0.T)) @ R0


def rotation_vector_error(R: Array, R_d: Array) -> Array:
    """θu of R_d Rᵀ [rad], (3,): the only one of the three that keeps growing up to θ = π.

    Source: thesis A, eq. 4.5–4.7, turned from tool into base axes and without its division by sin θ.
    """
    return log(R_d.dot(R.T))


def quaternion_error(R: Array, R_d: Array) -> Array:
    """sin(θ/2) u, (3,): the vector part of the error quaternion, taken the short way.

    Source: the blog's methods 1, 2 and 4 (Caccavale 1998, eq. 34; Yuan 1988), which are one function.
    """
    _, x, y, z = _quaternion(R_d @ R.T)
    return np.array([x, y, z])


def sine_error(R: Array, R_d: Array) -> Array:
    """sin θ u, (3,): half the skew part of R_d Rᵀ; it vanishes at θ = π as well as at 0.

    Source: the blog's method 3 (Caccavale 1998, eq. 45), pointing towards the target.
    """
    E = R_d @ R.T
    return 0.5 * np.array([E[2, 1] - E[1, 2], E[0, 2] - E[2, 0], E[1, 0] - E[0, 1]])


def continuous_error(R: Array, R_d: Array) -> Array:
    """θu [rad], (3,), faded to 0 over the last `FADE` before θ = π: continuous on all rotations, for a control law.

    At θ = π the axis u is as good as −u, so an error that always points the short way has to jump there, or to
    vanish. This one is `rotation_vector_error` up to π − FADE and vanishes at π; a tool that stands there leaves by
    itself, because next to π the error points away from it.
    """
    return np.array(continuous_error_of(R, R_d))


def continuous_error_of(R: Array, R_d: Array) -> tuple[float, float, float]:
    """`continuous_error` as three plain numbers [rad]: for a law that goes on with them one by one."""
    eta, x, y, z = _quaternion(R_d.dot(R.T))
    s = sqrt(x * x + y * y + z * z)
    # Near 0, θ/sin(θ/2) → 2 with an error of θ²/12 < 1e-17.
    scale = 2.0 if s < 1e-8 else 2.0 * atan2(s, eta) / s
    if eta < _FADE_ETA:
        share = eta / _FADE_ETA
        scale *= share * share * (3.0 - 2.0 * share)
    return scale * x, scale * y, scale * z


FADE = radians(5.0)
"""Width of the fade of `continuous_error` before θ = π [rad]. A choice: wide enough that the torque of a stiff law
changes slowly over it for a sampled loop, narrow enough that no task notices."""
_FADE_ETA = sin(0.5 * FADE)
"""cos(θ/2) where the fade begins."""


def _quaternion(R: Array) -> tuple[float, float, float, float]:
    """[η, ε] with η ≥ 0, dividing by the largest of the four components (Shepperd's choice)."""
    (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = R.tolist()
    trace = r00 + r11 + r22
    if trace > max(r00, r11, r22):
        w = 0.5 * sqrt(max(0.0, 1.0 + trace))
        f = 0.25 / w
        q = (w, f * (r21 - r12), f * (r02 - r20), f * (r10 - r01))
    elif r00 >= r11 and r00 >= r22:
        x = 0.5 * sqrt(max(0.0, 1.0 + r00 - r11 - r22))
        f = 0.25 / x
        q = (f * (r21 - r12), x, f * (r01 + r10), f * (r02 + r20))
    elif r11 >= r22:
        y = 0.5 * sqrt(max(0.0, 1.0 + r11 - r00 - r22))
        f = 0.25 / y
        q = (f * (r02 - r20), f * (r01 + r10), y, f * (r12 + r21))
    else:
        z = 0.5 * sqrt(max(0.0, 1.0 + r22 - r00 - r11))
        f = 0.25 / z
        q = (f * (r10 - r01), f * (r02 + r20), f * (r12 + r21), z)
    return q if q[0] >= 0.0 else (-q[0], -q[1], -q[2], -q[3])


def _outer_of_rotation() -> Array:
    """The matrix that takes the nine numbers of R, row by row, to the sixteen of 4 q qᵀ − 1, (9, 16)."""
    A = np.zeros((3, 3, 4, 4))
    for i, signs in enumerate(((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))):
        for j, sign in enumerate(signs):
            A[j, j, i, i] = sign
    for i, j in ((2, 1), (0, 2), (1, 0)):
        k = 3 - i - j
        for a, b in ((0, k + 1), (k + 1, 0)):
            A[i, j, a, b], A[j, i, a, b] = 1.0, -1.0
        for a, b in ((i + 1, j + 1), (j + 1, i + 1)):
            A[i, j, a, b] = A[j, i, a, b] = 1.0
    return A.reshape(9, 16)


_OUTER = _outer_of_rotation()
