"""The database: its settings, its versions, and what is said when it cannot be used."""

from __future__ import annotations

import sqlite3
import sys
import threading
from datetime import datetime, timedelta, timezone
from importlib import resources
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from library.made import recipe
from sqlalchemy import text

from burnish.errors import InputError
from burnish.library import Library
from burnish.library.database import HEAD, Database
from burnish.library.tables import Base


def test_migrations_lead_to_the_very_tables_that_the_program_uses(library: Library) -> None:
    with library.database.connection() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        assert compare_metadata(context, Base.metadata) == []


def test_the_program_s_version_is_the_newest_migration() -> None:
    config = Config()
    config.set_main_option("script_location", str(resources.files("burnish.library") / "migrations"))
    assert ScriptDirectory.from_config(config).get_heads() == [HEAD]


def test_sqlite_is_set_to_survive_and_to_keep_its_keys(tmp_path: Path) -> None:
    with Library.open(tmp_path) as library, library.database.connection() as connection:
        values = {
            name: connection.execute(text(f"PRAGMA {name}")).scalar()
            for name in ("journal_mode", "synchronous", "foreign_keys", "busy_timeout")
        }
    assert values == {"journal_mode": "wal", "synchronous": 2, "foreign_keys": 1, "busy_timeout": 30_000}


def test_tag_of_no_row_is_refused_by_the_database(library: Library) -> None:
    with pytest.raises(InputError, match=r"(?i)foreign key"), library.database.session() as session:
        session.execute(text("INSERT INTO tags (entry_id, word) VALUES ('nobody', 'felt')"))


def test_time_comes_back_as_the_same_moment_in_utc(library: Library, tmp_path: Path) -> None:
    row = library.add_recipe(recipe(tmp_path))
    found = library.recipes()[0]
    assert found.created == row.created
    assert found.created.tzinfo == timezone.utc
    assert abs(found.created - datetime.now(timezone.utc)) < timedelta(minutes=1)


def twice(library: Library, statement: str) -> None:
    """The same statement two times in one transaction."""
    with library.database.session() as session:
        session.execute(text(statement))
        session.execute(text(statement))


def test_transaction_that_fails_leaves_nothing(library: Library) -> None:
    with pytest.raises(InputError, match=r"(?i)unique|exists"):
        twice(library, "INSERT INTO alembic_version (version_num) VALUES ('9999')")
    assert library.database.version() == HEAD


@pytest.mark.parametrize(("version", "said"), [("0000", "burnish db upgrade"), ("9999", "newer program")])
def test_database_of_another_version_is_refused(library: Library, url: str | None, version: str, said: str) -> None:
    with library.database.connection() as connection:
        connection.execute(text(f"UPDATE alembic_version SET version_num = '{version}'"))
    with pytest.raises(InputError, match=said):
        Library.open(library.root, url)


def test_missing_driver_is_named_with_the_package_that_brings_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pg8000", None)
    with pytest.raises(InputError, match=r"'pg8000'.*burnish\[postgresql\]"):
        Database("postgresql://user@localhost/library", tmp_path)


@pytest.mark.parametrize("url", ["nonsense", "mysql://user@host/name", "postgresql+none://host/name", "://"])
def test_url_that_is_none_of_ours_is_refused(tmp_path: Path, url: str) -> None:
    with pytest.raises(InputError, match="expected postgresql://"):
        Database(url, tmp_path)


def test_server_that_does_not_answer_is_refused_without_its_password(tmp_path: Path) -> None:
    with pytest.raises(InputError) as refused:
        Library.open(tmp_path, "postgresql://user:secret@127.0.0.1:1/library")
    assert "secret" not in str(refused.value)
    assert "127.0.0.1" in str(refused.value)


def test_folder_and_url_come_from_the_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("BURNISH_LIBRARY")
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    assert Library.at().root == tmp_path / "data" / "burnish"
    monkeypatch.setenv("XDG_DATA_HOME", "")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert Library.at().root == tmp_path / "home" / ".local" / "share" / "burnish"
    monkeypatch.setenv("BURNISH_LIBRARY", str(tmp_path / "library"))
    monkeypatch.setenv("BURNISH_DATABASE", f"sqlite:///{tmp_path}/elsewhere.db")
    with Library.open() as library:
        assert library.root == tmp_path / "library"
        assert (tmp_path / "elsewhere.db").exists()


def test_library_in_a_place_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(InputError, match="making the library"):
        Library.open(tmp_path / "file" / "library")


def test_two_that_begin_a_database_at_once_wait_for_each_other(tmp_path: Path) -> None:
    # SQLite itself does not wait where a database that another one is writing shall be written ahead.
    other = sqlite3.connect(tmp_path / "burnish.db", isolation_level=None, check_same_thread=False)
    other.execute("BEGIN IMMEDIATE")
    done = threading.Timer(0.3, other.execute, ["COMMIT"])
    done.start()
    with Library.open(tmp_path) as library:
        assert library.everything() == []
    done.join()
    other.close()
