from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.control.wrench import JointSense, NoSense, WristSense
from burnish.core import Array, Dynamics, State
from burnish.errors import InputError
from burnish.model.model import Model

MASS, COM, OFFSET = 0.35, 0.04, 0.11
BIAS = np.array([1.5, -0.7, 0.4, 0.05, -0.08, 0.02])
MODEL = Model.jaco2().with_tool("tip", (0.0, 0.0, OFFSET))
HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])


def wrist_sense() -> WristSense:
    return WristSense(mass=MASS, com=COM, offset=OFFSET)


def wrist_reading(arm: Dynamics, F: Array, bias: Array) -> Array:
    """What a sensor ``OFFSET`` behind the tool point reads: all that pulls beyond it, summed in base axes."""
    z = arm.R[:, 2]
    weight = np.array([0.0, 0.0, -9.81 * MASS])
    force = F[:3] + weight
    moment = F[3:] + np.cross(OFFSET * z, F[:3]) + np.cross(COM * z, weight)
    return np.concatenate([arm.R.T @ force, arm.R.T @ moment]) + bias


def measured(q: Array, F: Array, *, bias: Array | None = None, t: float = 0.0) -> tuple[Dynamics, State]:
    """The model and the state of an arm with both kinds of sensors at rest under a contact wrench."""
    arm = MODEL.at(State(t=t, q=q, dq=np.zeros(6)))
    offset = np.zeros(6) if bias is None else bias
    state = State(t=t, q=q, dq=arm.dq, tau=arm.h + arm.g - arm.J.T @ F + offset, F=wrist_reading(arm, F, offset))
    return arm, state


def felt(sense: WristSense | JointSense, q: Array, F: Array, *, bias: Array | None = None, t: float = 0.0) -> Array:
    F_felt = sense.feel(*measured(q, F, bias=bias, t=t)).F
    assert F_felt is not None
    return F_felt


def random_poses(seed: int, count: int) -> list[Array]:
    return list(np.random.default_rng(seed).uniform(-np.pi, np.pi, (count, 6)))


# Wrist sensor.


def test_wrist_sensor_recovers_a_wrench_in_any_pose() -> None:
    rng = np.random.default_rng(1)
    for q in random_poses(2, 50):
        F = rng.normal(size=6) * [10.0, 10.0, 10.0, 1.0, 1.0, 1.0]
        assert_allclose(felt(wrist_sense(), q, F), F, atol=1e-12)


def test_wrist_sensor_feels_nothing_of_the_weight_of_the_tool() -> None:
    for q in random_poses(3, 20):
        assert_allclose(felt(wrist_sense(), q, np.zeros(6)), np.zeros(6), atol=1e-13)


def test_tare_of_a_wrist_sensor_removes_its_bias_in_every_pose() -> None:
    sense = wrist_sense()
    sense.tare([measured(q, np.zeros(6), bias=BIAS) for q in random_poses(4, 3)])
    F = np.array([3.0, -4.0, 5.0, 0.1, 0.2, -0.3])
    for q in random_poses(5, 20):
        assert_allclose(felt(sense, q, F, bias=BIAS), F, atol=1e-12)


def test_tare_of_a_wrist_sensor_is_the_mean_of_its_readings() -> None:
    sense = wrist_sense()
    noise = np.array([0.1, -0.2, 0.3, 0.01, 0.02, -0.03])
    sense.tare([measured(HOME, np.zeros(6), bias=BIAS + sign * noise) for sign in (-1.0, 1.0)])
    assert_allclose(felt(sense, HOME, np.zeros(6), bias=BIAS), np.zeros(6), atol=1e-13)


def test_second_tare_takes_the_place_of_the_first() -> None:
    sense = wrist_sense()
    for bias in (5.0 * BIAS, BIAS):
        sense.tare([measured(HOME, np.zeros(6), bias=bias)])
    assert_allclose(felt(sense, HOME, np.zeros(6), bias=BIAS), np.zeros(6), atol=1e-13)


def test_arm_without_a_wrist_sensor_is_refused() -> None:
    arm, state = measured(HOME, np.zeros(6))
    with pytest.raises(InputError, match="no wrist sensor"):
        wrist_sense().feel(arm, State(t=0.0, q=state.q, dq=state.dq))


# Joint torque sensors.


def regular_poses(seed: int, count: int) -> list[Array]:
    """Poses in which Λ is not damped: next to a singularity torques cannot tell the wrench."""
    poses = (HOME + q for q in np.random.default_rng(seed).uniform(-0.3, 0.3, (count, 6)))
    return [q for q in poses if np.linalg.svd(MODEL.kinematics(q)[2])[1][-1] > 0.05]


def test_joint_sensors_recover_a_wrench() -> None:
    rng = np.random.default_rng(6)
    for q in regular_poses(7, 50):
        F = rng.normal(size=6) * [10.0, 10.0, 10.0, 1.0, 1.0, 1.0]
        assert_allclose(felt(JointSense(), q, F), F, atol=1e-8)


def test_joint_sensors_feel_nothing_of_a_free_arm_that_moves_evenly() -> None:
    arm = MODEL.at(State(t=0.0, q=HOME, dq=np.full(6, 0.3)))
    F = JointSense().feel(arm, State(t=0.0, q=arm.q, dq=arm.dq, tau=arm.h + arm.g)).F
    assert_allclose(F, np.zeros(6), atol=1e-9)


def test_tare_of_joint_sensors_removes_their_bias() -> None:
    sense = JointSense()
    bias = np.array([0.4, -0.3, 0.2, -0.1, 0.05, -0.02])
    sense.tare([measured(HOME, np.zeros(6), bias=bias)])
    F = np.array([3.0, -4.0, 5.0, 0.1, 0.2, -0.3])
    assert_allclose(felt(sense, HOME, F, bias=bias), F, atol=1e-8)


def test_joint_sensors_follow_a_step_as_a_first_order_lag() -> None:
    sense = JointSense(time_constant=0.03)
    F = np.array([0.0, 0.0, 10.0, 0.0, 0.0, 0.0])
    felt(sense, HOME, np.zeros(6))
    for i in range(1, 61):
        share = felt(sense, HOME, F, t=1e-3 * i)[2] / 10.0
        assert share == pytest.approx(1.0 - np.exp(-1e-3 * i / 0.03), abs=1e-9)


def test_lag_of_joint_sensors_does_not_depend_on_the_rate() -> None:
    F = np.array([0.0, 0.0, 10.0, 0.0, 0.0, 0.0])
    shares = []
    for steps in (5, 50):
        sense = JointSense()
        felt(sense, HOME, np.zeros(6))
        for i in range(1, steps + 1):
            last = felt(sense, HOME, F, t=0.05 * i / steps)
        shares.append(last)
    assert_allclose(shares[0], shares[1], atol=1e-9)


def test_arm_without_joint_sensors_is_refused() -> None:
    arm, state = measured(HOME, np.zeros(6))
    with pytest.raises(InputError, match="no joint torque sensors"):
        JointSense().feel(arm, State(t=0.0, q=state.q, dq=state.dq))


# Neither.


def test_arm_that_feels_nothing_has_no_wrench() -> None:
    arm, state = measured(HOME, np.ones(6))
    assert NoSense().feel(arm, state).F is None


def test_model_without_the_wrench_is_left_alone() -> None:
    arm, state = measured(HOME, np.ones(6))
    wrist_sense().feel(arm, state)
    assert arm.F is None


# Noise, and the touch that follows from it.


def noisy_readings(count: int, sigma: Array) -> list[tuple[Dynamics, State]]:
    """Readings of a wrist sensor in free air with white noise of its forces, sensor axes."""
    rng = np.random.default_rng(8)
    readings = []
    for i in range(count):
        arm, state = measured(HOME, np.zeros(6), t=0.01 * i)
        assert state.F is not None
        readings.append((arm, State(t=state.t, q=state.q, dq=state.dq, F=state.F + sigma * rng.normal(size=6))))
    return readings


def test_tare_learns_the_noise_along_each_axis_of_the_sensor() -> None:
    sense = wrist_sense()
    sense.tare(noisy_readings(4000, np.array([0.05, 0.1, 0.2, 0.0, 0.0, 0.0])))
    R = measured(HOME, np.zeros(6))[0].R
    for axis, sigma in zip(R.T, (0.05, 0.1, 0.2), strict=True):
        assert sense.noise(axis) == pytest.approx(sigma, rel=0.05)


def test_touch_counts_from_three_times_the_tared_noise_on() -> None:
    sense = wrist_sense()
    sense.tare(noisy_readings(4000, np.array([0.0, 0.0, 0.5, 0.0, 0.0, 0.0])))
    z = measured(HOME, np.zeros(6))[0].R[:, 2]
    assert sense.touch_threshold(z) == pytest.approx(1.5, rel=0.05)


def test_touch_threshold_is_never_below_its_minimum() -> None:
    sense = WristSense(mass=MASS, com=COM, offset=OFFSET, least_touch=0.7)
    up = np.array([0.0, 0.0, 1.0])
    assert sense.touch_threshold(up) == 0.7
    sense.tare(noisy_readings(40, np.zeros(6)))
    assert sense.touch_threshold(up) == 0.7


def test_noise_of_joint_sensors_is_what_their_low_pass_leaves() -> None:
    rng = np.random.default_rng(9)
    readings = [measured(HOME, np.zeros(6), bias=0.02 * rng.normal(size=6), t=0.01 * i) for i in range(6000)]
    sense = JointSense(time_constant=0.03)
    sense.tare(readings)
    up = np.array([0.0, 0.0, 1.0])
    a = 1.0 - np.exp(-0.01 / 0.03)
    raw = 0.02 * np.linalg.norm(readings[0][0].J_bar[:, :3] @ up)
    # White noise through a first-order lag: σ √(a/(2 − a)).
    assert sense.noise(up) == pytest.approx(raw * np.sqrt(a / (2.0 - a)), rel=0.05)


def test_arm_that_feels_nothing_never_touches() -> None:
    assert NoSense().touch_threshold(np.array([0.0, 0.0, 1.0])) == np.inf
