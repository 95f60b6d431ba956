"""From a recipe to the strokes over a mould: the passes one after the other, each in a short order."""

from __future__ import annotations

from dataclasses import replace

from burnish.paths.order import ordered
from burnish.paths.patterns import Raster
from burnish.paths.reach import Reach
from burnish.paths.stroke import Stroke
from burnish.polish.recipe import MARGIN, Pass, Recipe
from burnish.surface import DistanceGrid, Mould


def planned(recipe: Recipe, mould: Mould, grid: DistanceGrid) -> list[list[Stroke]]:
    """The strokes of each pass, mould frame, at least one a pass.

    Raises:
        PlanError: nothing of the mould is left to work.
    """
    tool = recipe.tool
    reach = Reach.of(mould, grid, tip_radius=tool.tip_radius, margin=MARGIN, modulus=tool.modulus)
    return [_strokes(reach, mould, recipe, one) for one in passes_of(recipe)]


def passes_of(recipe: Recipe) -> tuple[Pass, ...]:
    """The passes of a recipe; one raster where it names none."""
    return recipe.passes or (Pass(pattern=Raster()),)


def _strokes(reach: Reach, mould: Mould, recipe: Recipe, one: Pass) -> list[Stroke]:
    own = recipe.of_pass(one)
    strokes = one.pattern.strokes(reach, mould, step=one.step, feed=own.feed, force=own.force)
    return [replace(stroke, tilt=one.tilt) for stroke in ordered(strokes)]
