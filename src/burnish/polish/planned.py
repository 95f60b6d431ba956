"""From a recipe to the strokes over a mould: the passes one after the other, each in a short order."""

from __future__ import annotations

from dataclasses import replace

from burnish.paths.ease import duration, eased
from burnish.paths.hertz import contact_radius
from burnish.paths.order import ordered
from burnish.paths.patterns import Polyline
from burnish.paths.reach import Reach
from burnish.paths.stroke import Stroke
from burnish.polish.depth import spindle_of
from burnish.polish.process import SLOWEST
from burnish.polish.recipe import LEAST_FORCE, MARGIN, Pass, Recipe
from burnish.surface import DistanceGrid, Mould
from burnish.trajectory.path import feed_share


def planned(recipe: Recipe, mould: Mould, grid: DistanceGrid) -> list[list[Stroke]]:
    """The strokes of each pass, mould frame, at least one a pass.

    Raises:
        PlanError: nothing of the mould is left to work.
    """
    tool = recipe.tool
    reach = Reach.of(mould, grid, tip_radius=tool.tip_radius, margin=MARGIN, modulus=tool.modulus)
    return [_strokes(reach, mould, recipe, one) for one in recipe.worked]


def _strokes(reach: Reach, mould: Mould, recipe: Recipe, one: Pass) -> list[Stroke]:
    own = recipe.of_pass(one)
    strokes = one.pattern.strokes(reach, mould, step=one.step, feed=own.feed, force=own.force)
    leaning = [replace(stroke, tilt=one.tilt) for stroke in ordered(strokes)]
    # A path that the user has drawn is theirs: it is refused rather than changed.
    return leaning if isinstance(one.pattern, Polyline) else _eased(own, one, leaning)


def _eased(recipe: Recipe, one: Pass, strokes: list[Stroke]) -> list[Stroke]:
    """The strokes, slower where the surface turns the tool too fast over most of one, as a fillet does.

    They remove the same. Where all of them together would be slower than the recipe allows, or one would press less
    than it may, they stay what they are, and the check of the plan says so.
    """
    least = max(recipe.limits.least_feed, SLOWEST)
    tool = recipe.tool
    radius = float(contact_radius(recipe.force, tool.tip_radius, 0.0, tool.modulus))
    rim = spindle_of(tool).speed(radius, one.tilt.angle)
    slower = [
        eased(stroke, rim) if feed_share(stroke.points, stroke.axes, stroke.feed) < least else stroke
        for stroke in strokes
    ]
    before, after = sum(map(duration, strokes)), sum(map(duration, slower))
    weak = any(
        new.force.min() < min(LEAST_FORCE, float(old.force.min())) for old, new in zip(strokes, slower, strict=True)
    )
    return strokes if weak or before < recipe.limits.least_feed * after else slower
