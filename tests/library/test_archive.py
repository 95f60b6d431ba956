"""A backup is whole while others write, and brings everything back, on either database."""

from __future__ import annotations

import threading
import zipfile
from pathlib import Path

import pytest
from library.made import job, recipe

from burnish.errors import InputError
from burnish.library import Library


def test_backup_of_one_library_is_restored_into_an_empty_one(library: Library, url: str | None, tmp_path: Path) -> None:
    kept = library.tag(library.add_recipe(recipe(tmp_path)), "felt")
    run = library.add_run(job(tmp_path / "job"))
    binned = library.bin(library.add_recipe(recipe(tmp_path, 5.0)))
    assert library.backup(tmp_path / "all.zip") == 3
    # Into the other kind of database where this one is a server's.
    with Library.open(tmp_path / "other") as other:
        assert other.restore_from(tmp_path / "all.zip") == 3
        assert (other.recipes(), other.runs(), other.binned()) == ([kept], [run], [binned])
        assert other.file(run).read_bytes() == (tmp_path / "job" / "run.mcap").read_bytes()
        assert other.check() == []


def test_library_that_holds_something_is_overwritten_only_when_asked(library: Library, tmp_path: Path) -> None:
    saved = library.add_recipe(recipe(tmp_path))
    library.backup(tmp_path / "all.zip")
    gone = library.file(library.add_recipe(recipe(tmp_path, 5.0)))
    with pytest.raises(InputError, match=r"holds 2 rows.*--overwrite"):
        library.restore_from(tmp_path / "all.zip")
    assert library.restore_from(tmp_path / "all.zip", overwrite=True) == 1
    assert library.recipes() == [saved]
    assert not gone.exists()
    assert library.check() == []


def test_backup_is_whole_while_others_enter_rename_and_remove(library: Library, tmp_path: Path) -> None:
    rows = [library.add_recipe(recipe(tmp_path, 3.0 + 0.1 * i)) for i in range(20)]
    stop = threading.Event()

    def work() -> None:
        for row in rows:
            if stop.is_set():
                return
            library.bin(library.rename(row, "renamed"))
            library.empty_bin()

    thread = threading.Thread(target=work)
    thread.start()
    try:
        saved = [library.backup(tmp_path / f"{number}.zip") for number in range(5)]
    finally:
        stop.set()
        thread.join()
    for number, count in enumerate(saved):
        with Library.open(tmp_path / f"library {number}") as other:
            assert other.restore_from(tmp_path / f"{number}.zip") == count
            assert other.check() == []


def test_older_backup_is_not_overwritten(library: Library, tmp_path: Path) -> None:
    (tmp_path / "all.zip").write_bytes(b"older")
    with pytest.raises(InputError, match="exists"):
        library.backup(tmp_path / "all.zip")
    assert (tmp_path / "all.zip").read_bytes() == b"older"


def test_damaged_file_of_the_library_is_not_saved_as_if_it_were_whole(library: Library, tmp_path: Path) -> None:
    library.file(library.add_recipe(recipe(tmp_path))).write_bytes(b"altered")
    with pytest.raises(InputError, match="was altered"):
        library.backup(tmp_path / "all.zip")
    assert list(tmp_path.glob("*all.zip*")) == []


def rewritten(archive: Path, change: dict[str, bytes | None]) -> Path:
    """A copy with other members: each name's ending, and what it holds then, or None to leave it out."""
    copy = archive.with_name("changed.zip")
    with zipfile.ZipFile(archive) as old, zipfile.ZipFile(copy, "w") as new:
        for name in old.namelist():
            content: bytes | None = old.read(name)
            for ending, other in change.items():
                content = other if name.endswith(ending) else content
            if content is not None:
                new.writestr(name, content)
    return copy


@pytest.mark.parametrize(
    "change", [{".toml": b"altered"}, {".toml": None}, {".json": b"{}"}, {".json": b"x" * 2_000_000}]
)
def test_damaged_archive_is_refused_and_changes_nothing(tmp_path: Path, change: dict[str, bytes | None]) -> None:
    with Library.open(tmp_path / "library") as library:
        row = library.add_recipe(recipe(tmp_path))
        library.backup(tmp_path / "all.zip")
        with pytest.raises(InputError):
            library.restore_from(rewritten(tmp_path / "all.zip", change), overwrite=True)
        assert library.recipes() == [row]
        assert library.check() == []


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 no archive", b"PK\x05\x06" + bytes(18) + b"tail"])
def test_what_is_no_archive_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "no.zip").write_bytes(content)
    with Library.open(tmp_path / "library") as library:
        if content.startswith(b"PK\x05"):
            assert library.restore_from(tmp_path / "no.zip") == 0
        else:
            with pytest.raises(InputError, match=r"no\.zip"):
                library.restore_from(tmp_path / "no.zip")
        with pytest.raises(InputError, match="missing"):
            library.restore_from(tmp_path / "missing.zip")


def test_card_of_an_archive_cannot_name_a_file_outside_the_library(tmp_path: Path) -> None:
    with Library.open(tmp_path / "library") as library:
        library.add_recipe(recipe(tmp_path))
        library.backup(tmp_path / "all.zip")
        with zipfile.ZipFile(tmp_path / "all.zip") as archive:
            card = next(name for name in archive.namelist() if name.startswith("cards/"))
            text = archive.read(card).decode()
        evil = text.replace('".toml"', '"/../../../evil"').encode()
        with pytest.raises(InputError, match="ending"):
            library.restore_from(rewritten(tmp_path / "all.zip", {".json": evil}), overwrite=True)
    assert not (tmp_path / "evil").exists()
