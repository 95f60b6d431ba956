"""Recipes and plans in files: what was written comes back, and a file that is anything else is refused."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from burnish.errors import InputError, PlanError
from burnish.model.tool import PolishingTool
from burnish.paths.patterns import Contour, CrossHatch, Geodesic, Polyline, Raster, Spiral
from burnish.paths.stroke import Stroke, as_plan
from burnish.paths.tilt import Tilt
from burnish.polish.plan_file import load_plan, read_plan, write_plan
from burnish.polish.recipe import BOUNDS, FEED, FORCE, TOOL, Bounds, Pass, Recipe
from burnish.polish.recipe_file import PATTERNS, as_tables, as_toml, from_tables, read_recipe, write_recipe
from burnish.polish.wanted import Even, Smoothing
from burnish.surface import Mould

FULL = Recipe(
    force=7.3,
    feed=1.0 / 30.0,
    grit='felt, 3 µm "diamond" = fine # not a comment',
    preston=3.7e-12,
    passes=(
        Pass(pattern=Raster(angle=0.1), force=5.1),
        Pass(pattern=CrossHatch(angle=-np.pi / 7.0), feed=0.011, step=1e-3 / 3.0),
        Pass(pattern=Spiral(), tilt=Tilt(angle=0.2, heading=-1.0 / 3.0)),
        Pass(pattern=Contour()),
        Pass(pattern=Geodesic()),
    ),
    tool=PolishingTool(tip_radius=0.0151, friction=1.0 / 3.0, spindle=-1000.0 / 3.0),
    limits=Bounds(joint_margin=0.3, least_feed=1.0 / 3.0),
    even=Even(depth=1e-6 / 3.0, slowest=0.004, fastest=0.031),
    roughness=Smoothing(before=1.1e-6, asymptote=1e-7 / 3.0, depth=2e-6, preston_factor=1.7),
)


def numbers(allowed: Any) -> st.SearchStrategy[float]:
    return st.floats(allowed.low, allowed.high)


@given(force=numbers(FORCE), feed=numbers(FEED), margin=numbers(BOUNDS["joint_margin"]), mass=numbers(TOOL["tip_mass"]))
@settings(max_examples=50, deadline=None)
def test_every_recipe_comes_back_bit_for_bit(force: float, feed: float, margin: float, mass: float) -> None:
    recipe = Recipe(
        force=force, feed=feed, limits=Bounds(joint_margin=margin), tool=PolishingTool(tip_mass=mass),
        passes=(Pass(pattern=Raster(angle=margin), force=force),),
    )  # fmt: skip
    assert from_tables(as_tables(recipe)) == recipe


def test_recipe_comes_back_from_its_file_bit_for_bit(tmp_path: Path) -> None:
    path = tmp_path / "recipe.toml"
    write_recipe(FULL, path)
    assert read_recipe(path) == FULL
    assert [one.name for one in tmp_path.iterdir()] == ["recipe.toml"]


def test_drawn_path_comes_back_from_its_file(tmp_path: Path) -> None:
    points = np.random.default_rng(0).uniform(-0.05, 0.05, (20, 3))
    path = tmp_path / "recipe.toml"
    write_recipe(Recipe(passes=(Pass(pattern=Polyline(points=points)),)), path)
    pattern = read_recipe(path).passes[0].pattern
    assert isinstance(pattern, Polyline)
    np.testing.assert_array_equal(pattern.points, points)


def test_every_pattern_can_be_written() -> None:
    assert {type(one.pattern) for one in FULL.passes} | {Polyline} == set(PATTERNS.values())


def test_every_number_in_the_file_has_its_unit_and_range_beside_it() -> None:
    lines = as_toml(FULL).splitlines()
    assert "feed = 0.03333333333333333  # [m/s] 0.005 to 0.08" in lines
    assert any(line.startswith("joint_margin = 0.3  # [rad]") and line.endswith("17.19°") for line in lines)
    for line in lines:
        if "=" in line and not line.startswith(("#", "grit", "pattern")):
            assert "  # [" in line, line


def test_empty_file_is_the_default_recipe(tmp_path: Path) -> None:
    path = tmp_path / "recipe.toml"
    path.write_text("")
    assert read_recipe(path) == Recipe()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("forse = 10.0", "did you mean 'force'"),
        ("[tool]\ntip_radios = 0.02", "did you mean 'tip_radius'"),
        ('[[passes]]\npattern = "rastr"', "did you mean 'raster'"),
        ('[[passes]]\npattern = "spiral"\nangle = 0.1', "has no key 'angle'"),
        ("[[passes]]\nforce = 10.0", "names no pattern"),
        ("force = 30.0", "force 30 N is out of range; expected 2 to 20 N"),
        ("force = nan", "out of range"),
        ("force = true", "out of range"),
        ('feed = "fast"', "feed 'fast' is out of range; expected 0.005 to 0.08 m/s"),
        (f"force = {10**400}", "out of range"),
        ("[tool]\ntip_radius = -0.02", "tool: tip_radius -0.02 m is out of range"),
        ("[limits]\njoint_speed = 1.5", "limits: joint_speed 1.5 is out of range; expected 0.1 to 0.9"),
        ('[[passes]]\npattern = "polyline"', "points are no path"),
        ('[[passes]]\npattern = "polyline"\npoints = [[0, 0], [1e9, 0]]', "a coordinate"),
        ('[[passes]]\npattern = "spiral"\ntilt = 0.01', "tilt: the angle"),
        ("passes = 3", "passes is no list"),
        ("tool = 3", "tool is no table"),
        ("grit = 3", "is no plain text"),
        ("grit = 2026-01-01", "is no plain text"),
        ("[tool]\nspindle_rpm = 3000\nspindle_rad_s = 300", "both state the spindle's speed; expected one of them"),
        ("[tool]\nspindle_rpm = 1e6", "tool: spindle_rpm 1e+06 rpm is out of range"),
        ("[tool]\nspindle_rad_s = 1e4", "tool: spindle_rad_s 10000 rad/s is out of range"),
        ("[tool]\nspindle = 300", "did you mean 'spindle_rpm'"),
        ("[even]\ndepth = 1e-6", "a tool that does not spin removes by distance"),
        ("[even]\nslowest = 0.01", "even does not state depth"),
        ("even = 3", "even is no table"),
        ("[tool]\nspindle_rpm = 3000\n[even]\ndepth = 1.0", "even: depth 1 m is out of range"),
        ("[even]\ndepth = 1e-6\nslowest = 0.05\nfastest = 0.04", "slowest 0.05 m/s is not less than fastest"),
        ("[roughness]\nbefore = 1e-6", "roughness does not state asymptote, depth"),
        ("force = ", "is no recipe"),
        ("a = " + "[" * 3000, "is no recipe"),
    ],
)
def test_recipe_that_cannot_be_used_is_refused_in_one_line(text: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "recipe.toml"
    path.write_text(text)
    with pytest.raises(InputError) as refused:
        read_recipe(path)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_spindle_may_be_stated_in_turns_a_minute(tmp_path: Path) -> None:
    path = tmp_path / "recipe.toml"
    path.write_text("[tool]\nspindle_rpm = -3000")
    assert read_recipe(path).tool.spindle == pytest.approx(-2.0 * np.pi * 50.0)
    line = next(line for line in as_toml(read_recipe(path)).splitlines() if line.startswith("spindle"))
    assert line.startswith("spindle_rad_s = -314.15")
    assert line.endswith("-3000 rpm")


def test_recipe_that_says_nothing_of_it_names_no_spindle_depth_or_roughness() -> None:
    text = as_toml(Recipe())
    for word in ("spindle", "even", "roughness"):
        assert word not in text


def test_recipe_that_is_too_large_or_missing_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "recipe.toml"
    path.write_bytes(b"#" * (2**20 + 1))
    with pytest.raises(InputError, match="larger than"):
        read_recipe(path)
    with pytest.raises(InputError, match="cannot be read"):
        read_recipe(tmp_path / "none.toml")


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8) | st.dates(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from([*as_tables(FULL), *TOOL, *BOUNDS,
        "pattern", "points", "angle", "step", "tilt"]), inner, max_size=5),
    max_leaves=12,
)  # fmt: skip


@given(tables=VALUES)
@settings(max_examples=150, deadline=None)
def test_tables_of_any_kind_are_a_recipe_or_refused(tables: Any) -> None:
    with suppress(InputError):
        assert isinstance(from_tables(tables), Recipe)


@given(where=st.integers(0, 10_000), what=st.binary(max_size=6))
@settings(max_examples=100, deadline=None)
def test_recipe_file_with_damaged_bytes_is_read_or_refused(where: int, what: bytes, tmp_path_factory: Any) -> None:
    data = as_toml(FULL).encode()
    where %= len(data)
    path = tmp_path_factory.getbasetemp() / "damaged.toml"
    path.write_bytes(data[:where] + what + data[where + len(what) :])
    with suppress(InputError):
        assert isinstance(read_recipe(path), Recipe)


def stroke() -> Stroke:
    x = np.linspace(0.0, 0.1, 11)
    return Stroke(
        points=np.column_stack((x, 0 * x, 0 * x)), normals=np.tile([0.0, 0.0, 1.0], (11, 1)), feed=0.02 + 0 * x,
        force=10.0 + 0 * x,
    )  # fmt: skip


def test_plan_comes_back_with_its_mould_and_recipe(tmp_path: Path) -> None:
    mould, path = Mould.load("plate"), tmp_path / "new" / "plan.json"
    write_plan(path, [stroke()], mould, FULL)
    plan = load_plan(path)
    assert plan.made_for == mould.sha256
    assert plan.recipe == FULL
    np.testing.assert_array_equal(plan.strokes[0].points, stroke().points)
    np.testing.assert_array_equal(read_plan(path)[0].normals, stroke().normals)


def test_plan_that_names_no_mould_is_a_plan(tmp_path: Path) -> None:
    mould, path = Mould.load("plate"), tmp_path / "plan.json"
    write_plan(path, [stroke()], mould, Recipe())
    plan = json.loads(path.read_text())
    path.write_text(json.dumps({"strokes": plan["strokes"]}))
    assert load_plan(path).made_for is None
    assert load_plan(path).recipe is None


@pytest.mark.parametrize(
    ("extra", "said"),
    [
        ({"mould": 3}, "its mould has no fingerprint"),
        ({"mould": {"name": "plate", "sha256": "short"}}, "its mould has no fingerprint"),
        ({"recipe": {"forse": 3}}, "did you mean 'force'"),
        ({"recipe": None}, "is no table"),
        ({"strokes": []}, "no strokes"),
    ],
)
def test_plan_that_lies_about_itself_is_refused(extra: dict[str, Any], said: str, tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    write_plan(path, [stroke()], Mould.load("plate"), Recipe())
    path.write_text(json.dumps(json.loads(path.read_text()) | extra))
    with pytest.raises(PlanError, match=said):
        load_plan(path)


WHOLE = json.dumps(
    as_plan([stroke()]) | {"mould": {"name": "plate", "sha256": "0" * 64}, "recipe": as_tables(FULL)}
).encode()


@given(where=st.integers(0, 100_000), what=st.binary(max_size=6))
@settings(max_examples=100, deadline=None)
def test_plan_file_with_damaged_bytes_is_read_or_refused(where: int, what: bytes, tmp_path_factory: Any) -> None:
    path = tmp_path_factory.getbasetemp() / "damaged.json"
    data = WHOLE
    where %= len(data)
    path.write_bytes(data[:where] + what + data[where + len(what) :])
    with suppress(PlanError):
        assert load_plan(path).strokes
