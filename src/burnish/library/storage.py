"""The files of the library: named by their content, whole or absent, and never outside the library's folder."""

from __future__ import annotations

import hashlib
import os
import stat
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePath

from burnish.errors import InputError
from burnish.library.rows import ENDING, Stored

CHUNK = 2**20


@contextmanager
def disk(doing: str) -> Iterator[None]:
    """Turn an error of the disk into one line.

    Args:
        doing: what could not be done.

    Raises:
        InputError: whatever the system said.
    """
    try:
        yield
    except OSError as error:
        where = "" if error.filename is None else f": {error.filename}"
        raise InputError(
            f"{doing} failed ({error.strerror or error}{where}); check that the place exists and has room"
        ) from error


@dataclass(frozen=True, kw_only=True)
class Source:
    """A file from outside: on the disk, or received."""

    called: str
    """What a message calls it."""
    content: Path | bytes
    """Where it lies, or what it holds."""

    def copied(self, folder: Path, role: str, ending: str, most: int) -> Stored:
        """Copy it into ``folder``, named by what it holds.

        Args:
            folder: where to.
            role: what it is to its row.
            ending: of the new name.
            most: largest size [B].

        Raises:
            InputError: if it cannot be read, is no regular file, is empty, or too large.
        """
        if isinstance(self.content, bytes):
            received = (self.content[i : i + CHUNK] for i in range(0, len(self.content), CHUNK))
            return written(_bounded(received, self.called, most), folder, role, ending)
        with disk(f"reading {self.called}"), _regular(self.content, self.called) as handle:
            return written(_bounded(_chunks(handle), self.called, most), folder, role, ending)

    @contextmanager
    def reading(self, stored: Stored, folder: Path) -> Iterator[Path]:
        """The copy in ``folder``, to be read; a refusal calls it by the name that its owner knows."""
        path = folder / PurePath(stored.path).name
        try:
            yield path
        except InputError as error:
            raise type(error)(str(error).replace(str(path), self.called)) from None


def written(chunks: Iterable[bytes], folder: Path, role: str, ending: str) -> Stored:
    """Write bytes into ``folder``, on the disk before this returns, named by what they are."""
    if not ENDING.fullmatch(ending):
        raise InputError(f"a file of the library cannot end in {ending[:20]!r}; expected letters such as '.stl'")
    draft = folder / f".draft-{role}"
    digest, size = hashlib.sha256(), 0
    with disk(f"writing into {folder}"), draft.open("wb") as file:
        for chunk in chunks:
            digest.update(chunk)
            size += len(chunk)
            file.write(chunk)
        file.flush()
        os.fsync(file.fileno())
        stored = Stored(role=role, sha256=digest.hexdigest(), size=size, ending=ending)
        os.replace(draft, folder / PurePath(stored.path).name)
    return stored


def place(stored: Stored, folder: Path, root: Path) -> None:
    """Move a file from ``folder`` to where it belongs; one that is there already stays."""
    source, target = folder / PurePath(stored.path).name, root / stored.path
    if source.exists():
        if target.exists():
            source.unlink()
            return
        target.parent.mkdir(parents=True, exist_ok=True)
        os.replace(source, target)
        settle(target.parent)


def write_whole(path: Path, data: bytes, draft: Path) -> None:
    """Write a small file, whole or not at all, on the disk before this returns; ``draft`` is where it grows."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with draft.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    os.replace(draft, path)
    settle(path.parent)


def settle(folder: Path) -> None:
    """Make the names in a folder survive a lost power supply."""
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def read_bounded(path: Path, most: int) -> bytes:
    """All of a small file.

    Raises:
        InputError: if it cannot be read, is no regular file, is empty, or too large.
    """
    with disk(f"reading {path}"), _regular(path, str(path)) as handle:
        return b"".join(_bounded(_chunks(handle), str(path), most))


def fault(stored: Stored, root: Path) -> str | None:
    """What is wrong with a file of the library: it is read from its first byte to its last. None if nothing is."""
    path = root / stored.path
    try:
        status = path.lstat()
    except OSError as error:
        return "is missing" if isinstance(error, FileNotFoundError) else f"cannot be read ({error.strerror})"
    if not stat.S_ISREG(status.st_mode) or not path.resolve().is_relative_to(root.resolve()):
        return "is a link or no file at all"
    if status.st_size != stored.size:
        return f"has {status.st_size} bytes instead of {stored.size}"
    try:
        with path.open("rb") as file:
            digest = hashlib.sha256()
            while chunk := file.read(CHUNK):
                digest.update(chunk)
    except OSError as error:
        return f"cannot be read ({error.strerror})"
    return None if digest.hexdigest() == stored.sha256 else "was altered: its content is not what its name says"


@contextmanager
def _regular(path: Path, called: str) -> Iterator[int]:
    """A regular file opened for reading; opening a pipe does not wait for a writer."""
    handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        if not stat.S_ISREG(os.fstat(handle).st_mode):
            raise InputError(f"{called} is no regular file; expected one that can be copied into the library")
        yield handle
    finally:
        os.close(handle)


def _chunks(handle: int) -> Iterator[bytes]:
    """The content of an open file."""
    while chunk := os.read(handle, CHUNK):
        yield chunk


def _bounded(chunks: Iterable[bytes], called: str, most: int) -> Iterator[bytes]:
    """The same, as long as it is something and not too much."""
    size = 0
    for chunk in chunks:
        size += len(chunk)
        if size > most:
            raise InputError(f"{called} is larger than {most / 2**20:g} MiB, the most that is taken of its kind")
        yield chunk
    if not size:
        raise InputError(f"{called} is empty; expected a file with something in it")
