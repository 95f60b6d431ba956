"""Reading PLY files, in text and in both binary forms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from burnish.core import Array
from burnish.errors import MouldError
from burnish.surface.polygons import MAX_FACES, triangulated

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}  # fmt: skip

_FORMS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_LONGEST_HEADER = 1 << 16
_CORNERS = ("vertex_indices", "vertex_index")


@dataclass(frozen=True, kw_only=True)
class Property:
    """A column of an element."""

    name: str
    """As the header has it."""
    kind: str
    """Type of the number, or of the entries of a list."""
    length: str | None
    """Type of the number that says how long a list is; None for a plain number."""


@dataclass(frozen=True, kw_only=True)
class Element:
    """A table of the file."""

    name: str
    """``vertex``, ``face`` or another."""
    count: int
    """Rows."""
    properties: list[Property]
    """Columns."""


def parse_ply(source: str, data: bytes) -> Array:
    """Corners of the triangles in the file's unit, (F, 3, 3).

    Raises:
        MouldError: it is no whole PLY file with x, y, z and lists of corners.
    """
    order, elements, start = _header(source, data)
    reader = _Text(source, data[start:]) if not order else _Binary(source, data, start, order)
    vertices: Array | None = None
    polygons: tuple[Array, NDArray[np.int64]] | None = None
    for element in elements:
        columns = reader.rows(element)
        if element.name == "vertex" and {"x", "y", "z"} <= set(columns):
            vertices = np.column_stack([columns[name][0] for name in "xyz"])
        if element.name == "face":
            polygons = next((columns[name] for name in _CORNERS if name in columns), None)
    if vertices is None or polygons is None or not len(polygons[1]):
        raise MouldError(f"{source} has no triangles; expected vertices with x, y, z and faces with vertex_indices")
    index, count = polygons
    if not np.all(np.abs(index) < 2.0**31) or np.any(index != np.rint(index)):
        raise MouldError(f"{source} is damaged: the corner of a face is no whole number; export it again")
    return triangulated(source, vertices, index.astype(np.int64), count)


def _header(source: str, data: bytes) -> tuple[str, list[Element], int]:
    """Byte order ('' for text), elements, and where they begin.

    Raises:
        MouldError: it is not the header of a PLY file that can be read.
    """
    end = data.find(b"end_header", 0, _LONGEST_HEADER)
    start = data.find(b"\n", end) + 1
    if not data.startswith(b"ply") or end < 0 or start == 0:
        raise MouldError(f"{source} is not a PLY file, or it was cut off: it has no header; export it again")
    order: str | None = None
    elements: list[Element] = []
    for line in data[:end].decode("latin-1").splitlines()[1:]:
        match line.split():
            case ["format", form, _] if form in _FORMS:
                order = _FORMS[form]
            case ["element", name, count] if count.isascii() and count.isdigit() and len(count) < 12:
                elements.append(Element(name=name, count=int(count), properties=[]))
            case ["property", "list", length, kind, name] if elements and {length, kind} <= set(_TYPES):
                elements[-1].properties.append(Property(name=name, kind=_TYPES[kind], length=_TYPES[length]))
            case ["property", kind, name] if elements and kind in _TYPES:
                elements[-1].properties.append(Property(name=name, kind=_TYPES[kind], length=None))
            case [] | ["comment" | "obj_info", *_]:
                pass
            case _:
                raise MouldError(f"{source} is damaged: its header has the line {line[:40]!r}; export it again")
    if order is None:
        raise MouldError(f"{source} is damaged: its header names no format; expected {', '.join(_FORMS)}")
    for element in elements:
        if element.count > (MAX_FACES if element.name == "face" else 3 * MAX_FACES):
            raise MouldError(
                f"{source} has {element.count} rows of '{element.name}'; at most {MAX_FACES} triangles are read: "
                "export it with a coarser tolerance"
            )
    return order, elements, start


_Columns = dict[str, tuple[Array, NDArray[np.int64]]]
"""Of each property the values, one row after the other, and how many each row has."""


class _Text:
    """The rows of a text file."""

    def __init__(self, source: str, body: bytes) -> None:
        self._source = source
        try:
            words = body.split()
            self._numbers = np.fromiter(map(float, words), np.float64, len(words))
        except ValueError:
            raise MouldError(f"{source} is damaged: a row has a word for a number; export it again") from None
        self._at = 0

    def rows(self, element: Element) -> _Columns:
        """The next table.

        Raises:
            MouldError: the file ends before it.
        """
        numbers, width = self._numbers, len(element.properties)
        if not any(entry.length for entry in element.properties):
            stop = self._at + element.count * width
            if stop > len(numbers):
                raise _cut(self._source, element)
            table = numbers[self._at : stop].reshape(element.count, width)
            self._at = stop
            one = np.ones(element.count, dtype=np.int64)
            return {entry.name: (table[:, i], one) for i, entry in enumerate(element.properties)}
        found: dict[str, tuple[list[float], list[int]]] = {entry.name: ([], []) for entry in element.properties}
        rest = numbers[self._at :].tolist()
        at = 0
        for _ in range(element.count):
            for entry in element.properties:
                count = 1
                if entry.length is not None:
                    count = _length(self._source, rest[at] if at < len(rest) else np.nan)
                    at += 1
                if at + count > len(rest):
                    raise _cut(self._source, element)
                found[entry.name][0].extend(rest[at : at + count])
                found[entry.name][1].append(count)
                at += count
        self._at += at
        return {name: (np.array(values), np.array(count, dtype=np.int64)) for name, (values, count) in found.items()}


class _Binary:
    """The rows of a binary file."""

    def __init__(self, source: str, data: bytes, start: int, order: str) -> None:
        self._source, self._data, self._at, self._order = source, data, start, order

    def rows(self, element: Element) -> _Columns:
        """The next table.

        Raises:
            MouldError: the file ends before it.
        """
        for corners in (0, 3, 4):  # All rows alike, which is the rule.
            columns = self._alike(element, corners)
            if columns is not None:
                return columns
            if not any(entry.length for entry in element.properties):
                raise _cut(self._source, element)
        return self._mixed(element)

    def _alike(self, element: Element, corners: int) -> _Columns | None:
        """The table if all its lists have so many entries; None if not, or if the file ends before."""
        fields: list[tuple[str, str] | tuple[str, str, tuple[int, ...]]] = []
        for i, entry in enumerate(element.properties):
            if entry.length is not None:
                fields.append((f"n{i}", self._order + entry.length))
                fields.append((f"v{i}", self._order + entry.kind, (corners,)))
            else:
                fields.append((f"v{i}", self._order + entry.kind))
        row = np.dtype(fields)
        if self._at + row.itemsize * element.count > len(self._data) or not row.itemsize:
            return None
        table = np.frombuffer(self._data, row, element.count, self._at)
        columns: _Columns = {}
        for i, entry in enumerate(element.properties):
            if entry.length is not None and np.any(table[f"n{i}"] != corners):
                return None
            with np.errstate(invalid="ignore"):  # A signalling NaN; what is not finite is refused later.
                values = table[f"v{i}"].astype(np.float64).ravel()
            columns[entry.name] = (values, np.full(element.count, corners if entry.length else 1, dtype=np.int64))
        self._at += row.itemsize * element.count
        return columns

    def _mixed(self, element: Element) -> _Columns:
        """The table row by row."""
        found: dict[str, tuple[list[Array], list[int]]] = {entry.name: ([], []) for entry in element.properties}
        for _ in range(element.count):
            for entry in element.properties:
                count = 1 if entry.length is None else _length(self._source, self._take(element, entry.length, 1)[0])
                found[entry.name][0].append(self._take(element, entry.kind, count))
                found[entry.name][1].append(count)
        with np.errstate(invalid="ignore"):
            return {
                name: (
                    np.concatenate(values or [np.empty(0)]).astype(np.float64),
                    np.array(count, dtype=np.int64),
                )
                for name, (values, count) in found.items()
            }

    def _take(self, element: Element, kind: str, count: int) -> Array:
        """The next numbers."""
        dtype = np.dtype(self._order + kind)
        stop = self._at + count * dtype.itemsize
        if stop > len(self._data):
            raise _cut(self._source, element)
        values = np.frombuffer(self._data, dtype, count, self._at)
        self._at = stop
        return values


def _length(source: str, value: float) -> int:
    """Length of a list.

    Raises:
        MouldError: it is no small whole number.
    """
    if not 0 <= value <= MAX_FACES or value != int(value):
        raise MouldError(f"{source} is damaged or was cut off: a list has {value:g} entries; export it again")
    return int(value)


def _cut(source: str, element: Element) -> MouldError:
    """What is said of a file that ends too early."""
    return MouldError(
        f"{source} was cut off: it ends before its {element.count} rows of '{element.name}'; export again"
    )
