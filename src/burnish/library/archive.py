"""A library as one file: its cards and files in a ZIP archive, checked on the way out and on the way in."""

from __future__ import annotations

import hashlib
import os
import zipfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path, PurePath
from typing import IO

from burnish.errors import InputError
from burnish.library.cards import FOLDER, MAX_BYTES, card_bytes, parse_card
from burnish.library.rows import Row, Stored
from burnish.library.storage import CHUNK, disk, written

MOST_CARDS = 1_000_000
"""Of an archive."""


def write(root: Path, rows: Sequence[Row], file: Path, now: Callable[[Row], Row | None]) -> int:
    """Write rows with their files, whole or not at all; others may write to the library at the same time.

    Args:
        root: of the library.
        rows: to be written.
        file: the archive, a new one.
        now: a row as it is now, or None: of one that is changed meanwhile the new files are taken.

    Returns:
        The number of rows.

    Raises:
        InputError: if the archive is there already or cannot be written, or a file of the library is damaged.
    """
    if file.exists():
        raise InputError(f"{file} exists; give another name, so that an older backup is not lost")
    draft = file.with_name(f".{file.name}.draft")
    count, seen = 0, set[str]()
    with disk(f"writing {file}"):
        try:
            with zipfile.ZipFile(draft, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
                for row in rows:
                    kept = _write_files(root, row, archive, seen, now)
                    if kept is not None:
                        archive.writestr(f"{FOLDER}/{kept.id}.json", card_bytes(kept))
                        count += 1
            with draft.open("rb") as done:
                os.fsync(done.fileno())
            os.replace(draft, file)
        finally:
            draft.unlink(missing_ok=True)
    return count


def read(file: Path, folder: Path) -> list[Row]:
    """Unpack an archive into a folder, every file named by its content, and checked. What it names is never a path.

    Raises:
        InputError: if it is none, or damaged.
    """
    rows = []
    try:
        with disk(f"reading {file}"), zipfile.ZipFile(file) as archive:
            names = [info for info in archive.infolist() if info.filename.startswith(f"{FOLDER}/")]
            if len(names) > MOST_CARDS:
                raise InputError(f"{file} holds {len(names)} cards; expected at most {MOST_CARDS}")
            for info in names:
                with archive.open(info) as member:
                    rows.append(parse_card(member.read(MAX_BYTES), f"{info.filename} in {file}"))
            for stored in {stored.path: stored for row in rows for stored in row.files}.values():
                with archive.open(stored.path) as member:
                    _unpack(member, stored, folder, file)
    except (zipfile.BadZipFile, KeyError, EOFError, NotImplementedError, RuntimeError) as error:
        raise InputError(
            f"{file} is damaged or no backup ({str(error)[:100]}); expected an archive of 'burnish db backup'"
        ) from None
    return rows


def _write_files(
    root: Path, row: Row, archive: zipfile.ZipFile, seen: set[str], now: Callable[[Row], Row | None]
) -> Row | None:
    """The files of a row; returns it as it was then."""
    current: Row | None = row
    while current is not None:
        try:
            for stored in current.files:
                if stored.path not in seen:
                    _write_file(root, stored, archive)
                    seen.add(stored.path)
            return current
        except FileNotFoundError:
            # It was changed or removed since it was listed, or somebody has deleted the file.
            before, current = current, now(row)
            if current == before:
                raise
    return None


def _write_file(root: Path, stored: Stored, archive: zipfile.ZipFile) -> None:
    digest = hashlib.sha256()
    with (root / stored.path).open("rb") as source, archive.open(stored.path, "w", force_zip64=True) as member:
        for chunk in _chunks(source):
            digest.update(chunk)
            member.write(chunk)
    if digest.hexdigest() != stored.sha256:
        raise InputError(f"{stored.path} was altered since it was entered; 'burnish db check' says what to do")


def _unpack(member: IO[bytes], stored: Stored, folder: Path, file: Path) -> None:
    """One file of an archive."""
    unpacked = written(_up_to(member, stored, file), folder, stored.role, stored.ending)
    if unpacked != stored:
        (folder / PurePath(unpacked.path).name).unlink()
        raise InputError(f"{stored.path} in {file} is damaged: its content is not what its name says")


def _up_to(member: IO[bytes], stored: Stored, file: Path) -> Iterator[bytes]:
    """No more than was announced."""
    size = 0
    for chunk in _chunks(member):
        size += len(chunk)
        if size > stored.size:
            raise InputError(f"{stored.path} in {file} is larger than its card says; the archive is damaged")
        yield chunk


def _chunks(file: IO[bytes]) -> Iterator[bytes]:
    while chunk := file.read(CHUNK):
        yield chunk
