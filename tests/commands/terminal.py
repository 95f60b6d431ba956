"""A program on a pseudo-terminal: keys are typed, the screen is read, as a person would."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Mapping
from types import TracebackType

import pexpect
import pyte

ROWS, COLUMNS = 40, 110
PATIENCE = 60.0
"""Time that anything gets to appear [s]: the machine may be busy; no test is about how long it takes."""

MOST_READS = 12
"""Pieces of output that are taken in before somebody looks again: about half a second's."""


class Terminal:
    """``burnish`` with these words on a terminal of its own."""

    def __init__(self, *words: str, environment: Mapping[str, str] | None = None) -> None:
        self._screen = pyte.Screen(COLUMNS, ROWS)
        self._stream = pyte.ByteStream(self._screen)
        self.program = pexpect.spawn(
            sys.executable,
            ["-m", "burnish", *words],
            dimensions=(ROWS, COLUMNS),
            env=os.environ | {"TERM": "xterm-256color", "PYTHONUNBUFFERED": "1"} | dict(environment or {}),
            timeout=PATIENCE,
        )
        self.program.delaybeforesend = None

    @property
    def text(self) -> str:
        """What the screen shows."""
        return "\n".join(line.rstrip() for line in self._screen.display)

    def look(self) -> str:
        """Take in what the program has written, up to a few pictures: on a busy machine the next is always there."""
        for _ in range(MOST_READS):
            if not self._take():
                break
        return self.text

    def _take(self) -> bool:
        """Take in what comes soon; false if nothing does."""
        try:
            self._stream.feed(self.program.read_nonblocking(1 << 16, timeout=0.05))
        except (pexpect.TIMEOUT, pexpect.EOF):
            return False
        return True

    def until(self, seen: str | Callable[[str], bool], typing: str = "") -> str:
        """Wait for a text, or until something is true of it; while waiting, a key is held that repeats."""
        there = seen if callable(seen) else lambda text: seen in text
        deadline = time.monotonic() + PATIENCE
        while not there(self.look()):
            assert time.monotonic() < deadline, f"waited in vain for {seen!r}:\n{self.text}"
            assert self.program.isalive() or there(self.look()), f"it ended before {seen!r}:\n{self.text}"
            if typing:
                self.type(typing)
        return self.text

    def row(self, label: str) -> str:
        """The row of the screen that begins with a label."""
        rows = [line for line in self.text.splitlines() if line.startswith(label)]
        return rows[0] if rows else ""

    def type(self, keys: str) -> None:
        """Keys, as a person types them."""
        self.program.send(keys)

    def hang_up(self) -> None:
        """Close the terminal, as when its window is closed; waits until the program has ended."""
        os.close(self.program.child_fd)
        self.program.closed = self.program.ptyproc.closed = True
        os.waitpid(self.program.pid, 0)
        self.program.terminated = self.program.ptyproc.terminated = True

    def ends(self) -> int:
        """The exit status, once it has ended."""
        while self.program.isalive():
            self._take()
        while self._take():
            pass
        self.program.close()
        assert self.program.signalstatus is None, f"killed by signal {self.program.signalstatus}:\n{self.text}"
        return int(self.program.exitstatus)

    def __enter__(self) -> Terminal:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if not self.program.closed:
            self.program.close(force=True)
