"""``burnish db`` and what the verbs enter, as a user meets them."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import pytest
from commands.test_cli import refusal, small_plate
from library.made import job, recipe

from burnish.cli import main
from burnish.commands import db
from burnish.commands.db_options import add_db
from burnish.commands.entered import entered
from burnish.errors import BurnishError, InputError
from burnish.library import Library


def run(*words: str) -> int:
    """The verb by itself."""
    parser = argparse.ArgumentParser()
    add_db(parser)
    return db.run(parser.parse_args(words))


@pytest.fixture
def library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A library with one recipe, which all commands find by the environment."""
    monkeypatch.setenv("BURNISH_LIBRARY", str(tmp_path / "library"))
    with Library.open() as opened:
        opened.add_recipe(recipe(tmp_path))
    return tmp_path / "library"


def test_init_makes_a_library_and_says_what_is_in_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for _ in range(2):
        assert run("--library", str(tmp_path / "new"), "init") == 0
        said = capsys.readouterr().out
        assert str(tmp_path / "new") in said
        assert "0 moulds, 0 tools, 0 recipes, 0 demonstrations, 0 plans, 0 runs" in said


def test_check_says_what_is_wrong_and_what_to_do(library: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("check") == 0
    assert "in order" in capsys.readouterr().out
    next(library.glob("files/*/*.toml")).unlink()
    assert run("check") == 1
    said = capsys.readouterr().out
    assert "is missing" in said
    assert "backup" in said


def test_reindex_brings_a_destroyed_database_back(library: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (library / "burnish.db").write_bytes(b"noise" * 1000)
    with pytest.raises(BurnishError, match="burnish db reindex"):
        run("init")
    assert run("reindex") == 0
    assert "1 rows" in capsys.readouterr().out
    assert run("check") == 0


def test_backup_and_restore_move_a_library(library: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    archive, other = str(tmp_path / "all.zip"), str(tmp_path / "other")
    assert run("backup", archive) == 0
    assert run("--library", other, "restore", archive) == 0
    with pytest.raises(InputError, match="--overwrite"):
        run("--library", other, "restore", archive)
    assert run("--library", other, "restore", archive, "--overwrite") == 0
    with Library.open(other) as opened:
        assert [row.name for row in opened.recipes()] == ["force 10"]


def test_upgrade_says_from_which_version_to_which(library: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("upgrade") == 0
    assert "version 0001 → 0001" in capsys.readouterr().out


def test_job_is_entered_with_its_mould_and_recipe(library: Path, tmp_path: Path) -> None:
    mould = small_plate(tmp_path / "part.stl")
    entered(job(tmp_path / "job"), mould=str(mould), recipe=str(recipe(tmp_path, 5.0)))
    entered(job(tmp_path / "bundled"), mould="dome")
    with Library.open() as opened:
        assert [row.name for row in opened.runs()] == ["bundled", "job"]
        assert [row.name for row in opened.moulds()] == ["part"]
        assert [row.force for row in opened.recipes()] == [5.0, 10.0]


def test_library_that_cannot_be_written_is_said_in_one_line_and_nothing_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_bytes(b"")
    monkeypatch.setenv("BURNISH_LIBRARY", str(tmp_path / "file"))
    entered(job(tmp_path / "job"))
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 1
    assert said[0].startswith("burnish: not entered into the library: ")


def test_refused_job_enters_nothing(library: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    refusal(capsys, "polish", "--mould", str(small_plate(tmp_path / "part.stl")), "--force", "99")
    with Library.open() as opened:
        assert (opened.runs(), opened.moulds()) == ([], [])


def test_campaign_is_entered(library: Path, tmp_path: Path) -> None:
    out = tmp_path / "campaign"
    main(["campaign", "--episodes", "1", "--jobs", "1", "--out", str(out)])
    assert json.loads((out / "campaign.json").read_text())["interrupted"] is False
    with Library.open() as opened:
        assert [(row.verb, row.ended, row.name) for row in opened.runs()] == [("campaign", "done", "campaign")]


@pytest.mark.slow
def test_polish_teach_and_replay_are_entered(library: Path, tmp_path: Path) -> None:
    mould = str(small_plate(tmp_path / "part.stl"))
    assert main(["polish", "--mould", mould, "--out", str(tmp_path / "polished")]) == 0
    assert main(["teach", "--device", "hand", "--yes", "--out", str(tmp_path / "taught")]) == 0
    assert main(["replay", str(tmp_path / "taught" / "run.mcap"), "--yes", "--out", str(tmp_path / "replayed")]) == 0
    with Library.open() as opened:
        assert [(row.verb, row.ended) for row in opened.runs()] == [
            ("replay", "done"),
            ("teach", "done"),
            ("polish", "done"),
        ]
        assert [row.mould for row in opened.demonstrations()] == ["dome"]
        assert [row.name for row in opened.moulds()] == ["part"]
        assert opened.runs(mould=opened.moulds()[0].geometry)[0].verb == "polish"
        assert opened.check() == []
