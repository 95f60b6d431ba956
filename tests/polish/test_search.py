"""Finding a mould that stands centimetres away."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from burnish.errors import InputError, PlanError
from burnish.polish.cell import Placement
from burnish.polish.guesses import Doubt, Guesses
from burnish.polish.search import MOST_TOUCHES, Found, Search
from burnish.rotation import exp, log
from burnish.surface import DistanceGrid

TIP = 0.02
HALF = np.array([0.06, 0.04, 0.012])
NOMINAL = Placement(p=np.array([0.0, -0.34, 0.2]), R=np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
FELT = 0.1e-3
"""Noise of a simulated touch [m]."""


@cache
def block(half: tuple[float, float, float] = (0.06, 0.04, 0.012)) -> DistanceGrid:
    """Exact distance to a block that stands on z = 0."""
    axes = [np.arange(-h - 0.03, h + 0.0301, 2e-3) for h in half[:2]]
    z = np.arange(0.004, 2.0 * half[2] + 0.0361, 2e-3)
    X = np.stack(np.meshgrid(*axes, z, indexing="ij"), axis=-1) - [0.0, 0.0, half[2]]
    q = np.abs(X) - half
    values = np.linalg.norm(np.maximum(q, 0.0), axis=-1) + np.minimum(q.max(axis=-1), 0.0)
    return DistanceGrid(origin=np.array([axes[0][0], axes[1][0], z[0]]), spacing=2e-3, values=values)


def upper_side() -> np.ndarray:
    x, y = np.meshgrid(np.linspace(-0.057, 0.057, 12), np.linspace(-0.037, 0.037, 8))
    return np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 2.0 * HALF[2])])


def searched(true: Placement, seed: int, only_down: bool = False, real: DistanceGrid | None = None) -> Found:
    """A search whose touches are computed: the tip marches along the line to the true surface, with noise."""
    search = Search(grid=block(), radius=TIP, nominal=NOMINAL, doubt=Doubt(), points=upper_side(), seed=seed)
    stands = Guesses(p=true.p[None], R=true.R[None])
    rng = np.random.default_rng(seed)
    while not search.done():
        line = next(line for line in search.next() if not only_down or line.way[2] < -0.5)
        t = float(stands.met(real or block(), line.start, line.way, TIP, line.far)[0])
        way = line.start + np.arange(0.0, min(t, line.far), 2e-4)[:, None] * line.way
        search.felt(way, line.start + (t + FELT * rng.normal()) * line.way if np.isfinite(t) else None)
    return search.found()


def test_grid_that_ends_beside_the_tip_is_refused_before_any_motion() -> None:
    wide = block()
    cut = 6
    origin = wide.origin + cut * wide.spacing * np.array([1.0, 1.0, 0.0])
    narrow = DistanceGrid(origin=origin, spacing=wide.spacing, values=wide.values[cut:-cut, cut:-cut])
    with pytest.raises(InputError, match=r"ends 18 mm beside the mould; a tip of 20 mm .* aside=0.03"):
        Search(grid=narrow, radius=TIP, nominal=NOMINAL, doubt=Doubt(), points=upper_side())


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_block_moved_by_up_to_50_mm_and_30_degrees_is_found_in_twelve_touches(seed: int) -> None:
    true = Guesses.drawn(NOMINAL, Doubt(), 1, np.random.default_rng(40 + seed)).one(0)
    found = searched(true, seed)
    middle = np.array([[0.0, 0.0, 2.0 * HALF[2]]])
    assert np.linalg.norm(found.placement.points(middle) - true.points(middle)) < 0.5e-3
    assert np.linalg.norm(log(found.placement.R @ true.R.T)) < np.deg2rad(0.5)
    assert found.touches <= MOST_TOUCHES
    assert found.untold == ""


def test_touches_from_above_do_not_tell_how_a_flat_block_slid_and_say_so() -> None:
    found = searched(NOMINAL, 3, only_down=True)
    for name in ("shift along x", "shift along y", "turn about z"):
        assert name in found.untold
    for name in ("shift along z", "turn about x", "turn about y"):
        assert name not in found.untold


def test_another_block_is_refused() -> None:
    with pytest.raises(PlanError, match="do not fit the mould"):
        searched(NOMINAL, 4, real=block((0.054, 0.03, 0.012)))


def test_marching_tip_meets_a_block_where_geometry_says() -> None:
    placement = Placement(p=np.zeros(3), R=exp(np.array([0.0, 0.0, 0.3])))
    guess = Guesses(p=placement.p[None], R=placement.R[None])
    start = placement.points(np.array([[0.11, 0.01, 0.012]]))[0]
    t = guess.met(block(), start, -placement.R[:, 0], TIP, 0.2)
    # From 110 mm to half the block, 60 mm, and the tip's radius.
    assert t[0] == pytest.approx(0.03, abs=1e-4)
    above = guess.met(block(), start + [0.0, 0.0, 0.05], -placement.R[:, 0], TIP, 0.2)
    assert np.isinf(above[0])


def test_pulled_guesses_touch_where_touches_were_and_differ_where_nothing_was_felt() -> None:
    rng = np.random.default_rng(5)
    guesses = Guesses.drawn(NOMINAL, Doubt(slide=5e-3, yaw=0.05, tilt=0.01), 50, rng)
    top = np.array([[0.02, 0.02], [-0.02, 0.01], [0.01, -0.02]])
    centres = NOMINAL.points(np.column_stack([top, np.full(3, 2.0 * HALF[2] + TIP)]))
    pulled = guesses.pulled(block(), centres, TIP, Doubt().scale(), np.zeros((50, 3)))
    assert np.abs(pulled.gaps(block(), centres, TIP)).max() < 1e-5
    # On a plane nothing says where it slid: the guesses stay where they were.
    assert np.allclose(pulled.p[:, :2], guesses.p[:, :2], atol=1.5e-3)
    assert pulled.p[:, 0].std() > 1e-3
