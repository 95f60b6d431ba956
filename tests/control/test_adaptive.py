from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from closed_loop import HOME, JACO2, arm_at, pose, run
from numpy.testing import assert_allclose

from burnish.control import Adaptive, ComputedTorque, GravityCompensation, OperationalSpace
from burnish.core import Array, JointReference
from burnish.errors import InputError
from burnish.model.model import Model

START = arm_at(JACO2, HOME)
COM = np.array([0.02, -0.01, 0.05])


def laden(mass: float) -> Model:
    """The arm with a point mass that the controller does not know of."""
    return JACO2.with_payload(mass, COM)


def operational() -> OperationalSpace:
    return OperationalSpace.at_frequency(15.0)


def off_by(law: Any, plant: Model, duration: float = 5.0, push: Array | None = None) -> float:
    """Position error that is left of standing still [m]."""
    end = run(JACO2, HOME, law, pose(START), duration, plant=plant, push=push, dt=2e-3)[-1]
    return float(np.linalg.norm(end.p - START.p))


def test_unknown_kilogram_leaves_an_error_and_is_learnt_within_five_seconds() -> None:
    plant, law = laden(1.0), Adaptive(law=operational())
    assert off_by(operational(), plant) > 5e-3
    assert off_by(law, plant) < 2e-3
    # The law asks for an error of 0, not for the right mass: the moments, which are learnt last, still pull at it.
    assert law.learnt_mass == pytest.approx(1.0, abs=0.1)


def test_model_that_carries_a_kilogram_too_much_is_corrected_downwards() -> None:
    heavy = laden(1.0)
    law = Adaptive(law=operational())
    end = run(heavy, HOME, law, pose(START), 5.0, plant=JACO2, dt=2e-3)[-1]
    assert np.linalg.norm(end.p - START.p) < 2e-3
    assert law.learnt_mass == pytest.approx(-1.0, abs=0.1)


def test_unknown_push_is_learnt() -> None:
    push = np.array([5.0, -3.0, 2.0, 0.0, 0.3, 0.0])
    law = Adaptive(law=operational(), mass_rate=0.0, moment_rate=0.0, push_rate=300.0, push_moment_rate=20.0)
    assert off_by(operational(), JACO2, push=push) > 2e-3
    assert off_by(law, JACO2, push=push) < 3e-4
    # After 5 s within the share of a newton that the slowest direction has yet to learn.
    assert_allclose(law.learnt_push[:3], push[:3], atol=1.0)


def test_joint_space_law_learns_a_payload_too() -> None:
    wanted = JointReference(q=HOME, dq=np.zeros(6), ddq=np.zeros(6))
    left = []
    for law in (ComputedTorque.at_frequency(15.0), Adaptive(law=ComputedTorque.at_frequency(15.0))):
        end = run(JACO2, HOME, law, wanted, 5.0, plant=laden(1.0), dt=2e-3)[-1]
        left.append(np.linalg.norm(end.q - HOME))
    assert left[1] < 0.1 * left[0]


def test_what_is_learnt_stays_within_its_bounds() -> None:
    law = Adaptive(law=operational(), mass=0.4, moment=0.01)
    off_by(law, laden(1.0), 2.0)
    assert law.learnt_mass == pytest.approx(0.4)
    assert np.abs(law.learnt_moment).max() <= 0.01


def test_law_that_has_learnt_nothing_is_the_law_inside() -> None:
    inner, outer = operational(), Adaptive(law=operational(), mass=0.0, moment=0.0, push=0.0, push_moment=0.0)
    for law in (inner, outer):
        law.reset(START)
    later = arm_at(JACO2, HOME, np.full(6, 0.3), 0.5)
    assert_allclose(outer.torque(later, pose(START)), inner.torque(later, pose(START)), atol=1e-12)


def test_law_without_a_motion_to_follow_is_refused() -> None:
    law = Adaptive(law=GravityCompensation())
    law.reset(START)
    with pytest.raises(InputError, match="error of a motion"):
        law.torque(START, None)  # type: ignore[arg-type]
