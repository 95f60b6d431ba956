"""A bench without a browser and without a real job: what the tests of the workshop share."""

from __future__ import annotations

from contextlib import contextmanager
from itertools import count
from pathlib import Path

import numpy as np
import trimesh
import viser

from burnish.gui.bench import Bench
from burnish.library import Library
from burnish.polish.cell import HOME
from burnish.runtime.machine import Mode
from burnish.runtime.mailbox import Glance, Mailbox

CHROMIUM = Path("/usr/bin/chromium")
FLAGS = (
    "--no-sandbox --use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader --disable-quic --no-first-run "
    "--disable-background-networking --disable-component-update --disable-sync"
).split()
"""WebGL without a graphics card, and a browser that does not ask its maker for anything."""


_MAILBOXES = count()


class FakeJob:
    """A job that does nothing but remember what it was told."""

    def __init__(self, line: list[str], folder: Path) -> None:
        self.line = line
        self.box = Mailbox.create(folder / f"mailbox-{next(_MAILBOXES)}")
        self.outcome: int | None = None
        self.said = ""
        self.asked: list[str] = []

    def pause(self) -> None:
        self.asked.append("pause")

    def stop(self) -> None:
        self.asked.append("stop")


class Hand:
    """A command that is given and taken by the test."""

    def __init__(self, *, mine: bool = True) -> None:
        self.mine = mine

    @property
    def free(self) -> bool:
        return not self.mine

    def take(self) -> None:
        self.mine = True


def block(folder: Path, side: float = 40.0) -> Path:
    """A small flat part as an STL file in millimetres: quickly planned and quickly polished."""
    path = folder / "block.stl"
    trimesh.creation.box([side, side, 10.0]).export(path)
    return path


@contextmanager
def bench(folder: Path):
    """A bench whose jobs are fakes; they are listed in `jobs`."""
    jobs: list[FakeJob] = []

    def launch(line: list[str], client: int | None) -> FakeJob:
        jobs.append(FakeJob(line, folder))
        return jobs[-1]

    with Library.open(folder / "library") as library:
        found = Bench(library, launch)
        found.jobs = jobs
        yield found
        found.close()


@contextmanager
def gui():
    """The GUI of a server that no browser looks at."""
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        yield server.gui
    finally:
        server.stop()


def glance(**changed) -> Glance:
    """An arm at work."""
    values = {
        "wall": 0.0, "t": 1.0, "phase": "pass", "mode": Mode.TORQUE, "cause": "", "stroke": 2, "strokes": 9,
        "done": 0.25, "q": HOME, "dq": np.zeros(6), "tau": np.zeros(6), "p": np.zeros(3), "R": np.eye(3),
        "v": np.zeros(6), "force": 9.8, "force_set": 10.0, "feed": 0.019, "feed_set": 0.02, "tilt": 0.01,
        "late_cycles": 3,
    }  # fmt: skip
    return Glance(**(values | changed))
