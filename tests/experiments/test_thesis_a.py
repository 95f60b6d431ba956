"""The printed motion of thesis A, and how much of it the arm can follow."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.control.task import SINGULAR_VALUE
from burnish.errors import PlanError
from burnish.experiments.thesis_a import END, START, reachable_share, start_joints, with_rotors
from burnish.model.ik import inverse_kinematics
from burnish.model.model import Model
from burnish.rotation import euler_xyz, from_euler_xyz
from burnish.sim import arms

MODEL = Model.jaco2()


def test_the_start_is_the_printed_pose_near_the_home_pose() -> None:
    p, R, _ = MODEL.kinematics(start_joints())
    assert_allclose(p, START[:3], atol=1e-5)
    assert_allclose(euler_xyz(R), START[3:], atol=1e-4)


def test_the_printed_motion_is_out_of_reach_in_its_middle_and_at_its_end() -> None:
    # At 6.2 s the share of the way is 0.334.
    for share in (0.334, 1.0):
        x = START + share * (END - START)
        with pytest.raises(PlanError):
            inverse_kinematics(MODEL, x[:3], from_euler_xyz(x[3:]), start_joints(), tries=4)


def test_the_reachable_share_ends_before_the_wrist_is_singular() -> None:
    q = start_joints()
    for share in np.linspace(0.0, reachable_share(), 20):
        x = START + share * (END - START)
        nearer = inverse_kinematics(MODEL, x[:3], from_euler_xyz(x[3:]), q, tries=0)
        assert np.abs(nearer - q).max() < 0.2, "the joints follow without a jump"
        q = nearer
    smallest = np.linalg.svd(MODEL.kinematics(q)[2], compute_uv=False)[-1]
    # The walk takes steps of 1/400 of the way; one more step and the bound is passed.
    assert SINGULAR_VALUE <= smallest < 1.1 * SINGULAR_VALUE


def test_rotors_are_added_to_the_plant_and_to_nothing_else() -> None:
    ideal, geared = arms.ideal(0), with_rotors(arms.ideal(0))
    assert (geared.plant.armature > 0.0).all()
    assert geared.friction is None
    assert_allclose(geared.plant.mass_scale, ideal.plant.mass_scale)
