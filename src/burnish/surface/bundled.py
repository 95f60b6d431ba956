"""The moulds that come with the package, as loose triangles in metres with z up.

A flat plate, a convex dome and a wave whose true shapes are known in closed form, so that everything that
is computed from their triangles can be checked, and the name of a free form that is kept as a file.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from burnish.core import Array

PLATE_SIDE, PLATE_THICKNESS = 200e-3, 20e-3
"""Sides and thickness of the plate [m]."""

DOME_RADIUS, DOME_SIDE, DOME_SKIRT = 150e-3, 100e-3, 10e-3
"""Radius of the sphere, sides of the patch, and height of the skirt under its corners [m]."""

WAVE_SIDES, WAVE_AMPLITUDE, WAVE_LENGTH, WAVE_SKIRT = (120e-3, 80e-3), 2e-3, 60e-3, 15e-3
"""Sides, amplitude and length of the wave, and mean height of its block less the amplitude [m]."""

FACET = 1e-3
"""Sides of the facets of dome and wave in plan [m]. The middle of a facet with circumradius c lies c²/2R
under a sphere of radius R, 1.7 to 2.2 µm on the dome; on the wave, R ≥ 46 mm in one direction, side²/8R
is at most 2.8 µm."""

FREE_FORM = "mould"
"""The mould with a pocket, a fillet, a hole and edges, which is an STL file among the assets."""


def plate() -> Array:
    """A flat box of 200 × 200 × 20 mm; worked on its top, z = 20 mm."""
    half = PLATE_SIDE / 2.0
    return block(np.array([-half, half]), np.array([-half, half]), lambda x, y: np.full_like(x, PLATE_THICKNESS))


def dome() -> Array:
    """A spherical cap of radius 150 mm over 100 × 100 mm on a skirt; its vertices lie on the sphere."""
    return block(_ticks(DOME_SIDE), _ticks(DOME_SIDE), dome_height)


def wave() -> Array:
    """A block of 120 × 80 mm whose top is a ±2 mm cosine along x, 60 mm long, with a crest in the middle."""
    return block(_ticks(WAVE_SIDES[0]), _ticks(WAVE_SIDES[1]), wave_height)


def dome_height(x: Array, y: Array) -> Array:
    """True height of the dome's surface above its base [m]."""
    centre = DOME_SKIRT - np.sqrt(DOME_RADIUS**2 - DOME_SIDE**2 / 2.0)
    return np.asarray(centre + np.sqrt(DOME_RADIUS**2 - x**2 - y**2))


def wave_height(x: Array, y: Array) -> Array:
    """True height of the wave's surface above its base [m]; the same for all y."""
    return np.asarray(WAVE_SKIRT + WAVE_AMPLITUDE * np.cos(2.0 * np.pi / WAVE_LENGTH * x) + 0.0 * y)


def block(x: Array, y: Array, height: Callable[[Array, Array], Array]) -> Array:
    """A closed solid with the surface z = height(x, y) on top, vertical sides and its base on z = 0.

    Args:
        x: rising coordinates of the grid lines across x [m], (nx,).
        y: the same across y [m], (ny,).
        height: height over arrays of x and y [m], positive.

    Returns:
        Triangle corners, outward, (F, 3, 3) [m].
    """
    grid_x, grid_y = np.meshgrid(x, y, indexing="ij")
    top = np.stack((grid_x, grid_y, height(grid_x, grid_y)), axis=-1)
    sheet = quads(top[:-1, :-1], top[1:, :-1], top[1:, 1:], top[:-1, 1:])
    rim = np.concatenate((top[:-1, 0], top[-1, :-1], top[:0:-1, -1], top[0, :0:-1]))
    return np.concatenate((sheet, skirt(rim), base(rim)))


def skirt(rim: Array) -> Array:
    """Vertical wall from a closed rim (N, 3), counter-clockwise seen from above, down to z = 0."""
    following = np.roll(rim, -1, axis=0)
    foot, following_foot = rim * [1.0, 1.0, 0.0], following * [1.0, 1.0, 0.0]
    return quads(foot, following_foot, following, rim)


def base(rim: Array) -> Array:
    """The bottom z = 0 under a rim that is star-shaped about the z axis, as a fan that faces down."""
    foot = rim * [1.0, 1.0, 0.0]
    return np.stack((np.zeros_like(foot), np.roll(foot, -1, axis=0), foot), axis=1)


def quads(a: Array, b: Array, c: Array, d: Array) -> Array:
    """Two triangles for each quadrilateral a b c d, (N, 3) each in any leading shape."""
    a, b, c, d = (corner.reshape(-1, 3) for corner in (a, b, c, d))
    return np.concatenate((np.stack((a, b, c), axis=1), np.stack((a, c, d), axis=1)))


def _ticks(side: float) -> Array:
    """Grid lines over a side that is centred on 0 [m], one facet apart."""
    return np.linspace(-side / 2.0, side / 2.0, round(side / FACET) + 1)


SURFACES: dict[str, Callable[[], Array]] = {"plate": plate, "dome": dome, "wave": wave}
"""The moulds that are computed."""

NAMES = (*SURFACES, FREE_FORM)
"""All bundled moulds."""
