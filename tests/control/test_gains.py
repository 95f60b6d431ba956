from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.control.gains import DampingRatio, by_frequency, double_diagonal_damping, joints, positive_definite, six
from burnish.core import Array
from burnish.errors import InputError


def random_spd(seed: int, m: int = 6) -> Array:
    root = np.random.default_rng(seed).normal(size=(m, m))
    return root @ root.T + 0.1 * np.eye(m)


def poles(A: Array, D: Array, K: Array) -> Array:
    """Roots of det(A s² + D s + K) = 0."""
    m = len(A)
    top = np.hstack([np.zeros((m, m)), np.eye(m)])
    return np.linalg.eigvals(np.vstack([top, -np.linalg.solve(A, np.hstack([K, D]))]))


@pytest.mark.parametrize("ratio", [0.3, 0.7, 1.5])
def test_double_diagonal_damping_gives_every_mode_of_a_full_inertia_one_ratio(ratio: float) -> None:
    A, K = random_spd(1), np.diag(np.random.default_rng(2).uniform(10.0, 900.0, 6))
    s = poles(A, double_diagonal_damping(A, K, ratio), K)
    omega2 = np.linalg.eigvals(np.linalg.solve(A, K)).real
    root = np.sqrt(complex(ratio**2 - 1.0))
    expected = np.concatenate([np.sqrt(omega2) * (-ratio + sign * root) for sign in (1.0, -1.0)])
    assert_allclose(np.sort_complex(s), np.sort_complex(expected), rtol=1e-6)


def test_double_diagonal_damping_is_symmetric_and_reduces_to_the_textbook() -> None:
    D = double_diagonal_damping(random_spd(3), np.diag(np.arange(1.0, 7.0)), 0.7)
    assert_allclose(D, D.T, atol=1e-12)
    D = double_diagonal_damping(np.diag([2.0, 3.0]), np.diag([50.0, 12.0]), 0.5)
    assert_allclose(D, np.diag([np.sqrt(2.0 * 50.0), np.sqrt(3.0 * 12.0)]), atol=1e-12)


def test_double_diagonal_damping_without_stiffness_damps_nothing() -> None:
    assert_allclose(double_diagonal_damping(random_spd(4), np.zeros((6, 6)), 1.0), np.zeros((6, 6)), atol=1e-9)


def test_gains_by_frequency_are_those_of_a_unit_mass() -> None:
    kp, kd = by_frequency([10.0, 3.0], 0.5)
    assert_allclose([kp, kd], [[100.0, 9.0], [10.0, 3.0]])


@pytest.mark.parametrize(
    ("value", "expected"),
    [(2.0, [2.0] * 6), ((2.0, 3.0), [2.0] * 3 + [3.0] * 3), ([1, 2, 3, 4, 5, 6], [1, 2, 3, 4, 5, 6])],
)
def test_task_gain_is_one_number_two_or_six(value: object, expected: list[float]) -> None:
    assert_allclose(six(object(), "kp", value), expected)  # type: ignore[arg-type]


@pytest.mark.parametrize("value", [[1.0] * 3, [1.0] * 5, np.ones((6, 6))])
def test_task_gain_of_another_shape_is_refused_with_what_was_expected(value: object) -> None:
    with pytest.raises(InputError, match="expected one number, two"):
        six(object(), "kp", value)  # type: ignore[arg-type]


def test_gain_is_a_copy_that_nobody_can_change() -> None:
    mine = np.ones(6)
    kept = joints(object(), "kp", mine)
    mine[0] = 9.0
    assert kept[0] == 1.0
    assert not kept.flags.writeable


@pytest.mark.parametrize(
    "matrix",
    [np.eye(3), -np.eye(6), np.triu(np.ones((6, 6))), np.full((6, 6), np.nan)],
    ids="shape sign skew nan".split(),
)
def test_inertia_that_no_body_has_is_refused(matrix: Array) -> None:
    with pytest.raises(InputError, match="inertia"):
        positive_definite(object(), "inertia", matrix)


@pytest.mark.parametrize("ratio", [-0.1, np.nan, np.inf])
def test_bad_damping_ratio_is_refused(ratio: float) -> None:
    with pytest.raises(InputError, match="ratio"):
        DampingRatio(ratio)
