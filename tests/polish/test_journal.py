"""The run's journal: what was written is read again, whatever happened to its end."""

from __future__ import annotations

from pathlib import Path

import pytest

from burnish.errors import RecordingError
from burnish.polish.journal import Journal, Mark, read


def marks(count: int = 5) -> list[Mark]:
    return [
        Mark(number=1, stroke=2, s=1e-3 * k, phase="pass", force=9.9, t=0.05 * k, metres=1e-3 * k, joules=3e-3 * k)
        for k in range(count)
    ]


def written(path: Path, found: list[Mark]) -> Path:
    with Journal(path, {"mould_sha256": "ab"}) as journal:
        for mark in found:
            journal.add(mark)
    return path


def test_what_is_written_is_read(tmp_path: Path) -> None:
    about, found = read(written(tmp_path / "journal.jsonl", marks()))
    assert about["mould_sha256"] == "ab"
    assert found == marks()


def test_torn_last_line_is_left_out_wherever_it_was_cut(tmp_path: Path) -> None:
    path = written(tmp_path / "journal.jsonl", marks())
    text = path.read_bytes()
    last = text[:-1].rfind(b"\n") + 1
    for size in range(last, len(text)):
        path.write_bytes(text[:size])
        assert read(path)[1] == marks()[:-1]


def test_journal_goes_on_behind_a_torn_line(tmp_path: Path) -> None:
    path = written(tmp_path / "journal.jsonl", marks())
    path.write_bytes(path.read_bytes()[:-7])
    written(path, marks(2))
    assert read(path)[1] == marks()[:-1] + marks(2)


def test_damage_before_the_last_line_is_refused_with_its_number(tmp_path: Path) -> None:
    path = written(tmp_path / "journal.jsonl", marks())
    lines = path.read_bytes().split(b"\n")
    for bad in (b"\x00\xff", b"[1]", b'{"number": 1}', lines[3].replace(b"9.9", b"NaN"), b"[" * 100_000):
        path.write_bytes(b"\n".join([*lines[:3], bad, *lines[4:]]))
        with pytest.raises(RecordingError, match="line 4"):
            read(path)


@pytest.mark.parametrize("text", ["", "{}\n", '{"format": "something else"}\n'])
def test_another_file_is_no_journal(tmp_path: Path, text: str) -> None:
    path = tmp_path / "journal.jsonl"
    path.write_text(text)
    with pytest.raises(RecordingError, match="no journal"):
        read(path)


def test_missing_folder_is_said(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="no journal at"):
        read(tmp_path / "nowhere" / "journal.jsonl")
