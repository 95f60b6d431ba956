"""A control process that hangs or dies in torque mode: the watchdog takes the arm to position mode, and it stands."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from hardware.standin import SERIAL, StandIn, urgent

from burnish.errors import HardwareError
from burnish.hardware.kinova_library import LibraryMissingError
from burnish.hardware.watchdog import Watchdog, take_over

CONTROL = """
import sys
from burnish import GravityCompensation, Hold, Limits, Model, Rig, Supervisor, control
from burnish.hardware.jaco2 import Jaco2
from burnish.hardware.torque_mode import TorqueSetup
from burnish.hardware.watchdog import Watchdog
from burnish.runtime.machine import Mode
from burnish.runtime.session import Session

model = Model.jaco2()
supervisor = Supervisor(limits=Limits.of(model), start=Mode.IDLE)
law = GravityCompensation(damping=2.0)
with Watchdog(sys.argv[1], patience=float(sys.argv[3])) as watchdog:
    robot = Session(Jaco2(model, serial=sys.argv[1]), TorqueSetup.thesis_a(), supervisor, watchdog.beat)
    with robot:
        for count, sample in enumerate(control(Rig(robot, model, supervisor), Hold(), law)):
            print(count, flush=True)
            if count == 60:
                if sys.argv[2] == "loop":
                    while True:
                        pass
                if sys.argv[2] == "end":
                    break
"""
PATIENCE = 0.12
"""Less than the 250 ms after which this arm would fall."""
STANDS = np.deg2rad(1.5)
"""What a joint may move in the meantime: the drawn arm's links weigh up to a tenth more or less than its model."""


@pytest.fixture
def arm(standin: StandIn) -> StandIn:
    """An arm on real time that lets go after 250 ms without a torque: what kept it from that was lost."""
    standin.reset(realtime=True)
    standin.fail("SetTorqueInactivityType", 1)
    return standin


def run(tmp_path: Path, then: str, cycles: int = 60) -> subprocess.Popen[str]:
    """The control process in torque mode, after some cycles."""
    program = tmp_path / "control.py"
    program.write_text(CONTROL)
    words = [sys.executable, str(program), SERIAL, then, str(PATIENCE)]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=urgent)
    assert process.stdout is not None
    for _ in range(cycles):
        if not process.stdout.readline():
            pytest.fail(f"the control process ended by itself: {process.communicate()[1]}")
    return process


def moved(arm: StandIn) -> float:
    """How far a joint got in all [rad]."""
    _, q, _ = arm.trace()
    return float(np.abs(q - q[0]).max())


@pytest.mark.slow
def test_arm_would_fall_without_the_watchdog(arm: StandIn, tmp_path: Path) -> None:
    process = run(tmp_path, "go on")
    assert arm.memory.mode == 1
    # The watchdog first, whose parent is the process.
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    for child in [*map(int, children), process.pid]:
        os.kill(child, signal.SIGKILL)
    process.communicate()
    time.sleep(1.0)
    assert moved(arm) > np.deg2rad(10.0)


@pytest.mark.slow
@pytest.mark.parametrize("how", ["killed", "stopped", "in a loop without end"])
def test_watchdog_takes_the_arm_to_position_mode(arm: StandIn, tmp_path: Path, how: str) -> None:
    process = run(tmp_path, "loop" if how == "in a loop without end" else "go on")
    if how == "killed":
        process.kill()
    elif how == "stopped":
        process.send_signal(signal.SIGSTOP)
    said = process.communicate(timeout=10.0)[1]
    assert process.returncode == -signal.SIGKILL
    assert "the arm is in position mode" in said
    time.sleep(0.5)
    times, q, mode = arm.trace()
    assert mode[-1] == 0.0
    after = q[times > times[mode == 1.0][-1] + 0.1]
    print(f"{1e3 * (times[mode == 1.0][-1] - arm.memory.torque_taken_at):.0f} ms after the last torque")
    assert moved(arm) < STANDS
    assert np.abs(after - after[0]).max() < np.deg2rad(0.1), "it stands"


@pytest.mark.slow
def test_watchdog_lets_a_program_end(arm: StandIn, tmp_path: Path) -> None:
    process = run(tmp_path, "end")
    said = process.communicate(timeout=10.0)[1]
    assert process.returncode == 0
    assert "watchdog" not in said
    assert arm.memory.mode == 0


def test_arm_in_position_mode_is_not_watched() -> None:
    with Watchdog("none", library="/nowhere", patience=0.02) as watchdog:
        watchdog.beat(True)
        watchdog.beat(False)
        # Were it watched, this process would be killed.
        time.sleep(0.2)


def test_watchdog_that_does_not_start_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(HardwareError, match="did not start"):
        Watchdog("none").__enter__()


def test_arm_that_cannot_be_had_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("burnish.hardware.watchdog.CLAIMS", 2)
    with pytest.raises(LibraryMissingError):
        take_over("none", str(tmp_path / "none.so"), None)
