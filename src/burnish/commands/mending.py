"""The repair of an earlier job: what it left under target, and the strokes that add that, as a job of its own."""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from burnish.analysis.metrics import Scalar
from burnish.commands.course import PLAN, Course, Earlier, earlier
from burnish.commands.judged import BEFORE, REMOVED, keep, removed, same_mould
from burnish.commands.order import Order
from burnish.commands.progress import Progress
from burnish.core import Array
from burnish.errors import InputError
from burnish.finish.removal import Coverage
from burnish.finish.repair import repair
from burnish.polish.depth import Ground, target
from burnish.polish.even import dwell_of
from burnish.polish.plan_file import write_plan
from burnish.surface import Mould, bundled

OWN = ("resume", "recipe", "pattern")
"""Options that say what the folder of a job says already."""


@dataclass(frozen=True, kw_only=True)
class Mending:
    """What an earlier job left, and the job that repairs it."""

    course: Course
    """How the repair is run; it has no strokes where nothing is to be done."""
    depth: Array
    """What was removed before [m], (V,)."""
    before: Coverage
    """How even that is."""
    target: float
    """What was wanted [m]."""
    zones: int
    """Places that lack depth."""

    def begin(self, folder: Path, mould: Mould) -> None:
        """Write into the folder of the repair what it is to do, and what was removed before."""
        folder.mkdir(parents=True, exist_ok=True)
        write_plan(folder / PLAN, self.course.strokes, mould, self.course.recipe)
        for name in (BEFORE, REMOVED):
            keep(folder, self.depth, mould, name)

    @property
    def says(self) -> str:
        """What is there, and what is to be done, in one line."""
        found = (
            f"removal {1e6 * self.before.mean:.3g} of {1e6 * self.target:.3g} µm, ±{self.before.cv_pct:.1f} %, "
            f"coverage {self.before.covered_pct:.1f} %"
        )
        if not self.zones:
            return f"nothing lacks: {found}; no repair is needed"
        places = "1 place" if self.zones == 1 else f"{self.zones} places"
        if not self.course.strokes:
            return f"nothing to repair: no stroke over {places} with less depth would make it more even: {found}"
        length = sum(stroke.length for stroke in self.course.strokes)
        return f"repair of {places}: strokes {len(self.course.strokes)}, {length:.2f} m; before: {found}"


@dataclass(frozen=True, kw_only=True)
class Worn:
    """An earlier job and its part, ready for a repair to be planned."""

    folder: Path
    """Of the job."""
    job: Earlier
    """What it was."""
    order: Order
    """Its options."""
    mould: Mould
    """Its part."""

    @classmethod
    def asked(cls, options: argparse.Namespace) -> Worn:
        """From the command line: the job of the folder ``--repair``, done or stopped.

        The file of a mould that is not bundled has to be given: what the journal names is never opened.

        Raises:
            RecordingError: there is no such job, or the mould is another one.
            InputError: its tool does not spin, or an option says what the folder says already.
        """
        folder, mould = Path(options.repair), options.mould
        given = [name for name in OWN if getattr(options, name, None) is not None]
        if given:
            raise InputError(f"--repair takes all from {folder}; leave out --{given[0]}")
        job = earlier(folder)
        if job.course.recipe.tool.spindle == 0.0:
            raise InputError(
                f"the tool of {folder} did not spin, and removes by distance: no feed adds what lacks. Work the places "
                "again with a pattern of your own, or state a spindle in the recipe"
            )
        order = Order.recorded(job.order, None if mould in bundled.NAMES else mould)
        part = order.part()
        same_mould(part, job, folder)
        return cls(folder=folder, job=job, order=order, mould=part)

    def mending(self, progress: Progress) -> Mending:
        """Plan the repair; ``progress`` is told what is being done.

        Raises:
            RecordingError: what was removed is not known.
            PlanError: the tool does not spin fast enough.
        """
        course, recipe = self.job.course, self.job.course.recipe
        progress.stage("planning the repair")
        grid = course.grid(self.mould)
        ground = Ground.of(self.mould, grid, recipe)
        depth = removed(self.folder, self.mould, len(ground.counted), REMOVED)
        wanted = target(recipe) * course.repeats
        whole = replace(course, mends="", strokes=(), skipped=frozenset(), repeats=1, since=None)
        # The lines of the last pass, whose lay the part shows; their feed is made anew.
        legs = replace(whole, recipe=replace(recipe, even=None)).legs(self.mould, grid)
        strokes = [leg.path for leg in legs if leg.number == legs[-1].number]
        plan = repair(dwell_of(recipe), ground.surface, strokes, depth, wanted, ground.counted)
        mends = replace(
            course, mends=str(self.folder), strokes=plan.strokes, skipped=frozenset(), since=None, runs=0
        )  # fmt: skip
        return Mending(
            course=mends, depth=depth, before=ground.judged(depth, wanted), target=wanted, zones=plan.zones
        )  # fmt: skip


def wishes(course: Course) -> dict[str, Scalar]:
    """What a report says of the spindle, of an even depth and of a repair, where there are such."""
    said: dict[str, Scalar] = {}
    tool, even = course.recipe.tool, course.recipe.even
    if tool.spindle != 0.0:
        said["spindle [rpm]"] = round(tool.spindle * 30.0 / np.pi, 1)
    if even is not None:
        said["even depth [µm]"] = 1e6 * even.depth
        said["feed fitted within [mm/s]"] = f"{1e3 * even.slowest:g} to {1e3 * even.fastest:g}"
    if course.mends:
        said["repair of the job in"] = course.mends
    return said
