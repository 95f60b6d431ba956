"""What is missing, altered or too much is found, and a database comes back from the files."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path

import pytest
from library.made import job, recipe
from library.postgres import Server
from sqlalchemy import text

from burnish.errors import InputError
from burnish.library import Library, RecipeRow
from burnish.library.cards import card_path


@pytest.fixture
def row(library: Library, tmp_path: Path) -> RecipeRow:
    return library.tag(library.add_recipe(recipe(tmp_path)), "felt")


def said(library: Library) -> str:
    return "\n".join(map(str, library.check()))


def test_missing_and_altered_files_are_found_and_a_backup_is_asked_for(library: Library, row: RecipeRow) -> None:
    path = library.file(row)
    whole = path.read_bytes()
    path.write_bytes(whole.replace(b"10", b"20"))
    assert "was altered" in said(library)
    path.write_bytes(whole[:-1])
    assert f"has {len(whole) - 1} bytes instead of {len(whole)}" in said(library)
    path.unlink()
    assert "its recipe is missing" in said(library)
    assert "from a backup" in said(library)
    with pytest.raises(InputError, match="burnish db check"):
        library.file(row)
    path.write_bytes(whole)
    assert said(library) == ""


def test_link_in_the_place_of_a_file_is_not_followed(library: Library, row: RecipeRow, tmp_path: Path) -> None:
    path = library.file(row)
    secret = tmp_path / "secret"
    secret.write_bytes(path.read_bytes())
    path.unlink()
    path.symlink_to(secret)
    assert "is a link" in said(library)
    with pytest.raises(InputError, match="missing"):
        library.file(row)


def test_file_that_no_row_has_is_found_and_moved_to_lost(library: Library, row: RecipeRow) -> None:
    stray = library.root / "files" / "zz" / "stray.stl"
    stray.parent.mkdir()
    stray.write_bytes(b"solid")
    assert "files/zz/stray.stl: no row has this file" in said(library)
    assert [finding.where for finding in library.reindex().findings] == ["files/zz/stray.stl"]
    assert [path.read_bytes() for path in (library.root / "lost").glob("*/stray.stl")] == [b"solid"]
    assert said(library) == ""


def test_row_without_a_card_and_card_without_a_row_are_found_and_mended(library: Library, row: RecipeRow) -> None:
    card = card_path(library.root, row.id)
    card.unlink()
    assert "its card is missing" in said(library)
    assert library.reindex().rows == 1
    assert card.exists()
    with library.database.connection() as connection:
        connection.execute(text("DELETE FROM entries"))
    assert "the database does not know it" in said(library)
    assert library.reindex().rows == 1
    assert library.recipes() == [row]
    assert said(library) == ""


def test_card_that_somebody_wrote_by_hand_wins_over_the_database(library: Library, row: RecipeRow) -> None:
    card = card_path(library.root, row.id)
    card.write_text(json.dumps(json.loads(card.read_text()) | {"name": "by hand"}))
    assert "its card says something else" in said(library)
    assert library.reindex().findings == ()
    assert [found.name for found in library.recipes()] == ["by hand"]


@pytest.mark.parametrize("damage", [b"", b"{", b"[]", b'{"format": "burnish library 1", "kind": "recipe"}'])
def test_damaged_card_is_written_anew_from_its_row(library: Library, row: RecipeRow, damage: bytes) -> None:
    card_path(library.root, row.id).write_bytes(damage)
    assert len(library.check()) == 1
    assert "written anew" in str(library.reindex().findings[0])
    assert library.recipes() == [row]
    assert said(library) == ""


def noise(path: Path) -> None:
    path.write_bytes(os.urandom(40_000))


def header(path: Path) -> None:
    path.write_bytes(b"no database at all" * 100)


def gone(path: Path) -> None:
    path.unlink()


def cut(path: Path) -> None:
    os.truncate(path, path.stat().st_size // 2)


def page(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[8192:12288] = os.urandom(4096)
    path.write_bytes(content)


@pytest.mark.parametrize("damage", [noise, header, gone, cut, page])
def test_destroyed_database_comes_back_from_the_files_with_all_rows(
    tmp_path: Path, damage: Callable[[Path], None]
) -> None:
    with Library.open(tmp_path / "library") as library:
        first = library.note(library.tag(library.add_recipe(recipe(tmp_path)), "felt"), "kept")
        second = library.bin(library.add_run(job(tmp_path / "job")))
    damage(tmp_path / "library" / "burnish.db")
    with Library.at(tmp_path / "library") as library:
        assert library.reindex().rows == 2
    with Library.open(tmp_path / "library") as library:
        assert library.recipes() == [first]
        assert library.binned() == [second]
        assert library.check() == []


def test_damaged_database_is_refused_with_what_to_do(tmp_path: Path) -> None:
    Library.open(tmp_path).close()
    noise(tmp_path / "burnish.db")
    with pytest.raises(InputError, match="burnish db reindex"):
        Library.open(tmp_path)


@pytest.mark.parametrize("statement", ["DROP SCHEMA public CASCADE; CREATE SCHEMA public", "DROP TABLE runs"])
def test_server_s_tables_that_were_lost_come_back_from_the_files(
    server: Server, tmp_path: Path, statement: str
) -> None:
    url = server.database()
    with Library.open(tmp_path / "library", url) as library:
        row = library.add_recipe(recipe(tmp_path))
        with library.database.connection() as connection:
            for part in statement.split(";"):
                connection.execute(text(part))
    with Library.at(tmp_path / "library", url) as library:
        assert library.reindex().rows == 1
        assert library.recipes() == [row]
        assert said(library) == ""
