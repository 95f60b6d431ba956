"""Stops judged by the motion of the simulated arm: what counts is that it moves no faster, no further, and no more."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from burnish.control import ComputedTorque
from burnish.core import Array, Controller, Dynamics, JointReference, Torque
from burnish.model.model import Model
from burnish.runtime.loop import Rig, control
from burnish.runtime.supervisor import Limits, Supervisor
from burnish.sim import arms
from burnish.sim.robot import HOME, SimRobot
from burnish.trajectory import Hold, Sine


@dataclass(kw_only=True)
class GoneWrong:
    """A law that from some time on does something else to its torque."""

    law: Controller[JointReference]
    at: float
    wrong: Callable[[Array, Dynamics], Array]

    def reset(self, arm: Dynamics) -> None:
        self.law.reset(arm)

    def torque(self, arm: Dynamics, reference: JointReference) -> Array:
        tau = self.law.torque(arm, reference)
        return self.wrong(tau, arm) if arm.t >= self.at else tau


def flipped(joint: int) -> Callable[[Array, Dynamics], Array]:
    """One joint with the wrong sign, and 2 N·m so that it does go somewhere."""

    def wrong(tau: Array, arm: Dynamics) -> Array:
        off = tau[joint] - arm.g[joint]
        tau[joint] = arm.g[joint] - off - 2.0 * np.sign(off)
        return tau

    return wrong


FAST = replace(Limits.jaco2(), free_speed=np.inf, impact_force=np.inf)
"""For motions of the joints that nobody may come near to."""


def run(
    rate: float, seed: int, law: Controller[JointReference], source: Sine | Hold, duration: float
) -> tuple[SimRobot, Supervisor, Array]:
    """The honest arm under a law; true joint speeds at every cycle."""
    arm = arms.honest(seed)
    model = Model.jaco2().with_armature(arm.armature)
    robot = SimRobot(rate=rate, plant=arm.plant)
    rig = Rig(robot, model, Supervisor(limits=FAST, period=1.0 / rate))
    speeds = [robot.truth_dq() for _ in control(rig, source, law, until=lambda now: now.t >= duration)]
    return robot, rig.supervisor, np.array(speeds)


def tracking(seed: int) -> ComputedTorque:
    return ComputedTorque.at_frequency(10.0, friction=arms.honest(seed).friction)


@pytest.mark.parametrize("rate", [100.0, 1000.0])
@pytest.mark.parametrize("joint", range(6))
def test_runaway_joint_is_stopped_below_its_speed_limit(rate: float, joint: int) -> None:
    law = GoneWrong(law=tracking(joint), at=0.5, wrong=flipped(joint))
    # The seed draws masses up to 10 % off, rotors and friction up to 30 %.
    _, supervisor, speeds = run(rate, joint, law, Sine(amplitude=0.2, period=3.0), 2.0)
    assert supervisor.tripped
    assert np.abs(speeds / Limits.jaco2().speed).max() <= 1.0
    assert np.degrees(np.abs(speeds[-1]).max()) < 1.0, "at rest at the end"


CAUSES: dict[str, Callable[[Array, Dynamics], Array]] = {
    "no number": lambda tau, arm: np.full(6, np.nan),
    "another length": lambda tau, arm: np.zeros(7),
}


@pytest.mark.parametrize("cause", CAUSES)
def test_law_that_breaks_holds_the_arm_in_the_same_cycle(cause: str) -> None:
    law = GoneWrong(law=tracking(1), at=0.5, wrong=CAUSES[cause])
    _, supervisor, speeds = run(100.0, 1, law, Sine(amplitude=0.2, period=3.0), 2.5)
    assert supervisor.event is not None
    assert supervisor.event.t == pytest.approx(0.5, abs=0.011)
    assert np.degrees(np.abs(speeds[-1]).max()) < 1.0


@pytest.mark.parametrize("seed", range(8))
def test_hold_carries_an_unknown_kilogram(seed: int) -> None:
    # As bad as the arm comes: a kilogram more, every mass a tenth more, torque sensors off, 10 ms late.
    arm = arms.honest(seed)
    plant = replace(arm.plant, payload=1.0, mass_scale=np.full(7, 1.1))
    robot = SimRobot(HOME, rate=100.0, plant=plant)
    model = Model.jaco2().with_armature(arm.armature)
    supervisor = Supervisor(limits=Limits.jaco2(), period=0.01)
    start, worst = None, 0.0
    while robot.time < 2.5:
        now = model.at(robot.read())
        broken = robot.time > 0.3
        robot.write(Torque(supervisor.filter(now, np.full(6, np.nan) if broken else now.tau)))
        if broken:
            start = now.p if start is None else start
            worst = max(worst, float(np.linalg.norm(now.p - start)))
    assert supervisor.tripped
    assert worst < 0.05
