"""The memory between a job and its workshop: whole glances, honest ages, and files that are none."""

from __future__ import annotations

import math
import multiprocessing
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from burnish.errors import RecordingError
from burnish.runtime.machine import Mode
from burnish.runtime.mailbox import COLUMNS, JOG_LASTS, KEYS, PATIENCE, ROWS, SEAT, SEATS, Glance, Mailbox, Order


def glance(value: float = 1.0, **others: object) -> Glance:
    """All its numbers are the same."""
    shown = Glance(
        wall=value, t=value, phase="pass", mode=Mode.TORQUE, cause="", stroke=1, strokes=3, done=value,
        q=np.full(6, value), dq=np.full(6, value), tau=np.full(6, value), p=np.full(3, value),
        R=np.full((3, 3), value), v=np.full(6, value), force=value, force_set=value, feed=value, feed_set=value,
        tilt=value, late_cycles=4,
    )  # fmt: skip
    return replace(shown, **others)  # type: ignore[arg-type]


@pytest.fixture
def ends(tmp_path: Path) -> tuple[Mailbox, Mailbox]:
    """The job's end and the server's."""
    return Mailbox.create(tmp_path / "box"), Mailbox.open(tmp_path / "box")


def test_other_side_sees_what_was_posted_last(ends: tuple[Mailbox, Mailbox]) -> None:
    job, server = ends
    assert server.latest() is None
    for value in (1.0, 2.0, 3.0):
        job.post(glance(value, mode=Mode.HOLD, cause="too fast: 50 °/s", waits_for=("r", "space")))
    seen = server.latest()
    assert seen is not None
    assert seen.number == 3
    assert (seen.mode, seen.cause, seen.phase, seen.waits_for) == (
        Mode.HOLD, "too fast: 50 °/s", "pass", ("r", "space"),
    )  # fmt: skip
    assert (seen.stroke, seen.strokes, seen.late_cycles) == (1, 3, 4)
    for array, shape in ((seen.q, (6,)), (seen.p, (3,)), (seen.R, (3, 3)), (seen.v, (6,))):
        assert array.shape == shape
        assert (array == 3.0).all()


def test_text_that_is_too_long_is_cut_between_characters(ends: tuple[Mailbox, Mailbox]) -> None:
    job, server = ends
    job.post(glance(cause="x" + "°" * 400))
    seen = server.latest()
    assert seen is not None
    assert seen.cause == "x" + "°" * 127


def test_glance_that_was_cut_short_leaves_the_one_before(ends: tuple[Mailbox, Mailbox]) -> None:
    job, server = ends
    for value in (1.0, 2.0, 3.0):
        job.post(glance(value))
    # The writer of the third died in the middle of it.
    (third,) = (at for at in (SEATS, SEATS + job._seat) if SEAT.unpack_from(job._memory, at)[0] == 3)
    job._memory[third + 40] ^= 1
    seen = server.latest()
    assert seen is not None
    assert seen.t == 2.0
    for at in (SEATS, SEATS + job._seat):
        job._memory[at + 8] ^= 1
    assert Mailbox.open(job.path).latest() is None
    assert server.latest() is seen


def write(path: Path, until: float) -> None:
    job, value = Mailbox.open(path), 0.0
    while time.monotonic() < until:
        value += 1.0
        job.post(glance(value))


def test_no_glance_is_read_in_halves_beside_a_busy_writer(tmp_path: Path) -> None:
    server = Mailbox.create(tmp_path / "box")
    writer = multiprocessing.get_context("fork").Process(target=write, args=(server.path, time.monotonic() + 0.7))
    writer.start()
    numbers = []
    while writer.is_alive():
        seen = server.latest()
        if seen is not None:
            values = {seen.t, seen.force, *seen.q.tolist(), *seen.R.ravel().tolist(), *seen.v.tolist()}
            assert values == {float(seen.number)}
            numbers.append(seen.number)
    assert len(set(numbers)) > 5
    assert numbers == sorted(numbers)


def test_track_hands_over_what_is_new_and_tells_what_was_lost(ends: tuple[Mailbox, Mailbox]) -> None:
    job, server = ends
    for k in range(5):
        job.mark(np.array([k, 0.0, 0.0]), 10.0, 0.02, 0.05)
    following, rows = server.track(0)
    assert following == 5
    assert rows.shape == (5, COLUMNS)
    assert rows[:, 0].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert rows[0, 3:].tolist() == [10.0, 0.02, 0.05]
    assert server.track(5)[1].shape == (0, COLUMNS)
    for k in range(ROWS + 10):
        job.mark(np.array([k, 0.0, 0.0]), 10.0, 0.02, 0.05)
    following, rows = server.track(5)
    assert following == ROWS + 15
    # One row may be under the pen, so it is not believed.
    assert following - 5 - len(rows) == 11
    assert rows[0, 0] == 11.0
    assert rows[-1, 0] == ROWS + 9


def test_nobody_commands_before_the_first_beat_and_after_the_last(ends: tuple[Mailbox, Mailbox]) -> None:
    job, server = ends
    assert not job.commanded
    assert job.age == math.inf
    server.beat()
    assert job.commanded
    server.beat(time.monotonic() - PATIENCE - 0.01)
    assert not job.commanded
    for at in (math.nan, -math.inf, time.monotonic() + 10.0):
        server.beat(at)
        assert not job.commanded


def test_orders_arrive_and_what_is_no_order_means_stop(ends: tuple[Mailbox, Mailbox]) -> None:
    job, server = ends
    assert job.wanted is Order.GO
    for order in (Order.PAUSE, Order.STOP, Order.GO):
        server.order(order)
        assert job.wanted is order
    server._numbers[1] = 77
    assert job.wanted is Order.STOP


def test_jog_lasts_a_moment_and_only_numbers_count(ends: tuple[Mailbox, Mailbox]) -> None:
    job, server = ends
    assert not job.jogged.any()
    server.jog(np.array([0.5, 0.0, 0.0, 0.0, 0.0, -3.0]))
    assert job.jogged.tolist() == [0.5, 0.0, 0.0, 0.0, 0.0, -1.0]
    server.jog(np.array([0.5, np.nan, 0.0, 0.0, 0.0, 0.0]))
    assert not job.jogged.any()
    server.jog(np.ones(6))
    server._reals[4] = server._reals[11] = time.monotonic() - JOG_LASTS - 0.01
    assert not job.jogged.any()


def test_keys_come_once_and_in_order(ends: tuple[Mailbox, Mailbox]) -> None:
    job, server = ends
    server.press("r")
    server.press("space")
    assert job.pressed() == ["r", "space"]
    assert job.pressed() == []
    for k in range(KEYS + 3):
        server.press(str(k))
    assert job.pressed() == [str(k) for k in range(3, KEYS + 3)]


def test_stage_is_told(ends: tuple[Mailbox, Mailbox]) -> None:
    job, server = ends
    assert server.stage == ""
    job.tell("planning the path")
    assert server.stage == "planning the path"


def test_file_that_is_no_mailbox_is_refused(tmp_path: Path) -> None:
    made = Mailbox.create(tmp_path / "box").path.read_bytes()
    other = tmp_path / "other"
    for content, what in (
        (b"", "no mailbox"),
        (b"x" * len(made), "no mailbox"),
        (made[:-1], "damaged"),
        (made[:12] + b"\x07" + made[13:], "damaged"),
        (made[:8] + b"\x09" + made[9:], "version 9"),
    ):
        other.write_bytes(content)
        with pytest.raises(RecordingError, match=what):
            Mailbox.open(other)
    with pytest.raises(RecordingError, match="cannot be opened"):
        Mailbox.open(tmp_path / "nowhere")
    with pytest.raises(RecordingError, match="cannot be opened"):
        Mailbox.open(tmp_path)
    with pytest.raises(RecordingError, match="every job has a new one"):
        Mailbox.create(other)
    with pytest.raises(RecordingError, match="64 joints"):
        Mailbox.create(tmp_path / "new", joints=64)


def test_mailbox_is_its_owners_alone(tmp_path: Path) -> None:
    assert Mailbox.create(tmp_path / "box").path.stat().st_mode & 0o777 == 0o600
