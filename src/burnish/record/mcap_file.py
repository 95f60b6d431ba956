"""An MCAP file that takes messages by the batch.

The writer of the ``mcap`` package takes about 10 µs a message, most of it with the interpreter held, which a
control loop of 1 kHz in the same process feels. Here messages come as bytes that are ready, and the indices are
numpy records. All rare records are the package's.

Source: the MCAP format specification, version 0.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping
from itertools import pairwise
from typing import IO

import numpy as np
import zstandard
from mcap import records
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC
from numpy.typing import NDArray

HEAD = np.dtype(
    [
        ("opcode", "u1"),
        ("length", "<u8"),
        ("channel", "<u2"),
        ("sequence", "<u4"),
        ("log_time", "<u8"),
        ("publish_time", "<u8"),
    ]
)
"""What stands before the bytes of a message."""
LENGTH_COUNTS_FROM = 9
"""A record's length does not count its opcode and the length itself [B]."""
CHUNK_HEAD = struct.Struct("<QQQII4sQ")
"""First and last time [ns], size and checksum of the content, the name of the compression with its length before it,
and the compressed size: what stands before the content of a chunk of ours."""
COMPRESSION = b"zstd"
LEVEL = 1
"""Of the compression: 3, the library's choice, takes twice as long to save a twentieth."""

Table = NDArray[np.uint64]
"""A row a message: number of its channel, time [ns], place in the bytes [B]."""


class McapFile:
    """Writes header, chunks and index of one file; not for two threads."""

    def __init__(self, file: IO[bytes], chunk_size: int) -> None:
        """Take an empty binary file; chunks are closed as soon as they hold ``chunk_size`` bytes."""
        self._file = file
        self._chunk_size = chunk_size
        self._position = 0
        self._checksum = 0
        self._compressor = zstandard.ZstdCompressor(level=LEVEL)
        self._pieces: list[NDArray[np.uint8]] = []
        self._pending: list[Table] = []
        self._pending_size = 0
        self._schemas: list[bytes] = []
        self._channels: list[bytes] = []
        # Packed at once: an hour of short chunks would be a hundred thousand objects.
        self._chunks = bytearray()
        self._chunk_count = 0
        self._span: tuple[int, int] | None = None
        self._metadata: list[bytes] = []
        self._counts: dict[int, int] = {}

    def begin(self, library: str, profile: str = "ros2") -> None:
        """Magic and header."""
        self._put(MCAP0_MAGIC + _bytes(records.Header(profile=profile, library=library)))

    def describe(self, schemas: Mapping[str, str], topics: Mapping[str, str]) -> dict[str, int]:
        """Make topics known whose messages are in the CDR of ROS 2.

        Args:
            schemas: message type to its ROS 2 definition.
            topics: topic to message type.

        Returns:
            Topic to the number of its channel.
        """
        numbers = {name: i + 1 for i, name in enumerate(schemas)}
        channels = {topic: i + 1 for i, topic in enumerate(topics)}
        for name, text in schemas.items():
            self.know(records.Schema(id=numbers[name], name=name, encoding="ros2msg", data=text.encode()))
        for topic, name in topics.items():
            self.know(
                records.Channel(
                    id=channels[topic], topic=topic, message_encoding="cdr", schema_id=numbers[name], metadata={}
                )
            )
        return channels

    def know(self, item: records.Schema | records.Channel) -> None:
        """Write a schema, or a channel whose schema was written before."""
        record = _bytes(item)
        (self._schemas if isinstance(item, records.Schema) else self._channels).append(record)
        self._put(record)

    def note(self, name: str, values: Mapping[str, str]) -> None:
        """Write names and values as one metadata record."""
        self.close_chunk()
        record = _bytes(records.Metadata(name=name, metadata=dict(values)))
        self._metadata.append(
            _bytes(records.MetadataIndex(offset=self._position, length=len(record), name=name)),
        )
        self._put(record)

    def write(self, raw: NDArray[np.uint8], table: Table) -> None:
        """Append messages.

        Args:
            raw: the messages with their heads, one behind the other.
            table: where they stand in ``raw``.
        """
        table[:, 2] += np.uint64(self._pending_size)
        self._pieces.append(raw)
        self._pending.append(table)
        self._pending_size += len(raw)
        if self._pending_size >= self._chunk_size:
            self.close_chunk()

    def close_chunk(self) -> None:
        """Hand what was written so far to the operating system, as a chunk that stands for itself."""
        if not self._pieces:
            return
        raw = self._pieces[0] if len(self._pieces) == 1 else np.concatenate(self._pieces)
        table = self._pending[0] if len(self._pending) == 1 else np.concatenate(self._pending)
        packed = self._compressor.compress(raw.data)
        first, last = int(table[:, 1].min()), int(table[:, 1].max())
        head = CHUNK_HEAD.pack(first, last, len(raw), checksum(raw.data), len(COMPRESSION), COMPRESSION, len(packed))
        length = len(head) + len(packed)
        start, size = self._position, LENGTH_COUNTS_FROM + length
        index, places = self._message_index(table, start + size)
        self._put(b"".join((struct.pack("<BQ", Opcode.CHUNK, length), head, packed, index)))
        entry = struct.pack(f"<QQQQI{len(places)}s", first, last, start, size, len(places), places)
        entry += struct.pack("<QI4sQQ", len(index), len(COMPRESSION), COMPRESSION, len(packed), len(raw))
        self._chunks += struct.pack("<BQ", Opcode.CHUNK_INDEX, len(entry)) + entry
        self._chunk_count += 1
        self._span = (first, last) if self._span is None else (min(first, self._span[0]), max(last, self._span[1]))
        self._pieces, self._pending, self._pending_size = [], [], 0

    def finish(self) -> None:
        """Write the last chunk, the index and the end; the file itself stays open."""
        self.close_chunk()
        self._put(_bytes(records.DataEnd(data_section_crc=self._checksum)))
        start = self._position
        groups = (
            b"".join(self._schemas),
            b"".join(self._channels),
            _bytes(self._statistics()),
            bytes(self._chunks),
            b"".join(self._metadata),
        )
        offsets = b""
        summary = b""
        for part in groups:
            if part:
                place = records.SummaryOffset(
                    group_opcode=Opcode(part[0]), group_start=start + len(summary), group_length=len(part)
                )
                offsets += _bytes(place)
                summary += part
        offset_start = start + len(summary)
        # The checksum covers the summary and the footer up to itself.
        foot = struct.pack("<BQQQ", Opcode.FOOTER, 20, start, offset_start)
        crc = zlib.crc32(summary + offsets + foot)
        footer = records.Footer(summary_start=start, summary_offset_start=offset_start, summary_crc=crc)
        self._put(summary + offsets + _bytes(footer) + MCAP0_MAGIC)

    def _put(self, data: bytes) -> None:
        self._file.write(data)
        # First what a killed process would lose, then the checksum, which is needed at the end.
        self._file.flush()
        self._checksum = checksum(data, self._checksum)
        self._position += len(data)

    def _message_index(self, table: Table, position: int) -> tuple[bytes, bytes]:
        """Times and places of a chunk's messages by channel, and where each channel's record will stand."""
        order = np.argsort(table[:, 0], kind="stable")
        channels, entries = table[order, 0], np.ascontiguousarray(table[order, 1:], dtype="<u8")
        edges = [0, *(np.flatnonzero(channels[1:] != channels[:-1]) + 1).tolist(), len(channels)]
        index, places = b"", b""
        for first, last in pairwise(edges):
            channel, size = int(channels[first]), 16 * (last - first)
            places += struct.pack("<HQ", channel, position + len(index))
            index += struct.pack("<BQHI", Opcode.MESSAGE_INDEX, 6 + size, channel, size) + entries[first:last].tobytes()
            self._counts[channel] = self._counts.get(channel, 0) + last - first
        return index, places

    def _statistics(self) -> records.Statistics:
        start, end = self._span if self._span is not None else (0, 0)
        return records.Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts=dict(self._counts),
            chunk_count=self._chunk_count,
            message_count=sum(self._counts.values()),
            message_start_time=start,
            message_end_time=end,
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )


def checksum(data: bytes | memoryview, start: int = 0) -> int:
    """CRC-32 in small pieces: from 5 KiB on zlib lets go of the interpreter, and a busy loop gives it back late."""
    for i in range(0, len(data), 4096):
        start = zlib.crc32(data[i : i + 4096], start)
    return start


def _bytes(record: records.McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]
