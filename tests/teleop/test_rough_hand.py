"""A rough hand at the simulated arm, near people: it is held back before the supervisor has to stop the arm."""

from __future__ import annotations

import numpy as np
import pytest

from burnish.campaign.operator import RoughHand
from burnish.commands.station import hand_led
from burnish.model.model import Model
from burnish.polish.cell import HOME
from burnish.runtime.limits import Limits
from burnish.runtime.loop import Rig, control
from burnish.runtime.operating import operator
from burnish.runtime.supervisor import Supervisor
from burnish.sim import arms
from burnish.sim.robot import SimRobot
from burnish.teleop.modes import Panel
from burnish.teleop.modes_b import BASE, MIXED, TOOL, ModesB
from burnish.teleop.reference import Pace

RATE = 100.0


def tripped(seed: int, seconds: float, most: float) -> str:
    """Why the supervisor stopped the arm; empty where it did not."""
    arm = arms.honest(seed)
    robot, supervisor = SimRobot(HOME, rate=RATE, plant=arm.plant), Supervisor(limits=Limits.jaco2(), period=1.0 / RATE)
    rig = Rig(robot, Model.jaco2().with_armature(arm.armature), supervisor)
    panel = Panel(modes=ModesB(mode=(BASE, MIXED, TOOL)[seed % 3], fitted=False))
    hand = RoughHand(seed=seed, period=1.0 / RATE, longest=most)
    moved = operator(read=hand.read, panel=panel, supervisor=supervisor, pace=Pace.near_people())
    way = 0.0
    for sample in control(rig, moved, hand_led(arm), until=lambda arm: arm.t > seconds):
        way += float(np.linalg.norm(sample.arm.v[:3])) / RATE
        if supervisor.event is not None:
            return f"at {sample.arm.t:.2f} s: {supervisor.event.cause}"
    # A hand that wants turns, or leans on a limit, moves the tool little: the least of 30 was 93 mm in 20 s.
    assert way > 0.003 * seconds, "the hand moved nothing"
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
