"""What a run left under its target, and the strokes that add it there and nowhere else.

The depth is judged as the tip sees it, averaged over a contact: finer unevenness, as between neighbouring lines, no
further pass of the same tip can take away. Places under target are joined to zones over the mesh; the strokes of the
run are cut to the zones, and their feed is made anew so that what lacks is added.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from burnish.core import Array, read_only
from burnish.errors import PlanError
from burnish.finish.dwell import Dwell
from burnish.paths.hertz import contact_radius
from burnish.paths.lead import with_leads
from burnish.paths.stroke import COLUMNS, Stroke
from burnish.surface import WorkingSurface

TOLERANCE = 0.05
"""Share of the target that a place may be under before it is repaired, and over before a tool may not pass over it."""
LEAST_FORCE = 2.0
"""Force of the gentlest repair, and at the ends of its strokes [N]."""
LEAD = 5e-3
"""Length at both ends of a repair stroke over which its force rises and falls [m]."""
_SHORTEST = 10e-3
"""Least length of a repair stroke [m]; a shorter one digs in where it starts and repairs little."""
SLOW = 3.0
"""Feed of a repair stroke on the mean, in least feeds: about that of a turn."""
FARTHEST = 10e-3
"""Longest way over which two pieces of a path are joined by a turn [m]: a few line distances."""
_PITCH, _SAME = 0.5e-3, 1e-6
"""Distance of the points of a turn, and of points that are one [m]."""
_ALIKE = float(np.cos(np.deg2rad(20.0)))
_CORE = 0.7
"""Share of a zone's mean lack from which a path leads over a place."""
_SMALLEST = 2.0
"""Least area of a zone, in areas of the contact: a smaller one is not worth an approach."""


@dataclass(frozen=True, kw_only=True)
class Repair:
    """A plan to bring a worked surface up to its target."""

    missing: Array
    """Depth that lacks at each vertex, as the tip sees it [m], (V,); 0 where nothing lacks or nothing is judged."""
    zone: NDArray[np.int64]
    """Zone of each vertex from 1, 0 for none, (V,)."""
    strokes: tuple[Stroke, ...]
    """What to do; empty if nothing lacks, or if the plan would leave the surface less even than it is."""

    @property
    def zones(self) -> int:
        """How many zones lack depth."""
        return int(self.zone.max(initial=0))


def repair(
    dwell: Dwell,
    surface: WorkingSurface,
    strokes: Sequence[Stroke],
    depth: Array,
    target: float,
    judged: NDArray[np.bool_],
    tolerance: float = TOLERANCE,
) -> Repair:
    """The zones of a worked surface that are under target, and the strokes that repair them.

    Args:
        dwell: the tool, and how fast and slow it may go.
        surface: vertices that carry the depth.
        strokes: the path of the run that left the depth.
        depth: what it removed [m], (V,).
        target: what it should have removed [m].
        judged: vertices that count, (V,).
        tolerance: share of the target that a place may be under, and over where a stroke may still pass.

    Raises:
        PlanError: target or tolerance are out of range, or the tool does not spin.
    """
    if not (target > 0.0 and 0.0 < tolerance < 1.0):
        raise PlanError(f"repair to {target} m within {tolerance}; expected a positive depth and a share below 1")
    radius = float(contact_radius(_force(strokes), dwell.law.tip_radius, 0.0, dwell.law.modulus))
    seen = as_the_tip_sees(surface, depth, radius, judged)
    zone = zones(surface, judged & (seen < (1.0 - tolerance) * target), _SMALLEST * np.pi * radius**2)
    missing = np.where(judged, np.clip(target - seen, 0.0, None), 0.0)
    # Towards the rim of a zone less lacks than the slow turns of a path would add; the width of the contact does it.
    weight = np.bincount(zone, surface.areas)
    mean = np.bincount(zone, surface.areas * missing) / np.maximum(weight, np.finfo(float).tiny)
    core = (zone > 0) & (missing >= _CORE * mean[zone])
    free = seen < (1.0 + tolerance) * target
    pieces = [piece for stroke in strokes for piece in _cut(stroke, surface, core, free)]
    if not pieces:
        return Repair(missing=read_only(missing), zone=zone, strokes=())
    pieces = _gentle(dwell, surface, pieces, missing, zone > 0)
    strokes = _worthwhile(dwell, surface, pieces, target - depth, judged)
    return Repair(missing=read_only(missing), zone=zone, strokes=tuple(strokes))


def _worthwhile(
    dwell: Dwell, surface: WorkingSurface, pieces: Sequence[Stroke], lacks: Array, judged: NDArray[np.bool_]
) -> list[Stroke]:
    """The pieces with their feed fitted, without those that leave the surface less even than it is without them.

    At its fastest a stroke still removes something. The worst is left out, and the others are fitted anew.
    """
    share = surface.areas * judged
    while pieces:
        fitted = dwell.fitted(surface, pieces, lacks, judged)
        depths = [dwell.depth(surface, [stroke]) for stroke in fitted]
        left = lacks - np.sum(depths, axis=0)
        # Of Σ w (l + d)² − Σ w l², for the piece that is left out.
        gain = [float(share @ (depth * (2.0 * left + depth))) for depth in depths]
        worst = int(np.argmin(gain))
        if gain[worst] > 0.0:
            return fitted
        pieces = [piece for i, piece in enumerate(pieces) if i != worst]
    return []


def as_the_tip_sees(surface: WorkingSurface, depth: Array, radius: float, judged: NDArray[np.bool_]) -> Array:
    """The depth averaged over a contact of this radius [m] around each vertex, with weights 1 − s²/a², (V,).

    At the rim of what is judged, (V,), only what is judged counts: beyond it nobody cares, and less is removed.
    """
    tree = cKDTree(surface.vertices)
    pairs = tree.sparse_distance_matrix(tree, radius, output_type="ndarray")
    pairs = pairs[judged[pairs["j"]] | ~judged[pairs["i"]]]
    weight = (1.0 - (pairs["v"] / radius) ** 2) * surface.areas[pairs["j"]]
    total = np.bincount(pairs["i"], weight, len(depth))
    return np.asarray(np.bincount(pairs["i"], weight * depth[pairs["j"]], len(depth)) / total)


def zones(surface: WorkingSurface, lacking: NDArray[np.bool_], least: float) -> NDArray[np.int64]:
    """Connected parts of the marked vertices (V,) of at least this area [m²], numbered from 1, largest first, (V,)."""
    ends = np.concatenate([surface.faces[:, [0, 1]], surface.faces[:, [1, 2]], surface.faces[:, [2, 0]]])
    ends = ends[lacking[ends].all(axis=1)]
    count = len(lacking)
    graph = coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(count, count))
    _, part = connected_components(graph, directed=False)
    area = np.bincount(part[lacking], surface.areas[lacking], part.max() + 1)
    order = np.argsort(-area, kind="stable")
    number = np.zeros(len(area), dtype=np.int64)
    number[order] = np.where(area[order] >= least, np.arange(1, len(area) + 1), 0)
    return np.where(lacking, number[part], 0)


def _cut(stroke: Stroke, surface: WorkingSurface, lacking: NDArray[np.bool_], free: NDArray[np.bool_]) -> list[Stroke]:
    """The pieces of a stroke over lacking places, joined where the way between them is short and not over target."""
    tree, arc = cKDTree(surface.vertices), stroke.arc
    nearest = tree.query(stroke.points)[1]
    open_ = free[nearest]
    runs: list[tuple[int, int]] = []
    for first, last in _runs(lacking[nearest]):
        if runs and arc[first] - arc[runs[-1][1]] < FARTHEST and open_[runs[-1][1] : first].all():
            runs[-1] = (runs[-1][0], last)
        else:
            runs.append((first, last))
    ways: list[list[Stroke]] = []
    for first, last in runs:
        piece = _rows(stroke, first, last)
        # A line may cross several zones: it goes on where the end of another one is nearest.
        near = sorted(ways, key=lambda way: float(np.linalg.norm(way[-1].points[-1] - piece.points[0])))
        for way in near[:2]:
            turn = _turn(way[-1], piece, surface, tree, free)
            if turn is not None:
                way += [turn, piece]
                break
        else:
            ways.append([piece])
    return [joined for way in ways if (joined := _joined(way)).length >= _SHORTEST]


def _rows(stroke: Stroke, first: int, last: int) -> Stroke:
    """Part of a stroke, both ends included; at least two points."""
    first = min(first, len(stroke.points) - 2)
    rows = slice(first, max(last, first + 1) + 1)
    return stroke.rows(rows)


def _joined(way: Sequence[Stroke]) -> Stroke:
    """Strokes one after the other as one; points that repeat are left out."""
    columns: dict[str, Any] = {name: np.concatenate([getattr(piece, name) for piece in way]) for name in COLUMNS}
    shares = [np.ones(len(piece.points)) if piece.stiffness is None else piece.stiffness for piece in way]
    softer = any(piece.stiffness is not None for piece in way)
    whole = replace(way[0], stiffness=np.concatenate(shares) if softer else None, **columns)
    moved = np.linalg.norm(np.diff(whole.points, axis=0), axis=1) > _SAME
    return whole.rows(np.concatenate(([True], moved)))


def _turn(one: Stroke, other: Stroke, surface: WorkingSurface, tree: cKDTree, free: NDArray[np.bool_]) -> Stroke | None:
    """A bend on the surface from the end of one piece to the start of the next.

    None if it were long, or led over places that are over target, or off the surface, or the tool leaned otherwise.
    """
    start, end = one.points[-1], other.points[0]
    away = float(np.linalg.norm(end - start))
    if not _SAME < away < FARTHEST or one.tilt != other.tilt:
        return None
    leaving, arriving = _direction(one.points[-2:]), _direction(other.points[:2])
    t = np.linspace(0.0, 1.0, int(np.ceil(2.0 * away / _PITCH)) + 1)[1:-1, None]
    points = (1 + 2 * t) * (1 - t) ** 2 * start + t**2 * (3 - 2 * t) * end
    points += 1.5 * away * (t * (1 - t) ** 2 * leaving - t**2 * (1 - t) * arriving)
    _, nearest = tree.query(points)
    normals = (1 - t) * one.normals[-1] + t * other.normals[0]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    own = surface.normals[nearest]
    lift = np.einsum("ij,ij->i", points - surface.vertices[nearest], own)
    if not free[nearest].all() or np.abs(lift).max() > _PITCH or np.einsum("ij,ij->i", own, normals).min() < _ALIKE:
        return None
    level = np.ones(len(points))
    return replace(
        one,
        points=points - lift[:, None] * own,
        normals=normals,
        feed=one.feed[-1] * level,
        force=min(one.force[-1], other.force[0]) * level,
        stiffness=None if one.stiffness is None else one.stiffness[-1] * level,
    )


def _direction(points: Array) -> Array:
    """Unit vector from the first to the last of some points."""
    along = points[-1] - points[0]
    return np.asarray(along / np.linalg.norm(along))


def _runs(marked: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last number of each run of marked points."""
    edge = np.diff(np.concatenate(([0], marked.astype(np.int8), [0])))
    return [(int(a), int(b) - 1) for a, b in zip(np.flatnonzero(edge > 0), np.flatnonzero(edge < 0), strict=True)]


def _gentle(
    dwell: Dwell, surface: WorkingSurface, pieces: Sequence[Stroke], missing: Array, lacking: NDArray[np.bool_]
) -> list[Stroke]:
    """The pieces pressed so gently that lines as slow as their turns remove what lacks on the mean."""
    tried = [replace(piece, feed=np.full(len(piece.points), SLOW * dwell.feed_min)) for piece in pieces]
    share = float(surface.areas[lacking] @ missing[lacking])
    share /= max(float(surface.areas[lacking] @ dwell.depth(surface, tried)[lacking]), 1e-300)
    gentle = [
        replace(piece, force=np.clip(share * piece.force, np.minimum(LEAST_FORCE, piece.force), piece.force))
        for piece in tried
    ]
    return [with_leads(piece, LEAD, min(1.0, LEAST_FORCE / float(piece.force.min()))) for piece in gentle]


def _force(strokes: Sequence[Stroke]) -> float:
    """Largest force of the strokes [N]."""
    return max(float(stroke.force.max()) for stroke in strokes)
