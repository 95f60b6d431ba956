from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import solve_ivp

from burnish.core import Array, State
from burnish.errors import InputError
from burnish.model.dh import DHChain
from burnish.model.inertia import Body
from burnish.model.lagrange import LagrangeModel, jaco2_lagrange

ORACLE = json.loads((Path(__file__).parent.parent / "data" / "jaco2_oracle.json").read_text())
JACO2 = jaco2_lagrange()
HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
ARMATURE = np.array([0.8, 0.8, 0.8, 0.15, 0.15, 0.15])
TOLERANCE = 1e-12
"""What is asked for is 1e-9; both sides are double precision sums of some hundred terms of about 10."""


def random_states(seed: int, count: int) -> list[tuple[Array, Array, Array]]:
    """q over two turns, speeds up to ten times the arm's, accelerations."""
    random = np.random.default_rng(seed)
    return [
        (random.uniform(-2 * np.pi, 2 * np.pi, 6), random.uniform(-6, 6, 6), random.uniform(-20, 20, 6))
        for _ in range(count)
    ]


def random_arm(n: int, seed: int) -> LagrangeModel:
    """An arm with any geometry, any bodies, and gravity anywhere."""
    random = np.random.default_rng(seed)
    chain = DHChain(
        alpha=random.uniform(-np.pi, np.pi, n),
        a=random.uniform(-0.5, 0.5, n),
        d=random.uniform(-0.5, 0.5, n),
        theta_sign=random.choice([-1.0, 1.0], n),
        theta_offset=random.uniform(-np.pi, np.pi, n),
    )
    bodies = []
    for i in range(n):
        sides = random.uniform(0.05, 0.3, 3)  # a box of these sides is a body that can be
        axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
        axes[:, 0] *= np.linalg.det(axes)
        mass = random.uniform(0.2, 4.0)
        moments = mass * (np.sum(sides**2) - sides**2) / 12
        com = random.uniform(-0.2, 0.2, 3)
        bodies.append(Body(name=f"box {i}", mass=mass, com=com, inertia=np.diag(moments), axes=axes))
    return LagrangeModel(
        chain=chain, links=tuple(bodies), gravity=random.normal(size=3) * 5, armature=random.uniform(0, 0.5, n)
    )


def engine_of(arm: LagrangeModel) -> pin.Model:
    """The same arm in Pinocchio, joint by joint; the engine's joint moves by θ, so callers pass sign and offset."""
    chain, engine = arm.chain, pin.Model()
    engine.gravity = pin.Motion(arm.gravity, np.zeros(3))
    joint, placement = 0, pin.SE3.Identity()
    for i, body in enumerate(arm.links):
        joint = engine.addJoint(joint, pin.JointModelRZ(), placement, f"joint {i}")
        placement = pin.SE3(np.eye(3), np.array([chain.a[i], 0.0, chain.d[i]])) * pin.SE3(
            pin.utils.rotate("x", chain.alpha[i]), np.zeros(3)
        )
        engine.appendBodyToJoint(joint, pin.Inertia(body.mass, body.com, body.tensor), placement)
    engine.addFrame(pin.Frame("tool", joint, placement, pin.FrameType.OP_FRAME))
    engine.armature = np.array(arm.armature)
    return engine


@pytest.mark.parametrize("sample", ORACLE["samples"])
def test_every_term_equals_two_engines(sample: dict[str, Any]) -> None:
    q, dq, ddq = (np.array(sample[key]) for key in ("q", "qd", "qdd"))
    arm = JACO2.at(State(t=0.0, q=q, dq=dq))
    C = JACO2.coriolis_matrix(q, dq)
    ours = {"J": arm.J, "Jdot_qd": arm.dJdq, "M": arm.M, "g": arm.g, "Cqd": arm.h, "C": C}
    ours |= {"tau": arm.M @ ddq + arm.h + arm.g, "U": JACO2.potential_energy(q), "K": JACO2.kinetic_energy(q, dq)}
    for name, value in ours.items():
        np.testing.assert_allclose(value, sample[name], rtol=0.0, atol=TOLERANCE, err_msg=name)
    np.testing.assert_allclose(arm.p, np.array(sample["T"])[:3, 3], atol=TOLERANCE)
    np.testing.assert_allclose(arm.R, np.array(sample["T"])[:3, :3], atol=TOLERANCE)


@pytest.mark.parametrize("name", ORACLE["named"])
def test_named_poses_equal_two_engines(name: str) -> None:
    pose = ORACLE["named"][name]
    q = np.array(pose["q"])
    np.testing.assert_allclose(JACO2.mass_matrix(q), pose["M"], atol=TOLERANCE)
    np.testing.assert_allclose(JACO2.gravity_torque(q), pose["g"], atol=TOLERANCE)


@pytest.mark.parametrize("n", [1, 2, 3, 7])
def test_any_arm_equals_the_engine(n: int) -> None:
    arm = random_arm(n, seed=n)
    engine = engine_of(arm)
    data, random = engine.createData(), np.random.default_rng(n)
    for _ in range(5):
        q, dq = random.uniform(-3, 3, (2, n))
        sign, theta = arm.chain.theta_sign, arm.chain.theta_sign * q + arm.chain.theta_offset
        ours = arm.at(State(t=0.0, q=q, dq=dq))
        pin.computeAllTerms(engine, data, theta, sign * dq)
        M = np.triu(data.M) + np.triu(data.M, 1).T
        np.testing.assert_allclose(ours.M, sign[:, None] * M * sign, atol=1e-12)
        np.testing.assert_allclose(ours.h + ours.g, sign * data.nle, atol=1e-11)
        np.testing.assert_allclose(ours.g, sign * data.g, atol=1e-11)
        tool = engine.getFrameId("tool")
        # The binding hands a Jacobian of one column out as a vector.
        J = pin.getFrameJacobian(engine, data, tool, pin.LOCAL_WORLD_ALIGNED).reshape(6, n)
        rate = pin.getFrameClassicalAcceleration(engine, data, tool, pin.LOCAL_WORLD_ALIGNED)
        np.testing.assert_allclose(ours.J, J * sign, atol=1e-12)
        np.testing.assert_allclose(ours.dJdq, rate.vector, atol=1e-11)


def test_mass_matrix_is_symmetric_and_positive_definite_at_1000_states() -> None:
    for q, _, _ in random_states(1, 1000):
        M = JACO2.mass_matrix(q)
        assert np.abs(M - M.T).max() < 1e-15
        # No M of this arm comes below; the wrist alone has 2.5e-4 kg·m².
        assert np.linalg.eigvalsh(M)[0] > 1e-4


def test_mass_rate_minus_twice_coriolis_is_skew_at_1000_states() -> None:
    step = 1e-6
    for q, dq, _ in random_states(2, 1000):
        rate = (JACO2.mass_matrix(q + step * dq) - JACO2.mass_matrix(q - step * dq)) / (2 * step)
        left = rate - 2 * JACO2.coriolis_matrix(q, dq)
        assert np.abs(left + left.T).max() < 1e-7  # limited by the finite difference


def test_power_of_the_torque_is_the_rate_of_the_energy_at_1000_states() -> None:
    step = 1e-5

    def energy(q: Array, dq: Array) -> float:
        return JACO2.kinetic_energy(q, dq) + JACO2.potential_energy(q)

    for q, dq, ddq in random_states(3, 1000):
        arm = JACO2.at(State(t=0.0, q=q, dq=dq))
        power = dq @ (arm.M @ ddq + arm.h + arm.g)
        rate = energy(q + step * dq, dq + step * ddq) - energy(q - step * dq, dq - step * ddq)
        assert rate / (2 * step) == pytest.approx(power, abs=1e-5, rel=1e-7)  # the bend of the path costs step²


def test_wrench_on_the_tool_and_its_joint_torque_have_the_same_power_at_1000_states() -> None:
    step, random = 1e-6, np.random.default_rng(4)
    for q, dq, _ in random_states(4, 1000):
        f = random.normal(size=3)
        before, after = JACO2.chain.at(q - step * dq).p, JACO2.chain.at(q + step * dq).p
        tau = JACO2.chain.jacobian(q)[:3].T @ f
        assert tau @ dq == pytest.approx(f @ (after - before) / (2 * step), abs=1e-7)


def test_gradients_are_derivatives() -> None:
    step = 1e-6
    for q, _, _ in random_states(5, 20):
        gradient, g = JACO2.mass_matrix_gradient(q), JACO2.gravity_torque(q)
        for j in range(6):
            dq = step * np.eye(6)[j]
            dM = (JACO2.mass_matrix(q + dq) - JACO2.mass_matrix(q - dq)) / (2 * step)
            dU = (JACO2.potential_energy(q + dq) - JACO2.potential_energy(q - dq)) / (2 * step)
            np.testing.assert_allclose(gradient[:, :, j], dM, atol=1e-9)
            assert g[j] == pytest.approx(dU, abs=1e-7)


def drift(arm: LagrangeModel, q: Array, dq: Array, seconds: float) -> float:
    """Largest change of the energy [J] while the arm moves unforced."""

    def rate(_: float, x: Array) -> Array:
        return np.concatenate((x[6:], arm.acceleration(x[:6], x[6:], np.zeros(6))))

    times = np.linspace(0, seconds, 101)
    path = solve_ivp(rate, (0, seconds), np.concatenate((q, dq)), "DOP853", times, rtol=1e-9, atol=1e-10)
    energies = [arm.kinetic_energy(x[:6], x[6:]) + arm.potential_energy(x[:6]) for x in path.y.T]
    assert path.y[6:].std() > 0.1  # it does move
    return float(np.ptp(energies))


def test_energy_is_conserved_over_10_s_of_free_motion_without_gravity() -> None:
    floating = replace(JACO2, gravity=np.zeros(3))
    assert drift(floating, HOME, np.array([0.5, -0.4, 0.6, 0.8, -0.7, 0.8]), 10.0) < 1e-6


def test_energy_is_conserved_over_10_s_of_falling_with_rotors() -> None:
    assert drift(replace(JACO2, armature=ARMATURE), HOME, np.zeros(6), 10.0) < 1e-6


def test_energy_is_conserved_over_1_s_of_falling_links_alone() -> None:
    # The hand has next to no inertia about joint 6: this fall whirls up to 100 rad/s and is hard to integrate.
    assert drift(JACO2, HOME, np.zeros(6), 1.0) < 1e-6


def test_acceleration_undoes_the_torque() -> None:
    for q, dq, ddq in random_states(6, 20):
        arm = JACO2.at(State(t=0.0, q=q, dq=dq))
        np.testing.assert_allclose(JACO2.acceleration(q, dq, arm.M @ ddq + arm.h + arm.g), ddq, atol=1e-9)


def test_armature_adds_to_the_diagonal_only() -> None:
    M = replace(JACO2, armature=ARMATURE).mass_matrix(HOME)
    np.testing.assert_allclose(M - JACO2.mass_matrix(HOME), np.diag(ARMATURE), atol=1e-15)


def test_dropping_the_coriolis_term_as_the_theses_do_is_felt_only_at_speed() -> None:
    at_limits = np.deg2rad([36, 36, 36, 48, 48, 48])
    h = [np.abs(JACO2.at(State(t=0.0, q=q, dq=at_limits)).h).max() for q, _, _ in random_states(7, 200)]
    g = [np.abs(JACO2.gravity_torque(q)).max() for q, _, _ in random_states(7, 200)]
    assert 0.01 < np.median(h) / np.median(g) < 0.1  # some hundredths of gravity at the speed limits


def test_state_or_arm_of_another_size_is_refused() -> None:
    with pytest.raises(InputError, match="7 joints"):
        JACO2.at(State(t=0.0, q=np.zeros(7), dq=np.zeros(7)))
    with pytest.raises(InputError, match="5 links"):
        replace(JACO2, links=JACO2.links[:5])
    with pytest.raises(InputError, match="armature"):
        replace(JACO2, armature=np.zeros(5))
