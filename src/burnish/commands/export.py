"""``burnish export``: a recording as a table, one row a cycle, or its desired poses as text."""

from __future__ import annotations

import argparse
import csv
from collections.abc import Callable, Iterator
from io import TextIOWrapper
from pathlib import Path
from typing import IO, Any

import numpy as np

from burnish.commands.options import relative
from burnish.errors import InputError, RecordingError
from burnish.record.compare import columns_of
from burnish.record.poses_file import pose_lines
from burnish.record.recording import QUANTITIES, Cycles, Recording
from burnish.record.whole_file import whole_file

ROWS = 10_000
"""Rows of a group in a Parquet file: a few MB."""


def run(options: argparse.Namespace) -> int:
    """Write the table beside the recording, or where it was asked for."""
    path = Path(options.file)
    out = Path(options.out) if options.out else path.with_suffix(f".{options.to}")
    write, missing = WRITERS[options.to], None
    if options.to == "parquet":
        missing = _parquet_missing()
    if missing:
        raise InputError(missing)
    recording = Recording(path)
    if out.exists() and out.samefile(path):
        raise InputError(f"--out {out} is the recording itself; give another name")
    with whole_file(out) as file:
        rows = write(recording, file)
    print(f"{rows} rows: {relative(out)}")
    return 0


def to_csv(recording: Recording, file: IO[bytes]) -> int:
    """A header with units, then a row a cycle; empty where a cycle has no such number. Returns the rows."""
    text = TextIOWrapper(file, encoding="utf-8", newline="", write_through=True)
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([f"{name} [{unit}]" if unit else name for name, unit in _columns(recording)])
    count = 0
    for block in recording.blocks():
        numbers = _numbers(block).tolist()
        writer.writerows(
            # NaN is not equal to itself.
            [*(value if value == value else None for value in row), phase]
            for row, phase in zip(numbers, block.phase.tolist(), strict=True)
        )
        count += len(block)
    text.detach()
    return count


def to_poses(recording: Recording, file: IO[bytes]) -> int:
    """The desired tool poses, a line each; cycles of joint motion have none. Returns the lines."""
    count = 0
    for block in recording.blocks():
        wanted = ~np.isnan(block.p_d).all(axis=1)
        p, Q = block.p_d[wanted], block.Q_d[wanted][:, [3, 0, 1, 2]]
        if not (np.isfinite(p).all() and np.isfinite(Q).all()):
            raise RecordingError(f"{recording.path}: a desired pose is not finite; it would not be a pose for an arm")
        file.write("".join(pose_lines(p, Q)).encode())
        count += len(p)
    if not count:
        raise RecordingError(f"{recording.path} has no desired tool pose; expected a run that moves the tool")
    return count


def to_parquet(recording: Recording, file: IO[bytes]) -> int:
    """A column a number, with its unit in the column's metadata. Returns the rows."""
    import pyarrow
    from pyarrow import parquet

    names = _columns(recording)
    fields = [
        pyarrow.field(name, pyarrow.string() if name == "phase" else pyarrow.float64(), metadata={"unit": unit})
        for name, unit in names
    ]
    schema = pyarrow.schema(fields, metadata=dict(recording.metadata))
    count = 0
    with parquet.ParquetWriter(file, schema, compression="zstd") as writer:
        for blocks in _gathered(recording.blocks()):
            numbers = np.concatenate([_numbers(block) for block in blocks])
            phases = np.concatenate([block.phase for block in blocks])
            columns = [*(pyarrow.array(column, from_pandas=True) for column in numbers.T), pyarrow.array(phases)]
            writer.write_table(pyarrow.Table.from_arrays(columns, schema=schema))
            count += len(numbers)
    return count


WRITERS: dict[str, Callable[[Recording, IO[bytes]], int]] = {"parquet": to_parquet, "csv": to_csv, "txt": to_poses}
"""Form to what writes it."""


def _parquet_missing() -> str | None:
    """Why Parquet cannot be written, or None."""
    try:
        import pyarrow.parquet  # noqa: F401
    except ImportError:
        return "Parquet needs the package pyarrow, which is not installed; install burnish[export], or use --to csv"
    return None


def _columns(recording: Recording) -> list[tuple[str, str]]:
    """Names and units of a row's numbers, and last the phase."""
    joints = len(recording.joint_names)
    names = [("t", "s")]
    for quantity in QUANTITIES:
        for part in columns_of(quantity, joints):
            unit = quantity.unit
            if quantity.field == "F":
                unit = "N" if part.startswith("force") else "N·m"
            names.append((part, unit))
    return [*names, ("phase", "")]


def _numbers(block: Cycles) -> np.ndarray[Any, np.dtype[np.float64]]:
    """All columns but the phase, (N, columns)."""
    columns = [block.t[:, None]]
    for quantity in QUANTITIES:
        values = getattr(block, quantity.field)
        columns.append(values.reshape(len(block), -1))
    return np.concatenate(columns, axis=1)


def _gathered(blocks: Iterator[Cycles]) -> Iterator[list[Cycles]]:
    """Blocks in heaps of about `ROWS` rows."""
    heap: list[Cycles] = []
    for block in blocks:
        heap.append(block)
        if sum(map(len, heap)) >= ROWS:
            yield heap
            heap = []
    if heap:
        yield heap
