"""How deep the abrasive has cut, at every place of the surface, and how evenly.

Preston's law, dh/dt = k p v: the depth grows with pressure and sliding speed. Under a spherical tip the
pressure is that of Hertz, p(s) = 3F/(2πa²) √(1 − s²/a²). Parallel tracks therefore leave the mean depth
h = k F v / (feed · step), whatever the shape of the pressure.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csc_array
from scipy.spatial import cKDTree

from burnish.core import Array
from burnish.errors import InputError
from burnish.finish.rubbing import Rubbing
from burnish.paths.hertz import contact_radius
from burnish.paths.reach import STEEPEST, Reach
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

HOLLOWEST = 0.8
"""Hollowest surface that is believed, in curvatures of the tip: in a hollow nearly as round as the tip Hertz's contact
grows without bound. The rule of thumb for which tip fits."""

Numbers: TypeAlias = NDArray[np.intp]

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
        curvature: ArrayLike = 0.0,
    ) -> Array:
        """Depth that N samples in the order of time have removed where all of a contact slides at one speed [m], (V,).

        The removed volume is k Σ F v dt exactly, wherever at least half of the contact lies on the surface.
        Only vertices that face the tool lose material. Depths of several passes add up.

        Args:
            surface: vertices that carry the depth.
            contacts: points of contact, mould frame [m], (N, 3).
            normals: outward unit normals there, (N, 3).
            force: normal force [N], (N,); a sample without force removes nothing.
            speed: sliding speed of the abrasive over the surface [m/s], (N,).
            dt: how long each sample lasts [s], (N,).
            curvature: mean curvature of the surface, for the size of the contact [1/m], convex positive; (N,) or one.

        Raises:
            InputError: the arrays do not fit together, or hold a value that is not finite.
        """
        # Without spin only the size of a velocity counts.
        velocity = np.multiply.outer(np.asarray(speed, dtype=np.float64), [1.0, 0.0, 0.0])
        rubbing = Rubbing.of(
            contacts=contacts, normals=normals, force=force, velocity=velocity, curvature=curvature
        )  # fmt: skip
        return self.depth_of(surface, rubbing, dt)

    def depth_of(self, surface: WorkingSurface, rubbing: Rubbing, dt: ArrayLike) -> Array:
        """Depth that contacts in the order of time, each ``dt`` [s] (N,) long, have removed, spinning or not [m], (V,).

        Raises:
            InputError: there is not one finite ``dt`` a contact.
        """
        dt = np.asarray(dt, dtype=np.float64)
        if dt.shape != rubbing.force.shape or not np.isfinite(dt).all():
            raise InputError(f"removal: dt of shape {dt.shape}; expected {rubbing.force.shape}, finite")
        kept = rubbing.pressing()
        depth = np.zeros(len(surface.vertices))
        if not len(kept):
            return depth
        rubbing, dt = _merged(rubbing[kept], dt[kept], self._radius(surface, rubbing[kept]))
        tree = cKDTree(surface.vertices)
        for start in range(0, len(dt), _CHUNK):
            part = slice(start, start + _CHUNK)
            vertex, sample, rate = self._rates(surface, tree, rubbing[part])
            depth += np.bincount(vertex, rate * dt[part][sample], minlength=len(depth))
        return depth

    def rates(self, surface: WorkingSurface, rubbing: Rubbing) -> csc_array:
        """Depth a second that each of N contacts removes at each vertex [m/s], sparse, (V, N).

        What a plan is made with: the depth is ``rates @ dt``, where nothing is merged.
        """
        tree, parts = cKDTree(surface.vertices), []
        for start in range(0, len(rubbing.force), _CHUNK):
            vertex, sample, rate = self._rates(surface, tree, rubbing[start : start + _CHUNK])
            parts.append((vertex, sample + start, rate))
        vertex, sample, rate = (np.concatenate(column) for column in zip(*parts, strict=True))
        return csc_array((rate, (vertex, sample)), shape=(len(surface.vertices), len(rubbing.force)))

    def _rates(self, surface: WorkingSurface, tree: cKDTree, rubbing: Rubbing) -> tuple[Numbers, Numbers, Array]:
        """Pairs of vertex and contact that meet, and the depth a second there [m/s]: k p |u + w n × ρ|."""
        contact, normal, w = rubbing.contacts, rubbing.normals, rubbing.spin
        radius = self._radius(surface, rubbing)
        pairs = cKDTree(contact).sparse_distance_matrix(tree, radius.max(), output_type="ndarray")
        sample, vertex, distance = pairs["i"], pairs["j"], pairs["v"]
        facing = np.einsum("ij,ij->i", normal[sample], surface.normals[vertex]) > 0.0
        shape = np.sqrt(np.clip(1.0 - (distance / radius[sample]) ** 2, 0.0, None)) * facing
        carried = np.bincount(sample, shape * surface.areas[vertex], minlength=len(contact))
        carried = np.maximum(carried, _OVERHANG * 2.0 / 3.0 * np.pi * radius**2)
        # |u + w n × ρ|² = u² + 2 w (u × n) · ρ + w² ρ², with ρ from the middle of the contact to the vertex.
        skew = 2.0 * w[:, None] * np.cross(rubbing.velocity, normal)
        still = np.einsum("ij,ij->i", rubbing.velocity, rubbing.velocity) - np.einsum("ij,ij->i", skew, contact)
        squared = still[sample] + np.einsum("ij,ij->i", skew[sample], surface.vertices[vertex])
        speed = np.sqrt(np.clip(squared + (w[sample] * distance) ** 2, 0.0, None))
        strength = self.coefficient * np.clip(rubbing.force, 0.0, None) / carried
        return vertex, sample, shape * speed * strength[sample]

    def _radius(self, surface: WorkingSurface, rubbing: Rubbing) -> Array:
        """Contact radius [m], (N,), not below what the vertices can carry."""
        least = 2.0 * float(np.sqrt(np.median(surface.areas)))
        curvature = np.maximum(rubbing.curvature, -HOLLOWEST / self.tip_radius)
        force = np.clip(rubbing.force, 0.0, None)
        return np.maximum(
            contact_radius(force, self.tip_radius, 0.0, self.modulus) / np.cbrt(1.0 + self.tip_radius * curvature),
            least,
        )


def _merged(rubbing: Rubbing, dt: Array, radius: Array) -> tuple[Rubbing, Array]:
    """Successive contacts that lie close together as one, and how long they last together [s].

    Means are weighted by F dt, so the removed volume and where it lies are kept.
    """
    moved = np.linalg.norm(np.diff(rubbing.contacts, axis=0), axis=1)
    place = np.concatenate(([0.0], np.cumsum(moved / (_MERGED * radius[1:]))))
    group = np.unique(np.floor(place), return_inverse=True)[1]
    total = np.bincount(group, rubbing.force * dt)
    lasting = np.bincount(group, dt)
    kept = total > 0.0

    def mean(values: Array) -> Array:
        columns = np.asarray(values).reshape(len(dt), -1).T
        sums = [np.bincount(group, rubbing.force * dt * column)[kept] / total[kept] for column in columns]
        return np.asarray(np.column_stack(sums).reshape(-1, *values.shape[1:]))

    normals = mean(rubbing.normals)
    merged = Rubbing(
        contacts=mean(rubbing.contacts),
        normals=normals / np.linalg.norm(normals, axis=1, keepdims=True),
        force=total[kept] / lasting[kept],
        velocity=mean(rubbing.velocity),
        spin=mean(rubbing.spin),
        curvature=mean(rubbing.curvature),
    )
    return merged, np.asarray(lasting[kept])


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
