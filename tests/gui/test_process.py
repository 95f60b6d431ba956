"""A job in its own process: what it says, who it heeds, and that nothing ends it but itself."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest
from commands.test_cli import small_plate

from burnish.gui.lease import Grant
from burnish.gui.process import Process, swept
from burnish.runtime.machine import Mode
from burnish.runtime.mailbox import PATIENCE, Mailbox, Order

MINE, OTHERS = Grant(number=1, who=7), Grant(number=2, who=7)


def test_refused_job_says_why_and_leaves_nothing(tmp_path: Path) -> None:
    job = Process(["polish", "--mould", str(tmp_path / "nowhere.stl")], MINE)
    assert job.wait() == 2
    assert "nowhere.stl" in job.said
    assert job.said.count("\n") == 1
    folder = job.box.path.parent
    assert job.close() == 2
    assert not folder.exists()


def test_job_has_a_session_of_its_own() -> None:
    job = Process(["--help"], MINE)
    # Ctrl-C at the server's terminal is not for the job.
    assert os.getsid(job._process.pid) == job._process.pid
    assert job.close() == 0


def test_only_the_grant_that_started_it_keeps_a_job_going() -> None:
    job = Process(["--help"], MINE)
    job.box.beat(0.0)
    job.beat(OTHERS, time.monotonic())
    assert not job.box.commanded
    job.beat(MINE, time.monotonic())
    assert job.box.commanded
    job.lost(OTHERS)
    assert job.box.commanded
    job.lost(MINE)
    assert not job.box.commanded
    assert job.close() == 0


def test_what_a_killed_server_left_is_swept_away(tmp_path: Path) -> None:
    # No process has a number beyond the system's largest.
    gone, here, other = (tmp_path / name for name in ("burnish-job-99999999-x", f"burnish-job-{os.getpid()}-y", "mine"))
    for folder in (gone, here, other):
        folder.mkdir()
        (folder / "mailbox").touch()
    swept(tmp_path)
    assert not gone.exists()
    assert (here / "mailbox").exists()
    assert (other / "mailbox").exists()


def test_orders_reach_the_mailbox_and_close_orders_a_stop() -> None:
    job = Process(["--help"], MINE)
    other = Mailbox.open(job.box.path)
    job.pause()
    assert other.wanted is Order.PAUSE
    job.box.order(Order.GO)
    job.close()
    assert other.wanted is Order.STOP


def watch(job: Process, phase: str) -> None:
    """Beat until the job is in this phase, and a little further."""
    until = time.monotonic() + 120.0
    while time.monotonic() < until and job.outcome is None:
        job.beat(MINE, time.monotonic())
        seen = job.box.latest()
        if seen is not None and seen.phase == phase and seen.done > 0.05:
            return
        time.sleep(0.01)
    raise AssertionError(f"the job never came to {phase}: {job.said}")


@pytest.mark.slow
def test_lost_commander_means_hold_and_the_job_goes_on_later(tmp_path: Path) -> None:
    mesh, out = small_plate(tmp_path / "p.stl", size=60.0), tmp_path / "out"
    job = Process(["polish", "--mould", str(mesh), "--out", str(out)], MINE)
    watch(job, "pass")
    last = time.monotonic()
    job.beat(MINE, last)
    held = None
    while job.outcome is None:
        seen = job.box.latest()
        if held is None and seen is not None and seen.mode is Mode.HOLD:
            held = seen
        time.sleep(0.002)
    assert held is not None
    assert held.cause == "whoever commanded the arm is gone"
    # Not before it is overdue; how soon after is measured in benchmarks/gui_gate.py, on a quiet machine.
    assert held.wall - last >= PATIENCE
    assert job.close() == 3
    again = Process(["polish", "--resume", str(out), "--mould", str(mesh)], MINE)
    while again.outcome is None:
        again.beat(MINE, time.monotonic())
        time.sleep(0.05)
    assert again.close() == 0
    assert [path.name for path in out.glob("run-*.mcap")] == ["run-2.mcap"]


@pytest.mark.slow
def test_closed_page_means_hold_in_the_next_cycles(tmp_path: Path) -> None:
    mesh = small_plate(tmp_path / "p.stl", size=60.0)
    job = Process(["polish", "--mould", str(mesh), "--out", str(tmp_path / "out")], MINE)
    watch(job, "pass")
    closed = time.monotonic()
    job.lost(MINE)
    assert job.wait() == 3
    seen = job.box.latest()
    assert seen is not None
    assert seen.mode is Mode.HOLD
    track, rows = job.box.track(0)
    assert track > 5
    assert rows[:, 3].max() > 5.0
    assert closed < seen.wall
    job.close()


@pytest.mark.slow
def test_paused_job_is_at_rest_and_says_that_it_was_ended_early(tmp_path: Path) -> None:
    mesh = small_plate(tmp_path / "p.stl", size=60.0)
    job = Process(["polish", "--mould", str(mesh), "--out", str(tmp_path / "out")], MINE)
    watch(job, "pass")
    job.pause()
    while job.outcome is None:
        job.beat(MINE, time.monotonic())
        time.sleep(0.05)
    seen = job.box.latest()
    assert seen is not None
    assert seen.mode is Mode.TORQUE
    assert abs(seen.dq).max() < 0.02
    assert "Interrupted." in job.said
    assert job.close() == 130
