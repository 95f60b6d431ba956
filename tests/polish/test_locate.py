"""Finding the mould by touch."""

from __future__ import annotations

import numpy as np
import pytest

from burnish.errors import PlanError
from burnish.polish.cell import Placement
from burnish.polish.locate import locate, touch_points
from burnish.rotation import exp
from burnish.surface import DistanceGrid

RADIUS, TIP = 0.15, 0.02
NOMINAL = Placement(p=np.array([0.0, -0.34, 0.2]), R=np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))


def sphere_grid() -> DistanceGrid:
    """Distance to a ball whose highest point is the origin of the mould's frame."""
    axis = np.arange(-0.07, 0.0701, 2e-3)
    z = np.arange(-0.03, 0.0401, 2e-3)
    X, Y, Z = np.meshgrid(axis, axis, z, indexing="ij")
    values = np.sqrt(X**2 + Y**2 + (Z + RADIUS) ** 2) - RADIUS
    return DistanceGrid(origin=np.array([-0.07, -0.07, -0.03]), spacing=2e-3, values=values)


def touches(true: Placement) -> np.ndarray:
    """Centres of a tip that touches the ball at five places, base frame."""
    xy = np.array([[0.0, 0.0], [0.04, 0.04], [-0.04, 0.04], [0.04, -0.04], [-0.04, -0.04]])
    n = np.column_stack([xy, np.sqrt(RADIUS**2 - (xy**2).sum(axis=1))]) / RADIUS
    return true.points((RADIUS + TIP) * n - np.array([0.0, 0.0, RADIUS]))


def test_moved_and_tilted_mould_is_found() -> None:
    turn = np.array([0.02, -0.015, 0.0])
    true = Placement(p=NOMINAL.p + [1e-3, -0.5e-3, 1.2e-3], R=exp(turn) @ NOMINAL.R)
    found = locate(sphere_grid(), NOMINAL, touches(true), TIP)
    # A ball may turn about its own centre unseen; where that centre is decides every normal.
    centre = np.array([[0.0, 0.0, -RADIUS]])
    # 0.2 mm over 150 mm is 0.08° of normal; the grid's own error and the prior leave less.
    assert np.linalg.norm(found.points(centre) - true.points(centre)) < 2e-4


def test_mould_in_its_place_stays_there() -> None:
    found = locate(sphere_grid(), NOMINAL, touches(NOMINAL), TIP)
    assert np.linalg.norm(found.p - NOMINAL.p) < 5e-5
    assert np.abs(found.R - NOMINAL.R).max() < 1e-3


def test_touches_of_another_mould_are_refused() -> None:
    centres = touches(NOMINAL)
    centres[1, 2] += 4e-3
    with pytest.raises(PlanError, match="do not fit the mould"):
        locate(sphere_grid(), NOMINAL, centres, TIP)


def test_touch_points_are_the_middle_and_the_corners() -> None:
    x, y = np.meshgrid(np.linspace(-1.0, 1.0, 21), np.linspace(-1.0, 1.0, 21))
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    chosen = points[touch_points(points)]
    assert np.allclose(chosen[0], 0.0)
    assert np.allclose(np.abs(chosen[1:, :2]), 1.0)
