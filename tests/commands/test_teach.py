"""``burnish teach`` as an operator meets it: keys typed on a terminal, in a pipe, and when something goes away."""

from __future__ import annotations

import json
import os
import re
import time
from pathlib import Path

import numpy as np
import pexpect
import pytest
from commands.terminal import PATIENCE, Terminal
from commands.test_cli import refusal

from burnish.cli import main
from burnish.record.poses_file import read_poses
from burnish.record.recording import Recording
from burnish.teach.demonstration import STORED, Demonstration

DOWN, RIGHT = "\x1b[6~", "\x1b[C"


class Seat(Terminal):
    """A terminal whose screen may be drawn faster than it can be read."""

    def look(self) -> str:
        """Take in some of what the program has written."""
        for _ in range(5):
            try:
                self._stream.feed(self.program.read_nonblocking(65536, timeout=0.05))
            except (pexpect.TIMEOUT, pexpect.EOF):
                break
        return self.text


def phases(path: Path) -> list[str]:
    """The phases of a recording in order, neighbours once."""
    found: list[str] = []
    for block in Recording(path).blocks():
        found += [phase for phase in block.phase.tolist() if not found or phase != found[-1]]
    return [phase for k, phase in enumerate(found) if k == 0 or phase != found[k - 1]]


def last_rows(path: Path) -> tuple[float, np.ndarray]:
    """Time and joint speeds of the last cycle."""
    *_, last = Recording(path).blocks()
    return float(last.t[-1]), last.dq[-1]


def time_of(path: Path, cycle: int) -> float:
    t = np.concatenate([block.t for block in Recording(path).blocks()])
    return float(t[cycle - 1])


def test_help_names_the_keys_and_the_options(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["teach", "--help"])
    said = " ".join(capsys.readouterr().out.split())
    for word in ("--device", "--mould", "--pace", "--yes", "R: record", "Space: cancel", "E: store and go home"):
        assert word in said


def test_without_a_terminal_nobody_can_press_keys(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert "--yes" in refusal(capsys, "teach", "--device", "hand", "--out", str(tmp_path / "out"))
    assert not (tmp_path / "out").exists()


def test_words_that_cannot_be_used_are_refused_before_anything_moves(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = ("--yes", "--out", str(tmp_path / "out"))
    assert "no such device" in refusal(capsys, "teach", "--device", "nothing.csv", *out)
    assert "pace" in refusal(capsys, "teach", "--device", "hand", "--pace", "1000", *out)
    assert "rate" in refusal(capsys, "teach", "--device", "hand", "--rate", "5", *out)
    assert "there is no mould" in refusal(capsys, "teach", "--device", "hand", "--mould", "nothing", *out)
    assert not (tmp_path / "out").exists()


def test_space_at_home_ends_the_session_and_nothing_is_stored(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with Seat("teach", "--device", "hand", "--pace", "10", "--out", str(out)) as terminal:
        terminal.until("mode        home")
        assert "R record" in terminal.row("keys")
        assert "Enter go on" in terminal.row("keys")
        terminal.type(" ")
        assert terminal.ends() == 0
        assert "Cancelled." in terminal.text
    assert STORED not in Recording(out / "run.mcap").ending
    assert json.loads((out / "metrics.json").read_text())["stored"] is False
    assert not (out / "desired_poses.txt").exists()


@pytest.mark.slow
def test_a_person_teaches_cancels_teaches_again_and_stores(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with Seat("teach", "--device", "keyboard", "--pace", "2", "--out", str(out)) as terminal:
        terminal.until("mode        home")
        terminal.type("\r")
        terminal.until("mode        ready")
        terminal.type("r")
        terminal.until("mode        record free polishing")
        # Cancel: the arm goes home, and everything begins anew.
        terminal.type(" ")
        terminal.until("mode        home")
        terminal.type("\r")
        terminal.until("mode        ready")
        terminal.type("r")
        terminal.until("mode        record free polishing")
        terminal.type("-")
        terminal.until("mode        record contact polishing", typing=DOWN)
        x = position(terminal)
        terminal.until(lambda text: abs(position(terminal) - x) > 0.012, typing=RIGHT)
        terminal.type("e")
        assert terminal.ends() == 0
        assert "Done." in terminal.text
    path = out / "run.mcap"
    seen = phases(path)
    assert seen[:4] == ["home", "to ready", "ready", "tare"]
    assert seen.count("home") == 2
    assert "to home" in seen
    first, last = map(int, Recording(path).ending[STORED].split())
    demonstration = Demonstration.of(Recording(path))
    assert len(demonstration.t) == last - first + 1
    assert demonstration.contact.any()
    assert set(demonstration.mode) == {"polishing"}
    poses = read_poses(out / "desired_poses.txt")
    assert len(poses.p) == len(demonstration.t)
    assert poses.p == pytest.approx(demonstration.placement.points(demonstration.p_d))
    assert np.abs(last_rows(path)[1]).max() < np.deg2rad(1.0)


def position(terminal: Seat) -> float:
    """The largest of the horizontal coordinates that a push to the right changes."""
    found = re.findall(r"([+-]\d+\.\d+)", terminal.row("position"))
    return float(found[0])


@pytest.mark.slow
def test_ctrl_c_while_recording_brings_the_arm_to_rest_within_300_ms(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with Seat("teach", "--device", "hand", "--pace", "4", "--out", str(out)) as terminal:
        terminal.until("mode        home")
        terminal.type("r")
        terminal.until("mode        record free")
        time.sleep(1.0)
        terminal.type("\x03")
        assert terminal.ends() == 130
        assert "Interrupted." in terminal.text
    path = out / "run.mcap"
    after = time_of(path, int(Recording(path).ending["interrupted_after"]))
    t, dq = last_rows(path)
    assert t - after <= 0.3
    assert np.abs(dq).max() < np.deg2rad(1.0)


@pytest.mark.slow
def test_a_terminal_that_is_closed_leaves_an_arm_at_rest_and_a_whole_recording(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with Seat("teach", "--device", "hand", "--pace", "4", "--out", str(out)) as terminal:
        terminal.until("mode        home")
        terminal.type("r")
        terminal.until("mode        record free")
        os.close(terminal.program.child_fd)
        terminal.program.closed = True
        deadline = time.monotonic() + PATIENCE
        while not (out / "report.html").exists():
            assert time.monotonic() < deadline
            time.sleep(0.05)
    path = out / "run.mcap"
    after = time_of(path, int(Recording(path).ending["interrupted_after"]))
    t, dq = last_rows(path)
    assert t - after <= 0.3
    assert np.abs(dq).max() < np.deg2rad(1.0)
    assert json.loads((out / "metrics.json").read_text())["cycles"] == int(Recording(path).ending["cycles"])


@pytest.mark.slow
def test_a_script_is_taught_and_stored_by_itself_and_its_end_is_the_end(tmp_path: Path) -> None:
    script = tmp_path / "script.csv"
    rows = ["0,0,0,0,0,0,0,00", "0.3,0,0,-0.5,0,0,0,00", "0.73,0,0,0,0,0,0,00", "1.2,0,0,0.5,0,0,0,00",
            "1.4,0,0,0,0,0,0,00", "1.7,0,0,0,0,0,0,00"]  # fmt: skip
    script.write_text("\n".join(["t,x,y,z,turn_x,turn_y,turn_z,buttons", *rows]) + "\n")
    out = tmp_path / "out"
    assert main(["teach", "--yes", "--device", str(script), "--out", str(out)]) == 0
    demonstration = Demonstration.of(Recording(out / "run.mcap"))
    # 0.43 s at half of 0.2 m/s, less a gentle start, down in the base and the mould alike.
    assert np.ptp(demonstration.p_d[:, 2]) == pytest.approx(0.03, abs=0.01)
    assert json.loads((out / "metrics.json").read_text())["outcome"] == "done"
