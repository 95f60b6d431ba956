"""The wrench that moves a rigid body, linear in what is unknown about the body."""

from __future__ import annotations

import numpy as np

from burnish.core import Array
from burnish.rotation import skew

GRAVITY = np.array([0.0, 0.0, -9.81])
"""Acceleration of gravity in base axes [m/s²]; that of `Model`."""


def body_regressor(R: Array, omega: Array, a: Array) -> Array:
    """Y, (6, 10), with Y θ the wrench [N, N·m] that moves a body fixed to the tool, in base axes about the tool point.

    With m the mass, c its centre of mass and I its inertia about the tool point, both in tool axes, and p̈, ω̇ = a:

        f = m (p̈ − γ) + [S(ω̇) + S(ω)²] R m c
        μ = R m c × (p̈ − γ) + R (I ω̇_t + ω_t × I ω_t)

    with γ gravity and ω_t = Rᵀω, ω̇_t likewise; θ = [m, m c (3), I_xx, I_xy, I_xz, I_yy, I_yz, I_zz]. A mass m at a
    known place has the last six in m and c, which is why they are parameters of their own.

    Args:
        R: tool rotation, base ← tool.
        omega: angular velocity, base axes [rad/s], (3,).
        a: acceleration of the tool point and angular acceleration, base axes [m/s², rad/s²], (6,).

    Source: Atkeson, An and Hollerbach 1986.
    """
    lift = a[:3] - GRAVITY
    omega_t, domega_t = R.T @ omega, R.T @ a[3:]
    Y = np.zeros((6, 10))
    Y[:3, 0] = lift
    Y[:3, 1:4] = (skew(a[3:]) + skew(omega) @ skew(omega)) @ R
    Y[3:, 1:4] = -skew(lift) @ R
    Y[3:, 4:] = R @ (_inertia_times(domega_t) + skew(omega_t) @ _inertia_times(omega_t))
    return Y


def _inertia_times(x: Array) -> Array:
    """L(x), (3, 6), with L(x) [I_xx, I_xy, I_xz, I_yy, I_yz, I_zz] = I x."""
    x1, x2, x3 = x.tolist()
    return np.array([[x1, x2, x3, 0.0, 0.0, 0.0], [0.0, x1, 0.0, x2, x3, 0.0], [0.0, 0.0, x1, 0.0, x2, x3]])
