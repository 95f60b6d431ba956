"""A rough hand at the simulated arm, near people: it is held back before the supervisor has to stop the arm."""

from __future__ import annotations

import numpy as np
import pytest

from burnish.commands.station import hand_led
from burnish.core import Array
from burnish.model.model import Model
from burnish.polish.cell import HOME
from burnish.runtime.limits import Limits
from burnish.runtime.loop import Rig, control
from burnish.runtime.operating import operator
from burnish.runtime.supervisor import Supervisor
from burnish.sim import arms
from burnish.sim.robot import SimRobot
from burnish.teleop.device import AT_REST, Axes, Reading
from burnish.teleop.modes import Panel
from burnish.teleop.modes_b import BASE, MIXED, TOOL, ModesB
from burnish.teleop.reference import Pace

RATE = 100.0
RELEASED = 0.02
"""Deflection below which the cap counts as let go."""


class RoughHand:
    """Pushes the cap to where chance wants it, as fast as fingers do: two lags of 25 to 50 ms each."""

    def __init__(self, robot: SimRobot, seed: int, most: float) -> None:
        self._robot, self._rng, self._most = robot, np.random.default_rng(seed), most
        self._wanted, self._half, self._cap = np.zeros((3, 6))
        self._t, self._until, self._lag = 0.0, 0.1, 0.05

    def read(self) -> Reading:
        """The cap now."""
        t = self._robot.time
        if t >= self._until:
            self._change(t)
        share = 1.0 - np.exp(-(t - self._t) / self._lag)
        self._t = t
        self._half = self._half + share * (self._wanted - self._half)
        self._cap = self._cap + share * (self._half - self._cap)
        axes: Axes = tuple(self._cap.tolist())
        return Reading(t=t, axes=AT_REST if np.abs(self._cap).max() < RELEASED else axes, buttons=(), age=0.0)

    def _change(self, t: float) -> None:
        """Another deflection: some axes or all, partly or to their ends, and now and then none."""
        rng = self._rng
        wanted: Array = rng.uniform(-1.0, 1.0, 6) * (rng.random(6) < rng.choice([1.0, 0.5, 0.2]))
        self._wanted = rng.choice([0.0, 1.0], p=[0.1, 0.9]) * (np.sign(wanted) if rng.random() < 0.3 else wanted)
        self._until = t + min(self._most, rng.exponential(rng.choice([0.15, 0.5, 2.0])))
        self._lag = rng.uniform(0.025, 0.05)


def tripped(seed: int, seconds: float, most: float) -> str:
    """Why the supervisor stopped the arm; empty where it did not."""
    arm = arms.honest(seed)
    robot, supervisor = SimRobot(HOME, rate=RATE, plant=arm.plant), Supervisor(limits=Limits.jaco2(), period=1.0 / RATE)
    rig = Rig(robot, Model.jaco2().with_armature(arm.armature), supervisor)
    panel = Panel(modes=ModesB(mode=(BASE, MIXED, TOOL)[seed % 3], fitted=False))
    moved = operator(
        read=RoughHand(robot, seed, most).read, panel=panel, supervisor=supervisor, pace=Pace.near_people()
    )
    way = 0.0
    for sample in control(rig, moved, hand_led(arm), until=lambda arm: arm.t > seconds):
        way += float(np.linalg.norm(sample.arm.v[:3])) / RATE
        if supervisor.event is not None:
            return f"at {sample.arm.t:.2f} s: {supervisor.event.cause}"
    assert way > 0.005 * seconds, "the hand moved nothing"
    return ""


# 401 went past the speed of the tool when joints that turn round were accelerated with 2.5 rad/s².
@pytest.mark.parametrize("seed", [0, 401])
def test_a_rough_hand_does_not_make_the_supervisor_stop_the_arm(seed: int) -> None:
    assert tripped(seed, seconds=16.0, most=0.15) == ""


@pytest.mark.slow
@pytest.mark.parametrize("most", [0.15, 10.0], ids=["restless", "slower"])
def test_rough_hands_do_not_make_the_supervisor_stop_the_arm_in_five_minutes(most: float) -> None:
    found = {seed: tripped(seed, seconds=20.0, most=most) for seed in range(1000, 1015)}
    assert not any(found.values()), found
