"""What is shown while somebody operates the arm, and the process that shows it.

A terminal may be slow, stopped by Ctrl-S, or closed, and drawing takes longer than a control cycle. So it is done by a
process of its own: the loop writes a line of JSON into a pipe, and when the pipe is full the line is dropped.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import asdict, dataclass

from typing_extensions import Self

PATIENCE = 2.0
"""Time that the process gets to leave the terminal in order [s]."""


@dataclass(frozen=True, kw_only=True)
class View:
    """All that is on the screen; what is not measured is None."""

    title: str
    """Arm, rate and law."""
    t: float
    """Time of the arm [s]."""
    mode: str
    """Of the operator."""
    moves: str
    """What it moves, and in whose axes."""
    deadman: str
    """Whether it is held; empty where there is none."""
    p: list[float]
    """Tool position, base frame [m]."""
    angles: list[float]
    """Tool orientation, intrinsic XYZ [deg]."""
    force: list[float] | None
    """Contact force, base axes [N]."""
    q: list[float]
    """Joint positions [deg]."""
    lower: list[float | None]
    """Joint limits [deg]; None for a joint that turns for ever."""
    upper: list[float | None]
    """The same above."""
    slowed: str
    """What slows the operator down; empty where nothing does."""
    device: str
    """What the operator commands with."""
    age: float | None
    """Time since it was last heard [s]; None if it is gone."""
    rate: float
    """Cycles in a second, measured."""
    late: int
    """Late cycles."""
    cycles: int
    """All cycles."""
    supervisor: str
    """Its state."""
    cause: str
    """Why it holds the arm; empty where it does not."""
    buttons: dict[str, str]
    """What each button does now."""
    keys: dict[str, str]
    """What each key does now."""
    note: str = ""
    """The answer to the last key."""
    speed: float = 0.0
    """Of the tool point [m/s]."""
    fingers: float | None = None
    """Angle that the fingers are told to go to, open is 0 [deg]; None where there are none."""


class Screen:
    """The process that draws; leaving the block ends it and leaves the terminal in order."""

    def __enter__(self) -> Self:
        # A session of its own: Ctrl-C is for the arm, and what is on the screen stays until the arm stands.
        self._process = subprocess.Popen(
            [sys.executable, "-m", "burnish.commands.drawn"], stdin=subprocess.PIPE, start_new_session=True, bufsize=0
        )
        assert self._process.stdin is not None, "it was asked for"
        self._pipe = self._process.stdin.fileno()
        os.set_blocking(self._pipe, False)
        self._gone = False
        return self

    def show(self, view: View) -> None:
        """Show this as soon as the terminal can; never waits for it."""
        if self._gone:
            return
        # A pipe takes a line of up to 4 KiB whole or not at all.
        line = json.dumps(asdict(view), separators=(",", ":")) + "\n"
        try:
            os.write(self._pipe, line.encode())
        except BlockingIOError:
            # The terminal is slow: the next one will be newer.
            return
        except OSError:
            self._gone = True

    def __exit__(self, *exception: object) -> None:
        try:
            self._process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
