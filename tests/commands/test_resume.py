"""Stopping and going on with a job, as a user meets it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from commands.test_cli import refusal, small_plate

from burnish.cli import main
from burnish.commands.course import Course, earlier
from burnish.polish.cellsim import plan_strokes
from burnish.polish.journal import NAME, Journal, Mark, read
from burnish.polish.recipe import Recipe
from burnish.surface import DistanceGrid, Mould


def journal(folder: Path, mesh: Path, *phases: str) -> None:
    """A job that was stopped at 60 mm of its first stroke."""
    order = {
        "mould": str(mesh), "unit": "mm", "arm": "honest", "sensor": "wrist", "force": "10.0", "feed": "0.02",
        "rate": "100.0", "seed": "0",
    }  # fmt: skip
    about = {"order": order, "course": Course().as_record(), "mould_sha256": Mould.load(str(mesh)).sha256}
    folder.mkdir()
    with Journal(folder / NAME, about) as file:
        for phase in phases:
            file.add(Mark(number=1, stroke=1, s=0.06, phase=phase, force=10.0, t=40.0, metres=0.06, joules=0.18))


def test_resume_begins_where_the_journal_ends(tmp_path: Path) -> None:
    mesh = small_plate(tmp_path / "p.stl")
    journal(tmp_path / "run", mesh, "pass", "stopped")
    course = earlier(tmp_path / "run").course
    mould = Mould.load(str(mesh))
    grid = DistanceGrid.of(mould)
    left = course.left(course.legs(mould, grid))
    whole = plan_strokes(mould, grid, Recipe(), course.recipe.tool)
    assert left[0].begun + left[0].lead == pytest.approx(0.06)
    assert left[0].begun + left[0].path.length == pytest.approx(whole[0].length)
    assert course.runs == 1


def test_change_of_the_abrasive_begins_a_new_count(tmp_path: Path) -> None:
    mesh = small_plate(tmp_path / "p.stl")
    journal(tmp_path / "a", mesh, "pass", "stopped")
    journal(tmp_path / "b", mesh, "pass", "change")
    assert not earlier(tmp_path / "a").changed
    assert earlier(tmp_path / "b").changed


def test_finished_job_and_other_moulds_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh, other = small_plate(tmp_path / "p.stl"), small_plate(tmp_path / "q.stl", size=40.0)
    journal(tmp_path / "done", mesh, "pass", "done")
    journal(tmp_path / "run", mesh, "pass", "stopped")
    assert "is done" in refusal(capsys, "polish", "--mould", str(mesh), "--resume", str(tmp_path / "done"))
    assert "fingerprint" in refusal(capsys, "polish", "--mould", str(other), "--resume", str(tmp_path / "run"))
    assert "with --mould" in refusal(capsys, "polish", "--resume", str(tmp_path / "run"))
    assert "no journal" in refusal(capsys, "polish", "--resume", str(tmp_path / "nowhere"))


def test_folder_of_a_job_is_not_written_over(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh = small_plate(tmp_path / "p.stl")
    journal(tmp_path / "run", mesh, "pass", "stopped")
    assert "holds a job already" in refusal(capsys, "polish", "--mould", str(mesh), "--out", str(tmp_path / "run"))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--passes", "0"), "1 to 20"),
        (("--skip", "9"), "no stroke 9 to skip"),
        (("--skip", "one"), "skip"),
        (("--abrasive-life", "-1"), "abrasive-life"),
        (("--pattern", "zigzag"), "zigzag"),
    ],
)
def test_bad_course_is_refused_in_one_line(
    words: tuple[str, ...], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mesh = small_plate(tmp_path / "p.stl")
    assert said in refusal(capsys, "polish", "--mould", str(mesh), "--out", str(tmp_path / "out"), *words)
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_worn_abrasive_stops_the_job_which_goes_on_to_its_end(tmp_path: Path) -> None:
    mesh, out = str(small_plate(tmp_path / "p.stl")), tmp_path / "run"
    assert main(["polish", "--mould", mesh, "--abrasive-life", "0.15", "--out", str(out)]) == 130
    assert read(out / NAME)[1][-1].phase == "change"
    half = json.loads((out / "metrics.json").read_text())
    assert main(["polish", "--mould", mesh, "--resume", str(out)]) == 0
    assert read(out / NAME)[1][-1].phase == "done"
    whole = json.loads((out / "metrics.json").read_text())
    assert whole["coverage_pct"] > half["coverage_pct"] + 20.0
    assert (out / "part.html").exists()
    for name in ("run.mcap", "run-2.mcap"):
        assert main(["verify", str(out / name), "--mould", mesh]) == 0
