"""The run's journal: an append-only file of what has been done, a line a checkpoint, from which a job goes on.

The first line says what the job is; each further one is a `Mark`. Every line is on the disk before the next one is
written (fsync), by a thread of its own, so that no control cycle waits for a disk. A run that was cut off leaves at
most its last line torn, and that line is left out.
"""

from __future__ import annotations

import json
import os
import queue
import threading
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from typing_extensions import Self

from burnish.errors import RecordingError

NAME = "journal.jsonl"
"""Its name in the folder of a run."""
FORMAT = "burnish journal 1"
"""What its first line says."""
ENDS = ("done", "stopped", "change")
"""Phases of a mark that end a run."""
EVERY = 1e-3
"""Path between two checkpoints [m]: what a power cut may make the tool work twice."""


@dataclass(frozen=True, kw_only=True)
class Mark:
    """How far a job has come."""

    number: int
    """Pass, from 1."""
    stroke: int
    """Stroke within the pass, from 1."""
    s: float
    """Path length of the stroke that is done [m]."""
    phase: str
    """What the arm is doing; ``done``, ``stopped`` and ``change`` end a run."""
    force: float
    """Mean measured normal force since the mark before [N]; 0 out of contact."""
    t: float
    """Time of the arm's clock in this run [s]."""
    metres: float
    """Path that the abrasive has done [m]."""
    joules: float
    """Work of friction that it has done [J]."""


class Journal:
    """A journal that is being written."""

    def __init__(self, path: Path, about: Mapping[str, Any]) -> None:
        """Open it; a new one begins with what the job is, an old one goes on behind its last whole line.

        Raises:
            RecordingError: the file cannot be written, or it is another job's.
        """
        self.path = path
        try:
            if path.exists():
                mend(path)
            self._file = open(path, "ab")  # noqa: SIM115  Closed by close().
        except OSError as error:
            raise RecordingError(
                f"the journal {path} cannot be written ({error.strerror or error}); choose another folder with --out"
            ) from error
        self._lines: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        self.error: str | None = None
        """Why writing ended early, or None."""
        self._thread = threading.Thread(target=self._write, name="journal", daemon=True)
        self._thread.start()
        if path.stat().st_size == 0:
            self._put({"format": FORMAT, **about})

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def add(self, mark: Mark) -> None:
        """Append a checkpoint; returns at once."""
        self._put(asdict(mark))

    def close(self) -> None:
        """Wait until all is on the disk."""
        self._lines.put(None)
        self._thread.join()
        self._file.close()

    def _put(self, record: Mapping[str, Any]) -> None:
        self._lines.put((json.dumps(record, ensure_ascii=False) + "\n").encode())

    def _write(self) -> None:
        """The thread: one line after the other onto the disk."""
        while (line := self._lines.get()) is not None:
            if self.error is not None:
                continue
            try:
                self._file.write(line)
                self._file.flush()
                os.fsync(self._file.fileno())
            except OSError as error:
                self.error = error.strerror or str(error)


def read(path: Path) -> tuple[dict[str, Any], list[Mark]]:
    """What the job is, and its checkpoints; a torn last line is left out.

    Raises:
        RecordingError: there is no journal, or a line of it is none.
    """
    try:
        text = path.read_bytes()
    except OSError as error:
        raise RecordingError(
            f"there is no journal at {path} ({error.strerror or error}); expected the folder of an earlier "
            "'burnish polish'"
        ) from error
    lines = text.split(b"\n")[:-1]
    records = [_record(path, number, line) for number, line in enumerate(lines, 1)]
    if not records or records[0].get("format") != FORMAT:
        raise RecordingError(f"{path} is no journal of this version; expected a first line with {FORMAT!r}")
    return records[0], [_mark(path, number, record) for number, record in enumerate(records[1:], 2)]


def mend(path: Path) -> None:
    """Cut a torn last line off, so that the next one begins on a line of its own."""
    text = path.read_bytes()
    whole = text.rfind(b"\n") + 1
    if whole < len(text):
        os.truncate(path, whole)


def _record(path: Path, number: int, line: bytes) -> dict[str, Any]:
    try:
        record = json.loads(line)
    except (ValueError, RecursionError):
        record = None
    if not isinstance(record, dict):
        raise RecordingError(
            f"line {number} of {path} is damaged; only the last one may be. Start the job anew, or cut the file there"
        )
    return record


def mark_of(record: Mapping[str, Any]) -> Mark:
    """The checkpoint of a record.

    Raises:
        ValueError: it is none.
    """
    known = {field.name: field.type for field in fields(Mark)}
    good = set(record) == set(known) and isinstance(record["phase"], str)
    good = good and all(_is_number(record[name]) for name in known if name != "phase")
    if not good:
        raise ValueError(f"no checkpoint; expected {', '.join(known)}")
    return Mark(**{**record, "number": int(record["number"]), "stroke": int(record["stroke"])})


def _mark(path: Path, number: int, record: Mapping[str, Any]) -> Mark:
    try:
        return mark_of(record)
    except ValueError as error:
        raise RecordingError(f"line {number} of {path} is {error}") from None


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and bool(np.isfinite(value))
