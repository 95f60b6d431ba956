"""What every control law must keep on every arm, whatever else it does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish import control
from burnish.control import (
    Adaptive,
    CartesianVelocity,
    ComputedTorque,
    DynamicNullSpace,
    ForceMotion,
    GeometricNullSpace,
    GravityCompensation,
    Hybrid,
    HybridNullSpace,
    Impedance,
    InertiaShapingImpedance,
    JacobianTranspose,
    LimitAvoidance,
    OperationalSpace,
    Posture,
    PostureReference,
    RedundantImpedance,
    TaskComputedTorque,
)
from burnish.core import Array, Controller, Dynamics, JointReference, State, ToolReference
from burnish.errors import BurnishError
from burnish.model.friction import Friction
from burnish.model.model import Model
from burnish.rotation import exp, rotation_vector_error

HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
START = 2.25
DT = 1e-3
MODEL = Model.jaco2()
MODELS = {"jaco2": MODEL, "seven": Model.from_urdf(Path(__file__).parent / "data" / "seven_dof.urdf", tool="tool0")}
SINGULAR = {
    # Stretched and folded, and the wrist with the axes of joints 4 and 6 in one line.
    "jaco2": [np.zeros(6), np.array([0.0, np.pi / 2, np.pi, 0.0, 0.0, 0.0]), HOME * [1, 1, 1, 1, 0, 1]],
    # Stretched, elbow stretched, wrist in line.
    "seven": [np.zeros(7), np.array([0.3, 0.5, 0.2, 0, 0.4, 0.5, 0.1]), np.array([0.3, 0.5, 0.2, 1, 0.4, 0, 0.1])],
}
STATES = 200
LARGEST_JUMP = 0.5
"""Torque [N·m] that a change of the input by `SMALL` may change."""
SMALL = 1e-6
INERTIA = np.diag([4.0, 5.0, 6.0, 0.3, 0.4, 0.5]) + 0.05


def tasks(model: Model, q: Array) -> list[Any]:
    """Both tasks for the null space."""
    return [Posture.at_frequency(q, 3.0), LimitAvoidance(lower=model.lower, upper=model.upper, kd=1.0)]


PID = {"stiffness": (400.0, 20.0), "damping": (20.0, 2.0), "integral_stiffness": (100.0, 10.0)}
PD = {"kp": 400.0, "kd": 40.0}
HYBRID = {"stiffness": 400.0, "damping": 22.0, "turn_rate": 5.0, "speed_gain": 10.0, "speed_rate_gain": 0.02}
SPEEDS = {"speed_gain": 60.0, "position_kp": 5.0, "orientation_kp": 5.0, "position_ki": 1.0, "orientation_kd": 0.2}


def friction(model: Model) -> Friction:
    return Friction(coulomb=np.ones(model.n), viscous=np.ones(model.n))


def masked(model: Model, q: Array, first: bool, last: bool) -> OperationalSpace:
    mask = (first,) * 3 + (last,) * 3
    return OperationalSpace(**PD, ki=100.0, mask=mask, null_space=tasks(model, q), joint_damping=5.0)


LAWS: dict[str, Callable[[Model, Array], Controller[Any]]] = {
    "Adaptive": lambda model, q: Adaptive(law=OperationalSpace(**PD), push_rate=10.0, push_moment_rate=1.0),
    "Adaptive, joints": lambda model, q: Adaptive(law=ComputedTorque(kp=100.0, kd=20.0)),
    "CartesianVelocity": lambda model, q: CartesianVelocity(speed_gain=50.0, integral_gain=100.0),
    "ComputedTorque": lambda model, q: ComputedTorque(kp=100.0, kd=20.0, ki=50.0, friction=friction(model)),
    "DynamicNullSpace": lambda model, q: DynamicNullSpace(**PID, joint_damping=1.0),
    "ForceMotion": lambda model, q: ForceMotion(friction=friction(model)),
    "GeometricNullSpace": lambda model, q: GeometricNullSpace(**PID, joint_damping=1.0),
    "GravityCompensation": lambda model, q: GravityCompensation(damping=1.0),
    "Hybrid": lambda model, q: Hybrid(**HYBRID),
    "HybridNullSpace": lambda model, q: HybridNullSpace(**HYBRID, joint_damping=1.0),
    "Impedance": lambda model, q: Impedance(stiffness=(400.0, 20.0), damping=(20.0, 2.0), joint_damping=1.0),
    "Impedance, ratio": lambda model, q: Impedance.from_stiffness((400.0, 20.0), feed_forward=1.0),
    "InertiaShapingImpedance": lambda model, q: InertiaShapingImpedance.from_stiffness((400.0, 20.0)),
    "InertiaShapingImpedance, A": lambda model, q: InertiaShapingImpedance.from_stiffness(400.0, inertia=INERTIA),
    "JacobianTranspose": lambda model, q: JacobianTranspose(**PID, joint_damping=1.0),
    "OperationalSpace": lambda model, q: OperationalSpace(**PD, ki=100.0),
    "OperationalSpace, position": lambda model, q: masked(model, q, True, False),
    "OperationalSpace, orientation": lambda model, q: masked(model, q, False, True),
    "PostureReference": lambda model, q: PostureReference(**SPEEDS),
    "RedundantImpedance": lambda model, q: RedundantImpedance.from_stiffness((400.0, 20.0)),
    "RedundantImpedance, A": lambda model, q: RedundantImpedance.from_stiffness(
        400.0, inertia=INERTIA, null_space=tasks(model, q)
    ),
    "TaskComputedTorque": lambda model, q: TaskComputedTorque(**PD, ki=100.0),
}
"""Every law, with all that it can do switched on; what depends on the arm and on where it is comes as an argument."""
NEEDS_INVERSE = ("InertiaShapingImpedance", "TaskComputedTorque")
CASES = [(name, arm) for name in LAWS for arm in MODELS if arm == "jaco2" or not name.startswith(NEEDS_INVERSE)]


every_law_and_arm = pytest.mark.parametrize(("name", "arm_name"), CASES)


def wants_joints(name: str) -> bool:
    return name in ("ComputedTorque", "GravityCompensation", "Adaptive, joints")


def arm_at(
    q: Array, dq: Array | None = None, t: float = START, F: Array | None = None, model: Model = MODEL
) -> Dynamics:
    F = np.array([1.0, -2.0, 9.0, 0.1, 0.2, -0.1]) if F is None else F
    return model.at(State(t=t, q=q, dq=np.zeros(model.n) if dq is None else dq)).feeling(F)


def random_q(model: Model, rng: np.random.Generator) -> Array:
    """Within the limits, and out of the margin of `LimitAvoidance`."""
    return rng.uniform(np.maximum(model.lower, -np.pi) + 0.4, np.minimum(model.upper, np.pi) - 0.4)


def wanted(name: str, arm: Dynamics, rng: np.random.Generator, angle: float | None = None) -> Any:
    """What the law takes, some way off and moving; ``angle`` is how far the tool is turned away [rad]."""
    n = len(arm.q)
    if wants_joints(name):
        return JointReference(q=arm.q + rng.uniform(-0.3, 0.3, n), dq=rng.normal(size=n), ddq=rng.normal(size=n))
    u = rng.normal(size=3)
    turn = (rng.uniform(0.0, 2.0) if angle is None else angle) * u / np.linalg.norm(u)
    return ToolReference(
        p=arm.p + rng.uniform(-0.05, 0.05, 3),
        R=exp(turn) @ arm.R,
        v=rng.normal(size=6) * 0.3,
        a=rng.normal(size=6),
        normal=np.array([0.0, 0.0, 1.0]),
        force=8.0,
    )


def at_rest(name: str, arm: Dynamics) -> Any:
    """The arm's own pose as the reference."""
    zero = np.zeros(len(arm.q))
    if wants_joints(name):
        return JointReference(q=arm.q, dq=zero, ddq=zero)
    return ToolReference(p=arm.p, R=arm.R, v=np.zeros(6), a=np.zeros(6))


def law_for(name: str, model: Model) -> Controller[Any]:
    return LAWS[name](model, HOME if model.n == 6 else np.zeros(7))


def arm_later(arm: Dynamics) -> Dynamics:
    return replace(arm, t=arm.t + DT)


def jump(
    name: str, law: Controller[Any], model: Model, q: Array, rng: np.random.Generator, angle: float | None = None
) -> float:
    """By how much the torque changes when position and speed of the joints change by `SMALL` [N·m]."""
    dq, direction = rng.uniform(-1.0, 1.0, model.n), rng.normal(size=model.n)
    step = SMALL * direction / np.linalg.norm(direction)
    arm = arm_at(q, dq, model=model)
    reference = wanted(name, arm, rng, angle)
    near = arm_at(q + step, dq + step[::-1], START + DT, model=model)
    taus = []
    for second in (arm_later(arm), near):
        law.reset(arm)
        law.torque(arm, reference)
        taus.append(law.torque(second, reference))
    assert np.isfinite(taus).all()
    return float(np.abs(taus[1] - taus[0]).max())


def test_the_laws_of_the_package_are_those_under_contract() -> None:
    assert sorted({name.split(",")[0] for name in LAWS}) == sorted(control.__all__)


@every_law_and_arm
def test_torque_is_finite_and_does_not_jump_over_random_states(name: str, arm_name: str) -> None:
    model, rng = MODELS[arm_name], np.random.default_rng(1)
    law = law_for(name, model)
    assert max(jump(name, law, model, random_q(model, rng), rng) for _ in range(STATES)) < LARGEST_JUMP


@every_law_and_arm
def test_torque_is_finite_and_does_not_jump_in_and_next_to_a_singularity(name: str, arm_name: str) -> None:
    # At distances from nothing to 0.3 rad: wherever a damping sets in, some step crosses it.
    model, rng = MODELS[arm_name], np.random.default_rng(2)
    law = law_for(name, model)
    distances = np.concatenate([[0.0], np.geomspace(1e-7, 0.3, 14)])
    for q in SINGULAR[arm_name]:
        for distance in distances:
            there = q + distance * rng.normal(size=model.n)
            assert jump(name, law, model, there, rng) < LARGEST_JUMP, f"{distance} rad from {q}"


@every_law_and_arm
def test_torque_does_not_jump_where_the_orientation_error_turns_round(name: str, arm_name: str) -> None:
    # Steps of 1e-6 over θ = π, and over the beginning of the fade of the error 5° before it.
    model, rng = MODELS[arm_name], np.random.default_rng(3)
    law = law_for(name, model)
    for angle in np.pi - np.concatenate([np.zeros(12), [1e-7, 1e-6, 1e-4, 1e-2], np.radians([2.5, 5.0, 5.001])]):
        assert jump(name, law, model, random_q(model, rng), rng, float(angle)) < LARGEST_JUMP, f"θ = {angle}"


def test_an_orientation_error_that_turns_round_at_half_a_turn_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    turning = OperationalSpace(**PD, orientation_error=rotation_vector_error)
    monkeypatch.setitem(LAWS, "OperationalSpace", lambda model, q: turning)
    with pytest.raises(AssertionError, match="θ = "):
        test_torque_does_not_jump_where_the_orientation_error_turns_round("OperationalSpace", "jaco2")


@every_law_and_arm
def test_torque_at_rest_on_the_target_is_the_weight(name: str, arm_name: str) -> None:
    # h is 0 at rest, so this holds for laws with and without it. Weights reach 20 N·m, and rounding of a pose 1e-16.
    model, rng, off = MODELS[arm_name], np.random.default_rng(4), []
    for _ in range(STATES):
        arm = arm_at(random_q(model, rng), F=np.zeros(6), model=model)
        law = LAWS[name](model, arm.q)
        law.reset(arm)
        for i in range(2):
            off.append(law.torque(replace(arm, t=START + i * DT), at_rest(name, arm)) - arm.g)
    assert np.abs(off).max() < 1e-9


@every_law_and_arm
def test_law_after_a_reset_is_as_new_and_two_alike_agree(name: str, arm_name: str) -> None:
    model = MODELS[arm_name]
    q = random_q(model, np.random.default_rng(5))
    used, new = LAWS[name](model, q), LAWS[name](model, q)
    rng = np.random.default_rng(6)
    used.reset(arm_at(q, model=model))
    for i in range(STATES // 4):
        arm = arm_at(random_q(model, rng), rng.normal(size=model.n), START + DT * i, model=model)
        used.torque(arm, wanted(name, arm, rng))
    for law in (used, new):
        law.reset(arm_at(q, t=9.0, model=model))
    for i in range(3):
        arm = arm_at(q, t=9.0 + DT * i, model=model)
        torques = [law.torque(arm, wanted(name, arm, np.random.default_rng(i))) for law in (used, new)]
        assert torques[0].shape == (model.n,)
        assert_allclose(torques[0], torques[1], atol=0.0)


@every_law_and_arm
def test_law_leaves_its_arguments_alone(name: str, arm_name: str) -> None:
    model = MODELS[arm_name]
    q = random_q(model, np.random.default_rng(7))
    law, arm = LAWS[name](model, q), arm_at(q, np.full(model.n, 0.2), model=model)
    reference = wanted(name, arm, np.random.default_rng(8))
    things = [
        getattr(thing, slot)
        for thing in (arm, reference)
        for slot in ("q", "dq", "ddq", "p", "R", "v", "a", "J", "dJdq", "M", "h", "g", "F")
        if hasattr(thing, slot)
    ]
    before = [np.copy(thing) for thing in things]
    law.reset(arm)
    for i in range(3):
        law.torque(replace(arm, t=START + 0.01 * i), reference)
    for thing, kept in zip(things, before, strict=True):
        assert_allclose(thing, kept, atol=0.0)


TAKES_ANYTHING = ("GravityCompensation", "ForceMotion")
"""The first uses no reference; the other belongs to the polishing job, which gives it no other kind."""


@pytest.mark.parametrize("name", [name for name in LAWS if name not in TAKES_ANYTHING])
def test_reference_of_the_wrong_kind_is_refused_by_name(name: str) -> None:
    law, arm = LAWS[name](MODEL, HOME), arm_at(HOME)
    for other in (None, at_rest("OperationalSpace" if wants_joints(name) else "ComputedTorque", arm)):
        if name == "Adaptive, joints" and other is not None:
            law = Adaptive(law=ComputedTorque(kp=1.0, kd=1.0))
        law.reset(arm)
        with pytest.raises(BurnishError, match=r"given a (NoneType|ToolReference|JointReference)"):
            law.torque(arm, other)


@pytest.mark.parametrize("name", [name for name in LAWS if name.startswith(NEEDS_INVERSE)])
def test_law_that_inverts_the_jacobian_refuses_a_redundant_arm_in_one_line(name: str) -> None:
    model = MODELS["seven"]
    with pytest.raises(BurnishError, match="6 joints; this one has 7") as refused:
        LAWS[name](model, np.zeros(7)).reset(arm_at(np.zeros(7), model=model))
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("name", ["ForceMotion", "InertiaShapingImpedance, A", "RedundantImpedance, A"])
def test_law_without_the_wrench_that_it_needs_refuses_before_motion(name: str) -> None:
    arm = MODEL.at(State(t=0.0, q=HOME, dq=np.zeros(6)))
    with pytest.raises(BurnishError, match="contact wrench"):
        LAWS[name](MODEL, HOME).reset(arm)


@pytest.mark.parametrize("name", ["InertiaShapingImpedance", "RedundantImpedance"])
def test_impedance_with_the_arms_own_inertia_needs_no_wrench(name: str) -> None:
    arm = MODEL.at(State(t=0.0, q=HOME, dq=np.zeros(6)))
    law = LAWS[name](MODEL, HOME)
    law.reset(arm)
    assert_allclose(law.torque(arm, at_rest(name, arm)), arm.g, atol=1e-9)


GAINS = {
    "Adaptive": "convergence mass_rate moment_rate push_rate push_moment_rate mass moment push push_moment",
    "CartesianVelocity": "speed_gain integral_gain integral singular_value",
    "ComputedTorque": "kp kd ki integral window",
    "DynamicNullSpace": "stiffness damping integral_stiffness integral joint_damping window",
    "GeometricNullSpace": "stiffness damping integral_stiffness integral joint_damping window",
    "GravityCompensation": "damping",
    "Hybrid": "stiffness damping turn_rate speed_gain speed_rate_gain derivative_time",
    "HybridNullSpace": "stiffness damping turn_rate speed_gain speed_rate_gain derivative_time joint_damping",
    "Impedance": "stiffness damping feed_forward joint_damping",
    "InertiaShapingImpedance": "stiffness damping",
    "JacobianTranspose": "stiffness damping integral_stiffness integral joint_damping window",
    "OperationalSpace": "kp kd ki integral joint_damping window",
    "PostureReference": "speed_gain position_kp orientation_kp position_ki orientation_ki position_kd integral window",
    "RedundantImpedance": "stiffness damping",
    "TaskComputedTorque": "kp kd ki integral window",
}


@pytest.mark.parametrize(("name", "gain"), [(name, gain) for name in GAINS for gain in GAINS[name].split()])
@pytest.mark.parametrize("value", [-1.0, np.nan, np.ones((2, 5)), "fast"], ids=["negative", "nan", "shape", "word"])
def test_bad_gain_is_refused_before_motion(name: str, gain: str, value: Any) -> None:
    law: Any = LAWS[name](MODEL, HOME)
    with pytest.raises(BurnishError):
        replace(law, **{gain: value})


PER_JOINT = {
    "CartesianVelocity": "speed_gain integral_gain",
    "ComputedTorque": "kp kd ki",
    "GeometricNullSpace": "joint_damping",
    "GravityCompensation": "damping",
    "Hybrid": "turn_rate speed_gain speed_rate_gain",
    "HybridNullSpace": "turn_rate joint_damping",
    "Impedance": "joint_damping",
    "PostureReference": "speed_gain",
}


@pytest.mark.parametrize(("name", "gain"), [(name, gain) for name in PER_JOINT for gain in PER_JOINT[name].split()])
def test_joint_gain_of_another_arm_is_refused_before_motion(name: str, gain: str) -> None:
    law: Any = LAWS[name](MODEL, HOME)
    with pytest.raises(BurnishError, match="6 joints"):
        replace(law, **{gain: np.ones(7)}).reset(arm_at(HOME))
