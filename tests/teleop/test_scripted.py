"""Files that are played, refused and recorded."""

from __future__ import annotations

from math import pi
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from teleop.clock import Clock

from burnish.errors import InputError
from burnish.teleop import scripted
from burnish.teleop.device import AT_REST, Axes, Reading
from burnish.teleop.scripted import HEAD, Line, Recorded, Scripted, open_script, read_script, write_script
from burnish.teleop.shaping import Memory, Shaping, shape

GOOD = f"""# push away, then turn with the second button held
{HEAD}
0.0, 0, 0, 0, 0, 0, 0, 00

0.5, 0, 0.5, 0, 0, 0, 0, 00
1.5, 0, 0, 0, 0, 0, -1, 01
2.0, 0, 0, 0, 0, 0, 0, 00
"""


@pytest.fixture
def script(tmp_path: Path) -> Path:
    path = tmp_path / "session.csv"
    path.write_text(GOOD)
    return path


def play(device: Scripted, clock: Clock, *times: float) -> list[Reading]:
    device.read()
    start, found = clock.now, []
    for t in times:
        clock.now = start + t
        found.append(device.read())
    return found


def test_a_line_holds_from_its_time_until_the_next(script: Path) -> None:
    clock = Clock()
    with open_script(script, clock) as device:
        found = play(device, clock, 0.0, 0.49, 0.5, 1.49, 1.5)
    assert [one.axes[1] for one in found] == [0.0, 0.0, 0.5, 0.5, 0.0]
    assert [one.axes[5] for one in found] == [0.0, 0.0, 0.0, 0.0, -1.0]
    assert [one.buttons for one in found][-2:] == [(False, False), (False, True)]
    assert all(one.age == 0.0 and one.connected for one in found)


def test_a_line_holds_at_its_time_although_differences_of_times_round() -> None:
    rest = Line(t=0.0, axes=AT_REST, buttons=(False,))
    clock = Clock()
    device = Scripted(
        [rest, Line(t=0.3, axes=AT_REST, buttons=(True,)), Line(t=1.0, axes=AT_REST, buttons=())], clock=clock
    )
    assert (clock.now + 0.3) - clock.now < 0.3
    assert play(device, clock, 0.3)[0].buttons == (True,)


def test_the_last_line_is_the_end_at_which_the_device_is_unplugged(script: Path) -> None:
    clock = Clock()
    device = open_script(script, clock)
    assert device.duration == 2.0
    before, at, after = play(device, clock, 1.999, 2.0, 2.3)
    assert (before.connected, at.connected, after.connected) == (True, False, False)
    assert after.axes == AT_REST
    assert after.age == pytest.approx(0.3)


def test_time_counts_from_the_first_reading(script: Path) -> None:
    clock = Clock()
    device = open_script(script, clock)
    clock.now += 1000.0
    assert device.read().connected


def test_a_script_that_ends_while_it_pushes_ends_in_a_ramp() -> None:
    clock, memory, shaping = Clock(), Memory(), Shaping(dead_band=0.0)
    push: Axes = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    device = Scripted(
        [Line(t=t, axes=axes, buttons=()) for t, axes in ((0.0, AT_REST), (0.1, push), (1.0, push))], clock=clock
    )
    pushed = []
    for reading in play(device, clock, 0.0, 0.5, 1.05, 1.15, 1.25):
        meant, memory = shape(reading, memory, shaping)
        pushed.append(meant.axes[0])
    assert pushed == pytest.approx([0.0, 1.0, 1.0, 0.5, 0.0])


axis = st.floats(-1.0, 1.0)
lines = st.lists(
    st.tuples(st.tuples(axis, axis, axis, axis, axis, axis), st.lists(st.booleans(), max_size=4).map(tuple)),
    min_size=2,
    max_size=20,
)


@given(lines, st.floats(1e-6, 100.0))
@settings(max_examples=30)
def test_what_is_written_reads_back_bit_by_bit(
    tmp_path_factory: pytest.TempPathFactory, found: list[tuple[Axes, tuple[bool, ...]]], step: float
) -> None:
    path = tmp_path_factory.mktemp("script") / "s.csv"
    script = [Line(t=step * k, axes=axes, buttons=buttons) for k, (axes, buttons) in enumerate(found)]
    write_script(path, script)
    assert read_script(path) == script


def test_a_recorded_session_plays_the_same_readings_again(script: Path, tmp_path: Path) -> None:
    clock, copy = Clock(), tmp_path / "copy.csv"
    clock.now = 7.3 * pi
    first, again = [], []
    with Recorded(open_script(script, clock), copy) as device:
        for _ in range(230):
            first.append(device.read())
            clock.now += 0.01
    clock.now = 7.3 * pi
    with open_script(copy, clock) as played:
        for _ in range(230):
            again.append(played.read())
            clock.now += 0.01
    # The end of the first is a device that is gone; the second goes on at rest until the recording ended.
    assert [(one.t, one.axes) for one in again] == [(one.t, one.axes) for one in first]
    assert [one.buttons for one in again[:200]] == [one.buttons for one in first[:200]]
    assert len(read_script(copy)) == 5


def test_of_a_frozen_device_what_is_left_is_recorded(tmp_path: Path) -> None:
    class Frozen:
        name = "frozen"
        age = 0.0

        def read(self) -> Reading:
            return Reading(t=self.age, axes=(1.0, 0.0, 0.0, 0.0, 0.0, 0.0), buttons=(), age=self.age)

        def __enter__(self) -> Frozen:
            return self

        def __exit__(self, *_: object) -> None:
            pass

    frozen = Frozen()
    with Recorded(frozen, tmp_path / "s.csv") as device:
        for frozen.age in (0.0, 0.15, 0.3, 0.4):
            device.read()
    assert [line.axes[0] for line in read_script(tmp_path / "s.csv")] == pytest.approx([1.0, 0.5, 0.0, 0.0])


def test_a_recording_is_kept_when_the_program_fails(script: Path, tmp_path: Path) -> None:
    clock = Clock()

    def fail(device: Recorded) -> None:
        with device:
            for _ in range(2):
                device.read()
                clock.now += 1.0
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail(Recorded(open_script(script, clock), tmp_path / "s.csv"))
    assert [line.axes[1] for line in read_script(tmp_path / "s.csv")] == [0.0, 0.5]


def test_a_session_that_is_too_long_stops_being_kept_and_says_so(
    script: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    clock = Clock()
    long = open_script(script, clock)
    monkeypatch.setattr(scripted, "MOST_LINES", 3)
    with Recorded(long, tmp_path / "s.csv") as device:
        for _ in range(20):
            device.read()
            clock.now += 0.1
    assert len(read_script(tmp_path / "s.csv")) == 3
    assert "is full at 3 lines" in caplog.text
    monkeypatch.setattr(scripted, "MOST_LINES", 2)
    with pytest.raises(InputError, match="has 3 lines; expected at most 2"):
        read_script(tmp_path / "s.csv")


def test_the_longest_recording_is_no_longer_than_what_is_read(tmp_path: Path) -> None:
    worst = -2.2250738585072014e-308
    lines = [Line(t=40_000.123456789012, axes=(worst,) * 6, buttons=(True,) * scripted.MOST_BUTTONS)]
    write_script(tmp_path / "s.csv", lines)
    longest = (tmp_path / "s.csv").stat().st_size - len(HEAD) - 1
    assert longest * scripted.MOST_LINES + len(HEAD) + 1 <= scripted.MAX_BYTES


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "begins with ''; expected t,x,y,z"),
        ("0,0,0,0,0,0,0,0\n", "begins with '0,0,0,0,0,0,0,0'; expected t,x"),
        (f"{HEAD}\n", "0 lines; expected two or more"),
        (f"{HEAD}\n0,0,0,0,0,0,0,0\n", "1 lines; expected two or more"),
        (f"{HEAD}\n0,0,0,0,0,0,0,0\n1,0,0,0,0,0,0\n", "line 3: expected eight words"),
        (f"{HEAD}\n0,0,0,0,0,0,0,0\n1,0,0,0,0,0,0,0,0\n", "line 3: expected eight words"),
        (f"{HEAD}\n0,0,0,0,0,0\n", "line 2: found 6 words"),
        (f"{HEAD}\n0,0,0,0,0,0,0,0\n1,a,0,0,0,0,0,0\n", "line 3: a time or an axis is no number"),
        (f"{HEAD}\n0,0,0,0,0,0,0,0\n1_0,0,0,0,0,0,0,0\n", "line 3: a time or an axis is no number"),
        (f"{HEAD}\n0,0,0,0,0,0,0,2\n1,0,0,0,0,0,0,0\n", "line 2: expected eight words, the last a 0 or 1"),
        (f"{HEAD}\n0,nan,0,0,0,0,0,0\n1,0,0,0,0,0,0,0\n", "line 2: a time or an axis is no number in its range"),
        (f"{HEAD}\n0,0,0,0,0,0,1.01,0\n1,0,0,0,0,0,0,0\n", "line 2: a time or an axis is no number in its range"),
        (f"{HEAD}\n0,0,0,0,0,0,0,0\ninf,0,0,0,0,0,0,0\n", "line 3: a time or an axis is no number in its range"),
        (f"{HEAD}\n-1,0,0,0,0,0,0,0\n1,0,0,0,0,0,0,0\n", "line 2: a time or an axis is no number in its range"),
        (f"{HEAD}\n0.1,0,0,0,0,0,0,0\n1,0,0,0,0,0,0,0\n", "times that rise from 0 on"),
        (f"{HEAD}\n0,0,0,0,0,0,0,0\n1,0,0,0,0,0,0,0\n1,0,0,0,0,0,0,0\n", "times that rise from 0 on"),
        ("naïve", "is no plain text"),
    ],
)
def test_what_is_no_script_is_refused_with_its_line(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "s.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        open_script(path)
    assert said in str(caught.value)


def test_a_file_that_is_too_large_is_not_read_to_its_end(tmp_path: Path) -> None:
    path = tmp_path / "s.csv"
    with path.open("wb") as file:
        file.truncate(2**32)
    with pytest.raises(InputError, match="larger than 32 MiB"):
        open_script(path)


def test_a_folder_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be written"):
        write_script(tmp_path / "none" / "s.csv", [])


@given(st.binary(max_size=300))
@settings(max_examples=50)
def test_any_bytes_are_a_script_or_refused(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    path = tmp_path_factory.mktemp("script") / "s.csv"
    for begin in (b"", HEAD.encode() + b"\n"):
        path.write_bytes(begin + data)
        try:
            open_script(path)
        except InputError:
            continue
