"""How a job is run beside what it is: passes, what is skipped, the abrasive's life, and where an earlier run ended."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from math import hypot, inf
from pathlib import Path
from typing import Any

import numpy as np

from burnish.core import Sample
from burnish.errors import InputError, RecordingError
from burnish.paths.stroke import Stroke
from burnish.polish.cell import Placement
from burnish.polish.cellsim import plan_strokes
from burnish.polish.depth import Ground
from burnish.polish.even import evened
from burnish.polish.journal import ENDS, NAME, Mark, mark_of, read
from burnish.polish.moves import Moves, five_touches
from burnish.polish.passes import Leg, after, legs_of, without
from burnish.polish.plan_file import read_plan
from burnish.polish.planned import planned
from burnish.polish.recipe import MOST_PASSES, Pass, Recipe
from burnish.polish.recipe_file import PATTERNS, as_tables, from_tables, read_recipe
from burnish.polish.search import Wide
from burnish.rotation import exp
from burnish.surface import DistanceGrid, Mould

BESIDE = 30e-3
"""Room of the distance grid around a mould that is looked for [m]: a tip and a half."""
PLAN = "plan.json"
"""Strokes of a repair, in its folder."""
LEARNT = 0.5
"""Share of the measured height that a job of several passes takes over from pass to pass."""


@dataclass(frozen=True, kw_only=True)
class Course:
    """The recipe and how it is run; alone, one raster from its beginning to its end."""

    recipe: Recipe = field(default_factory=Recipe)
    """What to do on the mould."""
    repeats: int = 1
    """How often the recipe's passes are done."""
    skipped: frozenset[int] = frozenset()
    """Numbers of the strokes that are left out in every pass, from 1."""
    most_metres: float = inf
    """Path that an abrasive may do before it is changed [m]."""
    search: bool = False
    """Whether the mould may stand centimetres off, and is looked for."""
    stands: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Where the simulated mould really stands off its place: x and y of the base frame [m], yaw [°]."""
    since: Mark | None = None
    """Where an earlier run of the job ended; None begins at the beginning."""
    runs: int = 0
    """Number of the earlier runs."""
    mends: str = ""
    """Folder of the job that this one repairs; empty for one of its own."""
    strokes: tuple[Stroke, ...] = field(default=(), compare=False)
    """Of a repair: what is worked, in place of what the recipe plans."""

    def __post_init__(self) -> None:
        most = max(1, MOST_PASSES // max(1, len(self.recipe.passes)))
        if not 1 <= self.repeats <= most:
            raise InputError(f"--passes {self.repeats} is out of range; expected 1 to {most} with this recipe")
        if not self.most_metres > 0.0:
            raise InputError(f"--abrasive-life {self.most_metres:g} m is out of range; expected more than 0")
        x, y, yaw = self.stands
        if not (hypot(x, y) <= 0.05 and abs(yaw) <= 30.0):
            raise InputError(f"--stands {x:g},{y:g},{yaw:g} is out of range; expected up to 0.05 m and ±30°")
        if (x, y, yaw) != (0.0, 0.0, 0.0) and not self.search:
            raise InputError("--stands moves the mould by more than a plain job looks for; give --search as well")

    @classmethod
    def asked(cls, options: argparse.Namespace) -> Course:
        """From the command line. A recipe's force and feed become those of the options, for whoever reads them next.

        Raises:
            InputError: an option is out of range, or contradicts the recipe.
        """
        if options.recipe is None:
            named = () if options.pattern is None else (Pass(pattern=PATTERNS[options.pattern]()),)
            recipe = Recipe(force=options.force, feed=options.feed, passes=named)
        elif options.pattern is not None:
            raise InputError("--recipe names the patterns of its passes; leave out --pattern")
        else:
            recipe = read_recipe(Path(options.recipe))
            options.force, options.feed = recipe.force, recipe.feed
        metres = inf if options.abrasive_life is None else options.abrasive_life
        return cls(
            recipe=recipe,
            repeats=options.passes,
            skipped=frozenset(options.skip),
            most_metres=metres,
            search=options.search,
            stands=options.stands,
        )

    @property
    def plain(self) -> bool:
        """Whether this is one raster from its beginning to its end, as the order alone says."""
        return self == Course(recipe=Recipe(force=self.recipe.force, feed=self.recipe.feed))

    def grid(self, mould: Mould) -> DistanceGrid:
        """Distance to the mould, wide enough for a tip beside it where it is looked for."""
        return DistanceGrid.of(mould, aside=BESIDE) if self.search else DistanceGrid.of(mould)

    def finder(self) -> Callable[[Moves], Iterator[Sample]]:
        """How the mould is found."""
        return Wide() if self.search else five_touches

    def placed(self, nominal: Placement) -> Placement:
        """Where the simulated mould stands."""
        x, y, yaw = self.stands
        turn = exp(np.array([0.0, 0.0, np.deg2rad(yaw)]))
        return Placement(p=nominal.p + [x, y, 0.0], R=turn @ nominal.R)

    def legs(self, mould: Mould, grid: DistanceGrid) -> list[Leg]:
        """All that is to be worked, in order, done before or not.

        Raises:
            PlanError: nothing of the mould is left to work.
            InputError: a stroke to skip is not there.
        """
        if self.mends:
            return without(legs_of([self.strokes]), self.skipped)
        recipe = self.recipe
        passes = planned(recipe, mould, grid) if recipe.passes else [plan_strokes(mould, grid, recipe, recipe.tool)]
        if recipe.even is not None:
            passes = evened(recipe, Ground.of(mould, grid, recipe), passes)
        return without(legs_of(passes * self.repeats), self.skipped)

    def touched(self, legs: list[Leg], mould: Mould, grid: DistanceGrid) -> list[Stroke]:
        """The strokes along which the mould is touched to find it: those of the whole job."""
        if self.mends:
            # The feed, which takes long to fit, does not matter for that.
            whole = replace(self, mends="", skipped=frozenset(), repeats=1, recipe=replace(self.recipe, even=None))
            legs = whole.legs(mould, grid)
        return [leg.path for leg in legs]

    def left(self, legs: list[Leg]) -> list[Leg]:
        """What an earlier run left of them; nothing when all was done."""
        mark = self.since
        return legs if mark is None else after(legs, mark.number, mark.stroke, mark.s)

    def as_record(self) -> dict[str, Any]:
        """Plain values for the journal's first line and a recording's metadata."""
        return {
            "recipe": as_tables(self.recipe),
            "passes": self.repeats,
            "skip": sorted(self.skipped),
            "search": self.search,
            "stands": list(self.stands),
            "abrasive_life_m": self.most_metres if self.most_metres < inf else None,
        } | ({"mends": self.mends} if self.mends else {})

    def as_metadata(self) -> dict[str, str]:
        """For a recording; nothing for a plain one."""
        if self.plain:
            return {}
        since = None if self.since is None else asdict(self.since)
        return {"course": json.dumps(self.as_record() | {"since": since}, ensure_ascii=False)}

    @classmethod
    def recorded(cls, metadata: Mapping[str, str], folder: Path) -> Course | None:
        """From a recording; None for a plain one.

        Args:
            metadata: of the recording.
            folder: where the recording lies; the strokes of a repair stand beside it.

        Raises:
            RecordingError: it does not describe a job.
            PlanError: the strokes of a repair cannot be read.
        """
        if "course" not in metadata:
            return None
        try:
            told = json.loads(metadata["course"])
            since = None if told["since"] is None else mark_of(told["since"])
            return cls.told(told, folder, since)
        except (IndexError, KeyError, TypeError, ValueError, RecursionError) as error:
            raise RecordingError(f"the recording does not describe its job ({error}); it cannot be run again") from None

    @classmethod
    def told(cls, told: Mapping[str, Any], folder: Path, since: Mark | None, runs: int = 0) -> Course:
        """From `as_record`; whatever is wrong with that is raised as it comes."""
        metres = told["abrasive_life_m"]
        return cls(
            recipe=from_tables(told["recipe"]),
            repeats=int(told["passes"]),
            skipped=frozenset(map(int, told["skip"])),
            search=bool(told["search"]),
            stands=(float(told["stands"][0]), float(told["stands"][1]), float(told["stands"][2])),
            most_metres=inf if metres is None else float(metres),
            since=since,
            runs=runs,
            mends=str(told.get("mends", "")),
            strokes=tuple(read_plan(folder / PLAN)) if "mends" in told else (),
        )


@dataclass(frozen=True, kw_only=True)
class Earlier:
    """A job that was stopped, as its journal tells it."""

    order: Mapping[str, str]
    """Options of the order, as in a recording."""
    course: Course
    """How it was run, and where it ended."""
    mould_sha256: str
    """Fingerprint of its mould."""
    changed: bool
    """Whether it stopped for a new abrasive."""


def unfinished(folder: Path) -> Earlier:
    """The job of a folder, ready to go on.

    Raises:
        RecordingError: there is no journal that can be read, or the job is done.
    """
    job = earlier(folder)
    if job.course.since is not None and job.course.since.phase == "done":
        raise RecordingError(f"the job of {folder} is done; there is nothing to go on with")
    return job


def earlier(folder: Path) -> Earlier:
    """The job of a folder, done or not.

    Raises:
        RecordingError: there is no journal that can be read; or it is a repair whose plan is not there.
    """
    path = folder / NAME
    about, marks = read(path)
    try:
        told, order, mould = about["course"], dict(about["order"]), str(about["mould_sha256"])
        last = marks[-1] if marks else None
        course = Course.told(told, folder, last, 1 + sum(mark.phase in ENDS for mark in marks[:-1]))
    except (IndexError, KeyError, TypeError, ValueError) as error:
        raise RecordingError(f"the first line of {path} does not describe a job ({error}); start it anew") from None
    return Earlier(order=order, course=course, mould_sha256=mould, changed=last is not None and last.phase == "change")
