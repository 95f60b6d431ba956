"""An operator of a supervised arm is held back by the very limits that would stop it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from burnish.core import Array, Dynamics, State
from burnish.model.model import Model
from burnish.runtime.guards import allowed_speed
from burnish.runtime.operating import EARLY, bounds, operator, watched
from burnish.runtime.supervisor import Limits, Supervisor
from burnish.teleop.device import AT_REST, Reading
from burnish.teleop.modes import Panel
from burnish.teleop.modes_b import ModesB
from burnish.teleop.reference import Operator, Pace

MODEL, LIMITS = Model.jaco2(), Limits.jaco2()
HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])


def arm_at(q: Array = HOME, t: float = 0.0) -> Dynamics:
    return MODEL.at(State(t=t, q=q, dq=np.zeros(6)))


def made() -> tuple[Operator, Supervisor]:
    supervisor = Supervisor(limits=LIMITS)
    panel, pace = Panel(modes=ModesB()), Pace.near_people()
    at_rest = Reading(t=0.0, axes=AT_REST, buttons=(), age=0.0)
    return operator(read=lambda: at_rest, panel=panel, supervisor=supervisor, pace=pace), supervisor


def test_operator_has_the_limits_of_the_supervisor() -> None:
    hand, _ = made()
    lower, upper = LIMITS.within(LIMITS.soft_margin, 0.1)
    assert_array_equal(hand.bounds.lower, lower)
    assert_array_equal(hand.bounds.upper, upper)
    assert_array_equal(bounds(LIMITS).speed, LIMITS.speed)
    assert hand.press < LIMITS.tool_force
    v = np.array([0.1, 0.0, 0.0])
    assert hand.allowed_speed(arm_at(), v) == allowed_speed(LIMITS, arm_at(), v)


def test_operator_has_nothing_to_say_while_the_supervisor_holds_the_arm() -> None:
    hand, supervisor = made()
    assert not hand.taken()
    supervisor.filter(arm_at(), np.full(6, np.nan))
    assert hand.taken()


@pytest.mark.parametrize("clearance", [made()[0].clearance, watched(LIMITS).closing, watched().closing])
def test_way_to_the_arm_itself_ends_where_the_supervisor_begins_to_brake(clearance: object) -> None:
    assert callable(clearance)
    folded = HOME.copy()
    # Joint 3 folds the forearm onto the upper arm.
    ways = []
    for q3 in np.linspace(HOME[2], 0.4, 60):
        folded[2] = q3
        true = watched().measure(arm_at(folded))
        way, _ = clearance(arm_at(folded))(np.zeros(6))
        assert way == (pytest.approx(true - LIMITS.self_slow) if true < LIMITS.self_slow + EARLY else np.inf)
        ways.append(way)
    assert min(ways) < EARLY
