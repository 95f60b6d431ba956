"""Feed profiles: what they remove, evenly or as asked, and what no feed can do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from surface.shapes import box

from burnish.core import Array
from burnish.errors import PlanError
from burnish.finish.dwell import FIRST, Dwell, _bounded_least_squares
from burnish.finish.removal import Removal, coverage
from burnish.finish.rubbing import Spindle
from burnish.paths.hertz import contact_radius
from burnish.paths.lead import with_leads
from burnish.paths.stroke import Stroke
from burnish.paths.tilt import Tilt
from burnish.surface import Mould, WorkingSurface

LAW = Removal(coefficient=1e-11, tip_radius=0.02, modulus=2e6)
DWELL = Dwell(law=LAW, spindle=Spindle(rate=300.0, tip_radius=0.02))
SURFACE = WorkingSurface.of(Mould.of("slab", box(0.06, 0.05, 0.01)), LAW.edge(10.0))
X, Y = SURFACE.vertices[:, :2].T
JUDGED = (np.abs(X) < 0.018) & (np.abs(Y) < 0.013)


def snake(lines: Array, half: float = 0.022, feed: float = 0.02) -> Stroke:
    """A path back and forth along x over the slab, with straight ways between the lines."""
    x = np.arange(-half, half, 0.5e-3)
    rows = [np.column_stack((x if k % 2 == 0 else x[::-1], np.full_like(x, y))) for k, y in enumerate(lines)]
    plan = np.concatenate(rows)
    points = np.column_stack((plan, np.full(len(plan), 0.01)))
    one = np.ones(len(points))
    return Stroke(points=points, normals=np.tile([0.0, 0.0, 1.0], (len(points), 1)), feed=feed * one, force=10.0 * one)


PATH = snake(np.arange(-0.02, 0.0201, 2.5e-3))
LEVEL = 3e-6


def cv(depth: Array) -> float:
    return coverage(depth, LEVEL, SURFACE.areas, JUDGED).cv_pct


def test_fitted_feed_removes_the_wanted_depth() -> None:
    fitted = DWELL.fitted(SURFACE, [PATH], np.full(len(X), LEVEL), JUDGED)
    found = coverage(DWELL.depth(SURFACE, fitted), LEVEL, SURFACE.areas, JUDGED)
    assert found.mean == pytest.approx(LEVEL, rel=0.02)
    assert found.cv_pct < 6.0


def test_fitted_feed_is_more_even_than_a_constant_one() -> None:
    # Uneven on purpose: lines lie closer on one side.
    path = snake(-0.02 + 0.04 * np.linspace(0.0, 1.0, 17) ** 1.4)
    fitted = DWELL.fitted(SURFACE, [path], np.full(len(X), LEVEL), JUDGED)
    assert cv(DWELL.depth(SURFACE, fitted)) < 0.5 * cv(DWELL.depth(SURFACE, [path]))


def test_depth_that_rises_over_the_part_is_met() -> None:
    wanted = LEVEL * (1.0 + 0.5 * X / 0.018)
    depth = DWELL.depth(SURFACE, DWELL.fitted(SURFACE, [PATH], wanted, JUDGED))
    off = (depth - wanted)[JUDGED] / LEVEL
    assert np.sqrt(np.mean(off**2)) < 0.06


@pytest.mark.parametrize("heading", [0.0, 0.5 * np.pi])
def test_depth_is_that_of_the_tilt_of_the_stroke(heading: float) -> None:
    tilt = Tilt(angle=0.25, heading=heading)
    depth = DWELL.depth(SURFACE, [replace(PATH, tilt=tilt)])
    radius = float(contact_radius(10.0, 0.02, 0.0, 2e6))
    level = 1e-11 * 10.0 * DWELL.spindle.speed(radius, tilt.angle) / (0.02 * 2.5e-3)
    assert coverage(depth, level, SURFACE.areas, JUDGED).mean == pytest.approx(level, rel=0.03)


def test_leaning_tip_cuts_where_it_touches_not_where_its_apex_is() -> None:
    line = snake(np.array([0.0]))
    depth = DWELL.depth(SURFACE, [replace(line, tilt=Tilt(angle=0.25, heading=0.5 * np.pi))]) * SURFACE.areas
    # By w ⟨ρ²⟩/u the faster side of the contact draws it to itself; the apex would be 5 mm beside the line.
    u, w, a = 300.0 * 0.02 * np.sin(0.25), 300.0 * np.cos(0.25), float(contact_radius(10.0, 0.02, 0.0, 2e6))
    assert abs(float(depth @ Y / depth.sum())) == pytest.approx(w * a**2 / 5.0 / u, rel=0.2)


def test_feed_keeps_within_its_bounds() -> None:
    for level in (1e-9, 1.0):
        feed = DWELL.fitted(SURFACE, [PATH], np.full(len(X), level), JUDGED)[0].feed
        assert feed.min() >= DWELL.feed_min * (1 - 1e-9)
        assert feed.max() <= DWELL.feed_max * (1 + 1e-9)


def test_least_depth_is_what_the_fastest_feed_leaves() -> None:
    least = DWELL.least(SURFACE, [PATH], JUDGED)
    fastest = DWELL.depth(SURFACE, [replace(PATH, feed=np.full(len(PATH.feed), DWELL.feed_max))])
    found = np.sort(fastest[JUDGED])
    assert found[int(0.9 * len(found))] < least <= found[-1] * 1.05


def test_tool_that_does_not_spin_is_refused() -> None:
    still = Dwell(law=LAW, spindle=Spindle(rate=10.0, tip_radius=0.02))
    with pytest.raises(PlanError, match="Raise the spindle rate"):
        still.fitted(SURFACE, [PATH], np.full(len(X), LEVEL), JUDGED)


def test_wanting_nothing_is_refused() -> None:
    with pytest.raises(PlanError, match="nothing is wanted"):
        DWELL.fitted(SURFACE, [PATH], np.zeros(len(X)), JUDGED)


def test_solver_finds_what_scipy_finds_within_the_bounds() -> None:
    from scipy.optimize import lsq_linear
    from scipy.sparse import csr_array

    rng = np.random.default_rng(3)
    A, b = rng.uniform(0.0, 1.0, (40, 8)), rng.uniform(0.0, 4.0, 40)
    low, high = np.full(8, 0.2), np.full(8, 0.9)
    none = csr_array((1, 8))
    np.testing.assert_allclose(
        _bounded_least_squares(csr_array(A), b, none, low, high), lsq_linear(A, b, (low, high)).x, atol=1e-3
    )


def test_tool_that_stands_longer_at_the_start_moves_on_faster(monkeypatch: pytest.MonkeyPatch) -> None:
    near = np.linalg.norm(PATH.points - PATH.points[0], axis=1) < 8e-3
    times = []
    for stand in (0.0, 2.0):
        monkeypatch.setattr("burnish.finish.dwell.STAND", stand)
        judged = (np.abs(X) < 0.024) & (np.abs(Y) < 0.021)
        feed = DWELL.fitted(SURFACE, [PATH], np.full(len(X), LEVEL), judged)[0].feed
        times.append(float(np.mean(1.0 / feed[near])))
    assert times[1] < 0.9 * times[0]


def test_stroke_that_begins_with_what_a_touch_leaves_removes_nothing_before_it_moves() -> None:
    led = with_leads(PATH, touching=FIRST / float(PATH.force[0]))
    start = np.hypot(*(SURFACE.vertices - PATH.points[0])[:, :2].T) < 3e-3
    stands, goes = (DWELL.depth(SURFACE, [stroke])[start].mean() for stroke in (PATH, led))
    assert goes < 0.4 * stands
