"""``burnish plan``: the tool path alone, checked, as JSON."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from burnish.commands.options import check_writable
from burnish.errors import InputError
from burnish.model.model import Model
from burnish.model.tool import PolishingTool
from burnish.polish.cell import nominal_placement, tool_down
from burnish.polish.cellsim import check_size, plan_strokes
from burnish.polish.feasible import follow
from burnish.polish.process import timed
from burnish.polish.recipe import Recipe
from burnish.polish.stroke import Stroke, as_plan
from burnish.surface import DistanceGrid, Mould


def run(options: argparse.Namespace) -> int:
    """Plan, check, write; nothing is written when the plan is refused."""
    path = Path(options.out)
    if path.is_dir():
        raise InputError(f"--out {path} is a folder; expected a file name such as plan.json")
    check_writable(path.parent)
    recipe = Recipe(force=options.force, feed=options.feed)
    mould = Mould.load(options.mould, options.unit)
    tool = PolishingTool()
    check_size(mould, tool)
    grid = DistanceGrid.of(mould)
    strokes = plan_strokes(mould, grid, recipe, tool)
    share = check_strokes(strokes, tool)
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(path.name + ".part")
    part.write_text(json.dumps(as_plan(strokes)))
    part.replace(path)
    length = sum(stroke.length for stroke in strokes)
    print(f"{mould.name}: {len(strokes)} strokes, {length:.2f} m, {100 * share:.0f} % of joint speed at most → {path}")
    return 0


def check_strokes(strokes: list[Stroke], tool: PolishingTool) -> float:
    """Largest share of joint speed over all strokes, where the mould is meant to stand.

    Raises:
        PlanError: if the arm cannot follow one of them.
    """
    model = tool.on(Model.jaco2())
    placement = nominal_placement(max(float(stroke.points[:, 2].max()) for stroke in strokes))
    upright = tool_down(model)
    return max(follow(model, timed(stroke, placement, upright)).speed_share for stroke in strokes)
