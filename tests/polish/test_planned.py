"""Planned strokes lie on the mould, in its pocket and over its fillets too."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from burnish.paths.patterns import Contour, Pattern, Raster
from burnish.polish.planned import planned
from burnish.polish.recipe import Pass, Recipe
from burnish.surface import DistanceGrid, Mould


@pytest.mark.slow
@pytest.mark.parametrize("pattern", [Raster(), Contour()])
def test_every_waypoint_on_the_mould_with_a_pocket_is_on_its_surface(pattern: Pattern) -> None:
    mould = Mould.load("mould")
    strokes = planned(Recipe(passes=(Pass(pattern=pattern),)), mould, DistanceGrid.of(mould))[0]
    points = np.concatenate([stroke.points for stroke in strokes])[::7]
    # In millimetres: in metres trimesh takes small triangles for points, and is wrong by 0.2 mm.
    mesh = trimesh.Trimesh(1e3 * mould.vertices, mould.faces, process=False)
    assert trimesh.proximity.closest_point(mesh, 1e3 * points)[1].max() < 0.05
