"""``burnish plan``: a checked plan and a table, or one line and nothing written."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
import pytest
import trimesh

from burnish.commands.plan import run
from burnish.commands.plan_options import PATTERNS, add_plan
from burnish.errors import InputError, PlanError
from burnish.paths.patterns import Polyline
from burnish.paths.tilt import Tilt
from burnish.polish import recipe_file
from burnish.polish.plan_file import load_plan
from burnish.polish.recipe import Bounds, Pass, Recipe
from burnish.polish.recipe_file import write_recipe
from burnish.surface import Mould


@pytest.fixture
def plate(tmp_path: Path) -> Path:
    path = tmp_path / "plate.stl"
    trimesh.creation.box((60.0, 40.0, 10.0)).export(path)
    return path


def options(*words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_plan(parser)
    return parser.parse_args(words)


def test_plan_names_its_mould_and_recipe_and_prints_its_margins(
    plate: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "plan.json"
    assert run(options("--mould", str(plate), "--force", "8", "--out", str(out))) == 0
    assert set(json.loads(out.read_text())) == {"strokes", "mould", "recipe"}
    plan = load_plan(out)
    assert plan.made_for == Mould.load(str(plate)).sha256
    assert plan.recipe == Recipe(force=8.0)
    assert all(np.allclose(one.force, 8.0) for one in plan.strokes)
    printed = capsys.readouterr().out
    for word in ("strokes", "joint speed", "joint torque", "joint limit", "singularity", "clearance", "of itself"):
        assert word in printed


def test_recipe_from_a_file_is_what_is_planned(plate: Path, tmp_path: Path) -> None:
    drawn = Recipe(passes=(Pass(pattern=Polyline(points=np.array([[-0.02, 0.0], [0.02, 0.005]])), force=6.0),))
    write_recipe(drawn, tmp_path / "recipe.toml")
    out = tmp_path / "plan.json"
    assert run(options("--mould", str(plate), "--recipe", str(tmp_path / "recipe.toml"), "--out", str(out))) == 0
    (one,) = load_plan(out).strokes
    assert np.allclose(one.force, 6.0)
    assert np.allclose(one.points[[0, -1], 0], [-0.02, 0.02], atol=1e-3)


def test_plan_that_the_arm_cannot_do_is_refused_and_nothing_is_written(plate: Path, tmp_path: Path) -> None:
    recipe = tmp_path / "recipe.toml"
    write_recipe(Recipe(limits=Bounds(joint_torque=0.1)), recipe)
    before = sorted(tmp_path.iterdir())
    with pytest.raises(PlanError, match="of its torque"):
        run(
            options("--mould", str(plate), "--recipe", str(tmp_path / "recipe.toml"), "--out", str(tmp_path / "p.json"))
        )
    assert sorted(tmp_path.iterdir()) == before


def test_recipe_and_single_figures_together_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="leave out --force"):
        run(options("--recipe", "r.toml", "--force", "8", "--out", str(tmp_path / "plan.json")))


def test_patterns_of_the_option_are_those_of_the_file() -> None:
    assert set(PATTERNS) == set(recipe_file.PATTERNS) - {"polyline"}


def test_leaning_tool_is_planned_checked_and_comes_back(plate: Path, tmp_path: Path) -> None:
    tilt = Tilt(angle=float(np.deg2rad(10.0)), heading=0.5)
    drawn = Pass(pattern=Polyline(points=np.array([[-0.015, 0.0], [0.015, 0.005]])), tilt=tilt)
    write_recipe(Recipe(passes=(drawn,)), tmp_path / "recipe.toml")
    out = tmp_path / "plan.json"
    assert run(options("--mould", str(plate), "--recipe", str(tmp_path / "recipe.toml"), "--out", str(out))) == 0
    plan = load_plan(out)
    assert all(one.tilt == tilt for one in plan.strokes)
    assert plan.recipe is not None
    assert plan.recipe.passes[0].tilt == tilt
