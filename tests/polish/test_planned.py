"""Planned strokes lie on the mould, in its pocket and over its fillets too."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from burnish.model.tool import PolishingTool
from burnish.paths.ease import duration
from burnish.paths.patterns import Contour, CrossHatch, Pattern, Polyline, Raster, Spiral
from burnish.paths.stroke import Stroke
from burnish.polish.planned import planned
from burnish.polish.process import SLOWEST
from burnish.polish.recipe import LEAST_FORCE, Bounds, Pass, Recipe
from burnish.surface import DistanceGrid, Mould
from burnish.trajectory.path import feed_share


@pytest.mark.slow
@pytest.mark.parametrize("pattern", [Raster(), Contour()])
def test_every_waypoint_on_the_mould_with_a_pocket_is_on_its_surface(pattern: Pattern) -> None:
    mould = Mould.load("mould")
    strokes = planned(Recipe(passes=(Pass(pattern=pattern),)), mould, DistanceGrid.of(mould))[0]
    points = np.concatenate([stroke.points for stroke in strokes])[::7]
    # In millimetres: in metres trimesh takes small triangles for points, and is wrong by 0.2 mm.
    mesh = trimesh.Trimesh(1e3 * mould.vertices, mould.faces, process=False)
    assert trimesh.proximity.closest_point(mesh, 1e3 * points)[1].max() < 0.05


def shares(strokes: list[Stroke]) -> list[float]:
    """What of its feed each stroke leaves the wrist."""
    return [feed_share(one.points, one.axes, one.feed) for one in strokes]


@pytest.mark.slow
@pytest.mark.parametrize("pattern", [CrossHatch(), Spiral()])
def test_strokes_over_the_fillets_are_slow_enough_for_the_wrist(pattern: Pattern) -> None:
    mould = Mould.load("mould")
    grid = DistanceGrid.of(mould)
    recipe = Recipe(passes=(Pass(pattern=pattern),))
    strokes = planned(recipe, mould, grid)[0]
    slow = [stroke for stroke in strokes if stroke.feed.min() < recipe.feed]
    assert slow
    assert min(shares(strokes)) >= SLOWEST
    assert recipe.limits.least_feed * sum(map(duration, strokes)) <= sum(one.length / recipe.feed for one in strokes)
    # Without a spindle nothing is taken off the force.
    assert min(float(stroke.force.min()) for stroke in slow) > 0.45 * recipe.force
    # Who asks for all of the feed is told that it cannot be had.
    strict = planned(replace(recipe, limits=Bounds(least_feed=1.0)), mould, grid)[0]
    assert min(shares(strict)) < SLOWEST


@pytest.mark.slow
def test_a_spinning_tool_presses_less_where_it_is_slower() -> None:
    mould = Mould.load("wave")
    # At 80 mm/s the waves turn the tool too fast.
    recipe = Recipe(feed=0.08, passes=(Pass(pattern=Raster()),), limits=Bounds(least_feed=0.1))
    grid = DistanceGrid.of(mould)
    for tool in (recipe.tool, PolishingTool(spindle=300.0)):
        (stroke,) = planned(replace(recipe, tool=tool), mould, grid)[0]
        slower = stroke.feed < 0.9 * recipe.feed
        assert slower.any()
        assert np.all((stroke.force[slower] < 0.9 * stroke.force.max()) == (tool.spindle > 0.0))
        assert stroke.force.min() >= LEAST_FORCE


def test_a_drawn_path_is_not_changed() -> None:
    mould = Mould.load("dome")
    path = Polyline(points=np.array([[-0.03, 0.0], [0.03, 0.0]]))
    (stroke,) = planned(Recipe(feed=0.08, passes=(Pass(pattern=path),)), mould, DistanceGrid.of(mould))[0]
    assert np.all(stroke.feed == 0.08)
