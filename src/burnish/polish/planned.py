"""From a recipe to the strokes over a mould: the passes one after the other, each in a short order."""

from __future__ import annotations

import numpy as np

from burnish.errors import InputError
from burnish.paths.order import ordered
from burnish.paths.patterns import Raster
from burnish.paths.reach import Reach
from burnish.paths.stroke import Stroke
from burnish.paths.tilt import Tilt
from burnish.polish.recipe import MARGIN, Pass, Recipe
from burnish.surface import DistanceGrid, Mould


def planned(recipe: Recipe, mould: Mould, grid: DistanceGrid) -> list[list[Stroke]]:
    """The strokes of each pass, mould frame, at least one a pass.

    Raises:
        PlanError: nothing of the mould is left to work.
        InputError: a pass leans the tool, which a job cannot drive.
    """
    tool = recipe.tool
    reach = Reach.of(mould, grid, tip_radius=tool.tip_radius, margin=MARGIN, modulus=tool.modulus)
    return [_strokes(reach, mould, recipe, number, one) for number, one in enumerate(passes_of(recipe), 1)]


def passes_of(recipe: Recipe) -> tuple[Pass, ...]:
    """The passes of a recipe; one raster where it names none."""
    return recipe.passes or (Pass(pattern=Raster()),)


def _strokes(reach: Reach, mould: Mould, recipe: Recipe, number: int, one: Pass) -> list[Stroke]:
    if one.tilt != Tilt():
        raise InputError(
            f"pass {number} leans the tool by {np.rad2deg(one.tilt.angle):.3g}°; expected tilt = 0: a job holds "
            "its tool along the normal"
        )
    own = recipe.of_pass(one)
    return ordered(one.pattern.strokes(reach, mould, step=one.step, feed=own.feed, force=own.force))
