from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.core import State
from burnish.errors import InputError
from burnish.model.model import Model
from burnish.rotation import euler_xyz, log
from burnish.sim.robot import HOME
from burnish.trajectory import EulerCubic

START = np.array([0.2, -0.3, 0.5, 1.65, 1.1, 0.1])
END = np.array([0.3, -0.4, 0.7, 2.4, 0.1, 0.6])
MODEL = Model.jaco2()


def reference(source: EulerCubic, t: float):
    return source.at(MODEL.at(State(t=t, q=HOME, dq=np.zeros(6))))


@pytest.fixture
def motion() -> EulerCubic:
    source = EulerCubic(start=START, end=END, duration=4.0)
    source.reset(MODEL.at(State(t=0.0, q=HOME, dq=np.zeros(6))))
    return source


@pytest.mark.parametrize(("t", "share"), [(0.0, 0.0), (2.0, 0.5), (4.0, 1.0), (9.0, 1.0)])
def test_position_and_angles_are_on_their_cubics(motion: EulerCubic, t: float, share: float) -> None:
    here, x = reference(motion, t), START + share * (END - START)
    assert_allclose(here.p, x[:3], atol=1e-12)
    assert_allclose(euler_xyz(here.R), x[3:], atol=1e-12)


@pytest.mark.parametrize("t", [0.3, 1.0, 2.2, 3.7])
def test_twist_and_acceleration_are_the_derivatives_of_the_pose(motion: EulerCubic, t: float) -> None:
    h = 1e-4
    before, here, after = (reference(motion, t + k * h) for k in (-1, 0, 1))
    turned = log(after.R @ before.R.T) / (2.0 * h)
    # Central differences: errors of h² times the third derivative.
    assert_allclose(here.v, np.concatenate([(after.p - before.p) / (2.0 * h), turned]), atol=1e-7)
    assert_allclose(here.a, (after.v - before.v) / (2.0 * h), atol=1e-7)


def test_a_motion_that_is_none_is_refused() -> None:
    with pytest.raises(InputError, match="six numbers"):
        EulerCubic(start=START[:3], end=END, duration=1.0)
    with pytest.raises(InputError, match="duration"):
        EulerCubic(start=START, end=END, duration=0.0)
