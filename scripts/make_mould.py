"""Writes the bundled free-form mould, 120 × 80 mm: a pocket, a fillet, a hole and edges, as a binary STL.

The mesh is a rectangular grid with two blocks cut out, one for the pocket and one for the hole. Each block
is filled by rings whose points run from its border to the shape inside it, so every edge of the part is a
row of mesh edges, and the file comes out the same on every run.

    python scripts/make_mould.py [FILE.stl]
"""

from __future__ import annotations

import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from burnish.surface.bundled import quads, skirt

Array = NDArray[np.float64]

ASSET = Path(__file__).parents[1] / "src" / "burnish" / "assets" / "moulds" / "mould.stl"

# All lengths in this file are millimetres, the unit of the STL file.
CELL = 1.25
HALF_X, HALF_Y = 60.0, 40.0
HEIGHT, RELIEF = 22.0, 2.5
FILLET, FILLET_STEPS = 10.0, 18
"""Radius of the rounded edge along y = −40, and facets of its quarter circle: 5° each."""
POCKET_CENTRE, POCKET_HALF, POCKET_CORNER = (-21.875, 5.0), (24.0, 17.0), 10.0
POCKET_DEPTH, POCKET_FILLET, POCKET_WALL = 3.0, 2.0, np.radians(60.0)
"""Depth, radius between floor and wall, and slope of the wall; the rim of the pocket is sharp."""
HOLE_CENTRE, HOLE_RADIUS = (35.0, 12.5), 7.0
GRAIN = 1e-4
"""Coordinates are rounded to 0.1 µm, so that the last bit of a cosine cannot change the file."""


def free_form(x: Array, y: Array) -> Array:
    """Height of the surface without pocket and hole, for y above the fillet."""
    return np.asarray(HEIGHT + RELIEF * np.cos(2.0 * np.pi * x / 110.0) * np.cos(2.0 * np.pi * y / 130.0))


def lift(xy: Array, drop: Array | float = 0.0) -> Array:
    """Points (…, 2) in plan, raised to the surface less a drop, (…, 3)."""
    return np.concatenate((xy, (free_form(xy[..., 0], xy[..., 1]) - drop)[..., None]), axis=-1)


def grid() -> tuple[Array, Array, Array]:
    """Points of the rectangular grid (nx, ny, 3) with the fillet along its first rows, and its lines."""
    x = np.linspace(-HALF_X, HALF_X, round(2.0 * HALF_X / CELL) + 1)
    angle = np.linspace(np.pi / 2.0, 0.0, FILLET_STEPS + 1)[:-1]
    start = FILLET - HALF_Y
    flat = np.linspace(start, HALF_Y, round((HALF_Y - start) / CELL) + 1)
    y = np.concatenate((start - FILLET * np.sin(angle), flat))
    drop = np.concatenate((FILLET * (1.0 - np.cos(angle)), np.zeros(len(flat))))
    return lift(np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1), drop), x, y


def block(x: Array, y: Array, centre: tuple[float, float], half: tuple[float, float]) -> tuple[slice, slice]:
    """The grid lines of a block in plan."""
    lines = []
    for line, middle, reach in zip((x, y), centre, half, strict=True):
        first, last = np.searchsorted(line, (middle - reach - 1e-9, middle + reach - 1e-9))
        lines.append(slice(int(first), int(last) + 1))
    return lines[0], lines[1]


def ring_of(points: Array) -> Array:
    """The border of a rectangular grid of points, counter-clockwise, each corner once."""
    return np.concatenate((points[:-1, 0], points[-1, :-1], points[:0:-1, -1], points[0, :0:-1]))


def rounded(cells: tuple[int, int], half: tuple[float, float], corner: float) -> Array:
    """A rounded rectangle around 0 with as many points as the border of a grid of cells, (N, 2).

    It begins and runs like ``ring_of``; each side, from the middle of one corner to the next, is divided
    evenly.
    """
    sides = []
    for side in range(4):
        along, out = half if side % 2 == 0 else half[::-1]
        arc, straight = np.pi / 4.0 * corner, 2.0 * (along - corner)
        s = np.arange(cells[side % 2]) / cells[side % 2] * (2.0 * arc + straight)
        turn = (np.maximum(s - arc - straight, 0.0) - np.maximum(arc - s, 0.0)) / corner
        forward = np.clip(s - arc, 0.0, straight) - straight / 2.0 + corner * np.sin(turn)
        outward = out - corner + corner * np.cos(turn)
        direction = np.array([(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)])
        sides.append(forward[:, None] * direction[side] + outward[:, None] * direction[side - 1])
    return np.concatenate(sides)


def between(first: Array, last: Array, steps: int) -> list[Array]:
    """Rings that lead from one ring (N, 2) to another, with the last and without the first."""
    return [*(first + (last - first) * k / steps for k in range(1, steps)), last]


def strips(rings: list[Array]) -> list[Array]:
    """Triangles between successive rings (N, 3), each inside the one before."""
    return [quads(b, a, np.roll(a, -1, axis=0), np.roll(b, -1, axis=0)) for a, b in pairwise(rings)]


def pocket(border: Array, cells: tuple[int, int]) -> list[Array]:
    """Triangles of the block around the pocket, inside its border (N, 3)."""

    def contour(inset: float) -> Array:
        half = (POCKET_HALF[0] - inset, POCKET_HALF[1] - inset)
        return rounded(cells, half, POCKET_CORNER - inset) + POCKET_CENTRE

    angle = np.linspace(POCKET_WALL, 0.0, 7)
    curve = POCKET_FILLET * (1.0 - np.cos(angle))
    wall = (POCKET_DEPTH - curve[0]) / np.tan(POCKET_WALL)
    inset = np.concatenate(([wall / 2.0], wall + POCKET_FILLET * (np.sin(POCKET_WALL) - np.sin(angle))))
    drop = np.concatenate(([(POCKET_DEPTH - curve[0]) / 2.0], POCKET_DEPTH - curve))
    lines = [np.linspace(-half / 2.0, half / 2.0, count + 1) for half, count in zip(POCKET_HALF, cells, strict=True)]
    core = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1) + POCKET_CENTRE
    rings = [border, *(lift(xy) for xy in between(border[:, :2], contour(0.0), 3))]
    rings += [lift(contour(i), d) for i, d in zip(inset, drop, strict=True)]
    rings += [lift(xy, POCKET_DEPTH) for xy in between(contour(inset[-1]), ring_of(core), 5)]
    floor = lift(core, POCKET_DEPTH)
    return [*strips(rings), quads(floor[:-1, :-1], floor[1:, :-1], floor[1:, 1:], floor[:-1, 1:])]


def annulus(outer: Array, inner: Array, centre: tuple[float, float]) -> Array:
    """Triangles that face down between two rings (N, 3) and (M, 3) that are star-shaped about a centre."""

    def angles(ring: Array) -> Array:
        return np.unwrap(np.arctan2(ring[:, 1] - centre[1], ring[:, 0] - centre[0]))

    first = int(np.argmin(np.abs(angles(inner) - angles(outer)[0])))
    inner = np.roll(inner, -first, axis=0)
    outer, inner = np.concatenate((outer, outer[:1])), np.concatenate((inner, inner[:1]))
    alpha, beta = angles(outer), angles(inner)
    i = j = 0
    triangles = []
    while i + 1 < len(outer) or j + 1 < len(inner):
        if j + 1 == len(inner) or (i + 1 < len(outer) and alpha[i + 1] <= beta[j + 1]):
            triangles.append((outer[i], inner[j], outer[i + 1]))
            i += 1
        else:
            triangles.append((outer[i], inner[j], inner[j + 1]))
            j += 1
    return np.array(triangles)


def mould() -> Array:
    """Triangle corners of the whole part, outward [mm], (F, 3, 3)."""
    top, x, y = grid()
    cells = np.stack((top[:-1, :-1], top[1:, :-1], top[1:, 1:], top[:-1, 1:]))
    keep = np.ones(cells.shape[1:3], dtype=bool)
    pieces = []
    for centre, half in ((POCKET_CENTRE, (28.125, 20.0)), (HOLE_CENTRE, (12.5, 12.5))):
        part = block(x, y, centre, half)
        keep[part[0].start : part[0].stop - 1, part[1].start : part[1].stop - 1] = False
        border = ring_of(top[part])
        count = (part[0].stop - part[0].start - 1, part[1].stop - part[1].start - 1)
        if centre == POCKET_CENTRE:
            pieces += pocket(border, count)
        else:
            circle = rounded(count, (HOLE_RADIUS, HOLE_RADIUS), HOLE_RADIUS) + HOLE_CENTRE
            pieces += strips([border, *(lift(xy) for xy in between(border[:, :2], circle, 6))])
            edge = lift(circle)
    pieces.append(quads(*(corner[keep] for corner in cells)))
    rim = ring_of(top)
    pieces += [skirt(rim), skirt(edge[::-1]), annulus(rim * [1.0, 1.0, 0.0], edge * [1.0, 1.0, 0.0], HOLE_CENTRE)]
    return np.concatenate(pieces)


def write_stl(path: Path, corners: Array) -> None:
    """Write a binary STL; its normals are left 0, which readers take as not given."""
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    data = np.zeros(len(corners), dtype=record)
    data["corners"] = np.rint(corners / GRAIN) * GRAIN
    header = b"burnish free-form mould, mm".ljust(80)
    path.write_bytes(header + len(corners).to_bytes(4, "little") + data.tobytes())


if __name__ == "__main__":
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else ASSET
    target.parent.mkdir(parents=True, exist_ok=True)
    write_stl(target, mould())
