"""Patterns over the bundled moulds: on the surface, without gouges, with the spacing that was asked for, everywhere."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from surface.shapes import angle_deg, dome_centre, grid, mould, tray

from burnish.core import Array
from burnish.errors import PlanError
from burnish.paths.hem import hem
from burnish.paths.hertz import recommended_step
from burnish.paths.patterns import Contour, CrossHatch, Geodesic, Pattern, Polyline, Raster, Spiral
from burnish.paths.raster import lines
from burnish.paths.reach import Reach
from burnish.paths.stroke import Stroke
from burnish.surface import Border, DistanceGrid, Mould, bundled

TIP, MARGIN, STEP = 0.02, 3e-3, 6e-3
PATTERNS: list[Pattern] = [
    Raster(angle=0.6),
    CrossHatch(angle=0.2),
    Spiral(),
    Contour(),
    Geodesic(),
    Polyline(points=np.array([[-0.2, -0.03], [0.2, 0.02], [0.0, 0.033], [-0.05, -0.03]])),
]
CASES = [
    pytest.param(name, pattern, id=f"{name}-{type(pattern).__name__}", marks=[pytest.mark.slow] * (name == "mould"))
    for name in ("dome", "mould")
    for pattern in PATTERNS
]


@cache
def reach(name: str) -> Reach:
    return Reach.of(mould(name), grid(name), tip_radius=TIP, margin=MARGIN)


FOUND: dict[tuple[str, int], list[Stroke]] = {}


def plan(name: str, pattern: Pattern, step: float | None = STEP) -> list[Stroke]:
    key = (name + str(step), id(pattern))
    if key not in FOUND:
        FOUND[key] = pattern.strokes(reach(name), mould(name), step=step, feed=0.02, force=10.0)
    return FOUND[key]


def joined(strokes: list[Stroke], field: str) -> Array:
    return np.concatenate([getattr(stroke, field) for stroke in strokes])


@pytest.mark.parametrize(("name", "pattern"), CASES)
def test_tip_touches_and_never_gouges(name: str, pattern: Pattern) -> None:
    strokes = plan(name, pattern)
    points, normals = joined(strokes, "points"), joined(strokes, "normals")
    gap = grid(name).at(points + TIP * normals)[0] - TIP
    assert np.abs(gap).max() < 2e-6
    assert np.abs(grid(name).at(points)[0]).max() < 50e-6


def test_no_line_of_a_raster_lies_close_beside_the_next_one() -> None:
    # At its fillet the mould ends in a shallow bow, wider by part of a step at both of its ends than in the middle.
    found = lines(reach("mould"), mould("mould"), step=None, feed=0.02, force=10.0, angle=0.0)
    places = joined(found, "points")
    for side in (-0.03, 0.0, 0.03):
        y = np.sort(places[(np.abs(places[:, 0] - side) < 1e-3) & (places[:, 1] < -0.03), 1])
        apart = np.diff(y)
        assert apart[apart > 0.1e-3].min() > 0.8e-3


@pytest.mark.parametrize(("name", "pattern"), CASES)
def test_borders_walls_and_steep_places_are_kept_clear_of(name: str, pattern: Pattern) -> None:
    strokes = plan(name, pattern)
    points = joined(strokes, "points")
    assert Border.of(mould(name), np.deg2rad(40)).distance(points).min() > MARGIN - 0.25e-3
    assert np.rad2deg(np.arccos(joined(strokes, "normals")[:, 2].min())) < 41


@pytest.mark.parametrize(("name", "pattern"), [case for case in CASES if not isinstance(case.values[1], Polyline)])
def test_path_has_no_sharp_corner(name: str, pattern: Pattern) -> None:
    for stroke in plan(name, pattern):
        way = np.diff(stroke.points[::2], axis=0)
        # A millimetre of a bend. A ring keeps the corners of what it goes round, rounded; the user's polyline its own.
        assert angle_deg(way[1:], way[:-1]).max() < (115 if isinstance(pattern, Contour) else 75)


@pytest.mark.parametrize(("name", "pattern"), CASES)
def test_no_stroke_is_shorter_than_it_is_worth(name: str, pattern: Pattern) -> None:
    assert min(stroke.length for stroke in plan(name, pattern)) > 9e-3


@pytest.mark.parametrize("pattern", PATTERNS[:-1], ids=lambda pattern: type(pattern).__name__)
def test_next_to_no_place_of_the_dome_is_further_from_a_line_than_the_step_allows(pattern: Pattern) -> None:
    ticks = np.arange(-0.044, 0.044, 1e-3)
    places = np.stack(np.meshgrid(ticks, ticks), -1).reshape(-1, 1, 2)
    path = joined(plan("dome", pattern), "points")[::2, :2]
    away = np.linalg.norm(places - path, axis=2).min(axis=1)
    # Half a step between lines; corners of the part between slanting ends, and of rings, lie further off.
    assert (away > 0.6 * STEP).mean() < 0.01
    assert away.max() < 1.1 * STEP


def test_raster_runs_at_its_angle() -> None:
    way = np.diff(plan("dome", PATTERNS[0])[0].points[:, :2], axis=0)
    heading = np.arctan2(way[:, 1], way[:, 0]) % np.pi
    assert np.median(np.abs(heading - 0.6)) < 1e-3


def test_raster_across_is_the_raster_of_the_turned_part() -> None:
    x, y = np.linspace(-0.03, 0.03, 61), np.linspace(-0.02, 0.02, 41)
    solid = tray(x, y, np.tile(0.012 + 0.002 * np.cos(x / 0.01)[:, None], (1, 41)))
    turned = solid @ np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1.0]])
    lengths = []
    for corners, angle in ((solid, 0.0), (turned, np.pi / 2)):
        part = Mould.of("part", corners)
        own = Reach.of(part, DistanceGrid.of(part), tip_radius=TIP, margin=MARGIN)
        found = Raster(angle=angle).strokes(own, part, step=STEP, feed=0.02, force=10.0)
        lengths.append(sum(stroke.length for stroke in found))
    assert lengths[1] == pytest.approx(lengths[0], rel=0.005)


def test_cross_hatch_is_two_rasters_at_a_right_angle() -> None:
    first, second = (Raster(angle=0.2 + extra) for extra in (0.0, np.pi / 2))
    one, other, both = plan("dome", first), plan("dome", second), plan("dome", PATTERNS[1])
    np.testing.assert_array_equal(joined(both, "points"), joined([*one, *other], "points"))


def test_spiral_on_the_dome_has_no_reversal_within_its_circle() -> None:
    longest = max(plan("dome", PATTERNS[2]), key=lambda stroke: stroke.length)
    angle = np.unwrap(np.arctan2(longest.points[:, 1], longest.points[:, 0]))
    within = np.linalg.norm(longest.points[:, :2], axis=1) < 0.044
    assert np.abs(np.diff(angle[within])).min() > 0
    assert abs(np.ptp(angle[within])) > 2 * np.pi * 6
    assert (np.sign(np.diff(angle[within])) == np.sign(angle[-1] - angle[0])).all()


def test_turns_of_the_spiral_are_a_step_apart_on_the_sphere() -> None:
    longest = max(plan("dome", PATTERNS[2]), key=lambda stroke: stroke.length)
    out = longest.points - dome_centre()
    latitude = bundled.DOME_RADIUS * np.arctan2(np.linalg.norm(out[:, :2], axis=1), out[:, 2])
    along = (longest.points[:, 0] > 0) & (np.abs(longest.points[:, 1]) < 0.5e-3) & (latitude < 0.044)
    crossings = latitude[along]
    crossings = crossings[np.concatenate(([True], np.diff(crossings) > 2e-3))]
    assert np.diff(crossings).max() < STEP * 1.03
    assert np.diff(crossings).min() > STEP * 0.9


def test_contour_of_the_dome_keeps_to_offsets_of_its_square() -> None:
    points = joined(plan("dome", PATTERNS[3]), "points")
    inset = 0.05 - np.abs(points[:, :2]).max(axis=1)
    assert inset.min() == pytest.approx(MARGIN, abs=0.2e-3)
    corner_free = np.abs(np.abs(points[:, 0]) - np.abs(points[:, 1])) > 0.02  # sides; links run elsewhere or rarely
    values = np.sort(inset[corner_free])
    level = values[np.concatenate(([True], np.diff(values) > 1e-3))]
    assert np.diff(level).max() < STEP


def test_geodesic_lines_on_the_dome_are_even_on_the_sphere() -> None:
    points = joined(plan("dome", PATTERNS[4]), "points") - dome_centre()
    across = bundled.DOME_RADIUS * np.arcsin(points[:, 1] / bundled.DOME_RADIUS)  # distance from the great circle y = 0
    inner = np.abs(points[:, 0]) < 0.03
    values = np.sort(across[inner])
    groups = np.split(values, np.flatnonzero(np.diff(values) > 2e-3) + 1)
    assert max(np.ptp(group) for group in groups) < 0.5e-3  # the heat method is good for a percent
    middles = np.array([group.mean() for group in groups])
    assert np.diff(middles).max() < STEP * 1.03
    assert np.diff(middles).min() > STEP * 0.85


@pytest.mark.slow
def test_polyline_is_followed_and_cut_at_the_pocket() -> None:
    line = Polyline(points=np.array([[-0.054, 0.005, 99.0], [0.02, 0.005, -99.0]]))
    strokes = plan("mould", line)
    points = joined(strokes, "points")
    assert np.abs(points[:, 1] - 0.005).max() < 50e-6
    assert len(strokes) == 2  # the floor of the pocket, and the bridge beside it; the rest is too short or out of reach
    assert points[:, 0].max() == pytest.approx(0.02, abs=0.2e-3)


@pytest.mark.parametrize(
    "points",
    [[[0.0, 0.0]], [[0, 0], [0, np.nan]], [0, 1], "ab", [[0, 0, 0, 0], [1, 1, 1, 1]], [[0, 0, 1], [0, 0, 2]], []],
)
def test_polyline_that_is_none_is_refused(points: object) -> None:
    with pytest.raises(PlanError, match="expected"):
        Polyline(points=points)  # type: ignore[arg-type]


def test_polyline_beside_the_part_is_refused() -> None:
    with pytest.raises(PlanError, match="nothing of 'dome' is left to work"):
        plan("dome", Polyline(points=np.array([[0.3, 0.3], [0.4, 0.4]])))


@pytest.mark.parametrize("pattern", PATTERNS, ids=lambda pattern: type(pattern).__name__)
@pytest.mark.parametrize("bad", [{"step": 0.0}, {"step": np.nan}, {"feed": -1.0}, {"force": 0.0}])
def test_values_out_of_range_are_refused(pattern: Pattern, bad: dict[str, float]) -> None:
    values = {"step": STEP, "feed": 0.02, "force": 10.0} | bad
    with pytest.raises(PlanError, match="expected a positive"):
        pattern.strokes(reach("dome"), mould("dome"), **values)  # type: ignore[arg-type]


@pytest.mark.parametrize("pattern", PATTERNS[:-1], ids=lambda pattern: type(pattern).__name__)
def test_part_without_a_workable_place_is_refused(pattern: Pattern) -> None:
    part = mould("dome")
    nowhere = Reach.of(part, grid("dome"), tip_radius=TIP, margin=0.049)
    with pytest.raises(PlanError, match="nothing of 'dome' is left"):
        pattern.strokes(nowhere, part, step=STEP, feed=0.02, force=10.0)


@pytest.mark.slow
def test_step_left_open_is_that_of_hertz_on_the_dome() -> None:
    strokes = plan("dome", Raster(), None)
    way = np.diff(strokes[0].points, axis=0)
    straight = np.abs(way[:, 1]) < 1e-3 * np.abs(way[:, 0])
    y = np.unique(np.round(strokes[0].points[1:][straight, 1], 5))
    y = y[np.concatenate(([True], np.diff(y) > 1e-3))]
    apart = np.linalg.norm(np.diff(np.column_stack((y, bundled.dome_height(0.047 + 0 * y, y))), axis=0), axis=1)
    expected = recommended_step(10.0, TIP, 1.0 / bundled.DOME_RADIUS, 2e6)
    assert apart.max() <= expected * 1.02
    assert apart.max() > expected * 0.93


@pytest.mark.slow
def test_force_follows_the_spacing_where_it_was_left_open() -> None:
    strokes = plan("mould", Raster(), None)
    force, points = joined(strokes, "force"), joined(strokes, "points")
    fillet = (points[:, 1] < -0.032) & (np.abs(points[:, 0]) < 0.03)
    flat = (points[:, 1] > -0.025) & (points[:, 1] < -0.02)
    assert np.median(force[flat]) == pytest.approx(10.0, rel=0.08)
    assert np.median(force[fillet]) < 7.0


def test_force_is_one_where_the_step_is_chosen() -> None:
    assert np.ptp(joined(plan("dome", PATTERNS[3]), "force")) < 1e-9


@pytest.mark.slow
def test_hem_lies_where_no_border_ends_the_work_and_presses_half() -> None:
    found = hem(reach("mould"), mould("mould"), step=STEP, feed=0.02, force=10.0)
    assert found
    assert joined(found, "force").max() == pytest.approx(5.0)
    points = joined(found, "points")
    assert Border.of(mould("mould"), np.deg2rad(40)).distance(points).min() > MARGIN + 0.2e-3
    assert hem(reach("dome"), mould("dome"), step=STEP, feed=0.02, force=10.0) == []
