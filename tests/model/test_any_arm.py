"""What the model of every arm keeps, whatever its joints are and whichever format it was written in."""

from __future__ import annotations

import numpy as np
import pytest
from model.arms import ARMS, MuJoCo, arm, random_states, slope
from numpy.testing import assert_allclose

from burnish.core import State
from burnish.model.friction import Friction
from burnish.rotation import log

every_arm = pytest.mark.parametrize("name", ARMS)
TOLERANCE = 1e-9
"""Two engines in double precision, torques below 200 N·m."""


@every_arm
def test_all_terms_are_those_of_mujoco(name: str) -> None:
    model, theirs = arm(name), MuJoCo(*ARMS[name])
    for state in random_states(model, 1, 50):
        found, expected = model.at(state), theirs.at(state.q, state.dq)
        for term in ("p", "R", "J", "dJdq", "M", "g", "h"):
            assert_allclose(getattr(found, term), expected[term], rtol=0.0, atol=TOLERANCE, err_msg=term)


@every_arm
def test_limits_are_those_of_mujoco(name: str) -> None:
    model = arm(name)
    assert_allclose([model.lower, model.upper], MuJoCo(*ARMS[name]).limits)


@every_arm
def test_mass_matrix_is_symmetric_and_positive_definite(name: str) -> None:
    model = arm(name)
    for state in random_states(model, 2, 50):
        M = model.at(state).M
        assert np.array_equal(M, M.T)
        assert np.linalg.eigvalsh(M)[0] > 0.0


@every_arm
def test_mass_rate_minus_twice_coriolis_is_skew(name: str) -> None:
    # C x = Γ(q̇, x), the bilinear form of h; Ṁ is a difference along q̇.
    model, random = arm(name), np.random.default_rng(3)
    for state in random_states(model, 3, 20):
        q, dq, x = state.q, state.dq, random.normal(size=model.n)
        rate = slope(lambda s, q=q, dq=dq: model.at(State(t=0.0, q=q + s * dq, dq=dq)).M)
        h_both, h_dq, h_x = (model.at(State(t=0.0, q=q, dq=v)).h for v in (dq + x, dq, x))
        assert x @ rate @ x == pytest.approx(x @ (h_both - h_dq - h_x), abs=1e-6)


@every_arm
def test_gravity_torque_is_the_slope_of_the_potential_energy(name: str) -> None:
    model, theirs = arm(name), MuJoCo(*ARMS[name])
    for state in random_states(model, 4, 10):
        for i, along in enumerate(np.eye(model.n)):
            U_rate = slope(lambda s, q=state.q, along=along: theirs.at(q + s * along, 0.0 * q)["U"])
            assert model.at(state).g[i] == pytest.approx(U_rate, abs=1e-6)


@every_arm
def test_jacobian_is_the_motion_of_the_tool(name: str) -> None:
    model = arm(name)
    for state in random_states(model, 5, 10):
        _, R, J = model.kinematics(state.q)
        for i, along in enumerate(np.eye(model.n)):
            v = slope(lambda s, q=state.q, along=along: model.kinematics(q + s * along)[0])
            w = slope(lambda s, q=state.q, along=along, R=R: log(model.kinematics(q + s * along)[1] @ R.T))
            assert_allclose(J[:, i], [*v, *w], atol=1e-8)


@every_arm
def test_tool_acceleration_at_constant_joint_speed_is_the_rate_of_the_twist(name: str) -> None:
    model = arm(name)
    for state in random_states(model, 6, 10):
        rate = slope(lambda s, q=state.q, dq=state.dq: model.kinematics(q + s * dq)[2] @ dq)
        assert_allclose(model.at(state).dJdq, rate, atol=1e-7)


@every_arm
def test_wrench_on_the_tool_and_its_joint_torque_have_the_same_power(name: str) -> None:
    model, random = arm(name), np.random.default_rng(7)
    for state in random_states(model, 7, 20):
        q, dq, f, m = state.q, state.dq, *random.normal(size=(2, 3))
        v = slope(lambda s, q=q, dq=dq: model.kinematics(q + s * dq)[0])
        w = slope(lambda s, q=q, dq=dq: log(model.kinematics(q + s * dq)[1] @ model.kinematics(q)[1].T))
        tau = model.at(state).J.T @ np.concatenate((f, m))
        assert tau @ dq == pytest.approx(f @ v + m @ w, abs=1e-7)


@every_arm
def test_point_payload_adds_its_inertia_and_its_weight_through_the_jacobian(name: str) -> None:
    bare = arm(name)
    loaded = bare.with_payload(0.5)
    for state in random_states(bare, 8, 10):
        before, after = bare.at(state), loaded.at(state)
        J = before.J[:3]
        assert_allclose(after.M, before.M + 0.5 * J.T @ J, atol=1e-12)
        assert_allclose(after.g, before.g + J.T @ [0.0, 0.0, 0.5 * 9.81], atol=1e-11)
        assert_allclose(after.h, before.h + 0.5 * J.T @ before.dJdq[:3], atol=1e-11)


@every_arm
def test_what_was_added_is_kept_by_what_is_added_later(name: str) -> None:
    bare = arm(name)
    friction = Friction(coulomb=np.ones(bare.n), viscous=np.zeros(bare.n))
    one = bare.with_friction(friction).with_armature(0.3).with_payload(0.5).with_tool("tip of it", (0.0, 0.1, 0.2))
    other = bare.with_payload(0.5).with_tool("tip of it", (0.0, 0.1, 0.2)).with_armature(0.3).with_friction(friction)
    assert one.friction is friction
    assert other.friction is friction
    for model in (one, other):
        assert model.tool == "tip of it"
        assert_allclose(model.armature, 0.3)
        assert_allclose([model.lower, model.upper], [bare.lower, bare.upper])
        assert_allclose(model.velocity_limit, bare.velocity_limit)
        assert_allclose(model.effort_limit, bare.effort_limit)
    for state in random_states(bare, 9, 5):
        for term in ("p", "R", "J", "M", "h", "g"):
            assert_allclose(getattr(one.at(state), term), getattr(other.at(state), term), atol=1e-12, err_msg=term)


@every_arm
def test_friction_is_in_no_term(name: str) -> None:
    bare = arm(name)
    rough = bare.with_friction(Friction(coulomb=np.full(bare.n, 9.0), viscous=np.full(bare.n, 9.0)))
    assert bare.friction is None
    for state in random_states(bare, 10, 3):
        for term in ("M", "h", "g"):
            assert_allclose(getattr(rough.at(state), term), getattr(bare.at(state), term), atol=0.0)


@every_arm
def test_distance_to_the_limits_is_that_of_the_nearer_one(name: str) -> None:
    model = arm(name)
    continuous = np.isinf(model.upper)
    middle = np.where(continuous, 7.0, 0.5 * (np.nan_to_num(model.lower) + np.nan_to_num(model.upper)))
    half = np.where(continuous, np.inf, 0.5 * (model.upper - model.lower))
    assert_allclose(model.limit_distance(middle), half)
    inside = np.where(continuous, 7.0, np.nan_to_num(model.upper) - 0.01)
    assert_allclose(model.limit_distance(inside), np.where(continuous, np.inf, 0.01), rtol=1e-9)
    beyond = np.where(continuous, -7.0, np.nan_to_num(model.lower) - 0.01)
    assert_allclose(model.limit_distance(beyond), np.where(continuous, np.inf, -0.01), rtol=1e-9)


def test_both_formats_give_the_same_arm() -> None:
    urdf, mjcf = arm("seven_dof.urdf"), arm("seven_dof.xml")
    for limit in ("lower", "upper", "effort_limit"):
        assert_allclose(getattr(urdf, limit), getattr(mjcf, limit), err_msg=limit)
    for state in random_states(urdf, 11, 50):
        ours, theirs = urdf.at(state), mjcf.at(state)
        for term in ("p", "R", "J", "dJdq", "M", "h", "g"):
            assert_allclose(getattr(ours, term), getattr(theirs, term), rtol=0.0, atol=TOLERANCE, err_msg=term)
