"""A device that plays a file, and the recorder of such files: an operator's session, again.

The file is text: the line of `HEAD`, then a line ``t, x, y, z, turn_x, turn_y, turn_z, buttons`` for each change, with
the time [s] from the first reading on, axes in [−1, 1], and a 0 or 1 for each button. A line holds until the next one;
the last one is the end, at which the device is unplugged. Lines that begin with # and empty ones do not count.
"""

from __future__ import annotations

import logging
import os
import re
import time
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import nan
from pathlib import Path
from types import TracebackType

from typing_extensions import Self

from burnish.errors import InputError
from burnish.teleop.device import AT_REST, Axes, Device, Reading, six
from burnish.teleop.shaping import freshness, scaled

HEAD = "t,x,y,z,turn_x,turn_y,turn_z,buttons"
MAX_BYTES = 32 * 2**20
"""Largest file that is read [B]; the longest recording fits, with all its digits."""
MOST_LINES = 150_000
"""More are neither recorded nor read: 25 minutes of a hand that moves without a pause, at 100 Hz."""
LONGEST = 86_400.0
"""Latest time that is believed [s]: a day."""
MOST_BUTTONS = 32
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
SLACK = 1e-9
"""A reading this much before a line's time counts as at it [s]: times are differences of floats."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class Line:
    """One line of a file."""

    t: float
    """Time from which it holds [s]."""
    axes: Axes
    buttons: tuple[bool, ...]


class Scripted:
    """A device that plays lines, from its first reading on."""

    def __init__(
        self, lines: Sequence[Line], *, name: str = "script", clock: Callable[[], float] = time.monotonic
    ) -> None:
        """``clock`` may be that of a simulation.

        Raises:
            InputError: if there are fewer than two lines, or their times do not rise from 0 on.
        """
        times = [line.t for line in lines]
        if len(lines) < 2 or times[0] != 0.0 or any(after <= before for before, after in pairwise(times)):
            raise InputError(f"{name}: {len(lines)} lines; expected two or more, at times that rise from 0 on")
        self.name = name
        self.duration = times[-1]
        """Time of the last line [s]."""
        self._lines, self._times, self._clock = tuple(lines), times, clock
        self._start: float | None = None

    def read(self) -> Reading:
        """The line that holds now; from the end on the device is gone."""
        t = self._clock()
        self._start = t if self._start is None else self._start
        since = t - self._start + SLACK
        line = self._lines[max(0, bisect_right(self._times, since) - 1)]
        over = since >= self.duration
        return Reading(
            t=t,
            axes=line.axes,
            buttons=tuple(pressed and not over for pressed in line.buttons),
            age=max(0.0, since - self.duration),
            connected=not over,
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """There is nothing to give back."""


class Recorded:
    """Another device, whose readings are kept, and written to a file when it is left."""

    def __init__(self, device: Device, path: Path) -> None:
        self.name = device.name
        self._device, self._path = device, path
        self._lines: list[Line] = []
        self._start: float | None = None
        self._last = 0.0

    def read(self) -> Reading:
        """The device's reading; no file is touched. Of a report that ages what is left of it is kept."""
        reading = self._device.read()
        self._start = reading.t if self._start is None else self._start
        axes = scaled(reading.axes, freshness(reading.age))
        line = Line(t=reading.t - self._start, axes=axes, buttons=reading.buttons)
        self._last = line.t
        changed = not self._lines or (line.axes, line.buttons) != (self._lines[-1].axes, self._lines[-1].buttons)
        if changed and len(self._lines) < MOST_LINES - 1:
            self._lines.append(line)
            if len(self._lines) == MOST_LINES - 1:
                logger.warning("the script %s is full at %d lines; what follows is not kept", self._path, MOST_LINES)
        return reading

    def __enter__(self) -> Self:
        self._device.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if self._lines and self._last > self._lines[-1].t:
                self._lines.append(Line(t=self._last, axes=AT_REST, buttons=()))
            if len(self._lines) > 1:
                write_script(self._path, self._lines)
        finally:
            self._device.__exit__(kind, error, trace)


def open_script(path: Path, clock: Callable[[], float] = time.monotonic) -> Scripted:
    """A device that plays a file.

    Raises:
        InputError: if it cannot be read or is no such file; the message names the line.
    """
    return Scripted(read_script(path), name=f"script {path}", clock=clock)


def read_script(path: Path) -> list[Line]:
    """The lines of a file.

    Raises:
        InputError: if it cannot be read or is no such file; the message names the line.
    """
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        raise InputError(f"{str(path)!r} cannot be read ({error}); expected a file that begins with {HEAD}") from None
    if len(data) > MAX_BYTES:
        raise InputError(f"{path} is larger than {MAX_BYTES // 2**20} MiB; expected a shorter script: split it")
    try:
        rows = data.decode("ascii").splitlines()
    except UnicodeDecodeError:
        raise InputError(f"{path} is no plain text; expected a file that begins with {HEAD}") from None
    used = [(number, row) for number, row in enumerate(rows, 1) if row.strip() and not row.startswith("#")]
    if not used or used[0][1].replace(" ", "") != HEAD:
        raise InputError(f"{path} begins with {used[0][1][:60] if used else ''!r}; expected {HEAD}")
    if len(used) - 1 > MOST_LINES:
        raise InputError(f"{path} has {len(used) - 1} lines; expected at most {MOST_LINES}: split it")
    return [_line(path, number, row.split(",")) for number, row in used[1:]]


def write_script(path: Path, lines: Sequence[Line]) -> None:
    """Write a file that `read_script` reads, whole or not at all, with all digits.

    Raises:
        InputError: if it cannot be written.
    """
    rows = (
        ",".join((*map(repr, (line.t, *line.axes)), "".join(str(int(pressed)) for pressed in line.buttons)))
        for line in lines
    )
    draft = path.with_name(f".{path.name}.draft")
    try:
        draft.write_text("\n".join((HEAD, *rows)) + "\n", encoding="ascii")
        os.replace(draft, path)
    except OSError as error:
        raise InputError(f"{path} cannot be written ({error.strerror}); name a file in a folder of yours") from None


def _line(path: Path, number: int, words: list[str]) -> Line:
    """One line, checked word by word."""
    try:
        t, *axes = (float(word) if NUMBER.fullmatch(word.strip()) else nan for word in words[:7])
        values = six(axes)
    except ValueError:
        raise InputError(
            f"{path}, line {number}: found {len(words)} words; expected seven numbers, and buttons"
        ) from None
    if not 0.0 <= t <= LONGEST or not all(-1.0 <= value <= 1.0 for value in values):
        raise InputError(
            f"{path}, line {number}: a time or an axis is no number in its range; expected axes in [-1, 1]"
        )
    buttons = words[7].strip() if len(words) == 8 else "?"
    if len(buttons) > MOST_BUTTONS or not set(buttons) <= {"0", "1"}:
        raise InputError(f"{path}, line {number}: expected eight words, the last a 0 or 1 for each button, such as 01")
    return Line(t=t, axes=values, buttons=tuple(button == "1" for button in buttons))
