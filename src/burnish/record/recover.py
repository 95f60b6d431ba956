"""Mending a recording that was cut off or damaged: all whole messages of it, in a new file with an index."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC

from burnish.errors import InputError, RecordingError
from burnish.record import mcap_fields
from burnish.record.mcap_file import LENGTH_COUNTS_FROM, McapFile, Table
from burnish.record.mcap_scan import Content, Damage, Piece, messages, open_recording, scan
from burnish.record.whole_file import whole_file

MENDED = "burnish_recovered"
"""Name of the metadata that a mended recording has besides those of the original."""
MAX_KNOWN = 4096
"""Most schemas, channels and metadata of a recording, each."""
LENGTH = struct.Struct("<Q")


@dataclass(kw_only=True)
class Saved:
    """What was saved of a recording, and what was not."""

    messages: int = 0
    """Whole messages."""
    first: int | None = None
    """Time of the earliest message [ns]."""
    last: int | None = None
    """Time of the latest one [ns]."""
    damages: list[Damage] = field(default_factory=list)
    """Where the file is not as it should be; none in one that is whole."""
    complete: bool = False
    """Whether the data reach their end; the index behind them may still be missing."""
    unread: int = 0
    """Bytes that gave nothing: damaged, or the beginning of what was never finished."""


def recover(path: Path, out: Path) -> Saved:
    """Write all whole messages of a recording to a new one, in their order, with an index.

    Args:
        path: the recording; it is only read.
        out: the new file; it appears when it is complete.

    Raises:
        RecordingError: if ``path`` is no recording.
        InputError: if ``out`` exists, or cannot be written.
    """
    data = open_recording(path)
    if out.exists():
        raise InputError(f"{out} exists; give another name with --out, so that nothing is lost")
    with whole_file(out) as file:
        mended = _Mended(McapFile(file, chunk_size=2**16))
        for found in scan(data):
            mended.take(found)
        mended.finish(len(data))
    return mended.saved


class _Mended:
    """The new file while it grows."""

    def __init__(self, file: McapFile) -> None:
        self.saved = Saved()
        self._file = file
        self._begun = False
        self._schemas: set[int] = set()
        self._channels: set[int] = set()
        self._notes = 0
        self._reached = len(MCAP0_MAGIC)

    def take(self, found: Piece | Content | Damage) -> None:
        """Keep what is whole of the next thing that was found."""
        self._lose_until(found.start)
        if isinstance(found, Damage):
            self.saved.damages.append(found)
            return
        if isinstance(found, Content):
            whole = self._chunk(found)
            self._reached += found.size if whole else 0
            return
        try:
            self._record(found)
        except RecordingError as error:
            self.saved.damages.append(Damage(found.start, str(error)))
        self._reached += LENGTH_COUNTS_FROM + len(found.body)

    def finish(self, size: int) -> None:
        """Index and end."""
        self._begin("ros2")
        if self.saved.damages:
            if not self.saved.complete:
                self._lose_until(size)
            reasons = "; ".join(f"byte {damage.start}: {damage.reason}" for damage in self.saved.damages[:10])
            self._file.note(MENDED, {"damages": reasons, "unread_bytes": str(self.saved.unread)})
        self._file.finish()

    def _lose_until(self, position: int) -> None:
        self.saved.unread += max(0, position - self._reached)
        self._reached = max(self._reached, position)

    def _begin(self, profile: str) -> None:
        if not self._begun:
            self._begun = True
            self._file.begin("burnish", profile)

    def _record(self, piece: Piece) -> None:
        """A record outside a chunk, or one beside the messages of a chunk."""
        if piece.opcode == Opcode.HEADER:
            self._begin(mcap_fields.header(piece.body).profile)
            return
        self._begin("ros2")
        if piece.opcode == Opcode.SCHEMA and len(self._schemas) < MAX_KNOWN:
            schema = mcap_fields.schema(piece.body)
            if schema.id not in self._schemas and schema.id > 0:
                self._schemas.add(schema.id)
                self._file.know(schema)
        elif piece.opcode == Opcode.CHANNEL and len(self._channels) < MAX_KNOWN:
            channel = mcap_fields.channel(piece.body)
            if channel.id not in self._channels and (channel.schema_id == 0 or channel.schema_id in self._schemas):
                self._channels.add(channel.id)
                self._file.know(channel)
        elif piece.opcode == Opcode.METADATA and self._notes < MAX_KNOWN:
            note = mcap_fields.metadata(piece.body)
            self._notes += 1
            self._file.note(note.name, note.metadata)
        elif piece.opcode == Opcode.MESSAGE:
            raw = bytes([piece.opcode]) + len(piece.body).to_bytes(8, "little") + bytes(piece.body)
            self._keep(raw, messages(raw)[0])
        elif piece.opcode == Opcode.DATA_END:
            self.saved.complete = True

    def _chunk(self, content: Content) -> bool:
        """Keep a chunk's messages; whether that was all of it."""
        table, others, end = messages(content.raw)
        self._begin("ros2")
        for piece in others:
            try:
                self._record(piece)
            except RecordingError as error:
                self.saved.damages.append(Damage(content.start, str(error)))
        if content.whole and not others and end == len(content.raw):
            self._keep(content.raw, table)
        else:
            for _, _, start in table.tolist():
                (length,) = LENGTH.unpack_from(content.raw, start + 1)
                raw = content.raw[start : start + LENGTH_COUNTS_FROM + length]
                self._keep(raw, messages(raw)[0])
        whole = content.whole and end == len(content.raw)
        if not whole:
            self.saved.damages.append(Damage(content.start, "its last chunk was never finished"))
        return whole

    def _keep(self, raw: bytes, table: Table) -> None:
        """Add messages to the new file, all of which belong to known channels."""
        if not set(table[:, 0].tolist()) <= self._channels:
            self.saved.damages.append(Damage(self._reached, "messages of a topic that is not described were left out"))
            return
        if len(table):
            self._file.write(np.frombuffer(raw, dtype=np.uint8), table)
            self.saved.messages += len(table)
            first, last = int(table[:, 1].min()), int(table[:, 1].max())
            self.saved.first = first if self.saved.first is None else min(first, self.saved.first)
            self.saved.last = last if self.saved.last is None else max(last, self.saved.last)
