"""Jobs as they are entered: whole, cut off, campaigns; and what is not what it says."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from library.made import campaign, demonstration, job, recipe

from burnish.errors import InputError, RecordingError
from burnish.library import Library
from burnish.record.recording import Recording


@pytest.fixture
def library(tmp_path: Path) -> Iterator[Library]:
    with Library.open(tmp_path / "library") as opened:
        yield opened


def test_whole_job_is_entered_with_what_its_recording_and_figures_say(library: Library, tmp_path: Path) -> None:
    row = library.add_run(job(tmp_path / "left door"))
    assert (row.name, row.verb, row.mould, row.arm, row.ended) == ("left door", "polish", "dome", "honest", "done")
    assert (row.duration, row.metrics["force_rms_N"]) == (3.0, 0.5)
    assert row.folder == str(tmp_path / "left door")
    assert [file.role for file in row.files] == ["recording", "metrics", "journal", "report"]


def test_job_that_was_cut_off_is_entered_as_lost_with_its_recording_mended(library: Library, tmp_path: Path) -> None:
    row = library.add_run(job(tmp_path / "job", cut=True))
    assert row.ended == "lost"
    assert row.outcome.startswith("lost: ")
    recording = Recording(library.file(row))
    assert recording.mended
    assert sum(map(len, recording.blocks())) > 100
    # Entered again unchanged it is the same row.
    assert library.add_run(tmp_path / "job").id == row.id


@pytest.mark.parametrize(
    ("outcome", "ended"),
    [
        ("done", "done"),
        ("interrupted", "interrupted"),
        ("paused: the abrasive is worn", "paused"),
        ("stopped by the supervisor: force", "stopped"),
        ("stopped: the mould was not found", "stopped"),
        ("cancelled", "cancelled"),
        ("", "lost"),
        ("whatever", "lost"),
    ],
)
def test_ending_is_the_first_word_of_the_outcome(
    library: Library, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, outcome: str, ended: str
) -> None:
    original = Recording.__init__

    def without_ending(self: Recording, path: Path) -> None:
        original(self, path)
        self.ending = {}

    monkeypatch.setattr(Recording, "__init__", without_ending)
    assert library.add_run(job(tmp_path / "job", outcome=outcome)).ended == ended


def test_campaign_is_entered_with_its_plain_figures(library: Library, tmp_path: Path) -> None:
    row = library.add_run(campaign(tmp_path / "campaign"))
    assert (row.verb, row.ended, row.duration) == ("campaign", "interrupted", 1800.0)
    assert row.metrics == {"episodes": 3, "virtual_hours": 0.5, "interrupted": True}


def test_folder_without_a_job_is_refused(library: Library, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    for folder in (tmp_path / "empty", tmp_path / "nowhere", recipe(tmp_path)):
        with pytest.raises(InputError):
            library.add_run(folder)
    assert library.check() == []


def test_folder_whose_name_cannot_be_shown_is_refused(library: Library, tmp_path: Path) -> None:
    for name in ("two\nlines", os.fsdecode(b"\xff")):
        with pytest.raises(InputError, match="cannot be shown"):
            library.add_run(job(tmp_path / name))


def test_link_in_a_job_s_folder_is_not_followed(library: Library, tmp_path: Path) -> None:
    folder = job(tmp_path / "job")
    (folder / "report.html").unlink()
    (folder / "report.html").symlink_to("/etc/hostname")
    with pytest.raises(InputError, match="is a link"):
        library.add_run(folder)


@pytest.mark.parametrize("content", ["no json", "[]", '{"a": NaN}', '{"a": 1e999}', '{"a": 99999999999999999999}'])
def test_figures_that_are_none_are_refused(library: Library, tmp_path: Path, content: str) -> None:
    folder = job(tmp_path / "job")
    (folder / "metrics.json").write_text(content)
    with pytest.raises(InputError):
        library.add_run(folder)
    assert library.runs() == []


def test_recording_that_is_none_is_refused_by_its_own_name(library: Library, tmp_path: Path) -> None:
    folder = job(tmp_path / "job")
    (folder / "run.mcap").write_bytes(b"no recording")
    with pytest.raises(RecordingError, match=r"job/run\.mcap"):
        library.add_run(folder)


def test_journal_that_is_none_is_refused(library: Library, tmp_path: Path) -> None:
    folder = job(tmp_path / "job")
    (folder / "journal.jsonl").write_text(json.dumps({"format": "another"}) + "\n")
    with pytest.raises(RecordingError, match="no journal"):
        library.add_run(folder)


def test_demonstration_is_refused_where_nothing_was_shown(library: Library, tmp_path: Path) -> None:
    row = library.add_demonstration(demonstration(tmp_path))
    assert (row.name, row.mould, row.device) == ("dome, by a hand", "dome", "a hand")
    assert row.duration > 0.0
    assert 0.0 < row.contact <= 1.0
    with pytest.raises(RecordingError, match="of 'polish'"):
        library.add_demonstration(job(tmp_path / "job") / "run.mcap")
