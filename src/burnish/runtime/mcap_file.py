"""An MCAP file that takes messages by the batch.

The writer of the ``mcap`` package takes about 10 µs a message, most of it with the interpreter held, which a
control loop of 1 kHz in the same process feels. Here the heads and the indices of a batch are numpy records:
about 1 µs a message, and the compression, which lets go of the interpreter. All rare records are the package's.

Source: the MCAP format specification, version 0.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping, Sequence
from itertools import chain
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


class McapFile:
    """Writes header, chunks and index of one file; not for two threads."""

    def __init__(self, file: IO[bytes], chunk_size: int) -> None:
        """Take an empty binary file; chunks are closed as soon as they hold ``chunk_size`` bytes."""
        self._file = file
        self._chunk_size = chunk_size
        self._position = 0
        self._pieces: list[bytes] = []
        self._pending: list[NDArray[np.uint64]] = []
        self._pending_size = 0
        self._known: list[records.Schema | records.Channel] = []
        self._chunks: list[records.ChunkIndex] = []
        self._metadata: list[records.MetadataIndex] = []
        self._counts: dict[int, int] = {}

    def begin(
        self, library: str, metadata: Mapping[str, str], schemas: Mapping[str, str], topics: Mapping[str, str]
    ) -> dict[str, int]:
        """Write all that stands before the first message.

        Args:
            library: who writes.
            metadata: names and values, stored as one record ``library``.
            schemas: message type to its ROS 2 definition.
            topics: topic to message type.

        Returns:
            Topic to the number of its channel.
        """
        self._put(MCAP0_MAGIC + _bytes(records.Header(profile="ros2", library=library)))
        record = _bytes(records.Metadata(name=library, metadata=dict(metadata)))
        self._metadata.append(records.MetadataIndex(offset=self._position, length=len(record), name=library))
        self._put(record)
        numbers = {name: i + 1 for i, name in enumerate(schemas)}
        channels = {topic: i + 1 for i, topic in enumerate(topics)}
        for name, text in schemas.items():
            self._known.append(records.Schema(id=numbers[name], name=name, encoding="ros2msg", data=text.encode()))
        for topic, name in topics.items():
            self._known.append(
                records.Channel(
                    id=channels[topic], topic=topic, message_encoding="cdr", schema_id=numbers[name], metadata={}
                )
            )
        self._put(b"".join(_bytes(item) for item in self._known))
        self._file.flush()
        return channels

    def write(
        self, channels: Sequence[int], stamps: Sequence[int], sequences: Sequence[int], data: Sequence[bytes]
    ) -> None:
        """Append messages, in the order of time.

        Args:
            channels: number of the channel of each message.
            stamps: times of the messages [ns].
            sequences: running numbers of the messages.
            data: the encoded messages.
        """
        heads = np.zeros(len(data), dtype=HEAD)
        heads["opcode"] = Opcode.MESSAGE
        heads["length"] = np.fromiter(map(len, data), np.int64, len(data)) + HEAD.itemsize - LENGTH_COUNTS_FROM
        heads["channel"], heads["sequence"] = channels, sequences
        heads["log_time"] = heads["publish_time"] = stamps
        raw, step = heads.tobytes(), HEAD.itemsize
        self._pieces += chain.from_iterable(
            zip((raw[i : i + step] for i in range(0, len(raw), step)), data, strict=True)
        )
        ends = self._pending_size + np.cumsum(heads["length"] + LENGTH_COUNTS_FROM)
        starts = np.concatenate([[self._pending_size], ends[:-1]])
        self._pending.append(np.stack([heads["channel"], heads["log_time"], starts], axis=1).astype(np.uint64))
        self._pending_size = int(ends[-1])
        if self._pending_size >= self._chunk_size:
            self._close_chunk()

    def finish(self) -> None:
        """Write the last chunk, the index and the end; the file itself stays open."""
        self._close_chunk()
        self._put(_bytes(records.DataEnd(data_section_crc=0)))
        start = self._position
        groups = (
            [item for item in self._known if isinstance(item, records.Schema)],
            [item for item in self._known if isinstance(item, records.Channel)],
            [self._statistics()],
            self._chunks,
            self._metadata,
        )
        offsets = b""
        summary = b""
        for group in groups:
            part = b"".join(_bytes(item) for item in group)
            if part:
                place = records.SummaryOffset(
                    group_opcode=Opcode(part[0]), group_start=start + len(summary), group_length=len(part)
                )
                offsets += _bytes(place)
                summary += part
        offset_start = start + len(summary)
        # The checksum covers the summary and the footer up to itself.
        foot = struct.pack("<BQQQ", Opcode.FOOTER, 20, start, offset_start)
        checksum = zlib.crc32(summary + offsets + foot)
        footer = records.Footer(summary_start=start, summary_offset_start=offset_start, summary_crc=checksum)
        self._put(summary + offsets + _bytes(footer) + MCAP0_MAGIC)
        self._file.flush()

    def _put(self, data: bytes) -> None:
        self._file.write(data)
        self._position += len(data)

    def _close_chunk(self) -> None:
        if not self._pieces:
            return
        raw = b"".join(self._pieces)
        packed = zstandard.compress(raw)
        table = np.concatenate(self._pending)
        first, last = int(table[:, 1].min()), int(table[:, 1].max())
        record = _bytes(
            records.Chunk(
                compression="zstd",
                data=packed,
                message_start_time=first,
                message_end_time=last,
                uncompressed_crc=zlib.crc32(raw),
                uncompressed_size=len(raw),
            )
        )
        start = self._position
        self._put(record)
        index, places = self._message_index(table)
        self._chunks.append(
            records.ChunkIndex(
                chunk_start_offset=start,
                chunk_length=len(record),
                message_start_time=first,
                message_end_time=last,
                message_index_offsets=places,
                message_index_length=len(index),
                compression="zstd",
                compressed_size=len(packed),
                uncompressed_size=len(raw),
            )
        )
        self._put(index)
        self._file.flush()
        self._pieces, self._pending, self._pending_size = [], [], 0

    def _message_index(self, table: NDArray[np.uint64]) -> tuple[bytes, dict[int, int]]:
        """Times and offsets of the messages of a chunk by channel, and where each channel's record will stand."""
        index, places = b"", {}
        for channel in np.unique(table[:, 0]).tolist():
            entries = np.ascontiguousarray(table[table[:, 0] == channel, 1:], dtype="<u8").tobytes()
            places[channel] = self._position + len(index)
            index += struct.pack("<BQHI", Opcode.MESSAGE_INDEX, 6 + len(entries), channel, len(entries)) + entries
            self._counts[channel] = self._counts.get(channel, 0) + len(entries) // 16
        return index, places

    def _statistics(self) -> records.Statistics:
        return records.Statistics(
            attachment_count=0,
            channel_count=sum(isinstance(item, records.Channel) for item in self._known),
            channel_message_counts=dict(self._counts),
            chunk_count=len(self._chunks),
            message_count=sum(self._counts.values()),
            message_start_time=min((chunk.message_start_time for chunk in self._chunks), default=0),
            message_end_time=max((chunk.message_end_time for chunk in self._chunks), default=0),
            metadata_count=len(self._metadata),
            schema_count=sum(isinstance(item, records.Schema) for item in self._known),
        )


def _bytes(record: records.McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]
