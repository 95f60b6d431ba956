"""Rasters over the bundled moulds: on the surface, without gouges, even, and gentle to the arm."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from surface.shapes import angle_deg, box, dome_centre, grid, mould, tray, wave_normal

from burnish.core import Array
from burnish.errors import InputError, PlanError
from burnish.paths.raster import Stroke, as_plan, from_plan, raster
from burnish.surface import Border, DistanceGrid, Mould, bundled

TIP, STEP, MARGIN = 0.015, 2.3e-3, 5e-3
STEPS = {"plate": 6e-3}  # large and flat: fewer lines tell as much
NAMES = bundled.NAMES


def plan(name: str, tip_radius: float = TIP) -> list[Stroke]:
    return planned(name, tip_radius)


@cache
def planned(name: str, tip_radius: float) -> list[Stroke]:
    step = STEPS.get(name, STEP)
    return raster(mould(name), grid(name), tip_radius=tip_radius, step=step, feed=0.02, force=10.0, margin=MARGIN)


def all_points(name: str, tip_radius: float = TIP) -> tuple[Array, Array]:
    strokes = plan(name, tip_radius)
    return np.concatenate([one.points for one in strokes]), np.concatenate([one.normals for one in strokes])


@pytest.mark.parametrize("name", ["plate", "dome", "wave"])
def test_smooth_mould_is_one_stroke(name: str) -> None:
    assert len(plan(name)) == 1


@pytest.mark.parametrize(
    ("name", "tip_radius"),
    [("plate", TIP), ("dome", TIP), ("wave", TIP), ("mould", TIP), ("wave", 0.025)],
)
def test_tip_touches_and_never_gouges(name: str, tip_radius: float) -> None:
    points, normals = all_points(name, tip_radius)
    gap = grid(name).at(points + tip_radius * normals)[0] - tip_radius
    assert np.abs(gap).max() < 2e-6
    assert np.abs(grid(name).at(points)[0]).max() < 30e-6  # the point of contact lies on the surface


def test_points_and_normals_on_the_dome_are_those_of_the_sphere() -> None:
    points, normals = all_points("dome")
    outward = points - dome_centre()
    assert np.abs(np.linalg.norm(outward, axis=1) - bundled.DOME_RADIUS).max() < 6e-6
    assert angle_deg(outward, normals).max() < 0.05


def test_points_and_normals_on_the_wave_are_those_of_the_wave() -> None:
    points, normals = all_points("wave")
    assert np.abs(points[:, 2] - bundled.wave_height(points[:, 0], points[:, 1])).max() < 10e-6
    assert angle_deg(wave_normal(points[:, 0]), normals).max() < 0.25


def test_normals_on_the_dome_turn_at_a_steady_rate() -> None:
    (stroke,) = plan("dome")
    rate = np.deg2rad(angle_deg(stroke.normals[1:], stroke.normals[:-1])) / np.diff(stroke.arc)
    steady = 1 / bundled.DOME_RADIUS
    assert np.abs(rate - steady).max() < 0.1 * steady  # facets of 1 mm would turn it by 100 %


@pytest.mark.parametrize("name", ["plate", "dome", "wave"])
def test_points_are_evenly_spaced(name: str) -> None:
    spacing = np.diff(plan(name)[0].arc)
    assert spacing.max() < 0.53e-3
    assert spacing.min() > 0.47e-3


@pytest.mark.parametrize("name", NAMES)
def test_path_has_no_sharp_corner(name: str) -> None:
    for stroke in plan(name):
        step = np.diff(stroke.points, axis=0)
        # Half a millimetre of a circle of half a step turns by 25°; a fillet of 10 mm bends what is planned in plan.
        assert angle_deg(step[1:], step[:-1]).max() < 60


@pytest.mark.parametrize(("name", "reach"), [("plate", (95, 95)), ("dome", (45, 45)), ("wave", (55, 35))])
def test_first_and_last_line_lie_at_the_inset(name: str, reach: tuple[float, float]) -> None:
    points, _ = all_points(name)
    np.testing.assert_allclose(1e3 * points[:, :2].max(axis=0), reach, atol=0.02)
    np.testing.assert_allclose(1e3 * points[:, :2].min(axis=0), [-reach[0], -reach[1]], atol=0.02)


def test_small_margin_is_kept_to_a_tenth_of_a_millimetre() -> None:
    (stroke,) = raster(mould("plate"), grid("plate"), tip_radius=TIP, step=0.03, feed=0.02, force=10.0, margin=1.5e-3)
    np.testing.assert_allclose(1e3 * np.abs(stroke.points[:, 1]).max(), 98.5, atol=0.1)


@pytest.mark.parametrize("name", NAMES)
def test_no_point_is_nearer_to_a_border_than_the_margin(name: str) -> None:
    points, _ = all_points(name)
    # Half circles may come nearer by 0.2 mm, where the border is not straight.
    assert Border.of(mould(name), np.deg2rad(40)).distance(points).min() > MARGIN - 0.22e-3


@pytest.mark.parametrize("name", NAMES)
def test_nothing_steeper_than_the_limit_is_worked(name: str) -> None:
    _, normals = all_points(name)
    assert np.rad2deg(np.arccos(normals[:, 2].min())) < 41


def lines_of(stroke: Stroke) -> Array:
    """y of the straight lines of a stroke [m], rising."""
    heading = np.diff(stroke.points[:, :2], axis=0)
    straight = np.abs(heading[:, 1]) < 1e-3 * np.abs(heading[:, 0])
    return np.unique(np.round(stroke.points[1:][straight, 1], 5))


@pytest.mark.parametrize("name", ["plate", "wave"])
def test_lines_are_even_and_a_step_apart_at_most(name: str) -> None:
    spacing = np.diff(lines_of(plan(name)[0]))
    assert spacing.max() <= STEPS.get(name, STEP) + 1e-5
    assert np.ptp(spacing) < 3e-5


def test_lines_on_the_dome_are_a_step_apart_on_the_surface() -> None:
    y = lines_of(plan("dome")[0])
    for x in (0.0, 0.045):
        points = np.column_stack((np.full_like(y, x), y, bundled.dome_height(np.full_like(y, x), y)))
        apart = np.linalg.norm(np.diff(points, axis=0), axis=1)
        assert apart.max() <= STEP + 1e-5
    assert apart.max() > 0.95 * STEP  # not denser than the slope asks for
    np.testing.assert_allclose(y, -y[::-1], atol=2e-5)


def test_path_covers_the_floor_of_the_pocket_and_leaves_its_wall() -> None:
    points, _ = all_points("mould")
    inside = (np.abs(points[:, 0] + 0.021875) < 0.024) & (np.abs(points[:, 1] - 0.005) < 0.017)
    assert inside.sum() > 200
    # What a tip of 15 mm reaches ends 9 mm from the rim; the free form is tilted by up to 8°.
    assert (np.abs(points[inside, 0] + 0.021875) < 0.0165).all()
    assert (np.abs(points[inside, 1] - 0.005) < 0.0095).all()


def test_path_goes_round_the_hole() -> None:
    points, _ = all_points("mould")
    assert np.linalg.norm(points[:, :2] - [0.035, 0.0125], axis=1).min() > 7e-3 + MARGIN - 0.25e-3


def test_path_follows_the_fillet_to_the_limit() -> None:
    points, normals = all_points("mould")
    assert points[:, 1].min() < -35.5e-3
    assert np.rad2deg(np.arccos(normals[:, 2].min())) > 30


def test_larger_margin_and_smaller_slope_leave_less() -> None:
    def length(margin: float, slope_deg: float) -> float:
        strokes = raster(
            mould("dome"), grid("dome"), tip_radius=TIP, step=10e-3, feed=0.02, force=10.0, margin=margin,
            max_slope=np.deg2rad(slope_deg),
        )  # fmt: skip
        return sum(stroke.length for stroke in strokes)

    assert length(5e-3, 40) > 1.05 * length(8e-3, 40)
    assert length(5e-3, 40) > 1.05 * length(5e-3, 15)


def test_plan_of_a_raster_comes_back() -> None:
    strokes = plan("mould")
    for one, back in zip(strokes, from_plan(as_plan(strokes)), strict=True):
        np.testing.assert_array_equal(one.points, back.points)
    assert {float(value) for one in strokes for value in one.feed} == {0.02}
    assert {float(value) for one in strokes for value in one.force} == {10.0}


def test_facets_of_a_coarse_file_do_not_make_the_tool_nod() -> None:
    # A cylinder of 150 mm in facets of 4 mm, 1.5° each: the slope of the tool would jump at every edge.
    x = np.linspace(-0.05, 0.05, 26)
    height = np.repeat((0.03 + np.sqrt(0.15**2 - x**2) - 0.15)[:, None], 2, axis=1)
    part = Mould.of("coarse", tray(x, np.array([-0.02, 0.02]), height))
    (stroke,) = raster(part, DistanceGrid.of(part), tip_radius=TIP, step=8e-3, feed=0.02, force=10.0, margin=8e-3)
    slope = np.rad2deg(np.arctan2(stroke.normals[:, 0], stroke.normals[:, 2]))
    error = slope - np.rad2deg(np.arcsin(stroke.points[:, 0] / 0.15))
    assert np.abs(error).max() < 0.75  # half of the angle between two facets: no overshoot
    step = np.abs(np.diff(slope))
    assert step.max() < 0.45  # the edge of 1.5° is spread over more than 1.5 mm


def test_part_smaller_than_the_margin_is_refused_with_advice() -> None:
    part = Mould.of("coin", box(0.02, 0.012, 0.005))
    with pytest.raises(PlanError, match=r"nothing of 'coin' is left to work .* reduce the inset"):
        raster(part, DistanceGrid.of(part), tip_radius=TIP, step=STEP, feed=0.02, force=10.0, margin=7e-3)


def test_slope_beyond_the_limit_leaves_nothing() -> None:
    x = np.array([-0.02, 0.02])
    part = Mould.of("ramp", tray(x, x, np.array([[0.01, 0.01], [0.05, 0.05]])))
    with pytest.raises(PlanError, match="slopes up to 40°"):
        raster(part, DistanceGrid.of(part), tip_radius=TIP, step=STEP, feed=0.02, force=10.0, margin=3e-3)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("step", 0),
        ("step", np.nan),
        ("feed", -1),
        ("force", np.inf),
        ("margin", -1),
        ("margin", np.nan),
        ("tip_radius", 0),
    ],
)
def test_values_out_of_range_are_refused(name: str, value: float) -> None:
    values = {"tip_radius": TIP, "step": STEP, "feed": 0.02, "force": 10.0, "margin": MARGIN, name: value}
    with pytest.raises(PlanError, match="expected"):
        raster(mould("plate"), grid("plate"), **values)


def test_step_that_would_take_days_is_refused() -> None:
    with pytest.raises(PlanError, match="lines"):
        raster(mould("dome"), grid("dome"), tip_radius=TIP, step=1e-6, feed=0.02, force=10.0, margin=MARGIN)


def test_tip_that_the_grid_cannot_serve_is_refused() -> None:
    with pytest.raises(InputError, match="serves radii"):
        raster(mould("dome"), grid("dome"), tip_radius=1.5e-3, step=STEP, feed=0.02, force=10.0, margin=MARGIN)
