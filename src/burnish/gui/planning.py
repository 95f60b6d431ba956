"""A plan made in a process of its own: the page stays awake, shows how far it is, and can end it."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import threading
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection

import numpy as np

from burnish.errors import BurnishError
from burnish.gui.paint import Canvas, Paint
from burnish.gui.refusal import Refusal, explained
from burnish.paths.stroke import Stroke
from burnish.polish.cell import nominal_placement
from burnish.polish.recipe import Recipe
from burnish.surface import Mould

CRASHED = "The planner ended without an answer"
STAGES = ("reading the mould", "looking where the tool fits", "laying the path", "checking the arm's way")
"""What is done, in order."""


@dataclass(frozen=True, kw_only=True)
class Preview:
    """What became of a plan."""

    strokes: tuple[Stroke, ...] = ()
    """The strokes, mould frame; those that were laid before it was refused, if it was."""
    notes: tuple[str, ...] = ()
    """What was changed or could not be checked, one sentence each."""
    length: float = 0.0
    """Of all strokes [m]."""
    duration: float = 0.0
    """Time of the strokes, without the ways between them [s]."""
    target: float = 0.0
    """Depth that the plan takes off in the middle of what it works [m]."""
    refusal: Refusal | None = None
    """Why it cannot be done; None if it can."""


class Planner:
    """Makes one plan at a time."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._process: multiprocessing.process.BaseProcess | None = None
        self.stage = ""
        """What is being done; empty if nothing is."""
        self.share = 0.0
        """How far it is, 0 to 1."""

    @property
    def busy(self) -> bool:
        """Whether a plan is being made."""
        return self._process is not None

    def start(self, mould: str, unit: str, recipe: Recipe, done: Callable[[Preview], None]) -> None:
        """Make a plan; one that is under way is given up.

        Args:
            mould: bundled name or path of the file.
            unit: of that file, or ``auto``.
            recipe: what to do on it.
            done: is given the result, in a thread of its own; never called if the plan is given up.
        """
        self.cancel()
        context = multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe(duplex=False)
        process = context.Process(target=work, args=(theirs, mould, unit, recipe), name="planner", daemon=True)
        with self._lock:
            self._process, self.stage, self.share = process, STAGES[0], 0.0
            process.start()
        theirs.close()
        threading.Thread(target=self._listen, args=(process, ours, done), name="planner", daemon=True).start()

    def cancel(self) -> None:
        """Give up what is under way, if anything is."""
        with self._lock:
            process, self._process, self.stage = self._process, None, ""
        if process is not None:
            process.kill()
            process.join()

    def _listen(
        self, process: multiprocessing.process.BaseProcess, pipe: Connection, done: Callable[[Preview], None]
    ) -> None:
        """The thread: stages until there is a result, or the process ends."""
        result = None
        with pipe, contextlib.suppress(EOFError, OSError):
            while result is None:
                message = pipe.recv()
                if isinstance(message, Preview):
                    result = message
                else:
                    self.stage, self.share = message
        with self._lock:
            if self._process is not process:
                return
            # The stage stays what is said until whoever waits has the result.
            self._process = None
        process.join()
        if result is None:
            why = f"{CRASHED} (exit status {process.exitcode})."
            result = Preview(
                refusal=Refusal(why=why, remedy="Plan again; a smaller or coarser mould needs less memory.")
            )
        done(result)


def work(pipe: Connection, mould: str, unit: str, recipe: Recipe) -> None:
    """The process: tells its stages, then the result."""
    # Whoever commands must be heard while a plan is made.
    os.nice(10)

    def tell(stage: int) -> None:
        pipe.send((STAGES[stage], stage / len(STAGES)))

    pipe.send(preview(mould, unit, recipe, tell))
    pipe.close()


def preview(name: str, unit: str, recipe: Recipe, tell: Callable[[int], None]) -> Preview:
    """Plan and check a job as ``burnish polish`` does.

    Args:
        name: bundled name or path of the mould.
        unit: of its file, or ``auto``.
        recipe: what to do.
        tell: is told the number of each stage.
    """
    # The engines are loaded by the process that needs them.
    from burnish.check.plan import check
    from burnish.check.ways import jaco2_workplace
    from burnish.commands.course import Course
    from burnish.polish.cellsim import SLIDE, TURN, check_size, half_size

    strokes: list[Stroke] = []
    placement = None
    try:
        tell(0)
        mould = Mould.load(name, None if unit == "auto" else unit)
        placement = nominal_placement(float(mould.vertices[:, 2].max()))
        check_size(mould, recipe.tool)
        tell(1)
        course = Course(recipe=recipe)
        grid = course.grid(mould)
        tell(2)
        strokes = [leg.path for leg in course.legs(mould, grid)]
        tell(3)
        every = np.concatenate([stroke.points for stroke in strokes])
        place = jaco2_workplace(mould, grid, strokes, recipe.tool, uncertainty=SLIDE + TURN * half_size(every))
        plan = check(place, strokes, recipe)
    except BurnishError as error:
        return Preview(strokes=tuple(strokes), refusal=explained(" ".join(str(error).split()), placement))
    return Preview(
        strokes=plan.strokes,
        notes=(*mould.warnings, *plan.notes),
        length=plan.length,
        duration=plan.duration,
        target=planned_depth(mould, plan.strokes, recipe),
    )


def planned_depth(mould: Mould, strokes: tuple[Stroke, ...], recipe: Recipe) -> float:
    """Depth that the strokes take off at half of the places that they touch, or more [m]."""
    paint = Paint(canvas=Canvas.of(mould), tool=recipe.tool)
    for stroke in strokes:
        step = np.gradient(stroke.arc)
        paint.rub(stroke.points, stroke.force, step)
    touched = paint.depth[paint.depth > 0.0]
    return float(np.median(touched)) if len(touched) else paint.target
