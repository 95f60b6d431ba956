"""The database: where it is, what a connection to it is set to, and in which version its tables are."""

from __future__ import annotations

import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import resources
from pathlib import Path
from typing import Any

from sqlalchemy import URL, Connection, Engine, create_engine, event, inspect, make_url, text
from sqlalchemy.exc import ArgumentError, NoSuchModuleError, SQLAlchemyError
from sqlalchemy.orm import Session

from burnish.errors import InputError
from burnish.library.tables import Base

NAME = "burnish.db"
"""Of an SQLite database in the library's folder."""
HEAD = "0001"
"""Version of the tables that this program reads and writes."""
PATIENCE = 30.0
"""How long a connection waits for another one to finish its work [s]."""


class Database:
    """A database; safe to be used by several threads and processes."""

    def __init__(self, url: str | None, root: Path) -> None:
        """Prepare it; nothing is connected yet.

        Args:
            url: such as ``postgresql://user@host/name``; None for SQLite in the library's folder.
            root: of the library.

        Raises:
            InputError: if the URL is none, or the database's driver is missing.
        """
        self.url = _checked(url) if url else URL.create("sqlite", database=str(root / NAME))
        try:
            self._engine = create_engine(self.url, **_settings(self.url))
        except ModuleNotFoundError as error:
            raise InputError(
                f"the database {self.shown} needs the Python package {error.name!r}, which is missing; "
                "install it with: pip install 'burnish[postgresql]'"
            ) from None
        if self.is_sqlite:
            _prepare_sqlite(self._engine)

    @property
    def is_sqlite(self) -> bool:
        """Whether it is a file of the library's folder."""
        return self.url.get_backend_name() == "sqlite"

    @property
    def file(self) -> Path:
        """The file of an SQLite database."""
        return Path(self.url.database or "")

    @property
    def shown(self) -> str:
        """Its URL without the password."""
        return self.url.render_as_string(hide_password=True)

    def close(self) -> None:
        """Give all connections back."""
        self._engine.dispose()

    @contextmanager
    def session(self) -> Iterator[Session]:
        """A transaction: what was done in it is kept as a whole when it ends well, and else not at all.

        Raises:
            InputError: if the database cannot be reached, is damaged, or refuses.
        """
        with self.speaking(), Session(self._engine, expire_on_commit=False) as session, session.begin():
            yield session

    @contextmanager
    def connection(self) -> Iterator[Connection]:
        """The same below the mapping, for its version.

        Raises:
            InputError: as above.
        """
        with self.speaking(), self._engine.begin() as connection:
            yield connection

    @contextmanager
    def speaking(self) -> Iterator[None]:
        """Turn a database's error into one line.

        Raises:
            InputError: whatever the database said.
        """
        try:
            yield
        except (SQLAlchemyError, sqlite3.Error) as error:
            raise InputError(
                f"the library's database {self.shown} cannot be used ({_said(error)}); check that it is there and may "
                "be written; if it is damaged, 'burnish db reindex' builds it anew from the files"
            ) from error

    def version(self) -> str | None:
        """Version of its tables; None for an empty database."""
        with self.connection() as connection:
            if not inspect(connection).has_table("alembic_version"):
                return None
            found = connection.execute(text("SELECT version_num FROM alembic_version")).scalar()
            return None if found is None else str(found)

    def upgrade(self) -> None:
        """Bring its tables to this program's version, or make them, in one transaction.

        Raises:
            InputError: if that is not possible.
        """
        # The migrations are loaded only where there is something to migrate.
        from alembic import command
        from alembic.config import Config

        config = Config()
        with resources.as_file(resources.files("burnish.library") / "migrations") as folder:
            config.set_main_option("script_location", str(folder).replace("%", "%%"))
            with self.connection() as connection:
                config.attributes["connection"] = connection
                command.upgrade(config, "head")

    def wipe(self) -> None:
        """Remove its tables with all that is in them.

        Raises:
            InputError: if it cannot be reached.
        """
        with self.connection() as connection:
            Base.metadata.drop_all(connection)
            connection.execute(text("DROP TABLE IF EXISTS alembic_version"))

    def damages(self) -> list[str]:
        """What SQLite finds wrong with its file; other databases look after themselves."""
        if not self.is_sqlite:
            return []
        with self.connection() as connection:
            said = [str(row[0]) for row in connection.execute(text("PRAGMA integrity_check(10)"))]
            return [line for line in said if line != "ok"]


def _checked(url: str) -> URL:
    """The URL that was meant."""
    try:
        found = make_url(url)
        if found.drivername in ("postgresql", "postgres"):
            found = found.set(drivername="postgresql+pg8000")
        if found.get_backend_name() not in ("sqlite", "postgresql"):
            raise ArgumentError(found.get_backend_name())
        found.get_dialect()
    except ModuleNotFoundError:
        return found
    except (ArgumentError, NoSuchModuleError, ValueError):
        raise InputError(
            "the database's URL cannot be used; expected postgresql://user:password@host/name or sqlite:////path"
        ) from None
    return found


def _said(error: Exception) -> str:
    """What the database itself said, in one line."""
    found = getattr(error, "orig", None) or error
    if found.args and isinstance(found.args[0], dict):
        found = found.args[0].get("M", found)  # A server's answer comes in fields; this is the message.
    return " ".join(str(found).split())[:200]


def _settings(url: URL) -> dict[str, Any]:
    """What a connection is made with."""
    if url.get_backend_name() == "sqlite":
        return {"connect_args": {"timeout": PATIENCE}}
    # What a server said goodbye to in the meantime is connected anew; several reads in one transaction see one state.
    return {
        "pool_pre_ping": True,
        "isolation_level": "REPEATABLE READ",
        "connect_args": {"timeout": PATIENCE},
    }


def _prepare_sqlite(engine: Engine) -> None:
    """Readers beside a writer, foreign keys, and rows that survive a killed process and a lost power supply."""

    @event.listens_for(engine, "connect")
    def connect(connection: sqlite3.Connection, record: object) -> None:
        # A transaction begins where we say so: several reads in one see one state.
        connection.isolation_level = None
        _write_ahead(connection)
        for setting in ("synchronous=full", "foreign_keys=on"):
            connection.execute(f"PRAGMA {setting}")

    @event.listens_for(engine, "begin")
    def begin(connection: Connection) -> None:
        connection.exec_driver_sql("BEGIN")


def _write_ahead(connection: sqlite3.Connection) -> None:
    """Have changes written ahead. Where several begin a database at once SQLite does not wait for its turn: we do."""
    until = time.monotonic() + PATIENCE
    while True:
        try:
            connection.execute("PRAGMA journal_mode=wal")
            return
        except sqlite3.OperationalError as error:
            if "locked" not in str(error) or time.monotonic() > until:
                raise
            time.sleep(0.01)
