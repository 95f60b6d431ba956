"""The fields of a record that came from outside, read one after the other and never past its end."""

from __future__ import annotations

import struct

from mcap.records import Channel, Header, Metadata, Schema

from burnish.errors import RecordingError

MAX_PAIRS = 10_000
"""Most names and values of one record."""


class Fields:
    """Reads a record's body from front to back; every method raises `RecordingError` where it does not go on."""

    def __init__(self, body: memoryview) -> None:
        self._body = body
        self._at = 0

    def take(self, size: int) -> memoryview:
        """The next ``size`` bytes."""
        piece = self._body[self._at : self._at + size]
        if len(piece) < size:
            raise RecordingError("a record is shorter than its fields; it is damaged")
        self._at += size
        return piece

    def number(self, kind: str) -> int:
        """A number of the struct kind (such as ``<I``)."""
        return int(struct.unpack(kind, self.take(struct.calcsize(kind)))[0])

    def data(self) -> bytes:
        """Bytes behind their length."""
        return bytes(self.take(self.number("<I")))

    def text(self) -> str:
        """A text behind its length."""
        try:
            return self.data().decode()
        except UnicodeDecodeError:
            raise RecordingError("a text in a record is not UTF-8; it is damaged") from None

    def pairs(self) -> dict[str, str]:
        """Names and values behind the length of all of them."""
        inner = Fields(self.take(self.number("<I")))
        found: dict[str, str] = {}
        while inner._at < len(inner._body):
            name = inner.text()
            found[name] = inner.text()
            if len(found) > MAX_PAIRS:
                raise RecordingError(f"a record has more than {MAX_PAIRS} names; at most so many are read")
        return found


def header(body: memoryview) -> Header:
    """The first record of a file."""
    fields = Fields(body)
    return Header(profile=fields.text(), library=fields.text())


def schema(body: memoryview) -> Schema:
    """The definition of a message type."""
    fields = Fields(body)
    return Schema(id=fields.number("<H"), name=fields.text(), encoding=fields.text(), data=fields.data())


def channel(body: memoryview) -> Channel:
    """A topic and how its messages are encoded."""
    fields = Fields(body)
    number, schema_id = fields.number("<H"), fields.number("<H")
    topic, encoding = fields.text(), fields.text()
    return Channel(id=number, schema_id=schema_id, topic=topic, message_encoding=encoding, metadata=fields.pairs())


def metadata(body: memoryview) -> Metadata:
    """Names and values under a name."""
    fields = Fields(body)
    return Metadata(name=fields.text(), metadata=fields.pairs())
