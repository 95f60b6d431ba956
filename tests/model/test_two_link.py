from __future__ import annotations

import numpy as np
import pytest

from burnish.core import Array, State
from burnish.errors import InputError
from burnish.inverse import weighted_inverse
from burnish.model.dh import DHChain
from burnish.model.inertia import Body
from burnish.model.lagrange import LagrangeModel
from burnish.model.two_link import TwoLinkArm, mask

Q = np.array([np.pi / 4, 3 * np.pi / 8])
UNEVEN = TwoLinkArm(
    length=np.array([0.7, 0.4]),
    mass=np.array([2.0, 0.8]),
    com=np.array([0.3, 0.25]),
    inertia=np.array([0.09, 0.02]),
    gravity=9.81,
)


def lagrange_of(arm: TwoLinkArm) -> LagrangeModel:
    """The same arm as a DH chain of two rods: the general way to the same terms."""
    links = tuple(
        Body(
            name=f"rod {i}", mass=m, com=np.array([c - length, 0, 0]), inertia=np.diag((inertia / 2, inertia, inertia))
        )
        for i, (m, c, length, inertia) in enumerate(zip(arm.mass, arm.com, arm.length, arm.inertia, strict=True))
    )
    chain = DHChain(alpha=np.zeros(2), a=arm.length, d=np.zeros(2), theta_sign=np.ones(2), theta_offset=np.zeros(2))
    return LagrangeModel(chain=chain, links=links, gravity=np.array([0.0, -arm.gravity, 0.0]))


def test_first_example_of_the_blog_joint_speed_to_tool_velocity() -> None:
    v = TwoLinkArm().jacobian(Q) @ np.full(2, np.pi / 10)
    np.testing.assert_allclose(v, [-0.8026, -0.01830, 0, 0, 0, np.pi / 5], atol=0.5e-4)
    assert v[1] == pytest.approx(-0.01830, abs=0.5e-5)  # printed with a digit more


def test_second_example_of_the_blog_tool_force_to_joint_torque() -> None:
    J = mask("x", "y") @ TwoLinkArm().jacobian(Q)
    np.testing.assert_allclose(J.T @ [1.0, 1.0], [-1.3066, -1.3066], atol=0.5e-4)


@pytest.mark.parametrize("arm", [TwoLinkArm(), UNEVEN], ids=["even", "uneven"])
def test_every_term_equals_the_general_lagrangian(arm: TwoLinkArm) -> None:
    general = lagrange_of(arm)
    for q, dq in np.random.default_rng(1).uniform(-4, 4, (50, 2, 2)):
        state = State(t=0.0, q=q, dq=dq)
        ours, theirs = arm.at(state), general.at(state)
        for name in ("p", "R", "J", "dJdq", "M", "h", "g"):
            np.testing.assert_allclose(getattr(ours, name), getattr(theirs, name), atol=1e-13, err_msg=name)


def test_operational_inertia_is_what_a_push_on_the_tool_feels() -> None:
    arm, f = UNEVEN, np.array([0.3, -1.2])
    for q in np.random.default_rng(2).uniform(0.4, 2.6, (20, 2)):
        J = mask("x", "y") @ arm.jacobian(q)
        acceleration = J @ np.linalg.solve(arm.mass_matrix(q), J.T @ f)
        np.testing.assert_allclose(arm.operational_inertia(q, "x", "y") @ acceleration, f, atol=1e-12)


def test_stripping_rows_of_the_jacobian_is_not_stripping_rows_of_the_inertia() -> None:
    both = TwoLinkArm().operational_inertia(Q, "x", "y")
    alone = TwoLinkArm().operational_inertia(Q, "x")
    assert alone[0, 0] < 0.9 * both[0, 0]  # free to move along y, the tool gives way more easily along x
    J, M = TwoLinkArm().jacobian(Q), TwoLinkArm().mass_matrix(Q)
    assert alone[0, 0] == pytest.approx(1 / (J[:1] @ np.linalg.solve(M, J[:1].T))[0, 0], rel=1e-12)


def test_joint_motion_in_the_null_space_of_a_mask_leaves_that_direction_alone() -> None:
    arm = UNEVEN
    J, M = mask("x") @ arm.jacobian(Q), arm.mass_matrix(Q)
    N = np.eye(2) - weighted_inverse(J, M) @ J
    np.testing.assert_allclose(J @ N, np.zeros((1, 2)), atol=1e-12)
    np.testing.assert_allclose(J @ np.linalg.solve(M, N.T @ [0.4, -1.0]), [0.0], atol=1e-12)


def bend(arm: TwoLinkArm, angle: float) -> Array:
    return arm.operational_inertia(np.array([0.3, angle]), "x", "y")


def test_operational_inertia_stays_bounded_and_smooth_through_the_stretched_arm() -> None:
    angles = np.linspace(-0.5, 0.5, 4001)
    inertias = np.array([bend(TwoLinkArm(), angle) for angle in angles])
    assert np.isfinite(inertias).all()
    assert np.abs(inertias).max() < 2 / 0.001  # the damping is as large as the threshold in the singularity
    jumps = np.abs(np.diff(inertias, axis=0)).max(axis=(1, 2))
    assert jumps.max() < 0.02 * np.abs(inertias).max()


def test_mask_picks_rows_in_the_order_that_is_asked_for() -> None:
    J = np.arange(12.0).reshape(6, 2)
    np.testing.assert_array_equal(mask("rz", "x") @ J, J[[5, 0]])
    np.testing.assert_array_equal(mask("x", "y", "z", "rx", "ry", "rz"), np.eye(6))


@pytest.mark.parametrize("dof", [("z",), ("x", "y", "rz"), (), ("x", "rx")])
def test_mask_that_two_planar_joints_cannot_control_is_refused(dof: tuple[str, ...]) -> None:
    with pytest.raises(InputError, match="x, y, rz"):
        TwoLinkArm().operational_inertia(Q, *dof)


def test_wrong_names_and_wrong_arms_are_refused() -> None:
    with pytest.raises(InputError, match="different ones of x, y, z, rx, ry, rz"):
        mask("x", "roll")
    with pytest.raises(InputError, match="different ones"):
        mask("x", "x")
    with pytest.raises(InputError, match="above 0"):
        TwoLinkArm(mass=np.array([1.0, -1.0]))
    with pytest.raises(InputError, match="two finite numbers"):
        TwoLinkArm(length=np.array([1.0]))
