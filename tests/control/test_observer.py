from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.control.observer import MomentumSense
from burnish.control.wrench import JointSense
from burnish.core import Array, Dynamics, State
from burnish.errors import InputError
from burnish.model.model import Model

HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
ARMATURE = np.array([0.8, 0.7, 0.6, 0.2, 0.1, 0.1])
LINKS = Model.jaco2()
MODEL = LINKS.with_armature(ARMATURE)
"""What the controller has: links and rotors in one M."""
DT = 1e-3


def swing(t: float, F: Array, bias: Array) -> tuple[Dynamics, State]:
    """The arm swinging under a contact wrench; sensors behind the gears feel its links alone, and are off by a bias."""
    phase = np.arange(6) + 3.0 * t
    q, dq, ddq = HOME + 0.1 * np.sin(phase), 0.3 * np.cos(phase), -0.9 * np.sin(phase)
    links = LINKS.at(State(t=t, q=q, dq=dq))
    tau = links.M @ ddq + links.h + links.g - links.J.T @ F + bias
    state = State(t=t, q=q, dq=dq, tau=tau)
    return MODEL.at(state), state


def rest(t: float, F: Array, bias: Array) -> tuple[Dynamics, State]:
    """The same arm at rest."""
    arm = MODEL.at(State(t=t, q=HOME, dq=np.zeros(6)))
    return arm, State(t=t, q=HOME, dq=arm.dq, tau=arm.g - arm.J.T @ F + bias)


def felt(sense: MomentumSense | JointSense, arm: Dynamics, state: State) -> Array:
    F = sense.feel(arm, state).F
    assert F is not None
    return F


NOTHING = np.zeros(6)
F = np.array([3.0, -4.0, 10.0, 0.2, 0.1, -0.3])
BIAS = np.array([0.4, -0.3, 0.2, -0.1, 0.05, -0.02])


def test_observer_feels_nothing_of_an_arm_that_swings_freely() -> None:
    sense = MomentumSense(armature=ARMATURE)
    wrenches = [felt(sense, *swing(DT * i, NOTHING, NOTHING)) for i in range(400)]
    # Once the start has died away. Of the trapezoid of 1 ms some mN·m are left.
    assert np.abs(wrenches[100:]).max() < 0.02


def test_static_residual_feels_the_inertia_that_the_observer_does_not() -> None:
    plain, observer = JointSense(), MomentumSense(armature=ARMATURE)
    worst = [
        np.max([np.abs(felt(sense, *swing(DT * i, NOTHING, NOTHING))[:3]) for i in range(400)][100:])
        for sense in (plain, observer)
    ]
    assert worst[1] < 0.05 * worst[0]


def test_rotors_that_are_not_told_are_felt_as_a_contact() -> None:
    told, untold = MomentumSense(armature=ARMATURE), MomentumSense(armature=np.zeros(6))
    off = [
        np.max([np.abs(felt(sense, *swing(DT * i, NOTHING, NOTHING))[:3]) for i in range(400)][100:])
        for sense in (told, untold)
    ]
    assert off[1] > 0.5 > off[0]


def test_observer_follows_a_step_of_the_wrench_as_a_first_order_lag() -> None:
    sense = MomentumSense(armature=ARMATURE, time_constant=0.03)
    felt(sense, *rest(0.0, NOTHING, NOTHING))
    felt(sense, *rest(DT, F, NOTHING))
    half = 0.5 * (1.0 - np.exp(-DT / 0.03))
    for i in range(2, 100):
        # The trapezoid of the first period saw the step by half.
        share = 1.0 - (1.0 - half) * np.exp(-DT * (i - 1) / 0.03)
        assert_allclose(felt(sense, *rest(DT * i, F, NOTHING)), share * F, atol=1e-8)


def test_observer_recovers_a_wrench_on_a_moving_arm_after_a_tare_at_rest() -> None:
    sense = MomentumSense(armature=ARMATURE)
    sense.tare([rest(DT * i, NOTHING, BIAS) for i in range(10)])
    for i in range(10, 400):
        last = felt(sense, *swing(DT * i, F, BIAS))
    # 15 ms late, in which the Jacobian of the swinging arm turns by half a per cent.
    assert_allclose(last, F, atol=0.01 * np.linalg.norm(F))


def test_reading_that_is_felt_again_changes_nothing() -> None:
    sense = MomentumSense(armature=ARMATURE)
    felt(sense, *rest(0.0, NOTHING, NOTHING))
    once = felt(sense, *rest(DT, F, NOTHING))
    assert_allclose(felt(sense, *rest(DT, F, NOTHING)), once, atol=0.0)


def test_tared_noise_is_that_of_the_filtered_force() -> None:
    # White noise σ through a trapezoid and a lag: σ² a/(2 − a) (1 + (1 − a))/2 with the share a of one step.
    rng = np.random.default_rng(3)
    sense = MomentumSense(armature=ARMATURE)
    sense.tare([rest(DT * i, NOTHING, 0.02 * rng.normal(size=6)) for i in range(20_000)])
    a = 1.0 - np.exp(-DT / sense.time_constant)
    arm, _ = rest(0.0, NOTHING, NOTHING)
    up = np.array([0.0, 0.0, 1.0])
    raw = 0.02 * np.linalg.norm(arm.J_bar[:, :3] @ up)
    assert sense.noise(up) == pytest.approx(raw * np.sqrt(a / (2.0 - a) * (2.0 - a) / 2.0), rel=0.1)


def test_arm_without_joint_sensors_is_refused() -> None:
    arm, state = rest(0.0, NOTHING, NOTHING)
    with pytest.raises(InputError, match="no joint torque sensors"):
        MomentumSense(armature=ARMATURE).feel(arm, State(t=0.0, q=state.q, dq=state.dq))
