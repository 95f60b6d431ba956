"""The control process ends in torque mode without a word: the arm holds by itself."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hardware.standin import SERIAL, StandIn, urgent

from burnish import Limits, Rig, Supervisor, TorqueSetup, control
from burnish.control import OperationalSpace
from burnish.hardware.jaco2 import Jaco2
from burnish.model.model import Model
from burnish.sim import arms
from burnish.trajectory import CubicPose

HOLDER = """
import sys
from burnish import GravityCompensation, Hold, Limits, Model, Rig, Supervisor, control
from burnish.hardware.jaco2 import Jaco2
from burnish.hardware.torque_mode import TorqueSetup

model = Model.jaco2()
with Jaco2(model, serial=sys.argv[1], torque=TorqueSetup.thesis_a()) as robot:
    rig = Rig(robot, model, Supervisor(limits=Limits.of(model)))
    for sample in control(rig, Hold(), GravityCompensation(damping=2.0)):
        print(sample.arm.t, flush=True)
"""
TICK = 0.01
"""Of the arm's base [s]: a command is taken, and a mode shown, up to that much later."""


@pytest.fixture
def arm_on_real_time(standin: StandIn) -> StandIn:
    standin.reset(realtime=True)
    return standin


def test_kill_9_in_torque_mode_leaves_an_arm_that_holds_within_250_ms(
    arm_on_real_time: StandIn, tmp_path: Path
) -> None:
    standin, model = arm_on_real_time, Model.jaco2()
    program = tmp_path / "holder.py"
    program.write_text(HOLDER)
    words = [sys.executable, str(program), SERIAL]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True, preexec_fn=urgent) as control:
        assert control.stdout is not None
        for _ in range(20):
            assert control.stdout.readline(), "the program that was to be killed has ended by itself"
        assert standin.memory.mode == 1
        control.kill()
        killed_at = standin.memory.time
    time.sleep(0.8)
    # Only now: what was sent before the end may be taken a tick after it.
    last_command = standin.memory.torque_taken_at
    times, q, mode = standin.trace()
    held_at = times[mode == 1.0][-1] + TICK
    assert standin.memory.mode == 0
    assert held_at - last_command <= 0.25 + TICK + 1e-6
    p = np.array([model.kinematics(at)[0] for at in q[times >= killed_at - TICK]])
    drift = np.linalg.norm(p - p[0], axis=1).max()
    assert drift <= 0.020
    assert times[-1] > held_at + 0.2, "too little was seen of the hold"
    print(f"held {1e3 * (held_at - last_command):.0f} ms after the last command; tool drift {1e3 * drift:.2f} mm")


def test_an_arm_that_is_left_alone_in_the_middle_of_a_move_stops_within_20_mm(
    standin: StandIn, jaco2: Callable[..., Jaco2]
) -> None:
    model = Model.jaco2().with_armature(arms.honest(1).armature)
    with jaco2(torque=TorqueSetup.thesis_a()) as robot:
        rig = Rig(robot, model, Supervisor(limits=Limits.of(model)))
        at = rig.read()
        move = CubicPose(p=at.p + [0.03, 0.0, 0.04], R=at.R, duration=2.0)
        law = OperationalSpace(kp=400.0, kd=40.0, ki=800.0)
        speeds = [np.linalg.norm(s.arm.v[:3]) for s in control(rig, move, law, until=lambda arm: arm.t >= 1.0)]
        standin.advance(1.0)
        times, q, mode = standin.trace()
    # At its fastest, where the last torque goes on for 250 ms.
    assert speeds[-1] > 0.03
    assert mode[-1] == 0.0
    p = np.array([model.kinematics(at)[0] for at in q[times >= standin.memory.torque_taken_at]])
    drift = np.linalg.norm(p - p[0], axis=1).max()
    print(f"left alone at {1e3 * speeds[-1]:.0f} mm/s: stopped after {1e3 * drift:.1f} mm")
    assert drift <= 0.020
