"""Reading STL files that may be anything: every file becomes triangles or one sentence that says why not.

An STL file is a heap of triangles without a unit and without a checksum. All that can be checked is
checked here, before anything is computed from it: the size before the file is read, the number of
triangles before they are parsed, the numbers before they are used.
"""

from __future__ import annotations

import re
import stat
from pathlib import Path

import numpy as np

from burnish.core import Array
from burnish.errors import MouldError

METRES_PER_UNIT = {"mm": 1e-3, "m": 1.0, "inch": 25.4e-3}
"""What one unit of the file may be worth [m]; the file itself does not say."""

MAX_BYTES = 50 * 2**20
"""Largest file that is read [bytes]: 50 MiB hold a million binary triangles."""

MAX_FACES = 500_000
"""Most triangles that are accepted: finer than any surface that a 15 mm tip could tell apart."""

_HEADER = 84
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_CORNER = re.compile(rb"\bvertex\s+(\S+)\s+(\S+)\s+(\S+)")


def read_stl(path: Path, unit: str = "mm") -> Array:
    """The triangles of a binary or ASCII STL file.

    Args:
        path: the file.
        unit: what one unit of the file is, ``mm``, ``m`` or ``inch``.

    Returns:
        Corners [m], in the file's axes, (F, 3, 3).

    Raises:
        MouldError: the file cannot be read, or it is not a whole STL file of finite numbers.
    """
    if unit not in METRES_PER_UNIT:
        raise MouldError(f"the unit '{unit}' is not known; expected one of {', '.join(METRES_PER_UNIT)}")
    data = _bytes(path)
    corners = _ascii(path, data) if _looks_ascii(data) else _binary(path, data)
    if not np.isfinite(corners).all():
        bad = int(np.count_nonzero(~np.isfinite(corners).all(axis=(1, 2))))
        raise MouldError(
            f"{path}: {bad} of {len(corners)} triangles have a corner that is not a finite number; export it again"
        )
    return corners * METRES_PER_UNIT[unit]


def _bytes(path: Path) -> bytes:
    """The content of a regular, readable file of an acceptable size."""
    try:
        status = path.stat()
        if stat.S_ISDIR(status.st_mode):
            raise MouldError(f"{path} is a directory; expected an STL file: name the file inside it")
        if not stat.S_ISREG(status.st_mode):
            raise MouldError(f"{path} is not a regular file; expected an STL file")
        if status.st_size == 0:
            raise MouldError(f"{path} is empty; expected an STL file: export it again")
        if status.st_size > MAX_BYTES:
            raise MouldError(
                f"{path} has {status.st_size / 2**20:.0f} MiB; at most {MAX_BYTES // 2**20} MiB are read: "
                "reduce the number of triangles, or save it as binary STL"
            )
        with path.open("rb") as file:
            return file.read(MAX_BYTES)
    except FileNotFoundError:
        raise MouldError(f"{path} does not exist; expected an STL file: check the name") from None
    except PermissionError:
        raise MouldError(f"{path} may not be read; allow this user to read it") from None
    except (OSError, ValueError) as error:  # ValueError: a name with a null character
        raise MouldError(f"{str(path)!r} cannot be read ({error}); expected an STL file") from None


def _looks_ascii(data: bytes) -> bool:
    """Whether the text form is meant; many binary writers also begin their header with ``solid``."""
    return data[:512].lstrip()[:5].lower() == b"solid" and len(data) != _binary_size(data)


def _binary_size(data: bytes) -> int:
    """The file size that a binary header promises [bytes]."""
    return _HEADER + _RECORD.itemsize * int.from_bytes(data[80:_HEADER], "little")


def _binary(path: Path, data: bytes) -> Array:
    """Corners in the file's unit, (F, 3, 3), once header and size agree."""
    if len(data) < _HEADER:
        raise MouldError(f"{path} is not an STL file: it has only {len(data)} bytes and does not begin with 'solid'")
    promised, size = int.from_bytes(data[80:_HEADER], "little"), _binary_size(data)
    if len(data) != size:
        reason = "it was cut off" if len(data) < size else "something follows the last triangle"
        raise MouldError(
            f"{path} is not an STL file, or {reason}: its header promises {promised} triangles, which take "
            f"{size} bytes, but it has {len(data)}; export it again"
        )
    _check_count(path, promised)
    corners = np.frombuffer(data, dtype=_RECORD, offset=_HEADER)["corners"]
    with np.errstate(invalid="ignore"):  # A signalling NaN; it is refused with the other numbers that are not finite.
        return corners.astype(np.float64)


def _ascii(path: Path, data: bytes) -> Array:
    """Corners in the file's unit, (F, 3, 3), once the text is complete."""
    text = data.lower()
    facets = text.count(b"endfacet")
    if b"endsolid" not in text:
        if b"facet" not in text:
            raise MouldError(
                f"{path} is not an STL file, or it was cut off: it begins with 'solid' but holds no triangle"
            )
        raise MouldError(f"{path} was cut off: it has {facets} whole triangles but no 'endsolid'; export it again")
    _check_count(path, facets)
    words = (word for corner in _CORNER.finditer(text) for word in corner.groups())
    try:
        numbers = np.fromiter(map(float, words), np.float64)
    except ValueError:
        raise MouldError(f"{path} is damaged: one of its corners is not three numbers; export it again") from None
    if len(numbers) != 9 * facets:
        raise MouldError(
            f"{path} is damaged: it has {len(numbers) // 3} corners for {facets} triangles; export it again"
        )
    return numbers.reshape(facets, 3, 3)


def _check_count(path: Path, faces: int) -> None:
    """A number of triangles that is worth parsing."""
    if faces == 0:
        raise MouldError(f"{path} has no triangles; expected a surface: export it again")
    if faces > MAX_FACES:
        raise MouldError(
            f"{path} has {faces} triangles; at most {MAX_FACES} are read: export it with a coarser tolerance"
        )
