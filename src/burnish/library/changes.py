"""Changes that happen as a whole or not at all, whenever the process that makes them is killed.

A change is prepared in a folder of its own below ``changes``: the new files, and last ``change.json``, which says all
of it. From then on it is done, by its maker or by whoever writes next:

1. files are moved to where they belong, 2. the cards are written, 3. the rows are committed, 4. cards and files that
nobody names any more are removed, 5. the folder is removed.

Every step can be done twice. What was never finished being prepared is thrown away; a lock that its maker holds while
it lives tells the two apart.
"""

from __future__ import annotations

import fcntl
import json
import os
import secrets
import shutil
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

from sqlalchemy import delete, select

from burnish.errors import InputError
from burnish.library.cards import card_bytes, card_of, card_path, from_card, stored_of
from burnish.library.database import PATIENCE, Database
from burnish.library.rows import ID, Row, Stored
from burnish.library.storage import disk, place, write_whole
from burnish.library.tables import Entry, File, entry_of

FOLDER = "changes"
SEAL = "change.json"
LOCK = "lock"
AT_ONCE = 500
"""Rows named in one statement."""


@contextmanager
def locked(root: Path) -> Iterator[None]:
    """Be the only one who writes, of all threads and processes.

    Raises:
        InputError: if somebody else does for too long.
    """
    with disk(f"locking the library {root}"):
        handle = os.open(root / LOCK, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o644)
    try:
        until = time.monotonic() + PATIENCE
        while not _taken(handle):
            if time.monotonic() > until:
                raise InputError(f"the library {root} is being written by another program; try again when it has ended")
            time.sleep(0.01)
        yield
    finally:
        os.close(handle)


@contextmanager
def prepared(root: Path) -> Iterator[Path]:
    """A folder for the files of a change; what is left of it in the end is removed."""
    with locked(root), disk(f"writing into {root}"):
        folder = root / FOLDER / secrets.token_hex(8)
        folder.mkdir(parents=True)
        handle = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    try:
        yield folder
    finally:
        if not (folder / SEAL).exists():
            shutil.rmtree(folder, ignore_errors=True)
        os.close(handle)


def make(
    root: Path,
    database: Database,
    folder: Path,
    *,
    put: Iterable[Row] = (),
    drop: Iterable[Row] = (),
    stale: Iterable[Stored] = (),
) -> None:
    """Make a change; to be called by whoever holds the lock.

    Args:
        root: of the library.
        database: of it.
        folder: from `prepared`, with those files of the rows that are new.
        put: rows as they are to be, new or changed.
        drop: rows that are removed for good, with their files.
        stale: further files that may be nobody's then.
    """
    gone, new = list(drop), list(put)
    left = [*stale, *(file for row in gone for file in row.files)]
    change = {
        "put": [card_of(row) for row in new],
        "drop": sorted({row.id for row in gone} - {row.id for row in new}),
        "stale": [asdict(file) for file in left],
    }
    sealed = json.dumps(change, allow_nan=False).encode()
    rows = _rows(json.loads(sealed), folder)  # What could not be read again is refused before it is sealed.
    with disk(f"writing into the library {root}"):
        write_whole(folder / SEAL, sealed, folder / "draft")
        _apply(root, database, folder, rows, json.loads(sealed))
        (folder / SEAL).unlink()


def finish(root: Path, database: Database) -> None:
    """Do what killed processes had sealed, and remove what they had not; to be called by whoever holds the lock."""
    base = root / FOLDER
    with disk(f"tidying up {base}"):
        for folder in sorted(base.iterdir()) if base.is_dir() else ():
            with _abandoned(folder) as abandoned:
                if abandoned and (folder / SEAL).exists():
                    change = json.loads((folder / SEAL).read_bytes())
                    _apply(root, database, folder, _rows(change, folder), change)
                if abandoned:
                    # Its maker may be removing it at this moment, unsealed.
                    shutil.rmtree(folder, ignore_errors=True)


def _rows(change: dict[str, Any], folder: Path) -> list[Row]:
    """The rows that a change writes."""
    return [from_card(card, str(folder)) for card in change["put"]]


def _apply(root: Path, database: Database, folder: Path, rows: Sequence[Row], change: dict[str, Any]) -> None:
    """Steps 1 to 4."""
    gone = [identifier for identifier in change["drop"] if ID.fullmatch(identifier)]
    stale = [stored_of(values) for values in change["stale"]]
    for row in rows:
        for file in row.files:
            place(file, folder, root)
        write_whole(card_path(root, row.id), card_bytes(row), folder / "draft")
    kept = set[tuple[str, str]]()
    with database.session() as session:
        for some in _batches([*gone, *(row.id for row in rows)]):
            # The tables' foreign keys see to what belongs to them.
            session.execute(delete(Entry).where(Entry.id.in_(some)))
        session.add_all([entry_of(row) for row in rows])
        session.flush()
        for some in _batches([file.sha256 for file in stale]):
            found = session.execute(select(File.sha256, File.ending).where(File.sha256.in_(some)))
            kept.update((sha256, ending) for sha256, ending in found)
    for identifier in gone:
        card_path(root, identifier).unlink(missing_ok=True)
    for file in stale:
        if (file.sha256, file.ending) not in kept:
            (root / file.path).unlink(missing_ok=True)


def _batches(values: Sequence[str]) -> Iterator[Sequence[str]]:
    """As many at a time as a database takes in one statement."""
    return (values[i : i + AT_ONCE] for i in range(0, len(values), AT_ONCE))


def _taken(handle: int) -> bool:
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


@contextmanager
def _abandoned(folder: Path) -> Iterator[bool]:
    """Whether the process that made a folder is gone."""
    try:
        handle = os.open(folder / LOCK, os.O_RDWR | os.O_CLOEXEC)
    except FileNotFoundError:
        # It is being removed, or was: its lock is made right after it, by somebody who holds the library's.
        yield True
        return
    try:
        yield _taken(handle)
    finally:
        os.close(handle)
