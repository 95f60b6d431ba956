"""The depth that a recipe wants: the text-book's, with and without a spindle, or the one that it names."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from finish.test_dwell import JUDGED, SURFACE, snake

from burnish.finish.dwell import Dwell
from burnish.finish.removal import coverage
from burnish.model.tool import PolishingTool
from burnish.paths.hertz import recommended_step
from burnish.paths.patterns import CrossHatch, Raster
from burnish.paths.tilt import Tilt
from burnish.polish.depth import law_of, spindle_of, target
from burnish.polish.recipe import PRESTON, Pass, Recipe
from burnish.polish.wanted import Even

SPINNING = PolishingTool(spindle=300.0)


def test_tool_that_does_not_spin_removes_by_distance_whatever_its_feed() -> None:
    step = recommended_step(8.0, 0.02, 0.0, 2e6)
    for feed in (0.01, 0.03):
        assert target(Recipe(force=8.0, feed=feed)) == PRESTON * 8.0 / step


def test_passes_add_up_and_a_cross_hatch_counts_twice() -> None:
    recipe = Recipe(passes=(Pass(pattern=Raster(), step=2e-3), Pass(pattern=CrossHatch(), force=5.0, step=4e-3)))
    assert target(recipe) == pytest.approx(PRESTON * (10.0 / 2e-3 + 2.0 * 5.0 / 4e-3))


@pytest.mark.parametrize("tilt", [Tilt(), Tilt(angle=0.2, heading=1.0)])
def test_spinning_tool_removes_by_time_what_the_model_says_of_its_lines(tilt: Tilt) -> None:
    recipe = Recipe(tool=SPINNING, passes=(Pass(pattern=Raster(), step=2.5e-3, tilt=tilt),))
    lines = replace(snake(np.arange(-0.02, 0.0201, 2.5e-3)), tilt=tilt)
    depth = Dwell(law=law_of(recipe), spindle=spindle_of(SPINNING)).depth(SURFACE, [lines])
    assert coverage(depth, 1e-6, SURFACE.areas, JUDGED).mean == pytest.approx(target(recipe), rel=0.03)


def test_named_depth_is_the_target() -> None:
    assert target(Recipe(tool=SPINNING, even=Even(depth=3e-6))) == 3e-6
