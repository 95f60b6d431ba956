"""`Process`: a job in a process of its own, started as a person would type it, commanded and watched by a mailbox."""

from __future__ import annotations

import math
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import IO

from burnish.gui.lease import Grant
from burnish.runtime.mailbox import Mailbox, Order

MEMORY = Path("/dev/shm")
"""Files that are on no disk: writing them never waits for one."""
PREFIX = "burnish-job-"
"""With what the name of a job's folder begins; the number of the server's process follows."""
TAIL = 8192
"""What is kept of a job's words [bytes]."""
PATIENCE = 60.0
"""Time that a job has for its arm to come to rest and its report to be written [s]."""


class Process:
    """One run of a verb. Nothing here ends it by force: it comes to rest by itself when it is told to, or abandoned."""

    def __init__(self, words: Sequence[str], grant: Grant) -> None:
        """Start ``burnish words… --live MAILBOX``, commanded by whoever holds this grant, and nobody else."""
        self.words, self.grant = tuple(words), grant
        where = MEMORY if MEMORY.is_dir() else Path(tempfile.gettempdir())
        swept(where)
        self._folder = Path(tempfile.mkdtemp(prefix=f"{PREFIX}{os.getpid()}-", dir=where))
        self.box = Mailbox.create(self._folder / "mailbox")
        self.box.beat()
        self._log: IO[bytes] = (self._folder / "log").open("w+b")
        command = [sys.executable, "-m", "burnish", *words, "--live", str(self.box.path)]
        self._process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=self._log, stderr=subprocess.STDOUT, start_new_session=True
        )

    @property
    def outcome(self) -> int | None:
        """Exit status of the verb; None while it runs.

        0 done, 2 refused, 3 the supervisor stopped the arm, 130 ended early; a negative one for a process that died.
        """
        return self._process.poll()

    @property
    def said(self) -> str:
        """The last lines that the job printed: its warnings, a refusal, its result."""
        size = self._log.seek(0, 2)
        self._log.seek(max(0, size - TAIL))
        return self._log.read().decode("utf-8", "replace")

    def beat(self, grant: Grant, at: float) -> None:
        """The commander was there at this time of `time.monotonic` [s]; another's beats are not heeded."""
        if grant == self.grant and self.outcome is None:
            self.box.beat(at)

    def lost(self, grant: Grant) -> None:
        """The commander is gone for sure: the arm is held in the next cycle."""
        if grant == self.grant:
            self.box.beat(-math.inf)

    def pause(self) -> None:
        """Come to rest, to go on later by ``--resume``."""
        self.box.order(Order.PAUSE)

    def stop(self) -> None:
        """Come to rest and end."""
        self.box.order(Order.STOP)

    def wait(self, timeout: float = PATIENCE) -> int | None:
        """The exit status; None if it still runs after this time [s]."""
        try:
            return self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            return None

    def close(self) -> int | None:
        """Order a stop, wait for the arm to be at rest, and give the mailbox back; None if the job still runs.

        Nobody beats for it in this time but its commander: without one the arm is held at once. A job that still runs
        then is left to its supervisor, and its mailbox with it.
        """
        self.stop()
        outcome = self.wait()
        if outcome is not None:
            self._log.close()
            self.box.close()
            shutil.rmtree(self._folder, ignore_errors=True)
        return outcome


def swept(where: Path) -> None:
    """Remove what servers that are no more have left; a job that still runs keeps the memory it has mapped."""
    for folder in where.glob(f"{PREFIX}*-*"):
        number = folder.name.removeprefix(PREFIX).partition("-")[0]
        if number.isdigit() and not Path(f"/proc/{number}").exists():
            shutil.rmtree(folder, ignore_errors=True)
