"""The feed along given strokes that removes what is wanted at every place: least squares on how long the tool dwells.

The depth is linear in the slowness σ = 1/feed along the path, ``h = h₀ + K σ``, with h₀ what the tool removes while it
stands and presses before it moves. Of the profiles that the arm can follow the one is taken that minimises

    Σ w (h₀ + K σ − h_wanted)² / h̄²  +  λ ∫ (a dσ/ds)² ds / (σ̄² L),      σ_fastest ≤ σ ≤ 1/feed_min

by projected gradients with Nesterov's momentum, restarted where it overshoots. Linear because the spindle, not the
feed, makes the sliding speed; a tool that does not spin removes per distance, and its feed changes nothing.

Source: Beck and Teboulle, SIAM J. Imaging Sci. 2 (2009), section 4; O'Donoghue and Candès, Found. Comput. Math. 15
(2015), section 3.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, hstack

from burnish.core import Array
from burnish.errors import PlanError
from burnish.finish.curvature import mean_curvature
from burnish.finish.removal import Removal
from burnish.finish.rubbing import Rubbing, Spindle
from burnish.paths.hertz import contact_radius
from burnish.paths.stroke import Stroke
from burnish.surface import WorkingSurface
from burnish.trajectory import TimedPath
from burnish.trajectory.path import time_path

RAMP, STAND = 0.5, 0.5
"""For how long the force rises, and then stands, before a stroke moves that begins with more than `FIRST` [s]."""
FIRST = 2.0
"""Force with which it begins to rise [N], about what a touch leaves: asked for none, a stiff tip comes off again."""
ACCELERATION = 0.1
"""Along and across a path [m/s²]."""
OUTSIDE = 0.005
"""Weight of a place that is not judged beside one that is: not to be spoilt, but not to be paid for."""
SMOOTHNESS = 1e-3
"""λ. With ten times as much the ends of the lines come out uneven, with a tenth the feed waves for nothing."""
SPINS = 5.0
"""Sliding speed of the spindle, in feeds, from which the removal goes by time."""
_NODES = 1.0 / 3.0
"""Distance of the places at which the feed is free, in contact radii."""
_ROUNDS, _ENOUGH = 400, 1e-5
"""Most rounds of the solver, and the relative change at which it ends."""
_ALL_BUT = 0.99
_DOWN = np.diag([1.0, -1.0, -1.0])


@dataclass(frozen=True, kw_only=True)
class Dwell:
    """A tool that removes by Preston's law, and how fast and slow it may go."""

    law: Removal
    """What a contact removes."""
    spindle: Spindle
    """How the tip turns."""
    feed_min: float = 0.005
    """[m/s]"""
    feed_max: float = 0.08
    """[m/s]"""

    def __post_init__(self) -> None:
        if not 0.0 < self.feed_min < self.feed_max < np.inf:
            raise PlanError(f"feed from {self.feed_min} to {self.feed_max} m/s; expected 0 < least < most")

    def depth(self, surface: WorkingSurface, strokes: Sequence[Stroke]) -> Array:
        """Depth that the strokes remove when they are run as timed, starts, turns and ends included [m], (V,)."""
        total = np.zeros(len(surface.vertices))
        for stroke in strokes:
            path = self._timed(stroke).with_ramp(RAMP, STAND, FIRST)
            axes = path.R[:, :, 2]
            # The apex of a leaning tip is not where it touches.
            contacts = path.p - self.law.tip_radius * (path.normal + axes)
            rubbing = self._rubbing(surface, contacts, path.normal, axes, path.force, path.v[:, :3])
            total += self.law.depth_of(surface, rubbing, np.full(len(path.p), path.dt))
        return total

    def fitted(
        self, surface: WorkingSurface, strokes: Sequence[Stroke], wanted: Array, judged: NDArray[np.bool_]
    ) -> list[Stroke]:
        """The strokes with the feed that removes what is wanted as nearly as the arm can.

        Args:
            surface: vertices that carry the depth.
            strokes: the path; its force stands, its feed is made anew.
            wanted: depth at each vertex [m], (V,); where nothing is to be removed 0 or less.
            judged: vertices that count, (V,).

        Raises:
            PlanError: the tool does not spin fast enough, no vertex counts, or nothing is wanted.
        """
        share = np.where(judged, 1.0, OUTSIDE) * surface.areas
        if not (judged.any() and (wanted[judged] > 0.0).any()):
            raise PlanError("dwell: nothing is wanted on the places that count; expected a positive depth on some")
        tracks = [self._track(surface, stroke) for stroke in strokes]
        stood = sum((track.stood for track in tracks), np.zeros(len(wanted)))
        scale = float(np.sqrt(share @ np.clip(wanted, 0.0, None) ** 2 / share.sum()))
        row = np.sqrt(share / share.sum()) / scale
        matrix = csr_array(hstack([track.rates for track in tracks]).multiply(row[:, None]))
        fastest, slowest = np.concatenate([track.fastest for track in tracks]), 1.0 / self.feed_min
        rough = _differences([len(track.fastest) for track in tracks])
        slowness = _bounded_least_squares(
            matrix, row * (wanted - stood), rough, np.minimum(fastest, slowest), np.full(len(fastest), slowest)
        )
        pieces = np.split(slowness, np.cumsum([len(track.fastest) for track in tracks])[:-1])
        return [
            replace(stroke, feed=1.0 / np.interp(stroke.arc, track.nodes, piece))
            for stroke, track, piece in zip(strokes, tracks, pieces, strict=True)
        ]

    def least(self, surface: WorkingSurface, strokes: Sequence[Stroke], judged: NDArray[np.bool_]) -> float:
        """Least even depth that the strokes can remove [m]: what they remove where the arm, at its fastest, is slowest.

        The deepest hundredth of the area, as around a place where the tool starts, is passed over.
        """
        tracks = [self._track(surface, stroke) for stroke in strokes]
        depth = sum((track.stood + track.rates @ track.fastest for track in tracks), np.zeros(len(judged)))[judged]
        order = np.argsort(depth)
        area = np.cumsum(surface.areas[judged][order])
        return float(depth[order][np.searchsorted(area, _ALL_BUT * area[-1])])

    def _track(self, surface: WorkingSurface, stroke: Stroke) -> _Track:
        """What a stroke removes for its slowness at its nodes."""
        arc, force = stroke.arc, stroke.force
        radius = float(contact_radius(float(np.mean(force)), self.law.tip_radius, 0.0, self.law.modulus))
        slide = self.spindle.speed(radius, stroke.tilt.angle)
        if slide < SPINS * self.feed_max:
            raise PlanError(
                f"dwell: the spindle rubs at {slide:.2f} m/s; expected {SPINS * self.feed_max:.2f} m/s, "
                f"{SPINS:g} times the largest feed: a tool that hardly spins removes by distance, so its feed "
                "cannot set the depth. Raise the spindle rate, or lower the largest feed"
            )
        velocity = self._feeding(stroke)
        rubbing = self._rubbing(surface, stroke.points, stroke.normals, stroke.axes, force, velocity)
        rates = self.law.rates(surface, rubbing)
        nodes = np.linspace(0.0, arc[-1], max(int(np.ceil(arc[-1] / (_NODES * radius))), 2) + 1)
        # Each point stands for half of the path to its neighbours.
        length = np.gradient(arc) * np.where(np.isin(np.arange(len(arc)), (0, len(arc) - 1)), 0.5, 1.0)
        path = self._timed(replace(stroke, feed=np.full(len(arc), self.feed_max)))
        way = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(path.p, axis=0), axis=1))))
        fastest = 1.0 / np.interp(arc, way * arc[-1] / way[-1], np.linalg.norm(path.v[:, :3], axis=1).clip(1e-3))
        spread = _hats(arc, nodes)
        # Where it begins with what a touch leaves, it moves on at once.
        stand = path.with_ramp(RAMP, STAND, FIRST).force[: -len(path.p)]
        return _Track(
            nodes=nodes,
            rates=csr_array(rates.multiply(length) @ spread),
            fastest=np.asarray(np.maximum((spread.T @ fastest) / spread.sum(axis=0).clip(1e-9), 1.0 / self.feed_max)),
            stood=np.asarray(rates[:, [0]].toarray()[:, 0] * (path.dt * stand.sum() / force[0])),
        )

    def _feeding(self, stroke: Stroke) -> Array:
        """Velocity along a stroke at its own feed [m/s], (N, 3); it hardly counts beside the spindle."""
        along = np.gradient(stroke.points, axis=0)
        return np.asarray(stroke.feed[:, None] * along / np.linalg.norm(along, axis=1, keepdims=True).clip(1e-12))

    def _timed(self, stroke: Stroke) -> TimedPath:
        """A stroke in time, in the mould's own frame."""
        return time_path(
            stroke.points,
            stroke.normals,
            stroke.feed,
            stroke.force,
            _DOWN,
            acceleration=ACCELERATION,
            axes=stroke.axes,
            tip_radius=self.law.tip_radius,
        )

    def _rubbing(
        self, surface: WorkingSurface, points: Array, normals: Array, axes: Array, force: Array, v: Array
    ) -> Rubbing:
        """The contacts of a path with a tool whose axes, into the work, are given."""
        radius = float(contact_radius(float(np.max(force)), self.law.tip_radius, 0.0, self.law.modulus))
        return self.spindle.rubbing(
            contacts=points,
            normals=normals,
            force=force,
            velocity=v,
            axes=axes,
            curvature=mean_curvature(surface, points, normals, 1.5 * radius),
        )


@dataclass(frozen=True, kw_only=True)
class _Track:
    """What one stroke removes for its slowness."""

    nodes: Array
    """Places of the slowness along the stroke [m], (J,)."""
    rates: csr_array
    """Depth a slowness [m/(s/m)], (V, J)."""
    fastest: Array
    """Least slowness that the arm can follow [s/m], (J,)."""
    stood: Array
    """Depth while the tool stands at the start [m], (V,)."""


def _hats(arc: Array, nodes: Array) -> csr_array:
    """Linear interpolation from nodes (J,) to places (N,), sparse, (N, J)."""
    k = np.clip(np.searchsorted(nodes, arc, side="right") - 1, 0, len(nodes) - 2)
    share = (arc - nodes[k]) / (nodes[k + 1] - nodes[k])
    rows = np.arange(len(arc))
    return csr_array(
        (np.concatenate((1.0 - share, share)), (np.tile(rows, 2), np.concatenate((k, k + 1)))),
        shape=(len(arc), len(nodes)),
    )


def _differences(counts: Sequence[int]) -> csr_array:
    """Differences of neighbouring nodes of a stroke, in contact radii, √(λ/J) each, sparse."""
    total = sum(counts)
    start = np.delete(np.arange(total), np.cumsum(counts) - 1)
    weight = np.full(len(start), np.sqrt(SMOOTHNESS / total) / _NODES)
    rows = np.tile(np.arange(len(start)), 2)
    values = np.concatenate((-weight, weight))
    return csr_array((values, (rows, np.concatenate((start, start + 1)))), shape=(len(start), total))


def _bounded_least_squares(A: csr_array, b: Array, D: csr_array, low: Array, high: Array) -> Array:
    """The x between low and high that minimises |A x − b|² + |D x|²/x̄², with x̄ the best constant x."""
    one = np.ones(A.shape[1])
    level = A @ one
    mean = float(np.clip(level @ b / max(float(level @ level), 1e-300), low.mean(), high.mean()))
    D = D / mean
    AT, DT = csr_array(A.T), csr_array(D.T)

    def curve(x: Array) -> Array:
        return np.asarray(AT @ (A @ x) + DT @ (D @ x))

    direction = one / np.sqrt(len(one))
    size = 0.0
    for _ in range(20):
        direction = curve(direction)
        size = float(np.linalg.norm(direction))
        direction /= size
    rise = AT @ b
    x = np.clip(mean * one, low, high)
    ahead, momentum = x, 1.0
    for _ in range(_ROUNDS):
        step = np.clip(ahead - (curve(ahead) - rise) / (1.05 * size), low, high)
        change = step - x
        if (ahead - step) @ change > 0.0:  # it overshoots
            momentum = 1.0
        after = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * momentum**2))
        ahead, x, momentum = step + (momentum - 1.0) / after * change, step, after
        if np.abs(change).max() < _ENOUGH * mean:
            break
    return np.asarray(x)
