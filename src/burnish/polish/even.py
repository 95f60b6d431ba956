"""A feed that removes the depth that a recipe asks for, fitted along the strokes of all its passes at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from burnish.core import Array
from burnish.errors import PlanError
from burnish.finish.dwell import Dwell
from burnish.finish.removal import Coverage
from burnish.paths.lead import with_leads
from burnish.paths.stroke import Stroke
from burnish.polish.depth import Ground, law_of, spindle_of, target
from burnish.polish.recipe import LEAST_FORCE, Recipe
from burnish.polish.wanted import Even

LEAD = 10e-3
"""Over which the force rises and falls at the ends of a stroke [m]: a spindle that presses while it stands digs in."""
OFF = 0.1
"""Share of the wanted depth by which the mean may miss it; beyond, the bounds of the feed keep it away."""


def bounds_of(recipe: Recipe) -> Even:
    """How fast and slow the tool may go where a feed is fitted: as the recipe says, or as usual."""
    return recipe.even or Even(depth=target(recipe))


def dwell_of(recipe: Recipe) -> Dwell:
    """The recipe's tool, as fast and slow as it may go."""
    bounds = bounds_of(recipe)
    return Dwell(law=law_of(recipe), spindle=spindle_of(recipe.tool), feed_min=bounds.slowest, feed_max=bounds.fastest)


def evened(recipe: Recipe, ground: Ground, passes: Sequence[Sequence[Stroke]]) -> list[list[Stroke]]:
    """The strokes of the passes with the feed that removes the wanted depth, and leads at their ends.

    Raises:
        PlanError: the depth is out of what the feed can do, or the tool does not spin fast enough.
    """
    wanted, dwell = target(recipe), dwell_of(recipe)
    strokes = [_led(stroke) for one in passes for stroke in one]
    fitted = dwell.fitted(ground.surface, strokes, np.full(len(ground.counted), wanted), ground.counted)
    mean = ground.judged(planned_depth(recipe, ground, fitted), wanted).mean
    if not (1.0 - OFF) * wanted < mean < (1.0 + OFF) * wanted:
        too_little = mean < wanted
        feed = dwell.feed_min if too_little else dwell.feed_max
        remedy = "Do more passes, press more" if too_little else "Do fewer passes or lines, press less"
        raise PlanError(
            f"even: {1e6 * wanted:.3g} µm are wanted, but between its turns at {1e3 * feed:.3g} mm/s the tool removes "
            f"{1e6 * mean:.3g} µm. {remedy}, or spin {'faster' if too_little else 'slower'}"
        )
    rest = iter(fitted)
    return [[next(rest) for _ in one] for one in passes]


def _led(stroke: Stroke) -> Stroke:
    """The stroke with leads that press no more than a touch leaves, so that the tool need not stand first."""
    return with_leads(stroke, LEAD, min(1.0, LEAST_FORCE / float(stroke.force.min())))


def planned_depth(recipe: Recipe, ground: Ground, strokes: Sequence[Stroke]) -> Array:
    """Depth that the strokes remove where they are run as planned [m], (V,)."""
    return dwell_of(recipe).depth(ground.surface, strokes)


def says(found: Coverage, depth: float) -> str:
    """The evenness of a plan by the wanted depth [m], in words."""
    return (
        f"{1e6 * found.mean:.3g} µm, {100 * found.mean / depth:.0f} % of what is wanted, ±{found.cv_pct:.1f} %; "
        f"coverage {found.covered_pct:.1f} %"
    )
