"""Coloured surfaces to look at, and the thin tubes that stand for lines."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from burnish.core import Array, read_only
from burnish.errors import InputError

CARBON = (0.29, 0.30, 0.325)
STEEL = (0.66, 0.68, 0.71)
FELT = (0.90, 0.84, 0.70)
PATH = (0.12, 0.45, 0.70)
TRACE = (0.90, 0.45, 0.10)
"""sRGB of an arm's links, of a mould, of a tool's tip, of a planned path and of the path that was moved."""

CREASE_DEG = 35.0
"""Faces that meet at a larger angle keep a sharp edge [°]."""
WELD = 1e-6
"""Corners closer than this are one point [m]; STL files repeat every point once a face."""


@dataclass(frozen=True, kw_only=True)
class Shape:
    """One surface in world coordinates, with its colour."""

    name: str
    """What it is, for a reader; shapes of one name are switched together."""
    vertices: Array
    """Points [m], (V, 3)."""
    faces: NDArray[np.int64]
    """Corners of the triangles, (F, 3), indices of ``vertices``."""
    colour: Array
    """sRGB in 0…1: one for all, (3,), or one a vertex, (V, 3)."""
    gloss: float = 0.25
    """Strength of the highlight, 0 (felt) to 1 (polished)."""

    def __post_init__(self) -> None:
        faces = np.array(self.faces, dtype=np.int64).reshape(-1, 3)
        faces.flags.writeable = False
        object.__setattr__(self, "faces", faces)
        object.__setattr__(self, "vertices", read_only(np.reshape(self.vertices, (-1, 3))))
        object.__setattr__(self, "colour", read_only(self.colour))
        points = len(self.vertices)
        if faces.size and (faces.min() < 0 or faces.max() >= points):
            raise InputError(f"Shape {self.name!r}: faces name vertices outside 0…{points - 1}; check the mesh")
        if not np.isfinite(self.vertices).all():
            raise InputError(f"Shape {self.name!r}: a vertex is not finite; check the mesh")
        if self.colour.shape not in ((3,), (points, 3)):
            raise InputError(
                f"Shape {self.name!r}: colour of shape {self.colour.shape}; expected (3,) or ({points}, 3)"
            )

    @property
    def corners(self) -> Array:
        """Positions of the corners of the faces [m], (F, 3, 3)."""
        return self.vertices[self.faces]

    @property
    def corner_colours(self) -> Array:
        """Colours (sRGB) at the corners of the faces, (F, 3, 3)."""
        return np.broadcast_to(self.colour, self.vertices.shape)[self.faces]

    @cached_property
    def corner_normals(self) -> Array:
        """Unit normals at the corners, (F, 3, 3): the mean of the neighbours that meet without a crease.

        Neighbours count with their area, found through the position of the corner, not through its index.
        """
        corners = self.corners
        area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        unit = _unit(area)
        _, welded = np.unique(np.round(self.vertices / WELD), axis=0, return_inverse=True)
        mine, theirs = _meetings(welded.ravel()[self.faces].ravel())
        smooth = np.einsum("nd,nd->n", unit[mine // 3], unit[theirs // 3]) >= np.cos(np.radians(CREASE_DEG))
        mine, near = mine[smooth], area[theirs[smooth] // 3]
        total = np.array([np.bincount(mine, near[:, axis], 3 * len(corners)) for axis in range(3)], np.float64).T
        return np.where(np.any(total, axis=1)[:, None], _unit(total), (0.0, 0.0, 1.0)).reshape(-1, 3, 3)


def tube(points: ArrayLike, radius: float, colour: ArrayLike, name: str, sides: int = 6) -> Shape:
    """A thin open tube along a line.

    Args:
        points: the line [m], (N, 3); points that repeat their predecessor are left out.
        radius: of the tube [m].
        colour: sRGB in 0…1, (3,).
        name: what it is.
        sides: edges of its cross-section.
    """
    line = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    if len(line):
        moved = np.linalg.norm(np.diff(line, axis=0), axis=1) > 1e-9
        line = line[np.concatenate([[True], moved])]
    if len(line) < 2:
        return Shape(name=name, vertices=np.zeros((0, 3)), faces=np.zeros((0, 3), int), colour=np.asarray(colour))
    first, second = _frames(_unit(np.asarray(np.gradient(line, axis=0))))
    angle = 2.0 * np.pi * np.arange(sides) / sides
    ring = np.cos(angle)[:, None] * first[:, None] + np.sin(angle)[:, None] * second[:, None]
    here, around = np.arange(len(line) - 1)[:, None] * sides, np.arange(sides)
    a, b = here + around, here + (around + 1) % sides
    faces = np.stack([a, b, b + sides, a, b + sides, a + sides], axis=-1).reshape(-1, 3)
    vertices = (line[:, None] + radius * ring).reshape(-1, 3)
    return Shape(name=name, vertices=vertices, faces=faces, colour=np.asarray(colour), gloss=0.1)


def thin(points: ArrayLike, tolerance: float) -> Array:
    """The line with fewer points, (≤ N, 3): a point is kept once the line has gone ``tolerance`` [m] further."""
    line = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    if len(line) < 3:
        return line
    gone = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    _, kept = np.unique(np.floor(gone / tolerance), return_index=True)
    return np.asarray(line[np.union1d(kept, [len(line) - 1])])


def _meetings(point: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """All pairs (mine, theirs) of corners at one point, each with itself too; ``point`` is that of each corner."""
    order = np.argsort(point, kind="stable")
    size = np.bincount(point)
    run = size[point[order]]
    start = (np.cumsum(size) - size)[point[order]]
    pair = np.arange(int(run.sum())) - np.repeat(np.cumsum(run) - run, run)
    return np.repeat(order, run), order[np.repeat(start, run) + pair]


def _frames(tangents: Array) -> tuple[Array, Array]:
    """Two unit vectors across each tangent that turn with the line, not around it, (N, 3) each."""
    first = np.empty_like(tangents)
    across = np.eye(3)[np.argmin(np.abs(tangents[0]))]
    for i, tangent in enumerate(tangents):
        across = across - (across @ tangent) * tangent
        length = float(np.sqrt(across @ across))
        if length < 1e-6:  # The line turned right into the old direction: start again.
            across = np.cross(tangent, np.eye(3)[np.argmin(np.abs(tangent))])
            length = float(np.sqrt(across @ across))
        across = first[i] = across / length
    return first, np.asarray(np.cross(tangents, first))


def _unit(vectors: Array) -> Array:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0.0, length, 1.0))
