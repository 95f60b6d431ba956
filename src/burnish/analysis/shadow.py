"""The shadow of triangles under one distant light: on themselves, and soft on the floor below them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from burnish.analysis.raster import rasterise
from burnish.core import Array

MAP_SIZE = 1024
"""Pixels of the maps along each side."""
MARGIN = 0.08
"""Free border of the maps, as a share of their width, into which the soft shadow may spread."""
PENUMBRA = 0.006
"""Width of the blur of the key light's shadow on the floor, as a share of the map."""
CONTACT = 0.025
"""Width of the blur of the darkening right under the shapes, as a share of the map."""


@dataclass(frozen=True, kw_only=True)
class _Map:
    """An orthographic view along a light: world point → (column, row, height towards the light)."""

    axes: Array
    """Rows: two directions across the light and the one towards it, (3, 3)."""
    origin: Array
    """Lower corner of the map across the light [m], (2,)."""
    scale: float
    """Pixels per metre."""

    @classmethod
    def along(cls, towards: Array, points: Array) -> _Map:
        side = np.cross(towards, (0.0, 1.0, 0.0) if abs(towards[1]) < 0.9 else (1.0, 0.0, 0.0))
        side /= np.linalg.norm(side)
        axes = np.stack([side, np.cross(towards, side), towards])
        across = points @ axes[:2].T
        low, extent = across.min(axis=0), max(float(np.ptp(across, axis=0).max()), 1e-6)
        border = MARGIN / (1.0 - 2.0 * MARGIN) * extent
        return cls(axes=axes, origin=low - border, scale=MAP_SIZE / (extent + 2.0 * border))

    def project(self, points: Array) -> tuple[Array, Array]:
        """Map positions [px], (…, 2), and height towards the light [m], (…,)."""
        seen = points @ self.axes.T
        return (seen[..., :2] - self.origin) * self.scale, seen[..., 2]

    def pixel(self, points: Array) -> NDArray[np.int64]:
        """Column and row of the pixel under each point, (N, 2), moved to the border where it is outside."""
        place, _ = self.project(points)
        return np.clip(place, 0, MAP_SIZE - 1).astype(np.int64)


@dataclass(frozen=True, kw_only=True)
class Shadow:
    """Where the light of one direction arrives."""

    floor: float
    """Height of the floor [m]: the lowest corner."""
    light: _Map
    height: Array
    """Height of the first surface that the light meets [m], (MAP_SIZE, MAP_SIZE); −inf where it passes."""
    cast_shade: Array
    """Blurred share of light that is kept from the floor, in the map of the light."""
    sky: _Map
    contact_shade: Array
    """Broadly blurred footprint of the shapes, in a map seen from above."""

    @classmethod
    def cast(cls, corners: Array, towards: Array) -> Shadow:
        """The shadow of triangles (F, 3, 3) under the light from direction ``towards`` (unit, pointing up)."""
        points = corners.reshape(-1, 3) if len(corners) else np.zeros((1, 3))
        floor = float(points[:, 2].min())
        light, sky = _Map.along(towards, points), _Map.along(np.array([0.0, 0.0, 1.0]), points)
        height = rasterise(*light.project(corners), MAP_SIZE, MAP_SIZE).nearness
        low = corners[corners[..., 2].min(axis=1) < floor + 0.25 * float(np.ptp(points[:, 2]))]
        footprint = np.isfinite(rasterise(*sky.project(low), MAP_SIZE, MAP_SIZE).nearness)
        return cls(
            floor=floor,
            light=light,
            height=height,
            cast_shade=gaussian_filter(np.isfinite(height).astype(np.float64), PENUMBRA * MAP_SIZE),
            sky=sky,
            contact_shade=gaussian_filter(footprint.astype(np.float64), CONTACT * MAP_SIZE),
        )

    def lit(self, points: Array) -> Array:
        """Share of the light that reaches surface points (N, 3): nine neighbours of the map are asked."""
        place, height = self.light.project(points)
        blocked = np.zeros(len(points))
        for dx in (-1.2, 0.0, 1.2):
            for dy in (-1.2, 0.0, 1.2):
                column, row = np.clip(place + np.array([dx, dy]), 0, MAP_SIZE - 1).astype(np.int64).T
                blocked += self.height[row, column] > height + 1.5 / self.light.scale
        return 1.0 - blocked / 9.0

    def on_floor(self, points: Array) -> Array:
        """Darkness 0…1 of the floor at points (N, 3) on it."""
        column, row = self.light.pixel(points).T
        x, y = self.sky.pixel(points).T
        return np.asarray(np.minimum(0.8 * self.cast_shade[row, column] + 0.7 * self.contact_shade[y, x], 1.0))
