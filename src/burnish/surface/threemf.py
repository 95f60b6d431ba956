"""Reading 3MF files: a zip archive with XML, either of which may be made to blow up; neither can here."""

from __future__ import annotations

import io
import posixpath
import struct
import zipfile
import zlib
from dataclasses import dataclass, field
from xml.parsers import expat

import numpy as np

from burnish.core import Array
from burnish.errors import MouldError
from burnish.surface.polygons import MAX_FACES, check_count, triangulated

METRES_PER_UNIT = {
    "micron": 1e-6, "millimeter": 1e-3, "centimeter": 1e-2, "inch": 25.4e-3, "foot": 0.3048, "meter": 1.0,
}  # fmt: skip
"""The units that a 3MF file may name [m]."""

_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"

MOST_ENTRIES = 2000
"""Files in the archive."""
MOST_TEXT = 256 * 2**20
"""Bytes of XML, unpacked: more than 1.2 million triangles take."""
_LOOSEST = 100
"""Unpacked bytes per packed byte: XML of real parts packs 5 to 20 times, a zip bomb a thousand times."""
_DEEPEST = 16
"""Components within components."""

_DAMAGED = (
    zipfile.BadZipFile, zlib.error, struct.error, EOFError, OSError, ValueError, RuntimeError, IndexError,
)  # fmt: skip
"""What the standard library says of a damaged archive."""

Key = tuple[str, str]
"""Path of a part of the archive, and number of an object in it."""


@dataclass(kw_only=True)
class Object:
    """What a part of the archive defines; grows while the XML is read."""

    vertices: list[str] = field(default_factory=list)
    """x, y, z one after the other."""
    triangles: list[str] = field(default_factory=list)
    """Vertex numbers, three a triangle."""
    components: list[tuple[Key, str]] = field(default_factory=list)
    """Other objects, and where they are."""


def parse_3mf(source: str, data: bytes) -> Array:
    """Corners of the triangles of all that is built, [m], (F, 3, 3).

    Raises:
        MouldError: it is no whole 3MF file, or it unpacks to more than a part can be.
    """
    objects: dict[Key, Object] = {}
    build: list[tuple[Key, str]] = []
    scale = METRES_PER_UNIT["millimeter"]
    parts = _parts(source, data)
    for number, (path, text) in enumerate(parts.items()):
        model = _Model(source, path, objects, build if number == 0 else [])
        model.read(text)
        if number == 0:
            scale = model.scale
    assembled = _Assembly(source, objects)
    placed = [(key, transform) for key, transform in build if assembled.count(key, 0)]
    check_count(source, sum(assembled.count(key, 0) for key, _ in placed))
    return np.concatenate([_moved(source, assembled.corners(key), transform) for key, transform in placed]) * scale


def _parts(source: str, data: bytes) -> dict[str, bytes]:
    """The models of the archive by their path, the one with the build first."""
    if data.count(b"PK\x01\x02") > MOST_ENTRIES:
        raise MouldError(f"{source} has more than {MOST_ENTRIES} files in its archive; expected a 3MF file of one part")
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            found = [entry for entry in archive.infolist() if entry.filename.lower().endswith(".model")]
            found.sort(key=lambda entry: entry.filename.lower().strip("/") != "3d/3dmodel.model")
            left = MOST_TEXT
            parts: dict[str, bytes] = {}
            for entry in found:
                if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) or entry.flag_bits & 1:
                    raise MouldError(f"{source} is encrypted or packed in an unusual way; save it as plain 3MF")
                most = min(left, _LOOSEST * entry.compress_size + 2**16)
                if entry.file_size > most:
                    raise MouldError(
                        f"{source} would unpack from {entry.compress_size} to {entry.file_size} bytes; expected at "
                        f"most {most}: that is no part but a trap, or too fine a mesh"
                    )
                with archive.open(entry) as file:
                    text = file.read(most + 1)
                if len(text) > most:
                    raise MouldError(f"{source} unpacks to more than its archive promises; save it again")
                left -= len(text)
                parts["/" + entry.filename.strip("/")] = text
    except _DAMAGED:
        raise MouldError(f"{source} is not a 3MF file, or its archive is damaged; save it again") from None
    if not parts:
        raise MouldError(f"{source} is not a 3MF file: its archive holds no model; save it again")
    return parts


class _Model:
    """One XML part, read from its start to its end without keeping a tree."""

    def __init__(self, source: str, path: str, objects: dict[Key, Object], build: list[tuple[Key, str]]) -> None:
        self._source, self._path, self._objects, self._build = source, path, objects, build
        self._object = Object()
        self.scale = METRES_PER_UNIT["millimeter"]
        """What one unit is worth [m]."""

    def read(self, text: bytes) -> None:
        """Collect the objects and the build.

        Raises:
            MouldError: it is no XML, or no 3MF model.
        """
        parser = expat.ParserCreate(namespace_separator=" ")
        parser.StartElementHandler = self._start
        parser.StartDoctypeDeclHandler = self._refuse_doctype
        try:
            parser.Parse(text, True)
        except expat.ExpatError as error:
            raise MouldError(f"{self._source} is damaged: its model is no XML ({error}); save it again") from None
        except KeyError as error:
            raise MouldError(f"{self._source} is damaged: an element has no {error}; save it again") from None

    def _refuse_doctype(self, *_: object) -> None:
        raise MouldError(f"{self._source} has a DOCTYPE in its model; expected none: save it again")

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        namespace, _, element = name.rpartition(" ")
        if namespace not in ("", _CORE):
            return
        if element == "vertex":
            self._object.vertices += (attributes["x"], attributes["y"], attributes["z"])
        elif element == "triangle":
            self._object.triangles += (attributes["v1"], attributes["v2"], attributes["v3"])
        elif element == "object":
            self._object = self._objects.setdefault((self._path, attributes["id"]), Object())
        elif element == "component":
            self._object.components.append(self._placed(attributes))
        elif element == "item":
            self._build.append(self._placed(attributes))
        elif element == "model":
            unit = attributes.get("unit", "millimeter")
            if unit not in METRES_PER_UNIT:
                raise MouldError(f"{self._source} has the unit '{unit[:20]}'; expected {', '.join(METRES_PER_UNIT)}")
            self.scale = METRES_PER_UNIT[unit]

    def _placed(self, attributes: dict[str, str]) -> tuple[Key, str]:
        """Which object, in which part of the archive, and its transform."""
        path = next((value for key, value in attributes.items() if key.rpartition(" ")[2] == "path"), self._path)
        return (posixpath.join("/", path), attributes["objectid"]), attributes.get("transform", "")


class _Assembly:
    """Objects with their components in place; each is put together once."""

    def __init__(self, source: str, objects: dict[Key, Object]) -> None:
        self._source, self._objects = source, objects
        self._counts: dict[Key, int] = {}
        self._corners: dict[Key, Array] = {}

    def count(self, key: Key, depth: int) -> int:
        """Triangles of an object with all its components.

        Raises:
            MouldError: it is missing, too large, or nested too deep or in itself.
        """
        if key not in self._counts:
            if key not in self._objects:
                raise MouldError(f"{self._source} is damaged: it builds object '{key[1][:20]}', which is not in it")
            if depth > _DEEPEST:
                raise MouldError(f"{self._source} has components over {_DEEPEST} deep, or in themselves; join them")
            item = self._objects[key]
            total = len(item.triangles) // 3
            for other, _ in item.components:
                total += self.count(other, depth + 1)
                if total > MAX_FACES:
                    check_count(self._source, total)
            self._counts[key] = total
        return self._counts[key]

    def corners(self, key: Key) -> Array:
        """Triangles of an object with all its components in the file's unit, (F, 3, 3)."""
        if key not in self._corners:
            item = self._objects[key]
            parts = [self._own(item)] if item.triangles else []
            parts += [
                _moved(self._source, self.corners(other), transform)
                for other, transform in item.components
                if self._counts[other]
            ]
            self._corners[key] = np.concatenate(parts)
        return self._corners[key]

    def _own(self, item: Object) -> Array:
        """The triangles of the object's own mesh."""
        try:
            vertices = np.fromiter(map(float, item.vertices), np.float64, len(item.vertices)).reshape(-1, 3)
            index = np.fromiter(map(int, item.triangles), np.int64, len(item.triangles))
        except (ValueError, OverflowError):
            raise MouldError(f"{self._source} is damaged: it has a word for a number; save it again") from None
        return triangulated(self._source, vertices, index, np.full(len(index) // 3, 3))


def _moved(source: str, corners: Array, transform: str) -> Array:
    """Corners moved by ``m00 m01 m02 m10 … m32``: p' = p M + t, turned round where M mirrors."""
    if not transform:
        return corners
    try:
        matrix = np.array([float(word) for word in transform.split()[:13]]).reshape(4, 3)
    except ValueError:
        raise MouldError(f"{source} is damaged: a transform is not 12 numbers; save it again") from None
    if not np.all(np.abs(matrix) < 1e9):
        raise MouldError(f"{source} is damaged: a transform holds a number that no part needs; save it again")
    moved = corners @ matrix[:3] + matrix[3]
    return np.asarray(moved[:, ::-1] if np.linalg.det(matrix[:3]) < 0.0 else moved)
