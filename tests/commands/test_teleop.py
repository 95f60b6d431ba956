"""``burnish teleop`` as an operator meets it: on a terminal, in a pipe, and when something goes away."""

from __future__ import annotations

import argparse
import json
import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pexpect
import pytest
from commands.terminal import PATIENCE, Terminal
from teleop.magellan import Spacenavd

from burnish.cli import main
from burnish.commands import teleop
from burnish.commands.drawn import bar, line, picture, worth_a_line
from burnish.commands.screen import View
from burnish.commands.station import LAWS, Station, station
from burnish.commands.teleop_options import add_teleop
from burnish.core import Array, Dynamics, Sample, ToolReference
from burnish.record.recording import Recording
from burnish.runtime.loop import control
from burnish.runtime.machine import Event, Mode
from burnish.teleop.device import AT_REST, Axes, Reading

HEAD = "t,x,y,z,turn_x,turn_y,turn_z,buttons"
UP = "\x1b[5~"
NUMBER = r"([+-]\d+\.\d+)"


@pytest.fixture
def script(tmp_path: Path) -> Path:
    """Up for 0.4 s, a button, down and about z for 0.4 s, at rest."""
    path = tmp_path / "script.txt"
    rows = ["0,0,0,0,0,0,0,00", "0.2,0,0,1,0,0,0,00", "0.6,0,0,0,0,0,0,00", "0.8,0,0,0,0,0,0,10", "0.9,0,0,0,0,0,0,00",
            "1.0,0,0,-1,0,0,1,00", "1.4,0,0,0,0,0,0,00", "1.8,0,0,0,0,0,0,00"]  # fmt: skip
    path.write_text("\n".join([HEAD, *rows]) + "\n")
    return path


def options(**given: object) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_teleop(parser)
    made = parser.parse_args([])
    vars(made).update(given)
    return made


class Hand:
    """A device for a station in virtual time."""

    def __init__(self) -> None:
        self.axes: Axes = AT_REST
        self.connected = True
        self.reads = 0

    def read(self) -> Reading:
        self.reads += 1
        return Reading(t=0.0, axes=self.axes, buttons=(), age=0.0, connected=self.connected)


def virtual(script: Path, **given: object) -> tuple[Station, Hand]:
    """A station whose arm does not wait for the wall."""
    place, hand = station(options(device=str(script), **given)), Hand()
    place.rig.robot = place.robot.robot
    place.operator.read = hand.read
    return place, hand


def row(text: str, label: str) -> list[float]:
    """The numbers behind a label; none of them is one while the row is being drawn."""
    rows = [r for r in text.splitlines() if r.startswith(label)]
    found = [float(value) for value in re.findall(NUMBER, rows[0])] if rows else []
    return found if len(found) == 3 else [float("nan")] * 3


def drawn(text: str) -> bool:
    """Whether the whole screen is there, in the mode of the start."""
    return "polishing" in text and "keys        q quit" in text and not np.isnan(row(text, "position")).any()


def in_a_pipe(*words: str, environment: dict[str, str] | None = None) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "burnish", "teleop", *words],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | (environment or {}),
    )


@dataclass(frozen=True)
class Recorded:
    """Columns of a recording."""

    t: Array
    p: Array
    dq: Array
    phase: set[str]


def samples(folder: Path, name: str = "run.mcap") -> Recorded:
    blocks = list(Recording(folder / name).blocks())
    t, p, dq = (np.concatenate([getattr(block, column) for block in blocks]) for column in ("t", "p", "dq"))
    return Recorded(t, p, dq, {phase for block in blocks for phase in block.phase})


# On a terminal.


def test_a_person_moves_the_tool_by_keys_changes_the_mode_and_quits(tmp_path: Path) -> None:
    with Terminal("teleop", "--device", "keyboard", "--out", str(tmp_path / "out")) as terminal:
        text = terminal.until(drawn)
        for label in (
            "mode",
            "device",
            "position",
            "force",
            "joint 6",
            "rate",
            "supervisor  torque",
            "buttons",
            "keys",
        ):
            assert label in text
        assert "1 turn about tool" in terminal.row("buttons")
        start = row(text, "position")[2]
        terminal.until(lambda text: row(text, "position")[2] > start + 0.015, typing=UP)
        terminal.type("1")
        terminal.until("mode        turn about tool")
        terminal.type("q")
        assert terminal.ends() == 0
        assert "Done." in terminal.text
    taught = samples(tmp_path / "out")
    assert taught.p[-1][2] > taught.p[0][2] + 0.01
    assert "turn about tool" in taught.phase


def test_ctrl_c_brings_the_arm_to_rest_and_keeps_the_recording(tmp_path: Path) -> None:
    with Terminal("teleop", "--device", "keyboard", "--out", str(tmp_path / "out")) as terminal:
        start = row(terminal.until(drawn), "position")[2]
        terminal.until(lambda text: row(text, "position")[2] > start + 0.01, typing=UP)
        terminal.type("\x03")
        assert terminal.ends() == 130
        assert "Interrupted." in terminal.text
    assert np.abs(samples(tmp_path / "out").dq[-1]).max() < np.deg2rad(1.0)


@pytest.mark.slow
def test_ctrl_z_leaves_no_arm_alone(tmp_path: Path) -> None:
    with Terminal("teleop", "--device", "keyboard", "--out", str(tmp_path / "out")) as terminal:
        terminal.until("polishing")
        terminal.type("\x1a")
        terminal.type("1")
        terminal.until("mode        turn about tool")
        terminal.type("q")
        assert terminal.ends() == 0


def test_a_terminal_that_is_closed_leaves_an_arm_at_rest_and_a_whole_recording(tmp_path: Path) -> None:
    with Terminal("teleop", "--device", "keyboard", "--out", str(tmp_path / "out")) as terminal:
        start = row(terminal.until(drawn), "position")[2]
        terminal.until(lambda text: row(text, "position")[2] > start + 0.01, typing=UP)
        terminal.hang_up()
    told = json.loads((tmp_path / "out" / "metrics.json").read_text())
    taught = samples(tmp_path / "out")
    assert told["outcome"] in ("interrupted: the terminal was closed", "interrupted: the device went away")
    assert len(taught.t) == told["cycles"]
    assert np.abs(taught.dq[-1]).max() < np.deg2rad(1.0)


@pytest.mark.slow
def test_the_terminal_is_as_before_when_the_program_has_ended(tmp_path: Path) -> None:
    words = f"teleop --device keyboard --seconds 0.3 --out {tmp_path / 'out'}"
    code = (
        "import subprocess, sys, termios; before = termios.tcgetattr(0); "
        f"done = subprocess.run([sys.executable, '-m', 'burnish', *'{words}'.split()]); "
        "print('THE SAME' if termios.tcgetattr(0) == before and done.returncode == 0 else 'CHANGED')"
    )
    with Terminal() as terminal:
        terminal.program.close(force=True)
        terminal.program = pexpect.spawn(sys.executable, ["-c", code], dimensions=(40, 110), timeout=PATIENCE)
        terminal.until("THE SAME")


# In a pipe.


def test_in_a_pipe_there_are_plain_lines_and_no_control_codes(script: Path, tmp_path: Path) -> None:
    out, err = in_a_pipe("--device", str(script), "--out", str(tmp_path / "out")).communicate(timeout=PATIENCE)
    assert err == ""
    assert out.isprintable() or set(filter(lambda c: not c.isprintable(), out)) == {"\n"}
    assert "polishing, tool" in out
    assert "turn about tool, tool" in out
    assert "Done." in out
    metrics = json.loads((tmp_path / "out" / "metrics.json").read_text())
    assert metrics["outcome"] == "done"
    assert metrics["supervisor_events"] == 0
    assert len(samples(tmp_path / "out").t) == metrics["cycles"]


@pytest.mark.slow
def test_a_reader_that_goes_away_does_not_stop_the_arm(script: Path, tmp_path: Path) -> None:
    program = in_a_pipe("--device", str(script), "--out", str(tmp_path / "out"))
    assert program.stdout is not None
    program.stdout.readline()
    program.stdout.close()
    program.wait(PATIENCE)
    taught = samples(tmp_path / "out")
    assert taught.t[-1] > 1.8
    assert np.abs(taught.dq[-1]).max() < np.deg2rad(1.0)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signals_end_it_with_everything_recorded(number: signal.Signals, script: Path, tmp_path: Path) -> None:
    program = in_a_pipe("--device", str(script), "--out", str(tmp_path / "out"))
    assert program.stdout is not None
    program.stdout.readline()
    program.send_signal(number)
    assert program.wait(PATIENCE) == 130
    program.stdout.close()
    metrics = json.loads((tmp_path / "out" / "metrics.json").read_text())
    assert metrics["outcome"].startswith("interrupted")
    assert len(samples(tmp_path / "out").t) == metrics["cycles"]


@pytest.mark.slow
def test_a_process_that_is_killed_leaves_a_recording(script: Path, tmp_path: Path) -> None:
    program = in_a_pipe("--device", str(script), "--out", str(tmp_path / "out"))
    assert program.stdout is not None
    while "polishing" not in program.stdout.readline():
        pass
    program.kill()
    program.wait()
    program.stdout.close()
    assert main(["recover", str(tmp_path / "out" / "run.mcap")]) == 0
    assert len(samples(tmp_path / "out", "run.recovered.mcap").t) > 3


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--device", "nowhere.txt"], "nowhere.txt"),
        (["--law", "ComputedTorque"], "OperationalSpace"),
        (["--law", "Foo"], "OperationalSpace"),
        (["--rate", "5000"], "expected 50 to 1000 Hz"),
        (["--seconds", "-1"], "expected more than 0"),
        (["--seconds", "nan"], "expected more than 0"),
        (["--seed", "-1"], "seed -1"),
        (["--deadman", "1"], "expected 2 to 32"),
        (["--modes", "a", "--deadman", "2"], "expected 3 to 32"),
        (["--mould", "teapot"], "plate, dome, wave, mould"),
        (["--view"], "display"),
    ],
)
def test_what_cannot_be_is_refused_in_a_line_and_writes_nothing(
    words: list[str],
    expected: str,
    script: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    given = [] if "--device" in words else ["--device", str(script)]
    assert main(["teleop", *given, *words, "--out", str(tmp_path / "out")]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("burnish: ")
    assert captured.err.count("\n") == 1
    assert expected in captured.err
    assert not (tmp_path / "out").exists()


class Broken:
    """A law that goes wrong."""

    def reset(self, arm: Dynamics) -> None: ...

    def torque(self, arm: Dynamics, reference: ToolReference) -> Array:
        return arm.g if arm.t < 0.3 else np.full(6, np.nan)


def test_where_nobody_can_acknowledge_a_stopped_arm_is_held_and_the_program_ends(
    script: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(LAWS, "OperationalSpace", lambda arm: Broken())
    assert main(["teleop", "--device", str(script), "--out", str(tmp_path / "out")]) == 3
    assert "stopped by the supervisor: the control law gave a torque that is not finite" in capsys.readouterr().out
    taught = samples(tmp_path / "out")
    assert taught.t[-1] > 1.3
    assert np.abs(taught.dq[-1]).max() < np.deg2rad(1.0)
    assert json.loads((tmp_path / "out" / "metrics.json").read_text())["supervisor_events"] == 1


# A real spacenavd, fed by a SpaceMouse on a serial line, into the arm.


def test_a_space_mouse_through_spacenavd_moves_the_arm_and_its_loss_stops_it(tmp_path: Path) -> None:
    with Spacenavd() as daemon:
        words = ("teleop", "--device", "spacenav", "--out", str(tmp_path / "out"))
        with Terminal(*words, environment=daemon.environment) as terminal:
            start = row(terminal.until(drawn), "position")
            daemon.mouse.move(0, 0, 0, 0, 0, 0)
            deadline = time.monotonic() + PATIENCE
            count = 0
            while not row(terminal.look(), "position")[2] >= start[2] + 0.02:
                assert time.monotonic() < deadline, terminal.text
                # A hand is never quite still, and the daemon does not repeat what has not changed.
                count += 1
                daemon.mouse.move(0, 300 + count % 2, 0, 0, 0, 0)
            there = row(terminal.text, "position")
            # The mouse's y is up; the other axes stay where they are.
            np.testing.assert_allclose(there[:2], start[:2], atol=5e-3)
            daemon.mouse.move(0, 0, 0, 0, 0, 0)
            daemon.mouse.press(0b01)
            terminal.until("mode        turn about tool")
            daemon.mouse.press(0)
            daemon.kill()
            assert terminal.ends() == 130
            assert "The device went away" in terminal.text or "the device went away" in terminal.text
    taught = samples(tmp_path / "out")
    assert np.abs(taught.dq[-1]).max() < np.deg2rad(1.0)
    assert taught.t[-1] > 0.5


# In virtual time.


@pytest.mark.parametrize("arm", ["ideal", "honest"])
def test_what_the_operator_does_in_a_cycle_is_in_the_torque_of_that_cycle(arm: str, script: Path) -> None:
    """Two stations alike; in cycle 50 one operator pushes. Their torques part in that very cycle, not a later one."""
    torques = []
    for pushes in (False, True):
        place, hand = virtual(script, arm=arm)
        sent = []
        loop = control(place.rig, place.operator, place.law)
        for cycle in range(52):
            hand.axes = (0.0, 0.0, 1.0, 0.0, 0.0, 0.0) if pushes and cycle >= 50 else AT_REST
            sent.append(next(loop).commanded)
            assert hand.reads == cycle + 1
        torques.append(np.array(sent))
    still, pushed = torques
    assert (still[:50] == pushed[:50]).all()
    # A cycle of the ideal arm is a millisecond, in which the jerk limit lets little through.
    assert np.abs(still[50] - pushed[50]).max() > 1e-3


@pytest.mark.parametrize("how", ["gone", "stop"])
@pytest.mark.parametrize("axes", [(1.0, 1, 1, 1, 1, 1), (0, -1.0, 0, 0, 0, 0), (0, 0, 0, 1.0, 0, 0)], ids=str)
def test_from_full_speed_the_honest_arm_is_at_rest_in_three_tenths_of_a_second(
    axes: Axes, how: str, script: Path
) -> None:
    place, hand = virtual(script, modes="b")
    place.operator.panel = place.operator.panel.step((False,)).step((True,)).step((False,)).step((True,))
    assert place.operator.panel.modes.mode.name == "all in base"
    samples: list[Sample] = []
    stopped = None
    for sample in control(place.rig, place.operator, place.law, until=lambda arm: arm.t > 1.5):
        samples.append(sample)
        hand.axes = axes if sample.arm.t > 0.1 else AT_REST
        if sample.arm.t >= 1.0 and stopped is None:
            stopped = sample.arm.t
            assert np.abs(sample.arm.dq).max() > 0.1, "it was not moving"
            if how == "stop":
                place.operator.stop()
            else:
                hand.connected = False
    assert not place.rig.supervisor.tripped
    after = [np.abs(s.arm.dq).max() for s in samples if stopped is not None and s.arm.t > stopped + 0.3]
    assert max(after) < np.deg2rad(1.0)


ROUGH = ("GeometricNullSpace", "DynamicNullSpace")
"""Laws whose gains suit slower motion: on the honest arm half of the speed makes a joint of the wrist too fast."""


def drive(place: Station, hand: Hand, seconds: float, push: float) -> list[Sample]:
    """Every direction and turn in its time, with pauses; ``push`` of full deflection."""
    moved = []
    for sample in control(place.rig, place.operator, place.law, until=lambda arm: arm.t > seconds):
        moved.append(sample)
        turn, phase = divmod(sample.arm.t, 0.75)
        axis = int(turn) % 3
        hand.axes = tuple(push * (-1.0) ** (turn // 3) * (k == axis and 0.1 < phase < 0.5) for k in range(6))
        if place.rig.supervisor.tripped:
            break
    return moved


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_every_law_of_tool_poses_follows_the_operator(law: str, script: Path) -> None:
    place, hand = virtual(script, law=law)
    push = 0.2 if law in ROUGH else 0.5
    moved = drive(place, hand, 5.0, push)
    assert not place.rig.supervisor.tripped, place.rig.supervisor.event
    assert all(isinstance(sample.reference, ToolReference) for sample in moved)
    # To both sides of where it began, along every axis, by 0.4 s of that share of the speed less the ramps.
    p = np.array([sample.arm.p for sample in moved])
    assert (np.ptp(p, axis=0) > 0.02 * push).all()


def test_a_joint_limit_and_a_stretched_arm_trip_nothing(script: Path) -> None:
    for axes in ((0.0, 0.0, 1.0, 0.0, 0.0, 0.0), (1.0, -1.0, 0.0, 0.0, 0.0, 0.0)):
        place, hand = virtual(script)
        for sample in control(place.rig, place.operator, place.law, until=lambda arm: arm.t > 8.0):
            hand.axes = axes if sample.arm.t > 0.1 else AT_REST
        assert not place.rig.supervisor.tripped, place.rig.supervisor.event
        assert np.abs(sample.arm.dq).max() < 0.1
        assert place.operator.slowed.cause != ""


def test_near_people_the_supervisor_has_nothing_to_stop(script: Path) -> None:
    place, hand = virtual(script, near_people=True)
    speeds = []
    for sample in control(place.rig, place.operator, place.law, until=lambda arm: arm.t > 2.0):
        hand.axes = (0.0, 0.0, 1.0, 0.0, 0.0, 0.0) if sample.arm.t > 0.1 else AT_REST
        speeds.append(np.linalg.norm(sample.arm.v[:3]))
    assert not place.rig.supervisor.tripped, place.rig.supervisor.event
    assert 0.05 < max(speeds) < 0.15


def test_a_stopped_arm_is_acknowledged_by_a_key_and_reset_by_another(script: Path) -> None:
    place, _ = virtual(script)
    session = teleop.Session(place=place, typed=list, seconds=None)
    supervisor, rig = place.rig.supervisor, place.rig
    loop = control(rig, place.operator, place.law)
    next(loop)
    supervisor.filter(rig.arm, np.full(6, np.nan))
    assert supervisor.mode is Mode.HOLD
    view = session._view(rig.arm, "polishing", 100.0)
    assert view.keys["a"] == "acknowledge"
    assert "not finite" in view.cause
    session._take("a")
    assert supervisor.tripped, "it was acknowledged too early"
    assert "1 s" in session._note
    for _ in range(110):
        next(loop)
    session._take("a")
    assert not supervisor.tripped
    supervisor.mode, supervisor.event = Mode.FAULT, Event(t=0.0, cause="read me", fault=True)
    session._take("a")
    assert supervisor.tripped
    assert session._view(rig.arm, "polishing", 100.0).keys["r"] == "reset"
    session._take("r")
    assert not supervisor.tripped


def test_the_fingers_close_while_the_arm_stands(script: Path) -> None:
    place, hand = virtual(script, modes="a")
    session = teleop.Session(place=place, typed=list, seconds=None)
    session.recorder, session.screen = Mock(), Mock()
    place.operator.panel = place.operator.panel.step((False, False)).step((True, False)).step((False, False))
    start = None
    for sample in control(place.rig, place.operator, place.law, until=lambda arm: arm.t > 1.5):
        start = sample.arm.p if start is None else start
        hand.axes = (1.0, 1.0, 1.0, 1.0, 1.0, 1.0) if sample.arm.t > 0.1 else AT_REST
        session._after(sample, "fingers")
        assert np.linalg.norm(sample.reference.p - start) == 0.0
    robot = place.robot.robot
    assert robot.fingers().min() > 0.5
    assert session._view(sample.arm, "fingers", 100.0).fingers > np.rad2deg(0.5)


def test_fingers_that_were_closed_on_something_open_as_soon_as_they_are_told_to(script: Path) -> None:
    place, hand = virtual(script, modes="a")
    session = teleop.Session(place=place, typed=list, seconds=None)
    # Something holds the fingers at these angles, whatever they are told.
    held, told = np.array([0.5, 0.62, 0.6]), list[float]()
    stuck = Mock(fingers=Mock(return_value=held), move_fingers=lambda angles: told.append(angles[0]))
    place.operator.panel = place.operator.panel.step((False, False)).step((True, False)).step((False, False))
    for sample in control(place.rig, place.operator, place.law, until=lambda now: now.t > 2.5):
        t = sample.arm.t
        hand.axes = (0.0, 0.0, 0.0, 0.0, 0.0, 1.0 if 0.1 < t < 2.0 else -1.0 if t >= 2.0 else 0.0)
        session._move_fingers(stuck)
        if t < 2.0:
            closing = told[-1]
        elif t < 2.45:
            opening = told[-1]
    # Ahead of them, so that the drives press with all they have; and nothing to unwind when they shall open.
    assert held.max() + np.deg2rad(4.0) < closing < held.max() + np.deg2rad(6.0)
    assert opening < held.min()
    assert told[-1] == pytest.approx(held.min() - teleop.FINGER_LEASH)


def test_the_polishing_tool_has_no_fingers(script: Path) -> None:
    place, _ = virtual(script, mould="plate", modes="a")
    assert place.operator.panel.modes.pressed(1).mode.name == "free"


# What is drawn.


def view(**others: object) -> View:
    given: dict[str, object] = {
        "title": "arm", "t": 1.0, "mode": "free", "moves": "", "deadman": "", "p": [0.1, 0.2, 0.3], "angles": [1.0] * 3,
        "force": None, "q": [0.0] * 6, "lower": [None] * 6, "upper": [None] * 6, "slowed": "", "device": "mouse",
        "age": 0.0, "rate": 100.0, "late": 0, "cycles": 1, "supervisor": "torque", "cause": "",
        "buttons": {}, "keys": {},
    }  # fmt: skip
    return View(**(given | others))  # type: ignore[arg-type]


def test_a_bar_is_empty_at_one_limit_full_at_the_other_and_coloured_near_them() -> None:
    marks = [bar(q, -100.0, 100.0).plain.index("█") for q in (-100.0, 0.0, 100.0)]
    assert marks == [1, 19, 36]
    drawn = [bar(q, -100.0, 100.0) for q in (0.0, 90.0, 97.0)]
    styles = [str(span.style) for text in drawn for span in text.spans if text.plain[span.start : span.end] == "█"]
    assert styles == ["green", "yellow", "red"]


def test_a_line_is_printed_when_something_happens_and_every_second() -> None:
    shown = view()
    assert not worth_a_line(shown, view(t=1.5))
    for change in ({"t": 2.0}, {"mode": "rotation"}, {"supervisor": "hold"}, {"age": None}, {"note": "done"}):
        assert worth_a_line(shown, view(**change))


def test_a_device_that_went_away_and_a_stopped_arm_are_said_in_words() -> None:
    said = line(view(age=None, supervisor="hold", cause="the tool force reached 30 N"))
    assert "mouse is gone" in said
    assert "hold: the tool force reached 30 N" in said
    assert picture(view(supervisor="fault", cause="x")).row_count == 19


def test_a_view_fits_into_what_a_pipe_takes_whole() -> None:
    long = view(cause="x" * 400, note="x" * 200, device="x" * 200, slowed="x" * 80)
    assert len(json.dumps(asdict(long))) < 4096


def test_help_loads_no_engine() -> None:
    code = "import sys, burnish.cli\ntry:\n burnish.cli.main(['teleop', '--help'])\nexcept SystemExit: pass\n"
    code += "assert not {'mujoco', 'pinocchio', 'numpy', 'rich', 'ruckig'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
