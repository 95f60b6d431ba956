"""Whether database, cards and files tell the same, and a database built anew from the other two."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path

from sqlalchemy import delete, select

from burnish.errors import InputError
from burnish.library.cards import FOLDER, card_bytes, card_path, read_card
from burnish.library.changes import finish
from burnish.library.database import HEAD, NAME, Database
from burnish.library.rows import Row
from burnish.library.storage import disk, fault, write_whole
from burnish.library.tables import Entry, entry_of, row_of

LOST = "lost"
"""Where a rebuilt library keeps what is nobody's."""
REINDEX = "run 'burnish db reindex'"
_CARD = re.compile(r"[0-9a-f]{32}\.json")


@dataclass(frozen=True, kw_only=True)
class Finding:
    """Something that is not as it should be."""

    what: str
    """In a few words."""
    where: str
    """Which row or file."""
    advice: str
    """What to do."""

    def __str__(self) -> str:
        return f"{self.where}: {self.what}; {self.advice}"


@dataclass(frozen=True, kw_only=True)
class Rebuilt:
    """What a rebuilt database holds."""

    rows: int
    """How many."""
    findings: tuple[Finding, ...]
    """What could not be used."""


def rows_and_cards(root: Path, database: Database, rows: Sequence[Row]) -> list[Finding]:
    """What differs between the database, the cards and the names of the files, while nobody writes."""
    found = [
        Finding(what=f"the database is damaged ({said})", where=NAME, advice=REINDEX) for said in database.damages()
    ]
    known = {row.id for row in rows}
    cards, bad = _cards(root)
    found += [Finding(what=said, where=path.name, advice=REINDEX) for path, said in bad]
    for row in rows:
        if row.id not in cards and not any(path.name == f"{row.id}.json" for path, _ in bad):
            found.append(Finding(what="its card is missing", where=_named(row), advice=REINDEX))
        elif row.id in cards and cards[row.id] != row:
            found.append(Finding(what="its card says something else", where=_named(row), advice=REINDEX))
    found += [
        Finding(what="the database does not know it", where=_named(card), advice=REINDEX)
        for card in cards.values()
        if card.id not in known
    ]
    advice = f"{REINDEX}: it is moved to '{LOST}'"
    return [*found, *(Finding(what=what, where=where, advice=advice) for where, what in _strays(root, rows))]


def contents(root: Path, rows: Sequence[Row], still: Callable[[Row], Row | None]) -> list[Finding]:
    """Files that are missing or altered; every one is read.

    Args:
        root: of the library.
        rows: whose files.
        still: a row as it is now, which may be without this file.
    """
    found, seen = [], set[str]()
    for row in rows:
        for file in row.files:
            if file.path in seen:
                continue
            seen.add(file.path)
            said = fault(file, root)
            if said is None:
                continue
            now = still(row)
            if now is not None and file in now.files:
                advice = f"bring {file.path} back from a backup, or enter it again"
                found.append(Finding(what=f"its {file.role} {said}", where=_named(row), advice=advice))
    return found


def rebuild(root: Path, database: Database) -> Rebuilt:
    """A database of what the cards say, while nobody writes.

    A card that is damaged or missing is written anew from its row, if the database still has it. Nothing is deleted:
    damaged databases and cards, and files that no card names, are moved to the folder ``lost``.
    """
    lost = root / LOST / f"{datetime.now(timezone.utc):%Y-%m-%d_%H-%M-%S_%f}"
    rows = {row.id: row for row in _usable(root, database, lost)}
    cards, bad = _cards(root)
    findings = []
    for path, said in bad:
        row = rows.get(path.stem)
        what = f"{said}; " + ("it was written anew" if row is not None else "it could not be used")
        findings.append(Finding(what=what, where=path.name, advice=f"look at it in {lost}"))
        _move(path, lost)
    with disk(f"writing into {root}"):
        for row in rows.values():
            if row.id not in cards:
                write_whole(card_path(root, row.id), card_bytes(row), root / FOLDER / ".draft")
    rows |= cards
    with database.session() as session:
        session.execute(delete(Entry))
        session.add_all([entry_of(row) for row in rows.values()])
    for where, what in list(_strays(root, list(rows.values()))):
        findings.append(Finding(what=what, where=where, advice=f"look at it in {lost}"))
        _move(root / where, lost)
    return Rebuilt(rows=len(rows), findings=tuple(findings))


def _usable(root: Path, database: Database, lost: Path) -> list[Row]:
    """The rows of the database, brought to this version; one that cannot be read is removed, and made anew."""
    try:
        if database.damages():
            raise InputError("the database is damaged")
        if database.version() != HEAD:
            database.upgrade()
        finish(root, database)
        with database.session() as session:
            return [row_of(entry) for entry in session.scalars(select(Entry))]
    except InputError:
        if database.is_sqlite:
            database.close()
            for end in ("", "-wal", "-shm"):
                path = database.file.with_name(database.file.name + end)
                if path.exists():
                    _move(path, lost)
        else:
            database.wipe()
        database.upgrade()
        finish(root, database)
        return []


def _cards(root: Path) -> tuple[dict[str, Row], list[tuple[Path, str]]]:
    """The rows of all cards, and what is no card with what is wrong with it."""
    cards: dict[str, Row] = {}
    bad = []
    with disk(f"reading {root / FOLDER}"):
        for path in sorted((root / FOLDER).iterdir()):
            try:
                if path.is_symlink() or not _CARD.fullmatch(path.name):
                    raise InputError("it is no card")
                row = read_card(path)
                cards[row.id] = row
            except InputError as error:
                bad.append((path, str(error)))
    return cards, bad


def _strays(root: Path, rows: Sequence[Row]) -> Iterator[tuple[str, str]]:
    """What lies below ``files`` and belongs to no row."""
    named = {file.path for row in rows for file in row.files}
    for folder, folders, files in os.walk(root / "files"):
        for name in sorted([*files, *(name for name in folders if (Path(folder) / name).is_symlink())]):
            where = (Path(folder) / name).relative_to(root).as_posix()
            if where not in named:
                yield where, "no row has this file"


def _move(path: Path, lost: Path) -> None:
    """Put something aside."""
    with disk(f"moving {path}"):
        lost.mkdir(parents=True, exist_ok=True)
        os.replace(path, lost / path.name)


def _named(row: Row) -> str:
    return f"{row.KIND} {row.name!r} ({row.id})"
