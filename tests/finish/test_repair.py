"""Repair: only what lacks is worked again, and afterwards it is even."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from finish.test_dwell import DWELL, JUDGED, LEVEL, PATH, SURFACE, X, Y

from burnish.core import Array
from burnish.errors import PlanError
from burnish.finish.removal import coverage
from burnish.finish.repair import TOLERANCE, _worthwhile, as_the_tip_sees, repair, zones
from burnish.paths.stroke import Stroke
from burnish.paths.tilt import Tilt

PLANNED = DWELL.fitted(SURFACE, [PATH], np.full(len(X), LEVEL), JUDGED)
EVEN = DWELL.depth(SURFACE, PLANNED)


def worn(stroke: Stroke) -> Stroke:
    """The same with 40 % of its force over a disc of 9 mm radius."""
    inside = np.hypot(*stroke.points[:, :2].T) < 9e-3
    return replace(stroke, force=stroke.force * np.where(inside, 0.4, 1.0))


WORN = DWELL.depth(SURFACE, [worn(stroke) for stroke in PLANNED])


def test_even_work_needs_no_repair() -> None:
    found = repair(DWELL, SURFACE, PLANNED, EVEN, LEVEL, JUDGED, tolerance=0.12)
    assert found.strokes == ()
    assert found.zones == 0


def test_one_repair_makes_a_worn_place_even() -> None:
    before = coverage(WORN, LEVEL, SURFACE.areas, JUDGED)
    found = repair(DWELL, SURFACE, PLANNED, WORN, LEVEL, JUDGED)
    after = coverage(WORN + DWELL.depth(SURFACE, found.strokes), LEVEL, SURFACE.areas, JUDGED)
    assert before.cv_pct > 15.0
    assert after.cv_pct < 8.0
    assert after.covered_pct > 98.0


def test_places_at_target_are_left_alone() -> None:
    found = repair(DWELL, SURFACE, PLANNED, WORN, LEVEL, JUDGED)
    added = DWELL.depth(SURFACE, found.strokes)
    far = JUDGED & (np.hypot(X, Y) > 9e-3 + 2 * 4.2e-3)
    assert added[far].max(initial=0.0) < TOLERANCE * LEVEL


def test_missing_depth_is_what_was_not_taken_off() -> None:
    found = repair(DWELL, SURFACE, PLANNED, WORN, LEVEL, JUDGED)
    centre = np.hypot(X, Y) < 3e-3
    # Upright the depth goes with F a, and a with the cube root of F.
    np.testing.assert_allclose(found.missing[centre], (1 - 0.4 ** (4 / 3)) * LEVEL, atol=0.05 * LEVEL)
    assert not found.missing[~JUDGED].any()


def test_two_places_are_two_zones_and_the_larger_one_is_the_first() -> None:
    lacking = (np.hypot(X + 0.015, Y) < 4e-3) | (np.hypot(X - 0.012, Y) < 7e-3)
    number = zones(SURFACE, lacking, 0.0)
    assert number.max() == 2
    assert set(number[X > 0.0][lacking[X > 0.0]]) == {1}
    assert not number[~lacking].any()


def test_zone_smaller_than_the_least_is_dropped() -> None:
    lacking = np.hypot(X, Y) < 3e-3
    assert zones(SURFACE, lacking, 1e-4).max() == 0


def test_what_is_finer_than_the_contact_is_not_seen() -> None:
    stripes: Array = LEVEL * (1.0 + 0.3 * np.sin(2 * np.pi * Y / 2.5e-3))
    seen = as_the_tip_sees(SURFACE, stripes, 4.2e-3, JUDGED)
    np.testing.assert_allclose(seen[JUDGED], LEVEL, rtol=0.05)


def test_what_is_not_judged_makes_no_lack_at_the_rim() -> None:
    seen = as_the_tip_sees(SURFACE, np.where(JUDGED, LEVEL, 0.0), 4.2e-3, JUDGED)
    np.testing.assert_allclose(seen[JUDGED], LEVEL, rtol=1e-12)


def test_strokes_that_would_do_harm_are_left_out() -> None:
    lacks = LEVEL - WORN
    useful = repair(DWELL, SURFACE, PLANNED, WORN, LEVEL, JUDGED).strokes
    # A line over what is at target adds something even at its fastest.
    at = np.flatnonzero(np.isclose(PLANNED[0].points[:, 1], -12.5e-3))
    harmful = replace(PLANNED[0].rows(slice(at[0], at[-1] + 1)), force=np.full(len(at), 2.0))
    kept = _worthwhile(DWELL, SURFACE, [harmful, *useful], lacks, JUDGED)
    assert len(kept) == len(useful)
    assert all(len(stroke.points) != len(at) for stroke in kept)


@pytest.mark.parametrize(("target", "tolerance"), [(0.0, 0.05), (LEVEL, 0.0), (LEVEL, 1.0)])
def test_target_without_meaning_is_refused(target: float, tolerance: float) -> None:
    with pytest.raises(PlanError, match="repair"):
        repair(DWELL, SURFACE, PLANNED, WORN, target, JUDGED, tolerance)


def test_repair_leans_the_tool_and_yields_as_the_work_did() -> None:
    tilt = Tilt(angle=0.2, heading=1.0)
    planned = [replace(one, tilt=tilt, stiffness=np.full(len(one.points), 0.5)) for one in PLANNED]
    found = repair(DWELL, SURFACE, planned, WORN, LEVEL, JUDGED)
    assert len(found.strokes) > 0
    for one in found.strokes:
        assert one.tilt == tilt
        assert one.stiffness is not None
        np.testing.assert_array_equal(one.stiffness, 0.5)
