"""What is learnt of the joints' friction: by the rule, within its bound, from a real engine."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.control.force import ForceMotion
from burnish.control.gears import LearntFriction
from burnish.core import Array, State, ToolReference, Torque
from burnish.errors import InputError
from burnish.model.friction import Friction
from burnish.model.model import Model
from burnish.model.tool import PolishingTool
from burnish.rotation import exp
from burnish.sim.plant import Plant
from burnish.sim.robot import SimRobot

F = np.array([1.0, 2.0, 0.5])
NOMINAL = Friction(coulomb=F, viscous=0.3 * np.ones(3))
M = np.diag([1.2, 0.8, 0.1]) + 0.05
DQ = np.array([0.2, -0.3, 0.1])


def test_at_first_it_is_the_nominal_friction() -> None:
    assert_allclose(LearntFriction(nominal=NOMINAL).torque(DQ), NOMINAL.torque(DQ), atol=0.0)


def test_joint_that_is_behind_gets_more_and_one_that_is_ahead_less() -> None:
    learnt = LearntFriction(nominal=NOMINAL)
    learnt.learn(DQ, np.sign(DQ) * [0.1, -0.1, 0.0], M, 0.01)
    assert learnt.shares[0] > 1.0 > learnt.shares[1]
    assert learnt.shares[2] == 1.0


def test_joints_of_any_weight_and_friction_are_corrected_by_the_same_acceleration() -> None:
    learnt = LearntFriction(nominal=replace(NOMINAL, viscous=np.zeros(3)), rate=7.0)
    dq = np.full(3, 0.5)
    before = learnt.torque(dq)
    learnt.learn(dq, np.full(3, 0.2), M, 0.01)
    # κ s dt, whatever M and F are.
    assert_allclose((learnt.torque(dq) - before) / np.diag(M), np.full(3, 7.0 * 0.2 * 0.01), atol=1e-12)


def test_share_stays_within_its_bound() -> None:
    learnt = LearntFriction(nominal=NOMINAL, most=0.4)
    for _ in range(1000):
        learnt.learn(DQ, np.array([5.0, 5.0, -5.0]) * np.sign(DQ), M, 0.01)
    assert_allclose(learnt.shares, [1.4, 1.4, 0.6], atol=1e-12)


def test_joint_without_coulomb_friction_keeps_its_share() -> None:
    learnt = LearntFriction(nominal=Friction(coulomb=np.array([1.0, 0.0]), viscous=np.array([0.0, 1.0])))
    learnt.learn(np.array([0.2, 0.2]), np.ones(2), np.eye(2), 0.1)
    assert learnt.shares[0] > 1.0
    assert learnt.shares[1] == 1.0


def test_broken_reading_teaches_nothing() -> None:
    learnt = LearntFriction(nominal=NOMINAL)
    learnt.learn(DQ, np.array([np.nan, 0.1, np.nan]), M, 0.01)
    assert learnt.shares[0] == learnt.shares[2] == 1.0
    assert learnt.shares[1] < 1.0


def test_nothing_is_learnt_in_a_cycle_without_length() -> None:
    learnt = LearntFriction(nominal=NOMINAL)
    learnt.learn(DQ, np.ones(3), M, 0.0)
    assert_allclose(learnt.shares, np.ones(3), atol=0.0)


@pytest.mark.parametrize("seed", range(20))
def test_it_adds_no_more_energy_than_it_says(seed: int) -> None:
    """Whatever the joints do: ∫ −s (σ − σ_real) τ_f dt ≤ ½ Σ F² most²/(κ M)."""
    rng = np.random.default_rng(seed)
    learnt = LearntFriction(nominal=NOMINAL)
    real, dt, energy, most = rng.uniform(0.5, 1.5, 3), 1e-4, 0.0, 0.0
    dq, s = DQ.copy(), np.zeros(3)
    for _ in range(20000):
        dq += 0.01 * (rng.normal(size=3) - dq)
        # The worst that the motion could do is to ask where the share is wrong.
        s = 0.99 * s + 0.02 * rng.normal(size=3) - 0.01 * np.sign(NOMINAL.torque(dq)) * (learnt.shares - real)
        energy -= dt * float(s @ ((learnt.shares - real) * NOMINAL.torque(dq)))
        most = max(most, energy)
        learnt.learn(dq, s, M, dt)
    bound = 0.5 * float(np.sum(F**2 * learnt.most**2 / (learnt.rate * np.diag(M))))
    assert 0.0 < most <= bound


@pytest.mark.parametrize(("name", "value"), [("rate", -1.0), ("most", np.inf), ("rate", np.nan)])
def test_figures_out_of_range_are_refused(name: str, value: float) -> None:
    with pytest.raises(InputError, match=f"{name} = {value}"):
        LearntFriction(nominal=NOMINAL, **{name: value})


# With the law, on the engine.

GEARS = Friction(coulomb=np.repeat([1.0, 0.4], 3), viscous=np.repeat([2.5, 0.6], 3))
REAL = np.array([1.3, 0.75, 1.25, 0.7, 1.3, 0.8])
START = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
TOOL = PolishingTool()
AXIS = np.array([0.6, 0.0, 0.8])


def swaying(law: ForceMotion, seconds: float) -> Array:
    """Distance from a tool pose that sways and nods in the air, with gears that are off by up to 30 % [m], (N,)."""
    plant = replace(
        Plant.ideal(seed=1),
        friction=Friction(coulomb=REAL * GEARS.coulomb, viscous=REAL * GEARS.viscous),
        armature=np.repeat([0.8, 0.15], 3),
    )
    model = TOOL.on(Model.jaco2()).with_armature(plant.armature)
    far = []
    with SimRobot(START, rate=500.0, plant=plant, tool=TOOL) as robot:
        state = robot.read()
        first = model.at(state)
        law.reset(replace(first, F=np.zeros(6)))
        while state.t < seconds:
            arm = replace(model.at(state), F=np.zeros(6))
            w = np.array([2.0, 2.7, 3.1, 2.3])
            A = np.array([0.03, 0.03, 0.02, 0.25])
            s, ds, dds = A * (1.0 - np.cos(w * arm.t)), A * w * np.sin(w * arm.t), A * w**2 * np.cos(w * arm.t)
            v, a = (np.concatenate([d[:3], d[3] * AXIS]) for d in (ds, dds))
            wanted = ToolReference(p=first.p + s[:3], R=exp(s[3] * AXIS) @ first.R, v=v, a=a)
            far.append(float(np.linalg.norm(wanted.p - arm.p)))
            robot.write(Torque(law.torque(arm, wanted)))
            state = robot.read()
    return np.array(far)


def test_gears_that_are_off_are_learnt_and_followed_more_closely() -> None:
    learnt = LearntFriction(nominal=GEARS)
    trusting, learning = (
        swaying(ForceMotion(friction=friction, position_integral=0.0, orientation_integral=0.0), 20.0)
        for friction in (GEARS, learnt)
    )
    last = len(learning) // 4
    assert np.abs(learnt.shares - REAL).max() < 0.5 * np.abs(REAL - 1.0).max()
    assert np.sqrt(np.mean(learning[-last:] ** 2)) < 0.4 * np.sqrt(np.mean(trusting[-last:] ** 2))


def test_what_is_known_of_the_gears_outlives_a_reset() -> None:
    learnt = LearntFriction(nominal=GEARS)
    law = ForceMotion(friction=learnt)
    swaying(law, 1.0)
    known = learnt.shares
    assert np.abs(known - 1.0).max() > 0.01
    model = TOOL.on(Model.jaco2())
    with SimRobot(START, rate=500.0, tool=TOOL) as robot:
        law.reset(replace(model.at(robot.read()), F=np.zeros(6)))
    assert_allclose(learnt.shares, known, atol=0.0)


@pytest.mark.parametrize(("felt", "learns"), [(0.0, True), (8.0, False)])
def test_what_the_surface_holds_teaches_nothing(felt: float, learns: bool) -> None:
    model, n = TOOL.on(Model.jaco2()), np.array([0.0, 0.6, 0.8])
    learnt = LearntFriction(nominal=GEARS)
    law = ForceMotion(friction=learnt, seek_speed=0.0)
    arm = replace(model.at(State(t=0.0, q=START, dq=np.zeros(6))), F=np.concatenate([felt * n, np.zeros(3)]))
    law.reset(arm)
    v = np.concatenate([0.02 * np.array([1.0, 0.0, 0.0]), np.zeros(3)])
    # Behind along the normal only; as fast as planned but for that.
    arm = replace(arm, dq=np.linalg.solve(arm.J, v))
    wanted = ToolReference(p=arm.p - 0.002 * n, R=arm.R, v=v, a=np.zeros(6), normal=n, force=8.0)
    for i in range(1, 2001):
        law.torque(replace(arm, t=1e-3 * i), wanted)
        if i == 1000:
            settled = learnt.shares
    assert (np.abs(learnt.shares - settled).max() > 1e-3) == learns
