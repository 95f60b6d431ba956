"""Two engines on one description: what the controller computes with against what the simulator moves."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.core import Array, State
from burnish.model.model import JACO2_URDF, Model
from burnish.model.tool import PolishingTool
from burnish.rotation import exp
from burnish.sim.plant import Plant
from burnish.sim.scene import GRAVITY, Scene, Workpiece, build
from burnish.surface import DistanceGrid

DATA = Path(__file__).parent.parent / "data"
TOOL = PolishingTool()
TOLERANCE = 1e-9
"""Two engines in double precision, torques below 30 N·m; five of the digits between are rounding."""


def mass_matrix(model: Any, data: Any) -> Array:
    M = np.zeros((model.nv, model.nv))
    try:
        mujoco.mj_fullM(model, data, M)
    except TypeError:
        # MuJoCo 3.
        mujoco.mj_fullM(model, M, data.qM)
    return M


class Engine:
    """A compiled MuJoCo model, its first ``n`` coordinates an arm's, asked for what `Dynamics` holds."""

    def __init__(self, model: Any, n: int, body: str, offset: float = 0.0) -> None:
        self.model, self.n, self.offset = model, n, offset
        self.body = model.body(body).id
        self.data = mujoco.MjData(model)

    def at(self, q: Array, dq: Array) -> dict[str, Array]:
        model, data, n = self.model, self.data, self.n
        data.qpos[:n] = q
        data.qvel[:n] = 0.0
        mujoco.mj_forward(model, data)
        g = data.qfrc_bias[:n].copy()
        data.qvel[:n] = dq
        mujoco.mj_forward(model, data)
        R = data.xmat[self.body].reshape(3, 3).copy()
        p = data.xpos[self.body] + self.offset * R[:, 2]
        J = np.zeros((6, model.nv))
        mujoco.mj_jac(model, data, J[:3], J[3:], p, self.body)
        M = mass_matrix(model, data)[:n, :n]
        return {"p": p, "R": R, "J": J[:, :n], "M": M, "g": g, "h": data.qfrc_bias[:n] - g}


def bare(path: Path, tool: str) -> Engine:
    """The engine's own reading of a description, no body merged into another."""
    spec = mujoco.MjSpec.from_file(str(path))
    spec.compiler.fusestatic = False
    model = spec.compile()
    return Engine(model, model.nv, tool)


def assert_engines_agree(ours: Model, theirs: Engine, seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(100):
        q, dq = rng.uniform(-2.0 * np.pi, 2.0 * np.pi, ours.n), rng.uniform(-1.0, 1.0, ours.n)
        arm = ours.at(State(t=0.0, q=q, dq=dq))
        for name, values in theirs.at(q, dq).items():
            assert_allclose(getattr(arm, name), values, rtol=0.0, atol=TOLERANCE, err_msg=name)


@pytest.mark.parametrize(
    ("path", "tool"),
    [
        (JACO2_URDF, "end_effector"),
        (DATA / "ur5e_like.urdf", "tool0"),
        (DATA / "seven_dof.urdf", "tool0"),
        (DATA / "prismatic.urdf", "tip"),
    ],
    ids=["jaco2", "ur5e_like", "seven_dof", "prismatic"],
)
def test_two_engines_read_the_same_arm(path: Path, tool: str) -> None:
    assert_engines_agree(Model.from_urdf(path, tool), bare(path, tool), seed=1)


def test_two_engines_see_the_same_arm_with_the_tool() -> None:
    # The tip's spring at its rest: the model has no such joint, and the rest is where it thinks that the tip is.
    scene = build(TOOL, Plant.ideal(), None)
    assert_engines_agree(TOOL.on(Model.jaco2()), Engine(scene.model, scene.n, "tool", TOOL.length), seed=2)


def test_two_engines_see_the_same_arm_with_gears() -> None:
    armature = np.array([0.8, 0.7, 0.6, 0.15, 0.14, 0.13])
    scene = build(TOOL, replace(Plant.ideal(), armature=armature), None)
    ours = TOOL.on(Model.jaco2().with_armature(armature))
    assert_engines_agree(ours, Engine(scene.model, scene.n, "tool", TOOL.length), seed=3)


@pytest.fixture
def displaced() -> tuple[Scene, Array, Array]:
    """A scene with a mould that stands askew and not where it was drawn; and where it really stands."""
    plant = replace(
        Plant.ideal(), mould_shift=np.array([1e-3, -2e-3, 1.5e-3]), mould_turn=np.array([0.02, -0.03, 0.01])
    )
    grid = DistanceGrid(origin=np.zeros(3), spacing=0.1, values=np.ones((2, 2, 2)))
    p, R = np.array([0.3, -0.4, 0.1]), exp(np.array([0.2, 0.1, 0.7]))
    return build(TOOL, plant, Workpiece(grid=grid, p=p, R=R)), p + plant.mould_shift, exp(plant.mould_turn) @ R


def test_world_of_the_engine_is_the_mould_where_it_really_stands(displaced: tuple[Scene, Array, Array]) -> None:
    scene, p, R = displaced
    engine, ours = Engine(scene.model, scene.n, "tool", TOOL.length), TOOL.on(Model.jaco2())
    for q in np.random.default_rng(4).uniform(-np.pi, np.pi, (10, 6)):
        found, arm = engine.at(q, np.zeros(6)), ours.at(State(t=0.0, q=q, dq=np.zeros(6)))
        assert_allclose(p + R @ found["p"], arm.p, atol=TOLERANCE)
        assert_allclose(R @ found["R"], arm.R, atol=TOLERANCE)


def test_gravity_stays_with_the_base(displaced: tuple[Scene, Array, Array]) -> None:
    scene, _, R = displaced
    assert_allclose(R @ scene.model.opt.gravity, GRAVITY, atol=1e-14)
    engine, ours = Engine(scene.model, scene.n, "tool"), TOOL.on(Model.jaco2())
    for q in np.random.default_rng(5).uniform(-np.pi, np.pi, (10, 6)):
        assert_allclose(engine.at(q, np.zeros(6))["g"], ours.at(State(t=0.0, q=q, dq=np.zeros(6))).g, atol=TOLERANCE)


def test_mass_scale_of_the_tool_makes_it_as_much_heavier() -> None:
    scale = np.array([1.0] * 6 + [1.2])
    scene = build(TOOL, replace(Plant.ideal(), mass_scale=scale), None)
    engine = Engine(scene.model, scene.n, "tool")
    without, with_tool = Model.jaco2(), TOOL.on(Model.jaco2())
    for q in np.random.default_rng(6).uniform(-np.pi, np.pi, (10, 6)):
        state = State(t=0.0, q=q, dq=np.zeros(6))
        g = without.at(state).g
        expected = g + 1.2 * (with_tool.at(state).g - g)
        assert_allclose(engine.at(q, np.zeros(6))["g"], expected, atol=TOLERANCE)


def test_mass_scale_of_all_makes_all_heavier() -> None:
    scene = build(TOOL, replace(Plant.ideal(), mass_scale=np.full(7, 0.9)), None)
    engine, ours = Engine(scene.model, scene.n, "tool", TOOL.length), TOOL.on(Model.jaco2())
    for q in np.random.default_rng(7).uniform(-np.pi, np.pi, (10, 6)):
        found, arm = engine.at(q, np.zeros(6)), ours.at(State(t=0.0, q=q, dq=np.zeros(6)))
        assert_allclose(found["M"], 0.9 * arm.M, atol=TOLERANCE)
        assert_allclose(found["g"], 0.9 * arm.g, atol=TOLERANCE)


def test_gears_of_the_plant_are_those_of_the_engine() -> None:
    ideal = Plant.ideal()
    friction = replace(ideal.friction, coulomb=np.arange(1.0, 7.0), viscous=np.arange(2.0, 8.0))
    model = build(TOOL, replace(ideal, friction=friction), None).model
    assert_allclose(model.dof_frictionloss, [*friction.coulomb, 0.0])
    assert_allclose(model.dof_damping, [*friction.viscous, TOOL.damping])


def test_tip_slides_on_the_spring_of_the_tool() -> None:
    scene = build(TOOL, Plant.ideal(), None)
    data = mujoco.MjData(scene.model)
    data.qpos[scene.n] = -1e-3
    mujoco.mj_forward(scene.model, data)
    assert data.qfrc_spring[scene.n] == pytest.approx(TOOL.stiffness * 1e-3)
    # Pushed in means towards the arm: the tip's centre comes nearer to the sensor.
    assert np.linalg.norm(data.xpos[scene.tip] - data.xpos[scene.tool]) == pytest.approx(TOOL.tip_centre - 1e-3)
