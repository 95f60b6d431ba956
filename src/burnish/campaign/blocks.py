"""Two moulds in closed form: their distance grids are coarse, exact enough, and made in milliseconds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from burnish.core import Array, read_only
from burnish.surface import DistanceGrid

SPACING = 3e-3
"""Of the grids [m]. Trilinear, a sphere of 150 mm is off by 8 µm; a plane is exact."""
HALF = 60e-3
"""Half of the sides of a block [m]."""
ABOVE, BELOW, ASIDE = 45e-3, 12e-3, 30e-3
"""Room of the grids above, below the top and aside [m]."""
DOME_RADIUS = 150e-3
"""[m]"""
TOP = 20e-3
"""Height of the top [m]."""


@dataclass(frozen=True, kw_only=True)
class Block:
    """A mould to press on, in its own frame, z up."""

    grid: DistanceGrid
    """Signed distance."""
    surface: Callable[[Array], tuple[Array, Array]]
    """Points of the top and their normals, (N, 3) each, at places in plan, (N, 2)."""
    top: float = TOP
    """Highest point [m]."""
    half: float = HALF
    """Half of its sides [m]."""


@cache
def plate(edge: bool) -> Block:
    """A flat block; with ``edge`` its side at x = half is inside the grid, else it has none."""

    def distance(x: Array, y: Array, z: Array) -> Array:
        above = z - TOP
        if not edge:
            return above
        beyond = x - HALF
        return np.hypot(np.maximum(above, 0.0), np.maximum(beyond, 0.0)) + np.minimum(np.maximum(above, beyond), 0.0)

    def surface(plan: Array) -> tuple[Array, Array]:
        flat = np.column_stack([plan, np.full(len(plan), TOP)])
        return flat, np.tile([0.0, 0.0, 1.0], (len(plan), 1))

    return Block(grid=_grid(distance), surface=surface)


@cache
def dome() -> Block:
    """A sphere, as far as the grid goes."""
    centre = np.array([0.0, 0.0, TOP - DOME_RADIUS])

    def distance(x: Array, y: Array, z: Array) -> Array:
        return np.asarray(np.sqrt(x**2 + y**2 + (z - centre[2]) ** 2) - DOME_RADIUS)

    def surface(plan: Array) -> tuple[Array, Array]:
        up = np.sqrt(DOME_RADIUS**2 - (plan**2).sum(axis=1))
        normals = np.column_stack([plan, up]) / DOME_RADIUS
        return centre + DOME_RADIUS * normals, normals

    return Block(grid=_grid(distance), surface=surface)


def _grid(distance: Callable[[Array, Array, Array], Array]) -> DistanceGrid:
    side = np.arange(-HALF - ASIDE, HALF + ASIDE + SPACING, SPACING)
    height = np.arange(TOP - BELOW, TOP + ABOVE, SPACING)
    values = distance(*np.meshgrid(side, side, height, indexing="ij"))
    origin = np.array([side[0], side[0], height[0]])
    return DistanceGrid(origin=read_only(origin), spacing=SPACING, values=read_only(values))
