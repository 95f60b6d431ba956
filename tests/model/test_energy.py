from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import lapack

from burnish.core import Array, State
from burnish.model.lagrange import jaco2_lagrange
from burnish.model.model import Model

MODEL = Model.jaco2()
LAGRANGE = jaco2_lagrange()
HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
STATES = 1000


def random_states(seed: int) -> list[State]:
    """q over two turns, speeds up to ten times the arm's."""
    random = np.random.default_rng(seed)
    return [
        State(t=0.0, q=random.uniform(-2 * np.pi, 2 * np.pi, 6), dq=random.uniform(-6, 6, 6)) for _ in range(STATES)
    ]


def energy(q: Array, dq: Array) -> float:
    """Kinetic energy of the model's M, and the potential that Lagrange's equations know without an engine [J]."""
    return float(dq @ MODEL.at(State(t=0.0, q=q, dq=dq)).M @ dq / 2) + LAGRANGE.potential_energy(q)


def fall(_: float, x: Array) -> Array:
    """Rate of (q, q̇) of the arm that nothing drives: q̈ = −M⁻¹ (h + g)."""
    arm = MODEL.at(State(t=0.0, q=x[:6], dq=x[6:]))
    return np.concatenate((x[6:], -lapack.dposv(arm.M, arm.h + arm.g)[1]))


def test_energy_is_conserved_over_10_s_of_falling_links_alone() -> None:
    # The hand has next to no inertia about joint 6: links alone whirl at up to 200 rad/s, so the eighth order needs
    # 50,000 evaluations. What is left of the energy is the integrator's and shrinks with rtol.
    path = solve_ivp(fall, (0.0, 10.0), np.concatenate((HOME, np.zeros(6))), "DOP853", rtol=3e-9, atol=3e-9)
    states = path.y.T[:: len(path.t) // 200]
    energies = [energy(x[:6], x[6:]) for x in states]
    assert np.ptp([LAGRANGE.potential_energy(x[:6]) for x in states]) > 10.0  # it does fall [J]
    assert np.ptp(energies) < 1e-6  # [J]


def test_mass_matrix_is_symmetric_and_positive_definite_at_1000_states() -> None:
    for state in random_states(1):
        M = MODEL.at(state).M
        assert np.array_equal(M, M.T)
        # No M of this arm comes below; the wrist alone has 2.5e-4 kg·m².
        assert np.linalg.eigvalsh(M)[0] > 1e-4


def test_mass_rate_minus_twice_coriolis_is_skew_at_1000_states() -> None:
    # With the C of h's bilinear form, xᵀ (Ṁ − 2C) x = 0 is xᵀ Ṁ x = 2 xᵀ Γ(q̇, x), for every x.
    step, random = 1e-6, np.random.default_rng(7)
    for state in random_states(2):
        q, dq, x = state.q, state.dq, random.normal(size=6)
        M1, M0 = (MODEL.at(State(t=0.0, q=q + s * dq, dq=dq)).M for s in (step, -step))
        h_sum, h_x = (MODEL.at(State(t=0.0, q=q, dq=v)).h for v in (dq + x, x))
        C_x = 0.5 * (h_sum - MODEL.at(state).h - h_x)
        assert abs(x @ (M1 - M0) @ x / (2.0 * step) - 2.0 * x @ C_x) < 1e-6  # a central difference of sums of 36 terms


def test_power_of_gravity_is_the_rate_of_the_potential_at_1000_states() -> None:
    step = 1e-6
    for state in random_states(3):
        above, below = (LAGRANGE.potential_energy(state.q + s * state.dq) for s in (step, -step))
        assert abs((above - below) / (2.0 * step) - state.dq @ MODEL.at(state).g) < 1e-6


def test_wrench_on_the_tool_and_its_joint_torque_have_the_same_power_at_1000_states() -> None:
    step, random = 1e-6, np.random.default_rng(4)
    for state in random_states(4):
        f, m = random.normal(size=(2, 3))
        (p1, R1, _), (p0, R0, _) = (MODEL.kinematics(state.q + s * state.dq) for s in (step, -step))
        S = (R1 - R0) @ MODEL.kinematics(state.q)[1].T / (2.0 * step)
        power = f @ (p1 - p0) / (2.0 * step) + m @ [S[2, 1], S[0, 2], S[1, 0]]
        assert abs(power - (MODEL.at(state).J.T @ np.concatenate((f, m))) @ state.dq) < 1e-6
