"""The part to be worked, as a triangle surface in its own frame.

Mould frame: the origin lies under the centre of the bounding box in x and y, z points up and is 0 at the
lowest point, so that the mould stands on its plane z = 0; the side to be worked faces +z.
"""

from __future__ import annotations

import hashlib
import logging
import os
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

import numpy as np
from typing_extensions import Self

from burnish.core import Array, read_only
from burnish.errors import MouldError
from burnish.surface import bundled
from burnish.surface.files import KINDS, read_mesh
from burnish.surface.repair import check_joined, closed, stitched, welded, without_doubles, without_thin
from burnish.surface.shells import seen_from_above
from burnish.surface.units import LARGEST_SIDE, SMALLEST_SIDE, fits, size_in_mm
from burnish.surface.winding import Faces, face_vectors, merged, oriented

_LOG = logging.getLogger(__name__)

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
    warnings: tuple[str, ...] = ()
    """What was assumed about the file and what was mended in it, a sentence each; also logged."""

    @classmethod
    def load(cls, name_or_path: str, unit: str | None = None) -> Self:
        """A bundled mould (``plate dome wave mould``), or else an STL, OBJ, PLY or 3MF file.

        Args:
            name_or_path: a bundled name wins over a file of that name; write ``./dome`` for the file.
            unit: what one unit of the file is: ``mm``, ``m`` or ``inch``; None to find out from its size. Bundled
                moulds ignore it, and 3MF files name their own.

        Raises:
            MouldError: the file cannot be read, is no surface that can be worked from above, or leaves open what is
                to be worked or in which unit.
        """
        if name_or_path in bundled.SURFACES:
            return cls.of(name_or_path, bundled.SURFACES[name_or_path]())
        if name_or_path == bundled.FREE_FORM:
            asset = resources.files("burnish") / "assets" / "moulds" / "mould.stl"
            with resources.as_file(asset) as path:
                return cls.of(name_or_path, read_mesh(path, "mm")[0])
        path = Path(name_or_path)
        if os.sep not in name_or_path and not path.suffix and not os.path.exists(name_or_path):
            raise MouldError(
                f"there is no mould '{name_or_path}'; expected {', '.join(bundled.NAMES)}, or the path of {KINDS}"
            )
        corners, assumed = read_mesh(path, unit)
        return cls.of(path.stem, corners, source=str(path), assumed=assumed)

    @classmethod
    def of(cls, name: str, corners: Array, source: str | None = None, assumed: tuple[str, ...] = ()) -> Self:
        """A mould from loose triangles (F, 3, 3) [m] in axes with z up, moved into the mould frame.

        Args:
            name: how the mould is called.
            corners: finite triangle corners [m], (F, 3, 3).
            source: what a message calls it; the name if None.
            assumed: sentences that come before those of the repair.

        Raises:
            MouldError: its size is out of range, it has no area, only one side, or nothing that faces up; or it is
                broken in a way that leaves open what its surface is.
        """
        source = source or name
        _check_size(source, corners)
        low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        origin = np.array([(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0, low[2]])
        vertices, faces = merged(corners - origin)
        if not len(faces) or np.linalg.norm(face_vectors(vertices, faces), axis=1).sum() < 2.0 * _least_area(corners):
            raise MouldError(f"{source} has no area: its {len(corners)} triangles are lines or points; export it again")
        vertices, faces, mended = _mended(source, vertices, faces)
        if np.clip(face_vectors(vertices, faces)[:, 2], 0.0, None).sum() < 2.0 * _least_area(corners):
            raise MouldError(
                f"{source} has nothing that faces up (+z); expected a surface to work from above: turn the part over, "
                "or flip the normals of the surface"
            )
        faces, seen = seen_from_above(source, vertices, faces)
        warnings = (*assumed, *mended, *seen)
        if warnings:  # Else not a bit has changed, nor the fingerprint.
            used, faces = np.unique(faces, return_inverse=True)
            vertices, faces = vertices[used], faces.reshape(-1, 3)
        for warning in warnings:
            _LOG.warning("%s: %s", source, warning)
        vertices = read_only(vertices)
        faces.flags.writeable = False
        return cls(name=name, vertices=vertices, faces=faces, sha256=_fingerprint(vertices, faces), warnings=warnings)


def _mended(source: str, vertices: Array, faces: Faces) -> tuple[Array, Faces, tuple[str, ...]]:
    """A mesh without the small faults of :mod:`repair`, whose neighbours agree, and what was done to it."""
    faces, joined = welded(source, vertices, faces)
    check_joined(source, faces)
    faces, thin = without_thin(vertices, faces)
    faces, doubled = without_doubles(faces)
    faces, seams = stitched(source, vertices, faces)
    faces, turned = oriented(source, vertices, faces)
    vertices, faces, openings = closed(vertices, faces)
    return vertices, faces, (*joined, *thin, *doubled, *seams, *turned, *openings)


def _least_area(corners: Array) -> float:
    """Area below which a surface is none [m²]: a millionth of its bounding square."""
    return 1e-6 * float(np.ptp(corners, axis=(0, 1)).max()) ** 2


def _check_size(source: str, corners: Array) -> None:
    """A bounding box that an arm's workspace can hold."""
    sides = np.ptp(corners, axis=(0, 1))
    if not fits(sides):
        raise MouldError(
            f"{source} measures {size_in_mm(sides)} mm; expected at least {1e3 * SMALLEST_SIDE:.0f} mm in x or y and "
            f"at most {1e3 * LARGEST_SIDE:.0f} mm anywhere: check the unit of the file (mm, m or inch) and its axes"
        )


def _fingerprint(vertices: Array, faces: Faces) -> str:
    """SHA-256 over the vertices in nanometres and the faces, both as little-endian integers."""
    grains = np.rint(vertices / _HASH_GRAIN).astype("<i8")
    return hashlib.sha256(grains.tobytes() + faces.astype("<i8").tobytes()).hexdigest()
