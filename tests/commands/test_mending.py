"""``--repair``: what an earlier job left under target is planned, worked and judged together with it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from commands.test_cli import refusal, small_plate

from burnish.cli import main
from burnish.commands.course import Course, earlier
from burnish.commands.judged import BEFORE, REMOVED, keep, removed
from burnish.core import Array
from burnish.model.tool import PolishingTool
from burnish.paths.patterns import Raster
from burnish.paths.tilt import Tilt
from burnish.polish.depth import Ground
from burnish.polish.journal import NAME, Journal, Mark
from burnish.polish.plan_file import load_plan
from burnish.polish.recipe import Pass, Recipe
from burnish.polish.wanted import Even, Smoothing
from burnish.surface import DistanceGrid, Mould

DEPTH = 5e-6
TILT = Tilt(angle=0.25, heading=0.5 * np.pi)
RECIPE = Recipe(
    tool=PolishingTool(spindle=300.0),
    passes=(Pass(pattern=Raster(), tilt=TILT),),
    even=Even(depth=DEPTH),
    roughness=Smoothing(before=1e-6, asymptote=1e-7, depth=3e-6),
)


def worked(folder: Path, mesh: Path, recipe: Recipe, phase: str = "done") -> tuple[Mould, Ground]:
    """A job that ended, as its journal tells it; returns its mould and what of it is judged."""
    mould = Mould.load(str(mesh))
    order = {
        "mould": str(mesh), "unit": "mm", "arm": "ideal", "sensor": "wrist", "force": "10.0", "feed": "0.02",
        "rate": "200.0", "seed": "0",
    }  # fmt: skip
    about = {"order": order, "course": Course(recipe=recipe).as_record(), "mould_sha256": mould.sha256}
    folder.mkdir()
    with Journal(folder / NAME, about) as file:
        file.add(Mark(number=1, stroke=1, s=0.06, phase=phase, force=10.0, t=40.0, metres=0.06, joules=0.18))
    return mould, Ground.of(mould, DistanceGrid.of(mould), recipe)


def hollow(ground: Ground) -> Array:
    """The wanted depth, but half of it over a disc in the middle."""
    away = np.hypot(*ground.surface.vertices[:, :2].T)
    return np.where(away < 9e-3, 0.5, 1.0) * DEPTH


@pytest.fixture
def plate(tmp_path: Path) -> Path:
    return small_plate(tmp_path / "p.stl", size=44.0)


def test_even_work_needs_no_repair_and_says_so_in_one_line(
    plate: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mould, ground = worked(tmp_path / "run", plate, RECIPE)
    keep(tmp_path / "run", np.full(len(ground.counted), DEPTH), mould, REMOVED)
    words = ["--mould", str(plate), "--repair", str(tmp_path / "run")]
    assert main(["polish", *words, "--out", str(tmp_path / "again")]) == 0
    said = capsys.readouterr().out
    assert "nothing lacks" in said
    assert len(said.splitlines()) == 1
    assert not (tmp_path / "again").exists()
    assert main(["plan", *words, "--out", str(tmp_path / "plan.json")]) == 0
    assert not (tmp_path / "plan.json").exists()


@pytest.mark.parametrize("phase", ["done", "stopped"])
def test_repair_plan_works_what_lacks_and_nothing_else(
    phase: str, plate: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mould, ground = worked(tmp_path / "run", plate, RECIPE, phase)
    keep(tmp_path / "run", hollow(ground), mould, REMOVED)
    words = ["--mould", str(plate), "--repair", str(tmp_path / "run"), "--out", str(tmp_path / "plan.json")]
    assert main(["plan", *words]) == 0
    plan = load_plan(tmp_path / "plan.json")
    assert plan.recipe == RECIPE
    for stroke in plan.strokes:
        assert stroke.tilt == TILT
        assert np.hypot(*stroke.points[:, :2].T).max() < 12e-3
    printed = capsys.readouterr().out
    assert "repair of 1 place" in printed
    assert "removal" in printed


def test_repair_of_what_cannot_be_known_is_refused(
    plate: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    worked(tmp_path / "run", plate, RECIPE)
    worked(tmp_path / "still", plate, Recipe())
    other = small_plate(tmp_path / "q.stl", size=40.0)

    def said(folder: str, *words: str) -> str:
        return refusal(capsys, "polish", "--repair", str(tmp_path / folder), "--out", str(tmp_path / "again"), *words)

    assert "removed.npz cannot be read" in said("run", "--mould", str(plate))
    assert "did not spin" in said("still", "--mould", str(plate))
    assert "fingerprint" in said("run", "--mould", str(other))
    assert "with --mould" in said("run")
    assert "leave out --pattern" in said("run", "--mould", str(plate), "--pattern", "spiral")
    assert "no journal" in said("nowhere", "--mould", str(plate))
    assert not (tmp_path / "again").exists()


def test_job_that_spins_says_so_in_its_journal(plate: Path, tmp_path: Path) -> None:
    worked(tmp_path / "run", plate, RECIPE)
    assert earlier(tmp_path / "run").course.recipe == RECIPE


@pytest.mark.slow
def test_repair_is_run_and_judged_together_with_the_work_before(plate: Path, tmp_path: Path) -> None:
    mould, ground = worked(tmp_path / "run", plate, RECIPE)
    before = hollow(ground)
    keep(tmp_path / "run", before, mould, REMOVED)
    out = tmp_path / "again"
    assert main(["polish", "--mould", str(plate), "--repair", str(tmp_path / "run"), "--out", str(out)]) == 0
    found = json.loads((out / "metrics.json").read_text())
    assert found["removal_cv_before_pct"] == pytest.approx(ground.judged(before, DEPTH).cv_pct)
    assert found["removal_cv_pct"] < 0.5 * found["removal_cv_before_pct"]
    count = len(ground.counted)
    np.testing.assert_array_equal(removed(out, mould, count, BEFORE), before)
    assert ((removed(out, mould, count, REMOVED) - before) >= 0.0).all()
    page = (out / "part.html").read_text()
    assert "after a repair" in page
    assert "Roughness Ra, estimated" in page
    assert main(["verify", str(out / "run.mcap"), "--mould", str(plate)]) == 0
    # A repair is a job like any other: what it left can be repaired again.
    assert main(["polish", "--mould", str(plate), "--repair", str(out), "--out", str(tmp_path / "third")]) == 0
