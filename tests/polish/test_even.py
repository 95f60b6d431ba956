"""A recipe that names a depth: the feed is fitted to it, or the recipe refused."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from surface.shapes import box

from burnish.errors import PlanError
from burnish.model.tool import PolishingTool
from burnish.paths.patterns import Raster
from burnish.paths.stroke import Stroke
from burnish.paths.tilt import Tilt
from burnish.polish.depth import Ground
from burnish.polish.even import evened, planned_depth
from burnish.polish.planned import planned
from burnish.polish.recipe import LEAST_FORCE, Pass, Recipe
from burnish.polish.wanted import Even
from burnish.surface import DistanceGrid, Mould

TILT = Tilt(angle=0.25, heading=0.5 * np.pi)
RECIPE = Recipe(
    tool=PolishingTool(spindle=300.0), passes=(Pass(pattern=Raster(), tilt=TILT),), even=Even(depth=4.5e-6)
)  # fmt: skip


@lru_cache
def ground() -> tuple[Ground, list[list[Stroke]]]:
    slab = Mould.of("slab", box(0.05, 0.04, 0.01))
    grid = DistanceGrid.of(slab)
    return Ground.of(slab, grid, RECIPE), planned(RECIPE, slab, grid)


def wanting(depth: float) -> Recipe:
    return replace(RECIPE, even=Even(depth=depth))


def test_fitted_plan_removes_the_named_depth_evenly_as_it_leans() -> None:
    place, passes = ground()
    (strokes,) = evened(RECIPE, place, passes)
    found = place.judged(planned_depth(RECIPE, place, strokes), 4.5e-6)
    assert found.mean == pytest.approx(4.5e-6, rel=0.03)
    assert found.cv_pct < 6.0
    assert all(one.tilt == TILT for one in strokes)


def test_fitted_plan_presses_no_less_than_a_stroke_has_to() -> None:
    place, passes = ground()
    soft = [[replace(stroke, force=0.25 * stroke.force) for stroke in one] for one in passes]
    (strokes,) = evened(wanting(1e-6), place, soft)
    assert min(float(stroke.force.min()) for stroke in strokes) >= LEAST_FORCE


@pytest.mark.parametrize(("depth", "said"), [(1e-7, "Do fewer passes"), (1e-4, "Do more passes")])
def test_depth_that_no_feed_gives_is_refused_with_what_it_would_be(depth: float, said: str) -> None:
    place, passes = ground()
    with pytest.raises(PlanError, match=said):
        evened(wanting(depth), place, passes)
