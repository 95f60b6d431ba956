"""A spherical tip on the mould: where it comes to rest, and which places it can touch.

The centre of a sphere of radius r that touches the mould lies on the level φ = r of the distance. Lowering
it along −z onto the first such point cannot gouge, whatever edges and pockets lie below.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from burnish.core import Array
from burnish.errors import InputError
from burnish.surface.distance import DistanceGrid

OBSTRUCTED = 0.25e-3
"""How deep a tip that is laid against a place may cut into the mould elsewhere before the place counts as out of
reach [m]. In a hollow of facets a tip of 15 mm always cuts in between: 0.23 mm if they meet at 10°."""

_CHUNK = 1 << 14
"""Points lowered at a time; bounds the memory (one column of the grid each)."""


@dataclass(frozen=True, kw_only=True)
class Touch:
    """A sphere at rest on the mould at N places; NaN where there is nothing to rest on."""

    centre: Array
    """Centres of the sphere, mould frame [m], (N, 3)."""
    normal: Array
    """Outward unit normals of the surface, (N, 3)."""
    contact: Array
    """Points of contact [m], (N, 3): centre − radius · normal."""


def lowered(grid: DistanceGrid, xy: Array, radius: float) -> Touch:
    """Lower a sphere along −z onto the mould.

    Args:
        grid: distance to the mould.
        xy: horizontal positions of the centre, mould frame [m], (N, 2).
        radius: of the sphere [m].

    Raises:
        InputError: the sphere is not smaller than the room that the grid has above the mould, or not larger
            than two spacings of the grid.
    """
    room = float(grid.values[:, :, -1].min())
    if not 2.0 * grid.spacing < radius < room:
        raise InputError(
            f"the tip radius is {1e3 * radius:.3g} mm; this distance grid of {1e3 * grid.spacing:.2f} mm serves radii "
            f"from {2e3 * grid.spacing:.3g} to {1e3 * room:.3g} mm"
        )
    centre = _at_rest(grid, xy, radius)
    normal, contact = np.full_like(centre, np.nan), np.full_like(centre, np.nan)
    met = ~np.isnan(centre[:, 2])
    normal[met] = unit(grid.at(centre[met])[1])
    contact[met] = centre[met] - radius * normal[met]
    return Touch(centre=centre, normal=normal, contact=contact)


def touching(grid: DistanceGrid, xy: Array, radius: float) -> Touch:
    """Rest a sphere on the mould so that it touches at given places of the upper surface.

    It is lowered beside each place, by what the slope there takes. Where that is out of reach, it rests
    against what keeps it away.

    Args:
        grid: distance to the mould.
        xy: horizontal positions of the points of contact, mould frame [m], (N, 2).
        radius: of the sphere [m].

    Raises:
        InputError: as for :func:`lowered`.
    """
    aim = laid(grid, xy, radius).centre[:, :2]
    missed = xy - lowered(grid, aim, radius).contact[:, :2]  # beside an edge, whose normals the grid rounds off
    return lowered(grid, aim + missed, radius)


def laid(grid: DistanceGrid, xy: Array, radius: float) -> Touch:
    """Lay a sphere against given places (N, 2) of the upper surface, whatever else it may cut into.

    Args:
        grid: distance to the mould.
        xy: horizontal positions of the points of contact, mould frame [m], (N, 2).
        radius: of the sphere [m].
    """
    contact = top(grid, xy)
    normal, met = np.full_like(contact, np.nan), ~np.isnan(contact[:, 2])
    normal[met] = unit(grid.at(contact[met])[1])
    return Touch(centre=contact + radius * normal, normal=normal, contact=contact)


def unobstructed(grid: DistanceGrid, centre: Array, radius: float) -> NDArray[np.bool_]:
    """Whether a sphere at these centres (N, 3) cuts into the mould nowhere, (N,); not at NaN."""
    met = ~np.isnan(centre[:, 2])
    met[met] = grid.distance(centre[met]) > radius - OBSTRUCTED
    return met


def top(grid: DistanceGrid, xy: Array) -> Array:
    """Points of the surface as seen from above, (N, 3) [m]; NaN where there is none or it is below the grid."""
    return _at_rest(grid, xy, 0.0)


def unit(vectors: Array) -> Array:
    """Vectors (N, 3) scaled to length 1; a zero vector stays one."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.maximum(length, np.finfo(float).tiny))


def _at_rest(grid: DistanceGrid, xy: Array, radius: float) -> Array:
    """Centres at rest (N, 3) [m]: the highest root of φ(x, y, ·) = r, NaN without one."""
    parts = [_height(grid, xy[start : start + _CHUNK], radius) for start in range(0, len(xy), _CHUNK)]
    height = np.concatenate(parts or [np.empty(0)])
    return np.where(np.isnan(height)[:, None], np.nan, np.column_stack((xy, height)))


def _height(grid: DistanceGrid, xy: Array, radius: float) -> Array:
    """Height of the centre at rest [m], (N,)."""
    nx, ny, nz = grid.values.shape
    place = (xy - grid.origin[:2]) / grid.spacing
    within = np.all((place >= 0.0) & (place <= (nx - 1, ny - 1)), axis=1)
    place[~within] = 0.0
    node = np.minimum(place.astype(np.int64), (nx - 2, ny - 2))
    f, g = (place - node).T[:, :, None]
    i, j = node.T
    column = (1.0 - f) * ((1.0 - g) * grid.values[i, j] + g * grid.values[i, j + 1])
    column += f * ((1.0 - g) * grid.values[i + 1, j] + g * grid.values[i + 1, j + 1])
    below = column < radius
    level = nz - 1 - np.argmax(below[:, ::-1], axis=1)  # highest node that is too low
    rows = np.flatnonzero(within & below.any(axis=1))
    k = level[rows]
    low, high = column[rows, k], column[rows, k + 1]
    height = np.full(len(xy), np.nan)
    height[rows] = grid.origin[2] + grid.spacing * (k + (radius - low) / (high - low))
    return height
