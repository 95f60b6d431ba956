"""``burnish plan``: the tool path alone, checked, as JSON."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from burnish.check.collision import Near
from burnish.check.plan import CheckedPlan, check
from burnish.check.ways import jaco2_workplace
from burnish.commands.course import Course
from burnish.commands.mending import Worn
from burnish.commands.options import check_writable
from burnish.commands.order import named
from burnish.commands.progress import Progress
from burnish.errors import InputError
from burnish.polish.cellsim import SLIDE, TURN, check_size, half_size
from burnish.polish.depth import Ground, target
from burnish.polish.even import planned_depth, says
from burnish.polish.plan_file import write_plan
from burnish.polish.recipe import Pass, Recipe
from burnish.polish.recipe_file import PATTERNS, read_recipe
from burnish.surface import Mould
from burnish.surface.access import Access

NOTHING = 1e-5
"""Area that nobody needs to be told of [m²]: a tenth of a square centimetre."""


def run(options: argparse.Namespace) -> int:
    """Plan, check, write; nothing is written when the plan is refused."""
    path = Path(options.out)
    if path.is_dir():
        raise InputError(f"--out {path} is a folder; expected a file name such as plan.json")
    check_writable(path.parent)
    mending = None
    if options.repair is None:
        course, mould = Course(recipe=_recipe(options)), Mould.load(options.mould, named(options.unit))
    else:
        worn = Worn.asked(options)
        with Progress() as progress:
            mending = worn.mending(progress)
        course, mould = mending.course, worn.mould
        print(mending.says)
        if not course.strokes:
            return 0
    recipe = course.recipe
    check_size(mould, recipe.tool)
    grid = course.grid(mould)
    legs = course.legs(mould, grid)
    touched = course.touched(legs, mould, grid)
    points = np.concatenate([stroke.points for stroke in touched])
    place = jaco2_workplace(mould, grid, touched, recipe.tool, uncertainty=SLIDE + TURN * half_size(points))
    plan = check(place, [leg.path for leg in legs], recipe, made_for=mould.sha256, touched=touched)
    write_plan(path, plan.strokes, mould, recipe)
    for line in _table(plan, mould, path, recipe):
        print(line)
    if recipe.even is not None or mending is not None:
        ground = Ground.of(mould, grid, recipe)
        wanted = target(recipe) if mending is None else mending.target
        depth = planned_depth(recipe, ground, plan.strokes) + (0.0 if mending is None else mending.depth)
        print(f"  removal       {says(ground.judged(depth, wanted), wanted)}")
    return 0


def _recipe(options: argparse.Namespace) -> Recipe:
    """The recipe that was asked for, by a file or by options."""
    given = {name: getattr(options, name) for name in ("force", "feed") if getattr(options, name) is not None}
    pattern, file = getattr(options, "pattern", None), getattr(options, "recipe", None)
    if file is not None:
        if given or pattern is not None:
            raise InputError("--recipe names force, feed and pattern already; leave out --force, --feed and --pattern")
        return read_recipe(Path(file))
    return Recipe(**given, passes=() if pattern is None else (Pass(pattern=PATTERNS[pattern]()),))


def _table(plan: CheckedPlan, mould: Mould, path: Path, recipe: Recipe) -> Iterator[str]:
    """The result in a few lines, for a terminal."""
    bounds, speed, torque, margin = recipe.limits, plan.speed, plan.torque, plan.joint_margin
    yield f"{mould.name}: {len(plan.strokes)} strokes, {plan.length:.2f} m, {plan.duration:.0f} s → {path}"
    yield f"  joint speed   {100 * speed.value:4.0f} % of the limit ({speed.what})"
    yield f"  joint torque  {100 * torque.value:4.0f} % of the limit ({torque.what})"
    yield f"  joint limit   {np.rad2deg(margin.value):4.0f}° away ({margin.what})"
    yield f"  singularity   {1e3 * plan.singularity:4.0f} mm a radian (at least {1e3 * bounds.singularity:.0f})"
    yield f"  clearance     {_distance(plan.clearances.around)}"
    if plan.clearances.itself is not None:
        yield f"  of itself     {_distance(plan.clearances.itself)}"
    access = Access.of(mould, recipe.tool.tip_radius)
    hollow = (access.summary,) if access.area(access.out_of_reach | access.tight) > NOTHING else ()
    for note in (*mould.warnings, *hollow, *plan.notes):
        yield f"  note: {note}"


def _distance(near: Near) -> str:
    """A least distance and between what it is."""
    if near.or_more:
        return f"{1e3 * near.distance:4.0f} mm or more"
    return f"{1e3 * near.distance:4.0f} mm ({near.first}, {near.second})"
