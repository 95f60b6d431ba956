"""Reading Wavefront OBJ files: the lines ``v`` and ``f``, and nothing else of them."""

from __future__ import annotations

import re

import numpy as np

from burnish.core import Array
from burnish.errors import MouldError
from burnish.surface.polygons import MAX_FACES, triangulated

_LINE = re.compile(rb"^[ \t]*([vf])[ \t]([^\r\n#]*)", re.MULTILINE)
_BESIDE = re.compile(rb"/\S*")


def parse_obj(source: str, data: bytes) -> Array:
    """Corners of the triangles in the file's unit, (F, 3, 3).

    Textures, normals, groups and materials are passed over; no other file is opened.

    Raises:
        MouldError: it is no OBJ file, or a line of it is damaged.
    """
    numbers: list[bytes] = []
    names: list[bytes] = []
    count: list[int] = []
    relative: list[int] = []
    for found in _LINE.finditer(data.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ")):
        if found[1] == b"v":
            place = found[2].split(None, 3)[:3]
            if len(place) < 3:
                raise MouldError(f"{source} is damaged: a vertex has {len(place)} numbers; export it again")
            numbers += place
        else:
            corners = _BESIDE.sub(b"", found[2]).split()
            names += corners
            count.append(len(corners))
            relative.append(len(numbers) // 3)
    if not numbers or not count:
        raise MouldError(f"{source} is not an OBJ file, or it has no triangles: no lines 'v' and 'f' were found")
    if len(count) > MAX_FACES:
        raise MouldError(
            f"{source} has {len(count)} polygons; at most {MAX_FACES} are read: export it with a coarser tolerance"
        )
    try:
        vertices = np.fromiter(map(float, numbers), np.float64, len(numbers)).reshape(-1, 3)
        named = np.fromiter(map(int, names), np.int64, len(names))
    except (ValueError, OverflowError):
        raise MouldError(f"{source} is damaged: a line 'v' or 'f' has a word for a number; export it again") from None
    counted = np.array(count)
    # Numbers begin with 1; negative ones count back from the last vertex before the line.
    index = np.where(named > 0, named - 1, np.repeat(relative, counted) + named)
    if np.any(named == 0):
        raise MouldError(
            f"{source} is damaged: a triangle names the corner 0; expected numbers from 1: export it again"
        )
    return triangulated(source, vertices, index, counted)
