"""All messages of one control cycle as one numpy record, so that a batch of cycles is written in one go."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

from burnish.record.mcap_file import HEAD, LENGTH_COUNTS_FROM, Table
from burnish.record.messages import Template, record_dtype

Stamps = NDArray[np.int64]


class Cycle:
    """The messages that a cycle has, in the order in which they stand in the file, each behind its head."""

    def __init__(self, parts: Sequence[tuple[str, int, Template]]) -> None:
        """Lay the messages one behind the other.

        Args:
            parts: topic, number of its channel and layout of each message.
        """
        blank, fields = bytearray(), {}
        offsets: list[int] = []
        for topic, channel, template in parts:
            offsets.append(len(blank))
            head = np.zeros(1, dtype=HEAD)
            head["opcode"], head["channel"] = Opcode.MESSAGE, channel
            head["length"] = len(template.blank) + HEAD.itemsize - LENGTH_COUNTS_FROM
            for name in ("sequence", "log_time", "publish_time"):
                kind, place = HEAD.fields[name][:2]  # type: ignore[index]
                fields[f"{topic} {name}"] = (kind, len(blank) + place)
            blank += head.tobytes()
            for name, (kind, place) in template.fields.items():
                fields[f"{topic} {name}"] = (kind, len(blank) + place)
            blank += template.blank
        self._topics = [topic for topic, _, _ in parts]
        self._channels = np.array([channel for _, channel, _ in parts], dtype=np.uint64)
        self._offsets = np.array(offsets, dtype=np.uint64)
        self._blank = bytes(blank)
        self._dtype = record_dtype(fields, len(blank))

    def encode(
        self, first: int, stamps: Stamps, columns: Mapping[str, Mapping[str, Any]]
    ) -> tuple[NDArray[np.uint8], Table]:
        """Cycles as bytes, and where their messages stand in them.

        Args:
            first: running number of the first cycle.
            stamps: times of the cycles [ns], (N,).
            columns: for each topic the names of its numbers and their values, (N,) or (N, count).
        """
        count, size = len(stamps), len(self._blank)
        raw = np.frombuffer(bytearray(self._blank * count), dtype=np.uint8)
        rows = raw.view(self._dtype)
        sec, nanosec = np.divmod(stamps, 1_000_000_000)
        numbers = np.arange(first, first + count, dtype=np.uint64) & np.uint64(0xFFFFFFFF)
        for topic in self._topics:
            rows[f"{topic} sequence"] = numbers
            rows[f"{topic} log_time"] = rows[f"{topic} publish_time"] = stamps
            rows[f"{topic} sec"], rows[f"{topic} nanosec"] = sec, nanosec
            for name, values in columns[topic].items():
                rows[f"{topic} {name}"] = values
        table = np.empty((count, len(self._topics), 3), dtype=np.uint64)
        table[:, :, 0] = self._channels
        table[:, :, 1] = stamps[:, None]
        table[:, :, 2] = np.arange(0, size * count, size, dtype=np.uint64)[:, None] + self._offsets
        return raw, table.reshape(-1, 3)
