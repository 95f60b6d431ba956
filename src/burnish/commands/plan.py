"""``burnish plan``: the tool path alone, checked, as JSON."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from burnish.check.collision import Near
from burnish.check.plan import CheckedPlan, check
from burnish.check.ways import jaco2_workplace
from burnish.commands.options import check_writable
from burnish.commands.order import AUTO
from burnish.errors import InputError
from burnish.paths.stroke import Stroke
from burnish.polish.cellsim import SLIDE, TURN, check_size, half_size, plan_strokes
from burnish.polish.plan_file import write_plan
from burnish.polish.planned import planned
from burnish.polish.recipe import Pass, Recipe
from burnish.polish.recipe_file import PATTERNS, read_recipe
from burnish.surface import DistanceGrid, Mould
from burnish.surface.access import Access

NOTHING = 1e-5
"""Area that nobody needs to be told of [m²]: a tenth of a square centimetre."""


def run(options: argparse.Namespace) -> int:
    """Plan, check, write; nothing is written when the plan is refused."""
    path = Path(options.out)
    if path.is_dir():
        raise InputError(f"--out {path} is a folder; expected a file name such as plan.json")
    check_writable(path.parent)
    recipe = _recipe(options)
    mould = Mould.load(options.mould, None if options.unit == AUTO else options.unit)
    check_size(mould, recipe.tool)
    grid = DistanceGrid.of(mould)
    strokes = _strokes(recipe, mould, grid)
    points = np.concatenate([stroke.points for stroke in strokes])
    place = jaco2_workplace(mould, grid, strokes, recipe.tool, uncertainty=SLIDE + TURN * half_size(points))
    plan = check(place, strokes, recipe, made_for=mould.sha256)
    write_plan(path, plan.strokes, mould, recipe)
    for line in _table(plan, mould, path, recipe):
        print(line)
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


def _strokes(recipe: Recipe, mould: Mould, grid: DistanceGrid) -> list[Stroke]:
    """The strokes of all passes; without passes those of ``burnish polish``."""
    if not recipe.passes:
        return plan_strokes(mould, grid, recipe, recipe.tool)
    return [stroke for strokes in planned(recipe, mould, grid) for stroke in strokes]


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
