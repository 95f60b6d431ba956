"""What the tool has taken off so far, kept vertex by vertex while it works, and its colours.

A quick account of Preston's law for the eye: every row of the track presses a Hertz patch that removes k F v dt. The
report's map comes from the true contact and the full law.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from burnish.core import Array
from burnish.model.tool import PolishingTool
from burnish.paths.hertz import contact_radius
from burnish.polish.recipe import PRESTON
from burnish.surface import Mould, WorkingSurface
from burnish.surface.winding import Faces, face_vectors

SHOWN = 8000
"""Vertices of a painted surface, about: a patch of felt is then several of them wide."""
MOST = 40_000
"""Vertices of a painted surface at most; a finer mesh is merged."""
FULL = 1.6
"""Share of the target at the end of the scale, as in the report."""
COVERED, OVERPOLISHED = 0.5, 1.5
"""Shares of the target between which a place is as wanted."""
STEEL = (0.66, 0.68, 0.71)
"""sRGB of what was not touched."""
LEVELS = 256
EXPOSURE = 0.6
"""Share of a colour's light that the surface has: the lamps of the picture are bright, and would wash it out."""


@dataclass(frozen=True, kw_only=True)
class Canvas:
    """The surface that is painted, mould frame."""

    vertices: Array
    """[m], (V, 3)."""
    faces: Faces
    """(F, 3)."""

    @classmethod
    def of(cls, mould: Mould) -> Canvas:
        """The faces of a mould that can be worked, in about `SHOWN` vertices.

        Raises:
            MouldError: nothing of it faces up.
        """
        size = np.linalg.norm(face_vectors(mould.vertices, mould.faces), axis=1).sum() / 2.0
        # Halving sides until all are short enough leaves triangles of about 0.2 edge².
        surface = WorkingSurface.of(mould, float(np.sqrt(size / (0.4 * SHOWN))))
        vertices, faces = merged(surface.vertices, surface.faces, size)
        return cls(vertices=vertices, faces=faces)

    @cached_property
    def surface(self) -> WorkingSurface:
        """Areas and normals of it."""
        return WorkingSurface(vertices=self.vertices, faces=self.faces)

    @cached_property
    def tree(self) -> cKDTree:
        """For what lies near a place."""
        return cKDTree(self.vertices)


def merged(vertices: Array, faces: Faces, size: float) -> tuple[Array, Faces]:
    """The mesh, or a coarser one where it has more than `MOST` vertices: those of a small cube become their mean."""
    if len(vertices) <= MOST:
        return vertices, faces
    cube = float(np.sqrt(size / SHOWN))
    _, number, count = np.unique(np.floor(vertices / cube), axis=0, return_inverse=True, return_counts=True)
    number = number.reshape(-1)
    means = np.stack([np.bincount(number, vertices[:, i]) / count for i in range(3)], axis=1)
    corners = number[faces]
    apart = (corners != np.roll(corners, 1, axis=1)).all(axis=1)
    return means, np.asarray(corners[apart], dtype=np.int64)


@dataclass(kw_only=True)
class Paint:
    """Depth at every vertex, and how much was wanted."""

    canvas: Canvas
    """What is painted."""
    tool: PolishingTool = field(default_factory=PolishingTool)
    """What rubs."""
    target: float = PRESTON * 10.0 / 2.5e-3
    """Depth that is wanted [m]; that of a plain raster until a plan says otherwise."""
    depth: Array = field(init=False)
    """What was taken off [m], (V,)."""

    def __post_init__(self) -> None:
        self.depth = np.zeros(len(self.canvas.vertices))
        self._least = 1.5 * float(np.sqrt(np.median(self.canvas.surface.areas)))

    def rub(self, p: Array, force: Array, way: Array) -> None:
        """Take off what contacts at ``p`` [m], (K, 3), remove under ``force`` [N] over a ``way`` of v·dt [m], (K,)."""
        if not len(p):
            return
        force = np.clip(np.nan_to_num(force), 0.0, None)
        a = contact_radius(force, self.tool.tip_radius, 0.0, self.tool.modulus)
        radius = np.maximum(a, self._least)
        for place, r, volume in zip(p, radius.tolist(), (PRESTON * force * way).tolist(), strict=True):
            near = self.canvas.tree.query_ball_point(place, r)
            if near:
                s = np.linalg.norm(self.canvas.vertices[near] - place, axis=1) / r
                shape = np.sqrt(np.clip(1.0 - s * s, 0.0, None))
                whole = max(float(shape @ self.canvas.surface.areas[near]), np.pi * r * r / 3.0)
                self.depth[near] += volume * shape / whole

    def shares(self) -> tuple[float, float]:
        """Shares of the area that are polished enough, and too much."""
        areas = self.canvas.surface.areas / self.canvas.surface.areas.sum()
        return float(areas @ (self.depth >= COVERED * self.target)), float(
            areas @ (self.depth > OVERPOLISHED * self.target)
        )

    def colours(self) -> NDArray[np.uint8]:
        """Linear red, green, blue and alpha of every vertex, (V, 4)."""
        level = np.clip(self.depth * ((LEVELS - 1) / (FULL * self.target)), 0, LEVELS - 1).astype(np.uint8)
        return scale(EXPOSURE)[level]


@cache
def scale(exposure: float = 1.0) -> NDArray[np.uint8]:
    """The colours of 0 to `FULL` targets, linear, (`LEVELS`, 4): the report's, but for steel that was not touched."""
    from matplotlib import colormaps

    levels = np.linspace(0.0, 1.0, LEVELS)
    removal = colormaps["viridis"](levels)[:, :3]
    done = np.clip(levels / 0.06, 0.0, 1.0)[:, None]
    colours = exposure * linear((1.0 - done) * np.array(STEEL) + done * removal)
    return np.column_stack([np.rint(255.0 * colours), np.full(LEVELS, 255.0)]).astype(np.uint8)


def linear(colours: Array) -> Array:
    """sRGB, 0 to 1, as light: what a GLB file holds (IEC 61966-2-1)."""
    return np.where(colours <= 0.04045, colours / 12.92, ((colours + 0.055) / 1.055) ** 2.4)
