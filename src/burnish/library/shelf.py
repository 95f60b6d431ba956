"""A library's folder and database: opening them, and rows in and out, each change whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from sqlalchemy import Select, select
from typing_extensions import Self

from burnish.errors import InputError
from burnish.library.changes import FOLDER as CHANGES
from burnish.library.changes import finish, locked, make, prepared
from burnish.library.database import HEAD, Database
from burnish.library.rows import Row, Stored
from burnish.library.storage import disk
from burnish.library.tables import TABLES, Entry, row_of

FOLDER, DATABASE = "BURNISH_LIBRARY", "BURNISH_DATABASE"
"""Names in the environment: the library's folder, and the URL of its database."""
MOST_ROWS = 1000
"""Of one list."""

R = TypeVar("R", bound=Row)


class Shelf:
    """What every library rests on; `Library` is its face."""

    root: Path
    """The folder."""

    def __init__(self, root: Path, database: Database) -> None:
        """Use `open`."""
        self.root = root
        self.database = database

    @classmethod
    def open(cls, where: str | Path | None = None, database: str | None = None) -> Self:
        """Open a library, or make an empty one where there is none.

        Args:
            where: its folder; None for ``$BURNISH_LIBRARY``, else ``burnish`` in ``$XDG_DATA_HOME`` or
                ``~/.local/share``.
            database: URL of its database; None for ``$BURNISH_DATABASE``, else SQLite in the folder.

        Raises:
            InputError: if it cannot be used, or its tables are of another version.
        """
        library = cls.at(where, database)
        try:
            version = library.database.version()
            if version is None:
                library.upgrade()
            elif version != HEAD:
                raise InputError(
                    f"the library's database is of version {version}, this program needs {HEAD}; "
                    + ("run 'burnish db upgrade'" if version < HEAD else "use the newer program that wrote it")
                )
            if any((library.root / CHANGES).iterdir()):
                with library.writing():
                    pass
        except BaseException:
            library.close()
            raise
        return library

    @classmethod
    def at(cls, where: str | Path | None = None, database: str | None = None) -> Self:
        """The library, whatever the state of its database; to mend or to upgrade it."""
        root = Path(where or os.environ.get(FOLDER) or _home()).absolute()
        with disk(f"making the library {root}"):
            for name in ("files", "cards", CHANGES):
                (root / name).mkdir(parents=True, exist_ok=True)
        return cls(root, Database(database or os.environ.get(DATABASE) or None, root))

    def close(self) -> None:
        """Give the database back."""
        self.database.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def get(self, kind: type[R], identifier: str) -> R:
        """A row by its id, in the bin or not.

        Raises:
            InputError: if there is none.
        """
        row = self.found(kind, identifier)
        if row is None:
            raise InputError(f"the library holds no {kind.KIND} {identifier[:40]!r}; it was removed, or never there")
        return row

    def found(self, kind: type[R], identifier: str) -> R | None:
        """The same; None if there is none."""
        with self.database.session() as session:
            entry = session.get(TABLES[kind.KIND], identifier)
            row = None if entry is None else row_of(entry)
        return row if isinstance(row, kind) else None

    def upgrade(self) -> None:
        """Bring the database's tables to this program's version, or make them."""
        with locked(self.root):
            self.database.upgrade()

    def everything(self) -> list[Row]:
        """All rows, the bin's too."""
        with self.database.session() as session:
            return [row_of(entry) for entry in session.scalars(select(Entry).order_by(Entry.id))]

    def as_it_is(self, row: R) -> R | None:
        """A row as it is now; None when it is gone."""
        return self.found(type(row), row.id)

    def rows(self, kind: type[R], query: Select[Entry], limit: int, offset: int) -> list[R]:
        """Some rows of a query."""
        if not 0 <= limit <= MOST_ROWS or offset < 0:
            raise InputError(
                f"rows {offset} to {offset + limit} cannot be listed; expected at most {MOST_ROWS} at once"
            )
        with self.database.session() as session:
            rows = [row_of(entry) for entry in session.scalars(query.limit(limit).offset(offset))]
        return [row for row in rows if isinstance(row, kind)]

    @contextmanager
    def writing(self) -> Iterator[None]:
        """Alone with the library, after what killed processes left is done or undone."""
        with locked(self.root):
            finish(self.root, self.database)
            yield

    def enter(self, read: Callable[[Path], R], name: str | None) -> R:
        """Copy, check, and enter; what is there already keeps its name, tags and notes, and leaves the bin."""
        with prepared(self.root) as folder:
            row = read(folder)
            if name is not None:
                row = replace(row, name=name)
            with self.writing():
                before = self.as_it_is(row)
                stale: Sequence[Stored] = ()
                if before is not None:
                    row = replace(row, name=before.name, created=before.created, tags=before.tags, notes=before.notes)
                    stale = [stored for stored in before.files if stored.path not in {f.path for f in row.files}]
                make(self.root, self.database, folder, put=[row], stale=stale)
        return row

    def edit(self, row: R, change: Callable[[R], R]) -> R:
        """Change a row as it is now, which may be another one than the caller saw."""
        with prepared(self.root) as folder, self.writing():
            changed = change(self.get(type(row), row.id))
            make(self.root, self.database, folder, put=[changed])
        return changed


def _home() -> Path:
    """Where programs keep a user's data."""
    base = os.environ.get("XDG_DATA_HOME")
    return (Path(base) if base and Path(base).is_absolute() else Path.home() / ".local" / "share") / "burnish"
