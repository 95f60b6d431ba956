from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.control.joint import ComputedTorque, GravityCompensation
from burnish.core import Array, Dynamics, JointReference, State
from burnish.errors import InputError
from burnish.model.friction import Friction
from burnish.model.model import Model

MODEL = Model.jaco2()


def random_arm(seed: int) -> Dynamics:
    rng = np.random.default_rng(seed)
    return MODEL.at(State(t=0.0, q=rng.uniform(-3.0, 3.0, 6), dq=rng.uniform(-1.0, 1.0, 6)))


def reference(seed: int) -> JointReference:
    q, dq, ddq = np.random.default_rng(seed).normal(size=(3, 6))
    return JointReference(q=q, dq=dq, ddq=ddq)


def acceleration(arm: Dynamics, tau: Array) -> Array:
    """What a torque does to the free arm."""
    return np.linalg.solve(arm.M, tau - arm.h - arm.g)


def test_computed_torque_makes_the_error_a_spring_and_a_damper() -> None:
    law = ComputedTorque(kp=[100.0, 90.0, 80.0, 70.0, 60.0, 50.0], kd=[20.0, 18.0, 16.0, 14.0, 12.0, 10.0])
    for seed in range(10):
        arm, wanted = random_arm(seed), reference(seed)
        law.reset(arm)
        expected = wanted.ddq + law.kp * (wanted.q - arm.q) + law.kd * (wanted.dq - arm.dq)
        # M of the wrist is about 1e-4 kg·m²: solving with it costs four digits.
        assert_allclose(acceleration(arm, law.torque(arm, wanted)), expected, rtol=1e-9)


def test_on_the_reference_computed_torque_is_inverse_dynamics() -> None:
    arm, ddq = random_arm(1), np.arange(6.0)
    law = ComputedTorque.at_frequency(20.0)
    law.reset(arm)
    tau = law.torque(arm, JointReference(q=arm.q, dq=arm.dq, ddq=ddq))
    assert_allclose(tau, arm.M @ ddq + arm.h + arm.g, atol=1e-12)


@pytest.mark.parametrize("damping_ratio", [0.3, 1.0, 2.0])
def test_gains_by_frequency_place_the_poles(damping_ratio: float) -> None:
    law = ComputedTorque.at_frequency(12.0, damping_ratio)
    roots = np.roots([1.0, float(np.asarray(law.kd)), float(np.asarray(law.kp))])
    assert float(np.prod(roots).real) == pytest.approx(12.0**2)
    assert float(np.sum(roots).real) == pytest.approx(-2.0 * damping_ratio * 12.0)


def test_integral_grows_with_the_error_and_the_time() -> None:
    law = ComputedTorque(kp=0.0, kd=0.0, ki=3.0)
    arm = random_arm(2)
    wanted = JointReference(q=arm.q + 0.1, dq=arm.dq, ddq=np.zeros(6))
    law.reset(arm)
    for i in range(1, 11):
        tau = law.torque(replace(arm, t=0.01 * i), wanted)
    assert_allclose(acceleration(arm, tau), np.full(6, 3.0 * 0.1 * 0.1), rtol=1e-9)


def test_integral_is_bounded() -> None:
    law = ComputedTorque(kp=0.0, kd=0.0, ki=10.0, integral=2.0)
    arm = random_arm(3)
    wanted = JointReference(q=arm.q + [1.0, -1.0, 1.0, -1.0, 1.0, -1.0], dq=arm.dq, ddq=np.zeros(6))
    law.reset(arm)
    for i in range(1, 101):
        tau = law.torque(replace(arm, t=0.1 * i), wanted)
    assert_allclose(acceleration(arm, tau), [2.0, -2.0, 2.0, -2.0, 2.0, -2.0], rtol=1e-9)


def test_reset_forgets_the_integral() -> None:
    law = ComputedTorque(kp=0.0, kd=0.0, ki=10.0)
    arm = random_arm(4)
    wanted = JointReference(q=arm.q + 1.0, dq=arm.dq, ddq=np.zeros(6))
    law.reset(arm)
    law.torque(replace(arm, t=1.0), wanted)
    law.reset(replace(arm, t=2.0))
    assert_allclose(law.torque(replace(arm, t=2.0), wanted), arm.h + arm.g, atol=1e-12)


def test_friction_is_compensated_at_the_desired_speed() -> None:
    friction = Friction(coulomb=np.arange(1.0, 7.0), viscous=np.arange(2.0, 8.0))
    arm, wanted = random_arm(5), reference(5)
    plain = ComputedTorque(kp=100.0, kd=20.0)
    compensating = ComputedTorque(kp=100.0, kd=20.0, friction=friction, friction_share=0.5)
    for law in (plain, compensating):
        law.reset(arm)
    # At speeds of 0.1 rad/s and more the sign of Coulomb friction has long turned: tanh(20) is 1.
    assert np.abs(wanted.dq).min() > 0.1
    expected = 0.5 * (friction.coulomb * np.sign(wanted.dq) + friction.viscous * wanted.dq)
    assert_allclose(compensating.torque(arm, wanted) - plain.torque(arm, wanted), expected, rtol=1e-9)


@pytest.mark.parametrize("name", ["kp", "kd", "ki"])
@pytest.mark.parametrize("value", [-1.0, np.nan, np.inf, [1.0, 1.0, 1.0, 1.0, 1.0, -1.0]])
def test_gain_that_is_negative_or_no_number_is_refused_by_name(name: str, value: float) -> None:
    with pytest.raises(InputError, match=f"{name} ="):
        ComputedTorque(**({"kp": 1.0, "kd": 1.0} | {name: value}))


def test_gravity_compensation_holds_the_weight() -> None:
    arm = random_arm(6)
    assert_allclose(GravityCompensation().torque(arm, None), arm.g, atol=0.0)


def test_gravity_compensation_takes_energy_out_of_a_moving_arm() -> None:
    arm = random_arm(7)
    law = GravityCompensation(damping=[1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    assert_allclose(law.torque(arm, None) - arm.g, -np.arange(1.0, 7.0) * arm.dq, atol=1e-12)
