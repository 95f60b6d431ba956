from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from burnish.core import Array
from burnish.errors import InputError
from burnish.rotation import (
    FADE,
    continuous_error,
    euler_xyz,
    exp,
    from_euler_xyz,
    from_quaternion,
    interpolate,
    log,
    quaternion,
    quaternion_error,
    rotation_vector_error,
    sine_error,
    skew,
)

Error = Callable[[Array, Array], Array]

ANGLES = [0.0, 1e-12, 1e-9, 1e-8, 9.9e-5, 1.01e-4, 0.03, 0.5, 1.5, np.pi - 1e-3, np.pi - 1e-6, np.pi - 1e-9]
"""From nothing to half a turn, next to both ends and on both sides of the thresholds inside."""
LENGTHS: list[tuple[Error, Callable[[float], float]]] = [
    (quaternion_error, lambda theta: float(np.sin(theta / 2.0))),
    (rotation_vector_error, lambda theta: theta),
    (sine_error, lambda theta: float(np.sin(theta))),
]
"""The three errors with their length as a function of the angle."""


def axes() -> list[Array]:
    """The coordinate axes, where the largest quaternion component changes, and ten others."""
    random = np.random.default_rng(1).normal(size=(10, 3))
    return [*np.eye(3), *(-np.eye(3)), *(random / np.linalg.norm(random, axis=1, keepdims=True))]


def random_rotations(seed: int, count: int) -> list[Array]:
    return list(Rotation.random(count, rng=np.random.default_rng(seed)).as_matrix())


# Exponential and logarithm.


def test_skew_is_the_cross_product() -> None:
    a, b = np.random.default_rng(2).normal(size=(2, 3))
    assert_allclose(skew(a) @ b, np.cross(a, b), atol=1e-15)


@pytest.mark.parametrize("theta", ANGLES)
def test_exp_is_the_matrix_exponential(theta: float) -> None:
    for u in axes():
        assert_allclose(exp(theta * u), expm(skew(theta * u)), atol=4e-15)


def test_exp_is_a_rotation_far_beyond_a_turn() -> None:
    for vector in np.random.default_rng(3).normal(size=(20, 3)) * 20.0:
        R = exp(vector)
        assert_allclose(R @ R.T, np.eye(3), atol=1e-14)
        assert np.linalg.det(R) == pytest.approx(1.0)


@pytest.mark.parametrize("theta", ANGLES)
def test_log_undoes_exp_near_zero_and_near_half_a_turn(theta: float) -> None:
    # The matrix holds its angle to about 1e-16, absolute: at π as well as at 0 because log goes by the quaternion.
    for u in axes():
        assert_allclose(log(exp(theta * u)), theta * u, atol=2e-15)


def test_log_of_half_a_turn_is_along_its_axis() -> None:
    for u in axes():
        vector = log(2.0 * np.outer(u, u) - np.eye(3))
        assert np.linalg.norm(vector) == pytest.approx(np.pi, abs=1e-12)
        assert abs(vector @ u) == pytest.approx(np.pi, abs=1e-12)


def test_log_agrees_with_scipy() -> None:
    for R in random_rotations(4, 200):
        assert_allclose(log(R), Rotation.from_matrix(R).as_rotvec(), atol=1e-13)


def test_inverse_rotation_has_the_opposite_vector() -> None:
    for R in random_rotations(5, 50):
        assert_allclose(log(R.T), -log(R), atol=1e-13)


# Quaternions.


def test_quaternion_is_scalar_first_and_agrees_with_scipy() -> None:
    for R in random_rotations(6, 200):
        x, y, z, w = Rotation.from_matrix(R).as_quat(canonical=True)
        assert_allclose(quaternion(R), [w, x, y, z], atol=1e-14)


@pytest.mark.parametrize("theta", ANGLES)
def test_quaternion_has_unit_norm_and_a_scalar_that_is_not_negative(theta: float) -> None:
    for u in axes():
        Q = quaternion(exp(theta * u))
        assert np.linalg.norm(Q) == pytest.approx(1.0, abs=1e-14)
        assert Q[0] >= 0.0


@pytest.mark.parametrize("theta", ANGLES)
def test_from_quaternion_undoes_quaternion(theta: float) -> None:
    for u in axes():
        assert_allclose(from_quaternion(quaternion(exp(theta * u))), exp(theta * u), atol=2e-15)


def test_quaternion_and_its_negative_are_one_rotation() -> None:
    Q = quaternion(random_rotations(7, 1)[0])
    assert_allclose(from_quaternion(-Q), from_quaternion(Q), atol=0.0)


@pytest.mark.parametrize("scale", [0.0, 0.998, 1.002, np.nan, np.inf])
def test_quaternion_that_is_not_unit_is_refused(scale: float) -> None:
    with np.errstate(invalid="ignore"):
        Q = scale * np.array([0.5, 0.5, 0.5, 0.5])
    with pytest.raises(InputError, match="Normalise"):
        from_quaternion(Q)


# Euler angles.


def test_from_euler_xyz_is_three_turns_about_moving_axes() -> None:
    for angles in np.random.default_rng(8).uniform(-np.pi, np.pi, (50, 3)):
        assert_allclose(from_euler_xyz(angles), Rotation.from_euler("XYZ", angles).as_matrix(), atol=1e-15)


def test_euler_xyz_undoes_from_euler_xyz() -> None:
    rng = np.random.default_rng(9)
    for _ in range(100):
        angles = rng.uniform([-np.pi, -np.pi / 2, -np.pi], [np.pi, np.pi / 2, np.pi])
        assert_allclose(euler_xyz(from_euler_xyz(angles)), angles, atol=1e-12)


@pytest.mark.parametrize("beta", [np.pi / 2, -np.pi / 2])
@pytest.mark.parametrize("short_of", [0.0, 1e-12, 1e-10, 1e-7, 1e-4])
def test_euler_xyz_gives_the_same_rotation_at_and_next_to_gimbal_lock(beta: float, short_of: float) -> None:
    for alpha, gamma in np.random.default_rng(10).uniform(-np.pi, np.pi, (10, 2)):
        R = from_euler_xyz(np.array([alpha, beta - np.sign(beta) * short_of, gamma]))
        # Below its threshold of 1e-9 the third angle is dropped, at a cost of that size.
        assert_allclose(from_euler_xyz(euler_xyz(R)), R, atol=2e-9)


def test_third_euler_angle_is_zero_in_gimbal_lock() -> None:
    assert euler_xyz(from_euler_xyz(np.array([0.3, np.pi / 2, 0.4]))) == pytest.approx([0.7, np.pi / 2, 0.0])


# Interpolation.


def test_interpolation_starts_and_ends_at_its_arguments() -> None:
    R0, R1 = random_rotations(11, 2)
    assert_allclose(interpolate(R0, R1, 0.0), R0, atol=1e-15)
    assert_allclose(interpolate(R0, R1, 1.0), R1, atol=1e-14)


def test_interpolation_turns_evenly_about_one_axis() -> None:
    R0, R1 = random_rotations(12, 2)
    whole = log(R1 @ R0.T)
    for s in (0.1, 0.35, 0.8):
        assert_allclose(log(interpolate(R0, R1, s) @ R0.T), s * whole, atol=1e-13)


# The orientation errors.


@pytest.mark.parametrize(("error", "length"), LENGTHS)
@pytest.mark.parametrize("theta", ANGLES)
def test_orientation_error_is_its_function_of_the_angle_along_the_axis(
    error: Error, length: Callable[[float], float], theta: float
) -> None:
    R = random_rotations(13, 1)[0]
    for u in axes():
        assert_allclose(error(R, exp(theta * u) @ R), length(theta) * u, atol=5e-15)


@pytest.mark.parametrize("error", [error for error, _ in LENGTHS])
def test_turning_the_tool_about_its_error_brings_it_nearer(error: Error) -> None:
    for R, R_d in zip(random_rotations(14, 50), random_rotations(15, 50), strict=True):
        before = Rotation.from_matrix(R_d @ R.T).magnitude()
        turned = Rotation.from_rotvec(0.01 * error(R, R_d)).as_matrix() @ R
        assert Rotation.from_matrix(R_d @ turned.T).magnitude() < before


@pytest.mark.parametrize("error", [error for error, _ in LENGTHS])
def test_orientation_error_turns_with_the_base_frame(error: Error) -> None:
    R, R_d, base = random_rotations(16, 3)
    assert_allclose(error(base @ R, base @ R_d), base @ error(R, R_d), atol=1e-14)


def product(a: Array, b: Array) -> Array:
    """Hamilton product of scalar-first quaternions."""
    return np.array([a[0] * b[0] - a[1:] @ b[1:], *(a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:]))])


def published_1(R: Array, R_d: Array) -> Array:
    """The blog's method 1: vec(Q_d ⊗ Q*) sign(scalar)."""
    error = product(quaternion(R_d), quaternion(R) * [1.0, -1.0, -1.0, -1.0])
    return np.asarray(error[1:] * np.sign(error[0]))


def published_2(R: Array, R_d: Array) -> Array:
    """Caccavale 1998, eq. 34: R vec(quat(Rᵀ R_d))."""
    return np.asarray(R @ quaternion(R.T @ R_d)[1:])


def published_3(R: Array, R_d: Array) -> Array:
    """Caccavale 1998, eq. 45: 2 η ε of R_d Rᵀ."""
    Q = quaternion(R_d @ R.T)
    return np.asarray(2.0 * Q[0] * Q[1:])


def published_4(R: Array, R_d: Array) -> Array:
    """Yuan 1988: η ε_d − η_d ε − S(ε_d) ε, S of the vector part, by the short way."""
    Q, Q_d = quaternion(R), quaternion(R_d)
    e = Q[0] * Q_d[1:] - Q_d[0] * Q[1:] - skew(Q_d[1:]) @ Q[1:]
    return np.asarray(e * np.sign(Q @ Q_d))


def published_5(R: Array, R_d: Array) -> Array:
    """Thesis A, eq. 4.5–4.7: angle times axis of Rᵀ R_d, in tool axes, divided by sin θ; turned to base axes."""
    E = R.T @ R_d
    theta = np.arccos((np.trace(E) - 1.0) / 2.0)
    axis = np.array([E[2, 1] - E[1, 2], E[0, 2] - E[2, 0], E[1, 0] - E[0, 1]]) / (2.0 * np.sin(theta))
    return np.asarray(R @ (theta * axis))


@pytest.mark.parametrize(
    ("published", "ours"),
    [
        (published_1, quaternion_error),
        (published_2, quaternion_error),
        (published_4, quaternion_error),
        (published_3, sine_error),
        (published_5, rotation_vector_error),
    ],
)
def test_published_orientation_error_is_one_of_three(published: Error, ours: Error) -> None:
    # Uniformly random pairs keep clear of θ = 0 and π by far more than the 1e-3 where thesis A's division loses digits.
    for R, R_d in zip(random_rotations(17, 100), random_rotations(18, 100), strict=True):
        assert_allclose(published(R, R_d), ours(R, R_d), atol=1e-11)


# The error that laws use.


def axis_of(seed: int) -> Array:
    u = np.random.default_rng(seed).normal(size=3)
    return np.asarray(u / np.linalg.norm(u))


@pytest.mark.parametrize("theta", [0.0, 1e-9, 1e-4, 0.5, 2.0, np.pi - FADE - 1e-6])
def test_continuous_error_is_the_rotation_vector_up_to_its_fade(theta: float) -> None:
    for R in random_rotations(20, 20):
        R_d = exp(theta * axis_of(21)) @ R
        assert_allclose(continuous_error(R, R_d), rotation_vector_error(R, R_d), atol=1e-12)


def test_continuous_error_vanishes_at_half_a_turn_and_has_no_jump_on_the_way_through() -> None:
    u, errors = axis_of(22), []
    for theta in np.linspace(np.pi - 1.2 * FADE, np.pi + 1.2 * FADE, 4001):
        errors.append(continuous_error(np.eye(3), exp(theta * u)))
    assert np.linalg.norm(errors[2000]) < 1e-6
    # Steps of 5e-5 rad; the fade is at most 1.5 π/FADE = 54 times as steep as θ.
    assert np.linalg.norm(np.diff(errors, axis=0), axis=1).max() < 60.0 * 1.2 * FADE / 2000.0


def test_rotation_vector_jumps_where_the_continuous_error_does_not() -> None:
    u = axis_of(23)
    before, after = (rotation_vector_error(np.eye(3), exp((np.pi + d) * u)) for d in (-1e-6, 1e-6))
    assert np.linalg.norm(after - before) > 6.0
