"""``--live``: a job that somebody outside watches and commands."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from commands.test_cli import refusal, small_plate

from burnish.cli import main
from burnish.commands.live import Live
from burnish.record.recording import Recording
from burnish.runtime.machine import Mode
from burnish.runtime.mailbox import Mailbox, Order


@contextmanager
def beating(box: Mailbox) -> Iterator[None]:
    ended = threading.Event()

    def beat() -> None:
        while not ended.wait(0.02):
            box.beat()

    thread = threading.Thread(target=beat)
    box.beat()
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


@pytest.mark.parametrize("verb", ["polish", "teach", "replay"])
def test_file_that_is_no_mailbox_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str], verb: str) -> None:
    words = [str(tmp_path / "none.mcap")] if verb == "replay" else ["--out", str(tmp_path / "out")]
    line = refusal(capsys, verb, *words, "--live", str(tmp_path / "nowhere"))
    assert ("none.mcap" if verb == "replay" else "mailbox") in line
    assert not (tmp_path / "out" / "run.mcap").exists()


def test_jog_needs_somebody_outside(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = refusal(capsys, "teach", "--yes", "--device", "jog", "--out", str(tmp_path / "out"))
    assert "--live FILE" in line


def test_arm_that_nobody_commands_does_not_move_and_does_so_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    box, out = Mailbox.create(tmp_path / "box"), tmp_path / "out"
    mesh = str(small_plate(tmp_path / "p.stl"))
    assert main(["polish", "--mould", mesh, "--live", str(box.path), "--out", str(out)]) == 3
    seen = box.latest()
    assert seen is not None
    assert seen.mode is Mode.HOLD
    assert seen.cause == "whoever commanded the arm is gone"
    recording = Recording(out / "run.mcap")
    assert recording.ending["abandoned_after"] == "1"
    assert "gone" in recording.ending["outcome"]
    q = np.concatenate([block.q for block in recording.blocks()])
    assert np.abs(q - q[0]).max() < np.deg2rad(0.5)
    assert json.loads((out / "metrics.json").read_text())["supervisor_events"] == 1
    assert box.stage == "writing the report"
    assert main(["verify", str(out / "run.mcap"), "--mould", mesh]) == 0
    assert "Bit-exact" in capsys.readouterr().out


def test_stall_of_the_job_itself_is_not_held_against_its_commander(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    now = [100.0]
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    live = Live(box=Mailbox.create(tmp_path / "box"))
    assert live.gone()
    live.box.beat()
    for _ in range(20):
        assert not live.gone()
        now[0] += 0.01
    now[0] += 5.0
    # Both stood still; the beat comes a moment later, or it does not.
    assert not live.gone()
    now[0] += 0.02
    assert not live.gone()
    now[0] += 0.031
    assert live.gone()
    live.box.beat()
    assert not live.gone()


def test_stop_that_was_ordered_before_it_began_ends_as_ctrl_c_does(tmp_path: Path) -> None:
    box, out = Mailbox.create(tmp_path / "box"), tmp_path / "out"
    box.order(Order.STOP)
    with beating(box):
        words = ["polish", "--mould", str(small_plate(tmp_path / "p.stl")), "--live", str(box.path), "--out", str(out)]
        words += ["--pace", "1"]
        assert main(words) == 130
    assert Recording(out / "run.mcap").ending["interrupted_after"] == "1"
    seen = box.latest()
    assert seen is not None
    assert seen.mode is Mode.TORQUE
    # At real time, or slower on a busy machine.
    assert json.loads((out / "metrics.json").read_text())["realtime_factor"] < 1.05


def test_keys_from_outside_lead_a_teaching_home_again(tmp_path: Path) -> None:
    box, out = Mailbox.create(tmp_path / "box"), tmp_path / "out"
    box.press("nonsense")
    with beating(box):
        # Space at home ends the session.
        ended = threading.Event()

        def cancel() -> None:
            while not ended.wait(0.02):
                seen = box.latest()
                if seen is not None and "space" in seen.waits_for:
                    box.press("space")

        thread = threading.Thread(target=cancel)
        thread.start()
        code = main(["teach", "--device", "jog", "--live", str(box.path), "--pace", "10", "--out", str(out)])
        ended.set()
        thread.join()
    assert code == 0
    assert "space" in Recording(out / "run.mcap").ending["keys"]
    assert Recording(out / "run.mcap").ending["outcome"] == "cancelled"
