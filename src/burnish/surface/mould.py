"""The part to be worked, as a triangle surface in its own frame.

Mould frame: the origin lies under the centre of the bounding box in x and y, z points up and is 0 at the
lowest point, so that the mould stands on its plane z = 0; the side to be worked faces +z.
"""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

import numpy as np
from typing_extensions import Self

from burnish.core import Array, read_only
from burnish.errors import MouldError
from burnish.surface import bundled
from burnish.surface.stl import read_stl
from burnish.surface.winding import Faces, face_vectors, merged, oriented

SMALLEST_SIDE = 10e-3
"""Least length of the longer horizontal side [m]: below, a 15 mm tip has nothing to work on."""

LARGEST_SIDE = 1.0
"""Greatest length of any side [m]: beyond the reach of the arms that this is for."""

_HASH_GRAIN = 1e-9
"""Coordinates are hashed in whole nanometres, so that a last bit of rounding is no other mould [m]."""


@dataclass(frozen=True, kw_only=True)
class Mould:
    """A surface of triangles that can be worked from above; see the module for its frame."""

    name: str
    """Bundled name, or the file's name without folder and ending."""
    vertices: Array
    """Corners [m], (V, 3)."""
    faces: Faces
    """Vertex numbers of each triangle, counter-clockwise seen from outside, (F, 3)."""
    sha256: str
    """Fingerprint of the geometry, of vertices and faces in the mould frame."""

    @classmethod
    def load(cls, name_or_path: str, unit: str = "mm") -> Self:
        """A bundled mould (``plate dome wave mould``), or else an STL file.

        Args:
            name_or_path: a bundled name wins over a file of that name; write ``./dome`` for the file.
            unit: what one unit of the file is: ``mm``, ``m`` or ``inch``. Bundled moulds ignore it.

        Raises:
            MouldError: the file cannot be read, or is no surface that can be worked from above.
        """
        if name_or_path in bundled.SURFACES:
            return cls.of(name_or_path, bundled.SURFACES[name_or_path]())
        if name_or_path == bundled.FREE_FORM:
            asset = resources.files("burnish") / "assets" / "moulds" / "mould.stl"
            with resources.as_file(asset) as path:
                return cls.of(name_or_path, read_stl(path, "mm"))
        path = Path(name_or_path)
        if os.sep not in name_or_path and not path.suffix and not os.path.exists(name_or_path):
            raise MouldError(
                f"there is no mould '{name_or_path}'; expected {', '.join(bundled.NAMES)}, or the path of an STL file"
            )
        return cls.of(path.stem, read_stl(path, unit), source=str(path))

    @classmethod
    def of(cls, name: str, corners: Array, source: str | None = None) -> Self:
        """A mould from loose triangles (F, 3, 3) [m] in axes with z up, moved into the mould frame.

        Args:
            name: how the mould is called.
            corners: finite triangle corners [m], (F, 3, 3).
            source: what a message calls it; the name if None.

        Raises:
            MouldError: its size is out of range, it has no area, only one side, or nothing that faces up.
        """
        source = source or name
        _check_size(source, corners)
        low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        origin = np.array([(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0, low[2]])
        vertices, faces = merged(corners - origin)
        if not len(faces) or np.linalg.norm(face_vectors(vertices, faces), axis=1).sum() < 2.0 * _least_area(corners):
            raise MouldError(f"{source} has no area: its {len(corners)} triangles are lines or points; export it again")
        faces = oriented(source, vertices, faces)
        if np.clip(face_vectors(vertices, faces)[:, 2], 0.0, None).sum() < 2.0 * _least_area(corners):
            raise MouldError(
                f"{source} has nothing that faces up (+z); expected a surface to work from above: turn the part over, "
                "or flip the normals of the surface"
            )
        vertices = read_only(vertices)
        faces.flags.writeable = False
        return cls(name=name, vertices=vertices, faces=faces, sha256=_fingerprint(vertices, faces))


def _least_area(corners: Array) -> float:
    """Area below which a surface is none [m²]: a millionth of its bounding square."""
    return 1e-6 * float(np.ptp(corners, axis=(0, 1)).max()) ** 2


def _check_size(source: str, corners: Array) -> None:
    """A bounding box that an arm's workspace can hold."""
    sides = np.ptp(corners, axis=(0, 1))
    if sides.max() > LARGEST_SIDE or sides[:2].max() < SMALLEST_SIDE:
        found = " × ".join(f"{1e3 * side:.6g}" for side in sides)
        raise MouldError(
            f"{source} measures {found} mm; expected at least {1e3 * SMALLEST_SIDE:.0f} mm in x or y and at most "
            f"{1e3 * LARGEST_SIDE:.0f} mm anywhere: check the unit of the file (mm, m or inch) and its axes"
        )


def _fingerprint(vertices: Array, faces: Faces) -> str:
    """SHA-256 over the vertices in nanometres and the faces, both as little-endian integers."""
    grains = np.rint(vertices / _HASH_GRAIN).astype("<i8")
    return hashlib.sha256(grains.tobytes() + faces.astype("<i8").tobytes()).hexdigest()
