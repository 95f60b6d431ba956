"""Reading STL files that may be anything: every file becomes triangles or one sentence that says why not.

An STL file is a heap of triangles without a unit and without a checksum. All that can be checked is
checked here, before anything is computed from it: the size before the file is read, the number of
triangles before they are parsed, the numbers before they are used.
"""

from __future__ import annotations

import re

import numpy as np

from burnish.core import Array
from burnish.errors import MouldError
from burnish.surface.polygons import check_count, check_finite

_HEADER = 84
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_CORNER = re.compile(rb"\bvertex\s+(\S+)\s+(\S+)\s+(\S+)")


def parse_stl(source: str, data: bytes) -> Array:
    """Corners of the triangles of a binary or ASCII STL file in its unit, (F, 3, 3).

    Raises:
        MouldError: it is not a whole STL file of finite numbers.
    """
    corners = _ascii(source, data) if _looks_ascii(data) else _binary(source, data)
    check_finite(source, corners)
    return corners


def _looks_ascii(data: bytes) -> bool:
    """Whether the text form is meant; many binary writers also begin their header with ``solid``."""
    return data[:512].lstrip()[:5].lower() == b"solid" and len(data) != _binary_size(data)


def _binary_size(data: bytes) -> int:
    """The file size that a binary header promises [bytes]."""
    return _HEADER + _RECORD.itemsize * int.from_bytes(data[80:_HEADER], "little")


def _binary(source: str, data: bytes) -> Array:
    """Corners in the file's unit, (F, 3, 3), once header and size agree."""
    if len(data) < _HEADER:
        raise MouldError(f"{source} is not an STL file: it has only {len(data)} bytes and does not begin with 'solid'")
    promised, size = int.from_bytes(data[80:_HEADER], "little"), _binary_size(data)
    if len(data) != size:
        reason = "it was cut off" if len(data) < size else "something follows the last triangle"
        raise MouldError(
            f"{source} is not an STL file, or {reason}: its header promises {promised} triangles, which take "
            f"{size} bytes, but it has {len(data)}; export it again"
        )
    check_count(source, promised)
    corners = np.frombuffer(data, dtype=_RECORD, offset=_HEADER)["corners"]
    with np.errstate(invalid="ignore"):  # A signalling NaN; it is refused with the other numbers that are not finite.
        return corners.astype(np.float64)


def _ascii(source: str, data: bytes) -> Array:
    """Corners in the file's unit, (F, 3, 3), once the text is complete."""
    text = data.lower()
    facets = text.count(b"endfacet")
    if b"endsolid" not in text:
        if b"facet" not in text:
            raise MouldError(
                f"{source} is not an STL file, or it was cut off: it begins with 'solid' but holds no triangle"
            )
        raise MouldError(f"{source} was cut off: it has {facets} whole triangles but no 'endsolid'; export it again")
    check_count(source, facets)
    words = (word for corner in _CORNER.finditer(text) for word in corner.groups())
    try:
        numbers = np.fromiter(map(float, words), np.float64)
    except ValueError:
        raise MouldError(f"{source} is damaged: one of its corners is not three numbers; export it again") from None
    if len(numbers) != 9 * facets:
        raise MouldError(
            f"{source} is damaged: it has {len(numbers) // 3} corners for {facets} triangles; export it again"
        )
    return numbers.reshape(facets, 3, 3)
