"""The bench: the one part that is mounted, its recipe, its plan and its job, whoever looks at them.

No browser here: pages show what the bench holds and call what it does. All calls may come from any thread.
"""

from __future__ import annotations

import json
import tempfile
import threading
from collections.abc import Callable, Mapping
from datetime import datetime
from pathlib import Path
from typing import Any, Protocol

from burnish.core import Array
from burnish.errors import BurnishError, InputError, RecordingError
from burnish.gui import words
from burnish.gui.part import WORKSHOP, Part
from burnish.gui.planning import Planner, Preview
from burnish.gui.stage import BUSY, LIVE, Stage, ended
from burnish.gui.wish import Edits, Wish
from burnish.library import Library, RecipeRow, RunRow
from burnish.polish.cell import HOME
from burnish.polish.journal import NAME, read
from burnish.polish.recipe_file import write_recipe
from burnish.runtime.mailbox import Glance, Mailbox


class Started(Protocol):
    """A job in a process of its own."""

    box: Mailbox
    """What is shared with it."""

    @property
    def outcome(self) -> int | None:
        """Its exit status; None while it runs."""

    @property
    def said(self) -> str:
        """The last lines that it had to say."""

    def pause(self) -> None:
        """Ask it to come to rest, to go on later."""

    def stop(self) -> None:
        """Ask it to come to rest and to end."""


Launch = Callable[[list[str], int | None], Started]
"""Starts a job: the words of a command line, without the program's name, and the client who commands it."""


class Bench:
    """What a workshop has under way."""

    def __init__(self, library: Library, launch: Launch) -> None:
        """An empty bench."""
        self.library = library
        self.lock = threading.RLock()
        self.planner = Planner()
        self.edits = Edits()
        self.part: Part | None = None
        self.preview: Preview | None = None
        self.stage = Stage.EMPTY
        self.trouble = ""
        """What went wrong last, in one sentence; empty if nothing did."""
        self.line: list[str] = []
        """The command line of the job that runs or ran last."""
        self.folder: Path | None = None
        """Where it writes."""
        self.metrics: Mapping[str, Any] = {}
        """What the last job reached."""
        self.job: Started | None = None
        self.shown = HOME
        """Joint positions in the picture while no job runs [rad]."""
        self.looked = 0
        """Grows with every change that a page has to show."""
        self._launch = launch

    @property
    def runs(self) -> Path:
        """Folder of the jobs."""
        return self.library.root / WORKSHOP / "runs"

    @property
    def live(self) -> bool:
        """Whether an arm is in motion."""
        return self.stage in LIVE

    @property
    def taught(self) -> bool:
        """Whether the job is a lesson, of which nobody knows how long it will be."""
        return self.line[:1] == ["teach"]

    def glance(self) -> Glance | None:
        """What the running job shows."""
        job = self.job
        return None if job is None else job.box.latest()

    # What is worked, and how.

    def mount(self, part: Part) -> None:
        """Put a part onto the bench; the plan of the one before is gone.

        Raises:
            InputError: the arm is at work, or a plan is being made.
        """
        with self.lock:
            self._idle()
            self.part, self.preview, self.trouble, self.metrics = part, None, "", {}
            self.stage = Stage.CHOSEN
            self._changed()

    def edit(self, change: Callable[[Wish], Wish]) -> None:
        """Change the wish; an old plan is no longer of it.

        Raises:
            InputError: the arm is at work, or the change is out of range.
        """
        with self.lock:
            self._idle()
            if self.edits.change(change(self.edits.now)):
                self._forget_plan()

    def undo(self) -> None:
        """Take the last edit back, if there is one."""
        with self.lock:
            self._idle()
            if self.edits.undo():
                self._forget_plan()

    def redo(self) -> None:
        """Do again what was undone last, if anything was."""
        with self.lock:
            self._idle()
            if self.edits.redo():
                self._forget_plan()

    def keep_recipe(self, name: str) -> RecipeRow:
        """Enter the recipe into the library under a name.

        Raises:
            InputError: the name is none.
        """
        with self.lock, tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "recipe.toml"
            write_recipe(self.edits.now.recipe, path)
            row = self.library.add_recipe(path, name=name.strip() or None)
            self._changed()
            return row

    def plan(self) -> None:
        """Plan the path in a process of its own; `preview` holds what becomes of it.

        Raises:
            InputError: nothing is mounted, or the arm is at work.
        """
        with self.lock:
            self._idle()
            part = self._mounted()
            self.stage, self.preview, self.trouble = Stage.PLANNING, None, ""
            self.planner.start(part.source, part.unit, self.edits.now.recipe, self._planned)
            self._changed()

    def cancel_plan(self) -> None:
        """Give the plan up."""
        with self.lock:
            if self.stage is Stage.PLANNING:
                self.planner.cancel()
                self.stage = Stage.CHOSEN
                self._changed()

    def _planned(self, preview: Preview) -> None:
        with self.lock:
            if self.stage is Stage.PLANNING:
                self.preview = preview
                self.stage = Stage.READY if preview.refusal is None else Stage.REFUSED
                self._changed()

    # The job.

    def start(self, client: int | None) -> None:
        """Start what was planned, commanded by this client.

        Raises:
            InputError: there is no plan, or the arm is at work.
        """
        with self.lock:
            if self.stage not in (Stage.READY, Stage.DONE) or self.preview is None:
                raise InputError("there is no checked plan; plan the path first")
            folder = self.new_folder("polish")
            folder.mkdir(parents=True, exist_ok=True)
            recipe = folder / "recipe.toml"
            write_recipe(self.edits.now.recipe, recipe)
            part = self._mounted()
            self.run(self.edits.now.words(part.source, part.unit, recipe, folder), folder, client)

    def resume(self, client: int | None, folder: Path | None = None) -> None:
        """Go on with the job of a folder; without one with the last job.

        Raises:
            InputError: there is none, or the arm is at work.
            RecordingError: it cannot be gone on with.
        """
        with self.lock:
            self._idle()
            folder = self.folder if folder is None else folder
            if folder is None:
                raise InputError("there is no job to go on with")
            if not resumable(folder):
                raise RecordingError(f"the job of {folder.name} is done, or has no journal; start it anew")
            mould = [] if self.part is None else ["--mould", self.part.source]
            self.run(["polish", *mould, "--resume", str(folder)], folder, client)

    def repair(self, client: int | None) -> None:
        """Work again what the last job left under target, as a job of its own.

        Raises:
            InputError: the last job is not done, or the arm is at work.
        """
        with self.lock:
            self._idle()
            if self.stage is not Stage.DONE or self.folder is None:
                raise InputError("there is no job whose result could be repaired; polish first")
            part, folder = self._mounted(), self.new_folder("repair")
            line = ["polish", "--mould", part.source, "--repair", str(self.folder), "--out", str(folder)]
            self.run(line, folder, client)

    def run(self, line: list[str], folder: Path, client: int | None) -> None:
        """Start a verb whose results go to a folder.

        Raises:
            InputError: the arm is at work.
        """
        with self.lock:
            self._idle()
            self.line, self.folder, self.metrics, self.trouble = line, folder, {}, ""
            self.job = self._launch(line, client)
            self.stage = Stage.RUNNING
            self._changed()

    def pause(self) -> None:
        """Ask the job to come to rest, to go on later."""
        self._end(lambda job: job.pause())

    def stop(self) -> None:
        """Ask the job to come to rest and to end."""
        self._end(lambda job: job.stop())

    def _end(self, ask: Callable[[Started], None]) -> None:
        with self.lock:
            if self.job is not None and self.stage in LIVE:
                ask(self.job)
                self.stage = Stage.ENDING
                self._changed()

    def press(self, key: str) -> None:
        """A key of teaching or replaying."""
        with self.lock:
            if self.job is not None and self.stage in LIVE:
                self.job.box.press(key)

    def jog(self, twist: Array) -> None:
        """Move the tool of a lesson like this for a moment, (6,) in [-1, 1]."""
        job = self.job
        if job is not None and self.stage is Stage.RUNNING:
            job.box.jog(twist)

    def pose(self, q: Array) -> None:
        """Show the arm like this while no job does; nothing moves."""
        with self.lock:
            self._idle()
            self.shown = q
            self._changed()

    def look(self) -> None:
        """Note whether the job has ended; called a few times a second."""
        with self.lock:
            if self.stage not in LIVE or self.job is None or self.job.outcome is None or self.folder is None:
                return
            code, self.metrics = self.job.outcome, metrics_of(self.folder)
            report = (self.folder / "report.html").is_file()
            self.stage = ended(code, paused=self.line[0] == "polish" and resumable(self.folder), report=report)
            if code != 0:
                last = self.job.box.latest()
                said = last.cause if code == 3 and last is not None and last.cause else words.refusal(self.job.said)
                self.trouble = f"The job was {words.ending(code)}" + (f": {said}" if said and code != 130 else ".")
            self._changed()

    @property
    def report(self) -> Path | None:
        """The page that the last job left, if it did."""
        found = None if self.folder is None else self.folder / "report.html"
        return found if found is not None and found.is_file() else None

    def folder_of(self, row: RunRow) -> Path:
        """Where a run of the library was made.

        Raises:
            InputError: the folder is gone.
        """
        folder = Path(row.folder)
        if not folder.is_dir():
            raise InputError(f"the folder of {row.name}, {folder}, is gone; the job cannot be gone on with")
        return folder

    def new_folder(self, verb: str) -> Path:
        """Where a new job writes."""
        return self.runs / f"{datetime.now():%Y-%m-%d_%H-%M-%S}_{verb}"

    def close(self) -> None:
        """End planning; a job is the server's."""
        self.planner.cancel()

    def _mounted(self) -> Part:
        if self.part is None:
            raise InputError("no mould is chosen; choose one first")
        return self.part

    def _idle(self) -> None:
        if self.stage in BUSY:
            raise InputError("a plan is being made" if self.stage is Stage.PLANNING else "the arm is at work")

    def _forget_plan(self) -> None:
        self.preview, self.trouble = None, ""
        self.stage = Stage.EMPTY if self.part is None else Stage.CHOSEN
        self._changed()

    def _changed(self) -> None:
        self.looked += 1


def resumable(folder: Path) -> bool:
    """Whether the job of a folder can be gone on with."""
    try:
        _, marks = read(folder / NAME)
    except BurnishError:
        return False
    return not marks or marks[-1].phase != "done"


def metrics_of(folder: Path) -> Mapping[str, Any]:
    """What a run has reached; nothing where it left no figures."""
    try:
        found = json.loads((folder / "metrics.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}
