"""Gains: checked one by one, from a natural frequency, or from a stiffness, an inertia and a damping ratio."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import lapack

from burnish.core import Array, Dynamics, read_only
from burnish.errors import InputError

Gain: TypeAlias = ArrayLike
"""One number for all, or one for each; the field says of what."""


@dataclass(frozen=True)
class DampingRatio:
    """In the place of damping gains: damp every mode of inertia and stiffness at this ratio; 1 does not overshoot."""

    ratio: float = 1.0
    """ζ of all modes."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.ratio < np.inf:
            raise InputError(f"DampingRatio: ratio = {self.ratio}; expected a finite number ≥ 0")


def double_diagonal_damping(inertia: Array, stiffness: Array, ratio: float) -> Array:
    """Damping D, (m, m), with which every mode of ``inertia`` ẍ + D ẋ + ``stiffness`` x = 0 has one damping ratio.

    With V such that Vᵀ A V = I and Vᵀ K V = diag(ω²):  D = A V diag(2 ζ ω) Vᵀ A. It is the only one that also
    couples what a full inertia couples, and it is smooth in A and K.

    Args:
        inertia: A, symmetric positive definite, (m, m).
        stiffness: K, symmetric positive semi-definite, (m, m).
        ratio: ζ.

    Source: Albu-Schäffer, Ott and Hirzinger 2003 (double diagonalisation); thesis B tunes D by hand.
    """
    omega2, V, _ = lapack.dsygv(stiffness, inertia, uplo="L")
    AV = inertia @ V
    return np.asarray((AV * (2.0 * ratio * np.sqrt(np.maximum(omega2, 0.0)))) @ AV.T)


def by_frequency(omega: Gain, damping_ratio: float) -> tuple[Array, Array]:
    """K_p [1/s²] and K_d [1/s] of a unit mass with the natural frequency ω [rad/s]: ω² and 2 ζ ω.

    Source: thesis B, eq. 4.7, with ζ = 1.
    """
    omega = np.asarray(omega, dtype=np.float64)
    return np.asarray(omega**2), np.asarray(2.0 * damping_ratio * omega)


def six(law: object, name: str, value: Gain) -> Array:
    """A task gain as (6,): from one number, from two (position, orientation), or from six.

    Raises:
        InputError: if there are other than 1, 2 or 6 of them, or one is negative or not finite.
    """
    values = _checked(law, name, value)
    if values.shape == (2,):
        values = np.repeat(values, 3)
    if values.shape not in ((), (6,)):
        raise InputError(
            f"{_place(law, name)} has shape {values.shape}; "
            "expected one number, two (position, orientation) or six (x, y, z, about x, about y, about z)"
        )
    return read_only(np.broadcast_to(values, 6))


def three(law: object, name: str, value: Gain) -> Array:
    """A gain of the position alone, or of the orientation alone, as (3,): from one number or three.

    Raises:
        InputError: if there are other than 1 or 3 of them, or one is negative or not finite.
    """
    values = _checked(law, name, value)
    if values.shape not in ((), (3,)):
        raise InputError(f"{_place(law, name)} has shape {values.shape}; expected one number or three, along x, y, z")
    return read_only(np.broadcast_to(values, 3))


def joints(law: object, name: str, value: Gain) -> Array:
    """A joint gain as an array, () or (n,); whether n is that of the arm is for `fit` to say.

    Raises:
        InputError: if it has another shape, or one number is negative or not finite.
    """
    values = _checked(law, name, value)
    if values.ndim > 1:
        raise InputError(f"{_place(law, name)} has shape {values.shape}; expected one number or one for each joint")
    return read_only(values)


def one(law: object, name: str, value: Gain) -> float:
    """A gain that is a single number.

    Raises:
        InputError: if it is not one, or it is negative or not finite.
    """
    values = _checked(law, name, value)
    if values.ndim > 0:
        raise InputError(f"{_place(law, name)} has shape {values.shape}; expected one number")
    return float(values)


def above_zero(law: object, name: str, value: Gain, *, infinite: bool = False) -> float:
    """A number above 0, and finite where ``infinite`` does not allow otherwise.

    Raises:
        InputError: if it is none.
    """
    values = np.asarray(value)
    if values.ndim > 0 or values.dtype.kind not in "iuf" or not values > 0.0 or (np.isinf(values) and not infinite):
        raise InputError(f"{_place(law, name)} = {value!r}; expected a number above 0")
    return float(values)


def fit(law: object, arm: Dynamics, **gains: Array) -> None:
    """Refuse joint gains, each () or (n,), of which one has not one number for each joint of the arm.

    Raises:
        InputError: naming it.
    """
    for name, values in gains.items():
        if values.shape not in ((), arm.q.shape):
            raise InputError(f"{_place(law, name)} has {len(values)} numbers; this arm has {len(arm.q)} joints")


def positive_definite(law: object, name: str, value: ArrayLike) -> Array:
    """An inertia as a symmetric positive definite (6, 6).

    Raises:
        InputError: if it is not one.
    """
    values = np.asarray(value, dtype=np.float64)
    if values.shape != (6, 6) or not np.isfinite(values).all():
        raise InputError(f"{_place(law, name)} has shape {values.shape}; expected a finite (6, 6) matrix")
    if not np.allclose(values, values.T, rtol=1e-9, atol=0.0) or np.linalg.eigvalsh(values)[0] <= 0.0:
        raise InputError(f"{_place(law, name)} is not symmetric positive definite; no body has such an inertia")
    return read_only(values)


def _checked(law: object, name: str, value: Gain) -> Array:
    try:
        values = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{_place(law, name)} = {value!r}; expected numbers") from None
    if not (np.isfinite(values).all() and (values >= 0.0).all()):
        raise InputError(f"{_place(law, name)} = {values}; expected finite numbers ≥ 0")
    return values


def _place(law: object, name: str) -> str:
    return f"{type(law).__name__}: {name}"
