from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.core import Array, Dynamics, State
from burnish.errors import DescriptionError, InputError
from burnish.model.friction import Friction
from burnish.model.lagrange import jaco2_lagrange
from burnish.model.model import JACO2_URDF, Model, urdf_estimates

DATA = Path(__file__).parent.parent / "data"
HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
TOLERANCE = 1e-9
"""Torques are below 20 N·m, lengths below 1 m: six digits are left for sums in another order."""
OTHERS = {"ur5e_like": ("tool0", 6), "seven_dof": ("tool0", 7), "prismatic": ("tip", 4)}
"""The other arms: tool frame and number of joints."""


def jaco2_at(q: Array, dq: Array | None = None) -> Dynamics:
    return Model.jaco2().at(State(t=0.0, q=q, dq=np.zeros(6) if dq is None else dq))


def random_states(n: int, seed: int, count: int) -> list[State]:
    rng = np.random.default_rng(seed)
    return [State(t=0.0, q=rng.uniform(-np.pi, np.pi, n), dq=rng.uniform(-1.0, 1.0, n)) for _ in range(count)]


def other(name: str) -> Model:
    return Model.from_urdf(DATA / f"{name}.urdf", tool=OTHERS[name][0])


# The packaged arm.


def test_jaco2_joints_without_an_end_have_no_limits() -> None:
    model = Model.jaco2()
    continuous = [True, False, False, True, True, True]
    assert np.isinf(model.lower).tolist() == continuous
    assert np.isinf(model.upper).tolist() == continuous
    assert np.all(model.lower < model.upper)


def test_jaco2_limits_are_those_of_the_data_sheet() -> None:
    # 36 and 48 deg/s, 30.5 and 6.8 N·m; ±133.75° and ±161° about 180°, rounded there to a quarter of a degree.
    model = Model.jaco2()
    assert_allclose(np.rad2deg(model.velocity_limit), [36.0] * 3 + [48.0] * 3)
    assert_allclose(model.effort_limit, [30.5] * 3 + [6.8] * 3)
    assert_allclose(np.rad2deg([model.lower[1], model.upper[1]]), [47.0, 313.0], atol=0.01)
    assert_allclose(np.rad2deg([model.lower[2], model.upper[2]]), [19.0, 341.0], atol=0.01)


def test_state_beyond_a_turn_is_the_state_within() -> None:
    turns = 2.0 * np.pi * np.array([3, 0, 0, -2, 1, 5])
    assert_allclose(jaco2_at(HOME + turns).J, jaco2_at(HOME).J, atol=1e-12)


def test_dynamics_carries_the_instant_and_the_measured_torque() -> None:
    tau = np.arange(6.0)
    arm = Model.jaco2().at(State(t=1.25, q=HOME, dq=np.zeros(6), tau=tau))
    assert arm.t == 1.25
    assert_allclose(arm.tau, tau)


def test_wrench_is_left_to_whoever_estimates_it() -> None:
    arm = Model.jaco2().at(State(t=0.0, q=HOME, dq=np.zeros(6), F=np.ones(6)))
    assert arm.F is None


def test_dynamics_is_not_overwritten_by_the_next_evaluation() -> None:
    model = Model.jaco2()
    first, second = random_states(6, 1, 2)
    arm = model.at(first)
    kept = {name: np.copy(getattr(arm, name)) for name in ("p", "R", "J", "dJdq", "M", "h", "g")}
    model.at(second)
    for name, values in kept.items():
        assert_allclose(getattr(arm, name), values, rtol=0.0, atol=0.0, err_msg=name)


def test_kinematics_is_that_of_the_dynamics() -> None:
    model = Model.jaco2()
    for state in random_states(6, 2, 10):
        arm = model.at(state)
        for ours, theirs in zip(model.kinematics(state.q), (arm.p, arm.R, arm.J), strict=True):
            assert_allclose(ours, theirs, atol=1e-14)


def test_link_poses_hold_the_tool() -> None:
    model = Model.jaco2()
    for state in random_states(6, 3, 5):
        arm = model.at(state)
        T = model.link_poses(state.q)["end_effector"]
        assert_allclose(T, np.block([[arm.R, arm.p[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]]), atol=1e-14)


def test_link_poses_hold_every_link_of_the_description() -> None:
    assert {"link_base", *(f"link_{i}" for i in range(1, 7)), "end_effector"} <= set(Model.jaco2().link_poses(HOME))


# Armature, payload, tool.


def test_armature_is_added_to_the_diagonal_of_the_mass_matrix() -> None:
    armature = np.array([0.8, 0.7, 0.6, 0.15, 0.14, 0.13])
    bare = Model.jaco2()
    geared = bare.with_armature(armature)
    for state in random_states(6, 4, 10):
        assert_allclose(geared.at(state).M, bare.at(state).M + np.diag(armature), atol=1e-12)


def test_armature_changes_neither_coriolis_nor_gravity() -> None:
    bare = Model.jaco2()
    geared = bare.with_armature(0.5)
    for state in random_states(6, 5, 10):
        assert_allclose(geared.at(state).h, bare.at(state).h, atol=1e-12)
        assert_allclose(geared.at(state).g, bare.at(state).g, atol=1e-12)


def test_model_with_armature_leaves_the_first_alone() -> None:
    bare = Model.jaco2()
    before = bare.at(State(t=0.0, q=HOME, dq=np.zeros(6))).M
    bare.with_armature(0.5)
    assert_allclose(bare.at(State(t=0.0, q=HOME, dq=np.zeros(6))).M, before, atol=0.0)
    assert not bare.armature.any()


def test_jaco2_agrees_with_lagrange_with_armature() -> None:
    armature = np.array([0.8, 0.8, 0.8, 0.15, 0.15, 0.15])
    model, oracle = Model.jaco2().with_armature(armature), jaco2_lagrange()
    for state in random_states(6, 6, 10):
        arm, theirs = model.at(state), oracle.at(state)
        assert_allclose(arm.M, theirs.M + np.diag(armature), atol=TOLERANCE)
        assert_allclose(arm.h, theirs.h, atol=TOLERANCE)
        assert_allclose(arm.g, theirs.g, atol=TOLERANCE)


@pytest.mark.parametrize(
    "armature", [-0.1, np.nan, np.inf, [0.1, 0.1, 0.1, 0.1, 0.1, -1e-9], np.ones(5), np.ones((6, 1))]
)
def test_armature_that_cannot_be_is_refused(armature: Any) -> None:
    with pytest.raises(InputError, match="armature"):
        Model.jaco2().with_armature(armature)


def test_payload_is_a_body_in_the_description(tmp_path: Path) -> None:
    # The inertia of a real body about its centre of mass: the triangle inequality holds with room.
    mass, com = 0.8, (0.01, -0.03, 0.05)
    inertia = np.array([[2e-3, 1e-4, -2e-4], [1e-4, 3e-3, 3e-4], [-2e-4, 3e-4, 2.5e-3]])
    terms = ((0, 0, "xx"), (0, 1, "xy"), (0, 2, "xz"), (1, 1, "yy"), (1, 2, "yz"), (2, 2, "zz"))
    values = " ".join(f'i{name}="{inertia[i, j]}"' for i, j, name in terms)
    body = (
        f'<link name="end_effector"><inertial><origin xyz="{com[0]} {com[1]} {com[2]}"/><mass value="{mass}"/>'
        f"<inertia {values}/></inertial></link>"
    )
    path = tmp_path / "loaded.urdf"
    text = JACO2_URDF.read_text()
    assert text.count('<link name="end_effector"/>') == 1
    path.write_text(text.replace('<link name="end_effector"/>', body))
    ours = Model.jaco2().with_payload(mass, com, inertia)
    theirs = Model.from_urdf(path, tool="end_effector")
    for state in random_states(6, 7, 10):
        a, b = ours.at(state), theirs.at(state)
        for name in ("M", "h", "g"):
            assert_allclose(getattr(a, name), getattr(b, name), atol=TOLERANCE, err_msg=name)


@pytest.mark.parametrize("mass", [0.0, -1.0, np.nan, np.inf])
def test_payload_without_mass_is_refused(mass: float) -> None:
    with pytest.raises(InputError, match="payload mass"):
        Model.jaco2().with_payload(mass)


@pytest.mark.parametrize(
    ("com", "inertia", "found"),
    [
        ((0.0, 0.0), None, "centre of mass"),
        ((0.0, np.nan, 0.0), None, "centre of mass"),
        ((0.0, 0.0, 0.0), np.eye(2), "symmetric"),
        ((0.0, 0.0, 0.0), np.full((3, 3), np.inf), "finite"),
        ((0.0, 0.0, 0.0), [[1, 0.5, 0], [0, 1, 0], [0, 0, 1]], "symmetric"),
        ((0.0, 0.0, 0.0), np.diag((1.0, 1.0, -0.1)), "none below 0"),
        ((0.0, 0.0, 0.0), np.diag((1.0, 1.0, 2.1)), "sum of the others"),
    ],
)
def test_payload_that_no_body_can_be_is_refused(com: Any, inertia: Any, found: str) -> None:
    with pytest.raises(InputError, match=found):
        Model.jaco2().with_payload(1.0, com, inertia)


def test_payload_may_be_a_thin_rod() -> None:
    bare = Model.jaco2()
    rod = bare.with_payload(0.3, inertia=np.diag((0.01, 0.01, 0.0)))
    points = bare.with_payload(0.15, (0.0, 0.0, d := np.sqrt(0.01 / 0.3))).with_payload(0.15, (0.0, 0.0, -d))
    for state in random_states(6, 8, 5):
        assert_allclose(rod.at(state).M, points.at(state).M, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "p", "R", "found"),
    [
        ("link_6", (0.0, 0.0, 0.1), None, "already"),
        ("end_effector", (0.0, 0.0, 0.1), None, "already"),
        ("tip", (0.0, 0.1), None, "three finite"),
        ("tip", (0.0, np.inf, 0.1), None, "three finite"),
        ("tip", (0.0, 0.0, 0.1), 1.01 * np.eye(3), "orthonormal"),
        ("tip", (0.0, 0.0, 0.1), np.diag((1.0, 1.0, -1.0)), "reflection"),
    ],
)
def test_tool_that_is_no_new_frame_is_refused(name: str, p: Any, R: Any, found: str) -> None:
    with pytest.raises(InputError, match=found):
        Model.jaco2().with_tool(name, p, R)


def test_friction_of_another_arm_is_refused() -> None:
    with pytest.raises(InputError, match=r"7 joints; .* has 6"):
        Model.jaco2().with_friction(Friction(coulomb=np.ones(7), viscous=np.ones(7)))


def test_new_tool_stands_in_the_old_one() -> None:
    p, R = np.array([0.02, -0.01, 0.11]), np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    bare = Model.jaco2()
    tipped = bare.with_tool("tip", p, R)
    for state in random_states(6, 10, 10):
        arm, tip = bare.at(state), tipped.at(state)
        assert_allclose(tip.p, arm.p + arm.R @ p, atol=1e-14)
        assert_allclose(tip.R, arm.R @ R, atol=1e-14)


def test_new_tool_moves_as_a_point_of_the_same_body() -> None:
    p = np.array([0.02, -0.01, 0.11])
    bare = Model.jaco2()
    tipped = bare.with_tool("tip", p)
    for state in random_states(6, 11, 10):
        arm, tip = bare.at(state), tipped.at(state)
        assert_allclose(tip.v[:3], arm.v[:3] + np.cross(arm.v[3:], arm.R @ p), atol=1e-13)
        assert_allclose(tip.v[3:], arm.v[3:], atol=1e-13)


def test_new_tool_has_no_weight() -> None:
    bare = Model.jaco2()
    tipped = bare.with_tool("tip", (0.0, 0.0, 0.1))
    for state in random_states(6, 12, 5):
        assert_allclose(tipped.at(state).M, bare.at(state).M, atol=1e-14)
        assert_allclose(tipped.at(state).g, bare.at(state).g, atol=1e-13)


# Other arms.


@pytest.mark.parametrize("name", OTHERS)
def test_other_arm_has_one_coordinate_a_joint(name: str) -> None:
    model = other(name)
    n = OTHERS[name][1]
    assert model.n == n
    assert len(model.joint_names) == n
    assert {v.shape for v in (model.lower, model.upper, model.velocity_limit, model.effort_limit)} == {(n,)}


def test_continuous_joints_of_other_arms_have_no_limits() -> None:
    assert np.isinf(other("ur5e_like").upper).tolist() == [True, False, False, False, False, True]
    assert_allclose(other("prismatic").lower, [-2.5, -2.6, -0.02, -np.inf])
    assert_allclose(other("prismatic").upper, [2.5, 2.6, 0.18, np.inf])


# Refusals.


def test_missing_tool_frame_is_answered_with_those_that_exist() -> None:
    with pytest.raises(DescriptionError, match=r"'gripper'; expected one of: .*link_6.*end_effector") as refusal:
        Model.from_urdf(JACO2_URDF, tool="gripper")
    assert "universe" not in str(refusal.value)


def test_state_of_another_arm_is_refused() -> None:
    with pytest.raises(InputError, match=r"7 joints.*has 6"):
        Model.jaco2().at(State(t=0.0, q=np.zeros(7), dq=np.zeros(7)))


@pytest.mark.parametrize("text", ["", "not a robot", "<mujoco/>", "<robot", "\x00\x01"])
def test_file_that_is_no_description_is_refused_by_its_path(tmp_path: Path, text: str) -> None:
    path = tmp_path / "wrong.urdf"
    path.write_text(text)
    with pytest.raises(DescriptionError, match=r"wrong\.urdf"):
        Model.from_urdf(path, tool="tool0")


def test_missing_file_is_refused_by_its_path(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match=r"nowhere\.urdf"):
        Model.from_urdf(tmp_path / "nowhere.urdf", tool="tool0")


def chain(joints: str) -> str:
    """A description with two massive links on a base, joined as told."""
    inertial = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
    links = "".join(f'<link name="{name}">{inertial}</link>' for name in ("base", "one", "two"))
    return f'<robot name="odd">{links}{joints}</robot>'


def joint(name: str, kind: str, parent: str, child: str) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
    )


@pytest.mark.parametrize(
    ("joints", "found"),
    [
        (
            joint("a", "revolute", "base", "one") + joint("b", "revolute", "base", "two"),
            r"not on the way to 'two': a; expected one serial chain",
        ),
        (joint("a", "revolute", "base", "one") + joint("b", "planar", "one", "two"), "'planar' of joint 'b'"),
        (joint("a", "floating", "base", "one") + joint("b", "revolute", "one", "two"), "'floating' of joint 'a'"),
    ],
    ids=["branch", "planar", "floating"],
)
def test_arm_that_is_no_serial_chain_is_refused_by_the_joint(tmp_path: Path, joints: str, found: str) -> None:
    path = tmp_path / "odd.urdf"
    path.write_text(chain(joints))
    with pytest.raises(DescriptionError, match=found):
        Model.from_urdf(path, tool="two")


# The estimates in the packaged description.


def test_packaged_description_carries_estimates_for_every_joint() -> None:
    armature, friction = urdf_estimates()
    for values in (armature, friction.coulomb, friction.viscous):
        assert values.shape == (6,)
        assert np.all(values > 0.0)


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda model: pickle.loads(pickle.dumps(model))])
def test_a_copy_has_a_work_space_of_its_own(copied: Callable[[Model], Model]) -> None:
    model = Model.jaco2().with_armature(0.1).with_payload(0.5)
    twin = copied(model)
    here, there = State(t=0.0, q=np.full(6, 1.0), dq=np.full(6, 0.3)), State(t=0.0, q=np.full(6, 2.0), dq=np.zeros(6))
    want = model.at(here)
    twin.at(there)
    got = model.at(here)
    assert_allclose(got.M, want.M, atol=0.0)
    assert_allclose(twin.at(here).p, want.p, atol=0.0)
    assert_allclose(twin.at(here).h, want.h, atol=1e-15)
