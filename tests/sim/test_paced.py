"""A simulated arm that keeps to a clock on the wall, which a test can turn."""

from __future__ import annotations

import numpy as np
import pytest

from burnish.core import Torque
from burnish.sim.paced import BEHIND, Paced
from burnish.sim.robot import SimRobot


class Wall:
    """A clock that goes on when somebody sleeps, and as far as the test says while the arm is computed."""

    def __init__(self) -> None:
        self.now = 100.0
        self.slept: list[float] = []

    def sleep(self, seconds: float) -> None:
        self.slept.append(seconds)
        self.now += seconds


@pytest.fixture
def wall() -> Wall:
    return Wall()


@pytest.fixture
def arm(wall: Wall) -> Paced:
    return Paced(SimRobot(rate=100.0), clock=lambda: wall.now, sleep=wall.sleep)


def test_samples_come_when_the_wall_says_so(arm: Paced, wall: Wall) -> None:
    for _ in range(5):
        state = arm.read()
        assert wall.now - 100.0 == pytest.approx(state.t)
        wall.now += 0.004
    assert wall.slept == pytest.approx([0.006] * 4)
    assert arm.late_cycles == 0


def test_a_short_delay_is_made_up_for_and_counted(arm: Paced, wall: Wall) -> None:
    arm.read()
    wall.now += 0.025
    arm.read()
    assert arm.late_cycles == 1
    arm.read()
    arm.read()
    assert wall.now - 100.0 == pytest.approx(0.03)
    assert arm.late_cycles == 1


def test_after_a_pause_the_arm_does_not_hurry(arm: Paced, wall: Wall) -> None:
    arm.read()
    wall.now += 10.0 * BEHIND
    before = arm.read()
    start = wall.now
    state = arm.read()
    assert wall.now - start == pytest.approx(state.t - before.t)


def test_commands_and_the_end_reach_the_arm(arm: Paced) -> None:
    with arm:
        arm.read()
        np.testing.assert_array_equal(arm.write(Torque(np.full(6, 100.0))), arm.robot._limit)
