"""Sound meshes spoilt in the ways in which files arrive spoilt, and files of them.

Each spoiler takes loose triangles in metres, (F, 3, 3), and gives back others; what it does to the surface is said in
its name. Units, cuts and numbers that are none are faults of the file.
"""

from __future__ import annotations

import io
import struct
import zipfile
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from burnish.core import Array
from burnish.surface.bundled import block
from burnish.surface.winding import merged

Rng = np.random.Generator
Spoiler = Callable[[Array, Rng], Array]


def stl(corners: Array) -> bytes:
    """A binary STL with these numbers."""
    record = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    record["corners"] = corners
    return bytes(80) + struct.pack("<I", len(corners)) + record.tobytes()


def obj(corners: Array) -> bytes:
    """An OBJ of shared vertices."""
    vertices, faces = merged(corners)
    lines = [f"v {x:.7g} {y:.7g} {z:.7g}" for x, y, z in vertices]
    return "\n".join([*lines, *(f"f {a} {b} {c}" for a, b, c in faces + 1), ""]).encode()


def ply(corners: Array) -> bytes:
    """A little-endian PLY of shared vertices."""
    vertices, faces = merged(corners)
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\nproperty float x\nproperty float y\n"
        f"property float z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = np.zeros(len(faces), dtype=[("n", "u1"), ("v", "<i4", 3)])
    rows["n"], rows["v"] = 3, faces
    return head.encode() + vertices.astype("<f4").tobytes() + rows.tobytes()


def threemf(corners: Array, unit: str = "millimeter") -> bytes:
    """A 3MF of shared vertices."""
    vertices, faces = merged(corners)
    nodes = "".join(f'<vertex x="{x:.7g}" y="{y:.7g}" z="{z:.7g}"/>' for x, y, z in vertices)
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in faces)
    model = (
        f'<?xml version="1.0"?><model unit="{unit}" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">'
        f'<resources><object id="1"><mesh><vertices>{nodes}</vertices><triangles>{triangles}</triangles></mesh>'
        '</object></resources><build><item objectid="1"/></build></model>'
    )
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("3D/3dmodel.model", model)
    return packed.getvalue()


def in_mm(form: Callable[[Array], bytes]) -> Callable[[Array], bytes]:
    """Write millimetres."""
    return lambda corners: form(1e3 * corners)


def stl_in_mm(corners: Array) -> bytes:
    """A binary STL in millimetres."""
    return stl(1e3 * corners)


def sound(corners: Array, rng: Rng) -> Array:
    """Nothing wrong."""
    return corners


def unmerged(corners: Array, rng: Rng) -> Array:
    """Every triangle on its own, its corners off by up to a micrometre."""
    return corners[rng.permutation(len(corners))] + rng.uniform(-0.5e-6, 0.5e-6, corners.shape)


def apart(corners: Array, rng: Rng) -> Array:
    """Every triangle on its own, its corners off by up to 20 µm: a heap that no tolerance joins."""
    return corners + rng.uniform(-20e-6, 20e-6, corners.shape)


def inward(corners: Array, rng: Rng) -> Array:
    """Everything inside out."""
    return corners[:, ::-1]


def half_flipped(corners: Array, rng: Rng) -> Array:
    """Every other triangle turned round, by chance."""
    return np.where(rng.random(len(corners))[:, None, None] < 0.5, corners[:, ::-1], corners)


def patch_flipped(corners: Array, rng: Rng) -> Array:
    """A region of the surface turned round."""
    middle = corners.mean(axis=1)
    return np.where((middle[:, 0] > 0.01)[:, None, None], corners[:, ::-1], corners)


def doubled(corners: Array, rng: Rng) -> Array:
    """A tenth of the triangles twice."""
    return np.concatenate((corners, corners[rng.random(len(corners)) < 0.1]))


def both_sides(corners: Array, rng: Rng) -> Array:
    """Every triangle once from each side."""
    return np.concatenate((corners, corners[:, ::-1]))


def zero_area(corners: Array, rng: Rng) -> Array:
    """Triangles that are lines, laid along edges."""
    some = corners[rng.random(len(corners)) < 0.05]
    lines = np.stack((some[:, 0], some[:, 1], (some[:, 0] + some[:, 1]) / 2.0), axis=1)
    points = np.repeat(some[:100, :1], 3, axis=1)
    return np.concatenate((corners, lines, points))


def slivers(width: float) -> Spoiler:
    """A sliver of this width along an edge of a fifth of the triangles."""

    def spoil(corners: Array, rng: Rng) -> Array:
        chosen = rng.random(len(corners)) < 0.2
        a, b, c = np.moveaxis(corners[chosen], 1, 0)
        height = np.linalg.norm(np.cross(b - a, c - a), axis=1) / np.linalg.norm(b - a, axis=1)
        middle = (a + b) / 2.0
        p = middle + np.minimum(width / height, 0.5)[:, None] * (c - middle)
        pieces = [np.stack(three, axis=1) for three in ((a, b, p), (b, c, p), (c, a, p))]
        return np.concatenate((corners[~chosen], *pieces))

    return spoil


def seams(corners: Array, rng: Rng) -> Array:
    """A tenth of the triangles cut in two, their neighbours not."""
    chosen = rng.random(len(corners)) < 0.1
    a, b, c = np.moveaxis(corners[chosen], 1, 0)
    p = (a + b) / 2.0
    return np.concatenate((corners[~chosen], np.stack((a, p, c), axis=1), np.stack((p, b, c), axis=1)))


def pin_holes(corners: Array, rng: Rng) -> Array:
    """One triangle in five hundred is missing."""
    return corners[rng.random(len(corners)) > 0.002]


def hole(corners: Array, rng: Rng) -> Array:
    """Everything within 6 mm of a place on top is missing."""
    middle = corners.mean(axis=1)
    there = (np.linalg.norm(middle[:, :2] - [0.015, 0.01], axis=1) < 6e-3) & (middle[:, 2] > 5e-3)
    return np.asarray(corners[~there])


def without_base(corners: Array, rng: Rng) -> Array:
    """The bottom is missing."""
    return np.asarray(corners[corners[:, :, 2].max(axis=1) > corners[:, :, 2].min() + 1e-6])


def _box(x: Array, y: Array, low: float, high: float) -> Array:
    """A closed box."""
    middle = np.array([x.mean(), y.mean(), low])
    return np.asarray(block(x - middle[0], y - middle[1], lambda u, v: np.full_like(u, high - low)) + middle)


def _beside(corners: Array, gap: float) -> Array:
    """A box of 30 × 30 mm beside the part, 10 mm high."""
    edge = corners[:, :, 0].max() + gap
    return _box(np.array([edge, edge + 0.03]), np.array([-0.015, 0.015]), 0.0, 0.01)


def beside(corners: Array, rng: Rng) -> Array:
    """A second part 10 mm beside the first."""
    return np.concatenate((corners, _beside(corners, 10e-3)))


def leaning(corners: Array, rng: Rng) -> Array:
    """A second part that touches the first with a side."""
    return np.concatenate((corners, _beside(corners, 0.0)))


def crossing(corners: Array, rng: Rng) -> Array:
    """A box inside the part that comes out at its side."""
    return np.concatenate((corners, _beside(corners, -10e-3) * [1.0, 1.0, 0.5]))


def inverted_piece(corners: Array, rng: Rng) -> Array:
    """A second part beside the first, inside out."""
    return np.concatenate((corners, _beside(corners, 10e-3)[:, ::-1]))


def floating(corners: Array, rng: Rng) -> Array:
    """A plate 5 mm above the part."""
    top = corners[:, :, 2].max() + 5e-3
    return np.concatenate((corners, _box(np.array([-0.02, 0.02]), np.array([-0.02, 0.02]), top, top + 2e-3)))


def _upper(corners: Array) -> Array:
    """The triangles that face up."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(corners[normal[:, 2] > 0.2 * np.linalg.norm(normal, axis=1)])


def sheet(corners: Array, rng: Rng) -> Array:
    """The upper surface alone."""
    return _upper(corners)


def sheet_down(corners: Array, rng: Rng) -> Array:
    """The upper surface alone, facing down."""
    return _upper(corners)[:, ::-1]


def two_sheets(corners: Array, rng: Rng) -> Array:
    """The upper surface, and another one half a millimetre over it."""
    return np.concatenate((_upper(corners), _upper(corners) + [0.0, 0.0, 0.5e-3]))


def in_two_colours(corners: Array, rng: Rng) -> Array:
    """The upper surface as two sheets, one of which faces down; they meet within 5 µm."""
    top = _upper(corners)
    left = top[:, :, 0].mean(axis=1) < 0.01
    return np.concatenate((top[left], top[~left][:, ::-1] + [5e-6, 0.0, 0.0]))


def twisted(corners: Array, rng: Rng) -> Array:
    """A lid over the part whose far half is wound through itself."""
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    across = np.linspace(-1.0, 1.0, 41)
    x = np.linspace(low[0], high[0], 41)
    y = np.cos(np.linspace(0.0, np.pi, 41))[:, None] * high[1] * np.ones(41)
    grid = np.stack((x[:, None] * np.ones(41), y * across[None, :], np.full((41, 41), high[2] + 0.01)), axis=-1)
    grid[:, :, 2] += 2e-3 * np.linspace(0.0, 1.0, 41)[:, None] * across[None, :]
    a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    return np.concatenate((np.stack((a, b, c), axis=-2), np.stack((a, c, d), axis=-2))).reshape(-1, 3, 3)


def not_a_number(corners: Array, rng: Rng) -> Array:
    """One corner is no place."""
    spoilt = corners.copy()
    spoilt[7, 1, 2] = np.nan
    return spoilt


@dataclass(frozen=True, kw_only=True)
class Defect:
    """A way to spoil a mesh and to write it, and what must come of it."""

    name: str
    """What is wrong."""
    spoil: Spoiler = sound
    """What it does to the triangles."""
    form: Callable[[Array], bytes] = stl_in_mm
    """How they are written."""
    ending: str = ".stl"
    """Ending of the file's name."""
    refused: str | None = None
    """A piece of the reason why it has to be refused; None where it must be planned."""
    said: str | None = None
    """A piece of the sentence that has to come with the mould; None where nothing has to be said."""


DEFECTS = (
    Defect(name="sound, STL"),
    Defect(name="sound, OBJ", form=in_mm(obj), ending=".obj"),
    Defect(name="sound, PLY", form=in_mm(ply), ending=".ply"),
    Defect(name="sound, 3MF", form=in_mm(threemf), ending=".3mf"),
    Defect(name="3MF in metres", form=lambda corners: threemf(corners, "meter"), ending=".3mf"),
    Defect(name="metres instead of mm", form=stl, said="taken as m"),
    Defect(name="inches instead of mm", form=lambda corners: stl(corners / 25.4e-3), said="taken as inch"),
    Defect(name="0.5 m or 0.5 inch", form=lambda corners: stl(4.5 * corners), refused="give the unit"),
    Defect(name="corners unmerged by 1 µm", spoil=unmerged, said="joined"),
    Defect(name="corners unmerged by 40 µm", spoil=apart, refused="hang on nothing"),
    Defect(name="all inward", spoil=inward, said="inward"),
    Defect(name="half of the triangles flipped", spoil=half_flipped, said="disagreed"),
    Defect(name="a region flipped", spoil=patch_flipped, said="disagreed"),
    Defect(name="triangles twice", spoil=doubled, said="twice"),
    Defect(name="triangles from both sides", spoil=both_sides, said="twice"),
    Defect(name="zero-area triangles", spoil=zero_area, said="without an area"),
    Defect(name="slivers of 10 µm", spoil=slivers(10e-6)),
    Defect(name="slivers of 0.5 µm", spoil=slivers(0.5e-6), said="without an area"),
    Defect(name="T-junctions", spoil=seams, said="edge of a neighbour"),
    Defect(name="pin holes", spoil=pin_holes, said="closed"),
    Defect(name="a hole of 12 mm", spoil=hole, said="shows its inside"),
    Defect(name="no bottom", spoil=without_base),
    Defect(name="open sheet", spoil=sheet),
    Defect(name="open sheet facing down", spoil=sheet_down, refused="faces up"),
    Defect(name="two sheets, one facing down", spoil=in_two_colours, said="turned round"),
    Defect(name="two sheets 0.5 mm apart", spoil=two_sheets, refused="over each other"),
    Defect(name="second shell beside", spoil=beside, said="2 separate pieces"),
    Defect(name="second shell touching", spoil=leaning, said="2 separate pieces"),
    Defect(name="second shell crossing the first", spoil=crossing, said="cuts through itself"),
    Defect(name="second shell inside out", spoil=inverted_piece, said="turned round"),
    Defect(name="second shell floating above", spoil=floating, refused="over each other"),
    Defect(name="sheet wound through itself", spoil=twisted, refused="shows its inside"),
    Defect(name="a corner that is no number", spoil=not_a_number, refused="finite"),
    Defect(name="file cut off", form=lambda corners: stl(1e3 * corners)[:-1000], refused="cut off"),
)
