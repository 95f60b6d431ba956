"""The records of an MCAP file that may be cut off, damaged or no such file at all.

Nothing that the file says is believed before it is checked: every length against the file, every size against a
bound, the content of a chunk against its checksum. Where the chain of records breaks, the next chunk that is whole
is looked for by the name of its compression, and the chain goes on from there.
"""

from __future__ import annotations

import mmap
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import zstandard
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC

from burnish.errors import RecordingError
from burnish.record.mcap_file import HEAD, LENGTH_COUNTS_FROM, Table

MAX_CHUNK = 16 * 2**20
"""Largest chunk that is unpacked [B]; ours have 64 KiB, and most other recorders stay at a few MiB."""
MAX_RECORD = 2 * MAX_CHUNK
"""Largest record of any kind [B]."""
MAX_DAMAGES = 100
"""Places of damage after which the rest is given up: what is searched is unpacked, and that takes time."""
LAST_OPCODE = 0x0F
"""Of the kinds that the format defines; from 0x80 on they are anybody's own and skipped."""
_RECORD = struct.Struct("<BQ")
_CHUNK = struct.Struct("<QQQII")
_FOOTER = struct.Struct("<BQQQI")
_MESSAGE = struct.Struct("<HIQ")
_LENGTH = struct.Struct("<Q")
_COMPRESSION = b"\x04\x00\x00\x00zstd"


class Piece(NamedTuple):
    """A record that is whole, as far as can be told."""

    opcode: int
    start: int
    """Its place in the file [B]."""
    body: memoryview
    """What stands behind its length."""


class Content(NamedTuple):
    """The records of a chunk."""

    start: int
    """The chunk's place in the file [B]."""
    size: int
    """How much of the file it takes [B]."""
    raw: bytes
    whole: bool
    """Whether all of it is there and its checksum is right; else ``raw`` is what could be unpacked."""


class Damage(NamedTuple):
    """A place where the file is not as it should be."""

    start: int
    """Where [B]."""
    reason: str


def open_recording(path: Path) -> mmap.mmap:
    """The bytes of a file, unread and not to be written.

    Raises:
        RecordingError: if it cannot be read, or does not begin as every MCAP file does.
    """
    try:
        with path.open("rb") as file:
            data = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
    except ValueError:
        raise RecordingError(f"{str(path)!r} is empty; expected a recording (MCAP)") from None
    except OSError as error:
        raise RecordingError(f"{path} cannot be read ({error.strerror}); expected a recording (MCAP)") from None
    if data[: len(MCAP0_MAGIC)] != MCAP0_MAGIC:
        data.close()
        raise RecordingError(f"{path} is no recording: it does not begin as an MCAP file does; check the name")
    return data


def scan(data: mmap.mmap | bytes) -> Iterator[Piece | Content | Damage]:
    """All records of the data section up to its end, chunks unpacked, and what is wrong with it."""
    view = memoryview(data)
    position, damages = len(MCAP0_MAGIC), 0
    while True:
        found = _next(view, position)
        yield found
        if isinstance(found, Piece):
            position = found.start + LENGTH_COUNTS_FROM + len(found.body)
            if found.opcode == Opcode.DATA_END:
                reason = _end(view, found, position)
                if reason:
                    yield Damage(found.start, reason)
                return
        elif isinstance(found, Content) and found.whole:
            position += found.size
        else:
            damages += 1
            after = _search(data, position + 1)
            if after is None:
                return
            if damages >= MAX_DAMAGES:
                yield Damage(after, f"damaged in more than {MAX_DAMAGES} places; the rest was not looked at")
                return
            position = after


def messages(raw: bytes) -> tuple[Table, list[Piece], int]:
    """What stands in a chunk's content.

    Returns:
        Channel, time and place of each whole message, the other records, and where the last whole record ends.
    """
    rows: list[tuple[int, int, int]] = []
    others: list[Piece] = []
    position, end, view = 0, len(raw), memoryview(raw)
    smallest = HEAD.itemsize - LENGTH_COUNTS_FROM
    while position + LENGTH_COUNTS_FROM <= end:
        opcode, length = _RECORD.unpack_from(raw, position)
        after = position + LENGTH_COUNTS_FROM + length
        if after > end or opcode == 0:
            break
        if opcode == Opcode.MESSAGE:
            if length < smallest:
                break
            channel, _, time = _MESSAGE.unpack_from(raw, position + LENGTH_COUNTS_FROM)
            rows.append((channel, time, position))
        else:
            others.append(Piece(opcode, position, view[position + LENGTH_COUNTS_FROM : after]))
        position = after
    return np.array(rows, dtype=np.uint64).reshape(-1, 3), others, position


def _next(view: memoryview, position: int) -> Piece | Content | Damage:
    """The record at a position, checked."""
    left = len(view) - position
    if left == 0:
        return Damage(position, "it ends without its index")
    if left < LENGTH_COUNTS_FROM:
        return Damage(position, f"it is cut off in the first {LENGTH_COUNTS_FROM} bytes of a record")
    opcode, length = _RECORD.unpack_from(view, position)
    if opcode == 0 or LAST_OPCODE < opcode < 0x80 or length > MAX_RECORD:
        return Damage(position, "there is no record where one should begin")
    body = view[position + LENGTH_COUNTS_FROM : position + LENGTH_COUNTS_FROM + length]
    if opcode == Opcode.CHUNK:
        return _content(body, position, length)
    if len(body) < length:
        return Damage(position, "it is cut off inside a record")
    return Piece(opcode, position, body)


def _end(view: memoryview, data_end: Piece, position: int) -> str | None:
    """What is wrong with a file from the end of its data on, or with their checksum."""
    checksum = int.from_bytes(data_end.body[:4], "little")
    if len(data_end.body) < 4 or (checksum and zlib.crc32(view[: data_end.start]) != checksum):
        return "the data do not have their checksum: a name, a value of the metadata or an index is damaged"
    foot_at = len(view) - _FOOTER.size - len(MCAP0_MAGIC)
    if foot_at < position or view[-len(MCAP0_MAGIC) :] != MCAP0_MAGIC:
        return "its index is cut off"
    opcode, length, start, _, checksum = _FOOTER.unpack_from(view, foot_at)
    if (
        opcode != Opcode.FOOTER
        or length != _FOOTER.size - LENGTH_COUNTS_FROM
        or not (start == 0 or position <= start <= foot_at)
    ):
        return "its end is damaged"
    if start and checksum and zlib.crc32(view[start : len(view) - len(MCAP0_MAGIC) - 4]) != checksum:
        return "its index does not have its checksum"
    return None


def _content(body: memoryview, start: int, length: int) -> Content | Damage:
    """A chunk, unpacked as far as it goes."""
    name_at = _CHUNK.size
    if len(body) < name_at + 4:
        return Damage(start, "it is cut off inside a chunk")
    first, last, size, checksum, name_length = _CHUNK.unpack_from(body)
    data_at = name_at + name_length + _LENGTH.size
    if name_length > 16 or size > MAX_CHUNK or last < first:
        return Damage(start, "a chunk begins with sizes or times that cannot be")
    if len(body) < data_at:
        return Damage(start, "it is cut off inside a chunk")
    name = bytes(body[name_at : name_at + name_length])
    (packed_size,) = _LENGTH.unpack_from(body, data_at - _LENGTH.size)
    if packed_size != length - data_at:
        return Damage(start, "a chunk's sizes contradict each other")
    if name not in (b"", b"zstd"):
        return Damage(start, f"a chunk is packed with {name.decode(errors='replace')!r}; only zstd can be read")
    packed = body[data_at:]
    raw = bytes(packed[: size + 1]) if not name else _unpacked(packed, size)
    if len(body) < length:
        return Content(start, LENGTH_COUNTS_FROM + len(body), raw[:size], whole=False)
    if len(raw) != size or (checksum and zlib.crc32(raw) != checksum):
        return Damage(start, "a chunk does not have its checksum")
    return Content(start, LENGTH_COUNTS_FROM + length, raw, whole=True)


def _unpacked(packed: memoryview, size: int) -> bytes:
    """At most ``size`` + 1 bytes, whatever the packed data promise."""
    pieces: list[bytes] = []
    count = 0
    try:
        with zstandard.ZstdDecompressor(max_window_size=MAX_CHUNK).stream_reader(packed) as reader:
            while count <= size and (piece := reader.read(size + 1 - count)):
                pieces.append(piece)
                count += len(piece)
    except zstandard.ZstdError:
        pass
    return b"".join(pieces)


def _search(data: mmap.mmap | bytes, position: int) -> int | None:
    """The start of the next chunk from ``position`` on that is whole; None if there is none."""
    view = memoryview(data)
    before = LENGTH_COUNTS_FROM + _CHUNK.size - 4
    tried = 0
    at = data.find(_COMPRESSION, position + before)
    while at >= 0 and tried < MAX_DAMAGES:
        start = at - before
        if view[start] == Opcode.CHUNK:
            tried += 1
            found = _next(view, start)
            if isinstance(found, Content) and found.whole:
                return start
        at = data.find(_COMPRESSION, at + 1)
    return None
