from __future__ import annotations

import numpy as np
import pytest

from burnish.core import State
from burnish.model.model import Model
from burnish.runtime.limits import Limits
from burnish.runtime.supervisor import Supervisor
from burnish.runtime.swing import FAST, SOFTER, SWINGS, Swing

LIMITS = Limits.jaco2()
MODEL = Model.jaco2()
HOME = np.deg2rad([270.0, 180.0, 180.0, 0.0, 10.0, 180.0])
DT = 0.01


def share_after(*peaks: float) -> float:
    """Of one joint that swings with these speeds [rad/s], and one that stands beside it."""
    swing = Swing(share=np.ones(2))
    for peak in peaks:
        for part in (0.5, 1.0, 0.5):
            share = swing.at(np.array([part * peak, 0.0]))
    assert share[1] == 1.0
    return float(share[0])


def test_swings_that_die_leave_the_hold_as_it_is() -> None:
    peaks = [0.8 * (-0.7) ** k for k in range(12)]
    assert share_after(*peaks) == 1.0


def test_swings_that_grow_halve_the_hold_at_each_of_them() -> None:
    assert share_after(0.6, -0.6, 0.6) == SOFTER
    assert share_after(0.6, -0.6, 0.6, -0.6) == SOFTER**2


def test_a_speed_of_exactly_nothing_is_no_turn() -> None:
    swing = Swing(share=np.ones(1))
    for speed in (0.6, 0.0, -0.6, 0.0, 0.6, 0.0, -0.6):
        share = swing.at(np.array([speed]))
    assert share[0] == SOFTER**2


def test_one_slow_swing_that_grows_is_a_load_that_falls() -> None:
    slow = 0.5 * FAST
    assert share_after(slow, -0.6, 0.1) == 1.0
    assert share_after(slow, -1.1 * slow, 1.2 * slow, -slow) == SOFTER


def test_what_hardly_moves_does_not_swing() -> None:
    assert share_after(*[0.9 * SWINGS * (-1) ** k for k in range(20)]) == 1.0


def held(delay: int, inertia: float, cycles: int, softer: bool = True) -> float:
    """Fastest that the last joint is in the last half second of so many cycles after a stop [rad/s].

    It moves by itself: I q̈ = τ − g − 0.4 q̇, with readings this many cycles old and a cycle from torque to effect.
    """
    supervisor = Supervisor(limits=LIMITS, period=DT)
    q, dq, past, due, seen = 0.0, 0.5, [0.0], 0.0, []
    for k in range(cycles):
        past.append(q)
        reading = HOME + np.array([0.0] * 5 + [past[max(0, len(past) - 1 - delay)]])
        arm = MODEL.at(State(t=DT * k, q=reading, dq=np.array([0.0] * 5 + [dq])))
        if k == 0:
            supervisor.filter(arm, arm.g)
            supervisor.stop("asked to")
            continue
        if not softer:
            supervisor._swing = Swing(share=np.ones(6))
        torque = float((supervisor.filter(arm, arm.g) - arm.g)[5])
        for _ in range(10):
            dq += 0.1 * DT * (due - 0.4 * dq) / inertia
            q += 0.1 * DT * dq
        due = torque
        if k >= cycles - 50:
            seen.append(abs(dq))
    return max(seen)


@pytest.mark.parametrize("delay", [0, 1, 2, 3, 4, 5])
@pytest.mark.parametrize("inertia", [0.1, 0.15, 0.2])
def test_held_joint_comes_to_rest_whatever_the_age_of_its_readings(delay: int, inertia: float) -> None:
    assert held(delay, inertia, 300) < 0.01


def test_hold_that_stays_as_it_is_would_shake_the_joint() -> None:
    assert held(4, 0.1, 100, softer=False) > 2.0
    assert held(4, 0.1, 100) < 0.5
