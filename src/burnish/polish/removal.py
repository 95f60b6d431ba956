"""How deep the abrasive has cut, at every place of the surface, and how evenly.

Preston's law, dh/dt = k p v: the depth grows with pressure and sliding speed. Under a spherical tip the
pressure is that of Hertz, p(s) = 3F/(2πa²) √(1 − s²/a²). Parallel tracks therefore leave the mean depth
h = k F v / (feed · step), whatever the shape of the pressure.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from burnish.core import Array
from burnish.errors import InputError
from burnish.polish.hertz import contact_radius
from burnish.polish.reach import STEEPEST, Reach
from burnish.surface import Border, Mould, WorkingSurface, top

VERTICES_PER_RADIUS = 3.0
"""Vertices that the contact radius should span at least: the sides of the working surface are at most a/3."""

COVERED, OVERPOLISHED = 0.5, 1.5
"""Shares of the target from which a place counts as covered, and as polished too much."""

_MERGED = 1.0 / 8.0
"""Samples within this share of the contact radius along the path become one."""

_OVERHANG = 0.5
"""Least share of the contact that carries the whole force: where the tip overhangs an edge the pressure rises, in
this model at most twofold, because it says nothing about an edge."""

_CHUNK = 4096
"""Merged samples worked on at a time; bounds the memory."""

_ON_TOP = 0.5e-3
"""How far a vertex may lie under the surface as seen from above and still belong to it [m]."""


@dataclass(frozen=True, kw_only=True)
class Removal:
    """Preston's law under a spherical tip; its fields are its constants."""

    coefficient: float
    """Preston's k [1/Pa]: a calibrated value of tool, abrasive and part, of which no table can be trusted."""
    tip_radius: float
    """Radius of the tip [m]."""
    modulus: float
    """Contact modulus E* [Pa]."""

    def __post_init__(self) -> None:
        """Refuse constants that no tool has."""
        if not (0.0 < self.coefficient < np.inf and 0.0 < self.tip_radius < np.inf and 0.0 < self.modulus < np.inf):
            raise InputError(f"{self}; expected positive numbers")

    def edge(self, force: float) -> float:
        """Longest side of a working surface that resolves the contact at this force [m]."""
        return float(contact_radius(force, self.tip_radius, 0.0, self.modulus)) / VERTICES_PER_RADIUS

    def depth(
        self,
        surface: WorkingSurface,
        *,
        contacts: ArrayLike,
        normals: ArrayLike,
        force: ArrayLike,
        speed: ArrayLike,
        dt: ArrayLike,
        curvature: float = 0.0,
    ) -> Array:
        """Depth that N samples in the order of time have removed [m], (V,); depths of several passes add up.

        The removed volume is k Σ F v dt exactly, wherever at least half of the contact lies on the surface.
        Only vertices that face the tool lose material.

        Args:
            surface: vertices that carry the depth.
            contacts: points of contact, mould frame [m], (N, 3).
            normals: outward unit normals there, (N, 3).
            force: normal force [N], (N,); a sample without force removes nothing.
            speed: sliding speed of the abrasive over the surface, spindle included [m/s], (N,).
            dt: how long each sample lasts [s], (N,).
            curvature: normal curvature of the surface, for the size of the contact [1/m], convex positive.

        Raises:
            InputError: the arrays do not fit together, or hold a value that is not finite.
        """
        columns = _columns(contacts, normals, force, speed, dt)
        columns = columns[columns[:, 6] > 0.0]
        depth = np.zeros(len(surface.vertices))
        if not len(columns):
            return depth
        contact, normal, pressing, work = _merged(columns, self._radius(surface, columns[:, 6], curvature))
        radius = self._radius(surface, pressing, curvature)
        tree = cKDTree(surface.vertices)
        for start in range(0, len(work), _CHUNK):
            part = slice(start, start + _CHUNK)
            depth += _cut(surface, tree, contact[part], normal[part], radius[part], self.coefficient * work[part])
        return depth

    def _radius(self, surface: WorkingSurface, force: Array, curvature: float) -> Array:
        """Contact radius [m], (N,), not below what the vertices can carry."""
        least = 2.0 * float(np.sqrt(np.median(surface.areas)))
        return np.maximum(contact_radius(force, self.tip_radius, curvature, self.modulus), least)


def _columns(contacts: ArrayLike, normals: ArrayLike, force: ArrayLike, speed: ArrayLike, dt: ArrayLike) -> Array:
    """The samples in one array, (N, 9): contact, normal, force, speed, dt."""
    parts = [np.asarray(values, dtype=np.float64) for values in (contacts, normals, force, speed, dt)]
    count = len(parts[0]) if parts[0].ndim else 0
    shapes = [(count, 3), (count, 3), (count,), (count,), (count,)]
    if [values.shape for values in parts] != shapes:
        raise InputError(f"removal: arrays of shapes {[values.shape for values in parts]}; expected {shapes}")
    columns = np.column_stack(parts)
    if not np.isfinite(columns).all():
        raise InputError("removal: a sample holds a value that is not a finite number; leave such samples out")
    return columns


def _merged(columns: Array, radius: Array) -> tuple[Array, Array, Array, Array]:
    """Successive samples that lie close together as one: contacts, normals, forces, and Σ F v dt [N·m].

    Means are weighted by F v dt, so the removed volume and where it lies are kept.
    """
    moved = np.linalg.norm(np.diff(columns[:, :3], axis=0), axis=1)
    place = np.concatenate(([0.0], np.cumsum(moved / (_MERGED * radius[1:]))))
    group = np.unique(np.floor(place), return_inverse=True)[1]
    work = columns[:, 6] * np.abs(columns[:, 7]) * columns[:, 8]
    total = np.asarray(np.bincount(group, work), dtype=np.float64)
    kept = total > 0.0
    mean = np.stack([np.bincount(group, work * columns[:, i]) for i in range(7)], axis=1)[kept] / total[kept, None]
    return mean[:, :3], mean[:, 3:6], mean[:, 6], total[kept]


def _cut(surface: WorkingSurface, tree: cKDTree, contact: Array, normal: Array, radius: Array, volume: Array) -> Array:
    """Depth from volumes [m³] (N,) that are each spread over a contact like Hertz's pressure [m], (V,)."""
    pairs = cKDTree(contact).sparse_distance_matrix(tree, radius.max(), output_type="ndarray")
    sample, vertex, distance = pairs["i"], pairs["j"], pairs["v"]
    facing = np.einsum("ij,ij->i", normal[sample], surface.normals[vertex]) > 0.0
    shape = np.sqrt(np.clip(1.0 - (distance / radius[sample]) ** 2, 0.0, None)) * facing
    carried = np.bincount(sample, shape * surface.areas[vertex], minlength=len(contact))
    carried = np.maximum(carried, _OVERHANG * 2.0 / 3.0 * np.pi * radius**2)
    return np.asarray(np.bincount(vertex, shape * (volume / carried)[sample], minlength=len(surface.vertices)))


@dataclass(frozen=True, kw_only=True)
class Coverage:
    """How much of an area received what it should."""

    covered_pct: float
    """Share of the area with at least half of the target [%]."""
    overpolished_pct: float
    """Share of the area with more than one and a half times the target [%]."""
    cv_pct: float
    """Standard deviation over the area by its mean [%]; 0 where nothing was removed."""
    mean: float
    """Mean depth over the area [m]."""


def coverage(depth: Array, target: float, areas: Array, mask: NDArray[np.bool_]) -> Coverage:
    """Judge a depth over the part of the surface that counts.

    Args:
        depth: removed depth at the vertices [m], (V,).
        target: depth that is wanted [m].
        areas: area of each vertex [m²], (V,).
        mask: vertices that count, (V,); see :func:`workable`.

    Raises:
        InputError: no vertex counts, or the target is not positive.
    """
    share = areas[mask].sum()
    if not (share > 0.0 and target > 0.0):
        raise InputError(f"coverage of {1e4 * share:.3g} cm² with a target of {target} m; expected positive values")
    weight, found = areas[mask] / share, depth[mask]
    mean = float(weight @ found)
    spread = float(np.sqrt(weight @ (found - mean) ** 2))
    return Coverage(
        covered_pct=min(100.0 * float(weight @ (found >= COVERED * target)), 100.0),
        overpolished_pct=min(100.0 * float(weight @ (found > OVERPOLISHED * target)), 100.0),
        cv_pct=100.0 * spread / mean if mean > 0.0 else 0.0,
        mean=mean,
    )


def edge_band(mould: Mould, points: Array, width: float, max_slope: float = STEEPEST) -> NDArray[np.bool_]:
    """Points (N, 3) within ``width`` [m], in plan, of the border of what is flat enough, rims of holes included."""
    return np.asarray(Border.of(mould, max_slope).distance(points) < width)


def workable(surface: WorkingSurface, reach: Reach) -> NDArray[np.bool_]:
    """Vertices that a coverage can be asked of: within the reach of the tip, outside its margin, and not hidden."""
    place = surface.vertices[:, :2]
    with np.errstate(invalid="ignore"):
        on_top = top(reach.grid, place)[:, 2] - surface.vertices[:, 2] < _ON_TOP
    return np.asarray(reach.free(place) & on_top)
