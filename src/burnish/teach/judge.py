"""How well a replay held what was shown: by the true contact, which nobody but the simulator knows."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from burnish.core import Array, Sample
from burnish.polish.cell import Placement
from burnish.sim.truth import Truth
from burnish.teach.cleanup import Piece, Taught, contact_points, gone_by
from burnish.teach.replay import Along


@dataclass(kw_only=True)
class ReplayLog:
    """Where on which piece the reference was at each cycle."""

    t: list[float] = field(default_factory=list)
    measured: list[float] = field(default_factory=list)
    """Force that was felt along the tool's axis [N]."""
    repeat: list[int] = field(default_factory=list)
    """Number of the repeat, from 1; 0 where nothing was followed."""
    piece: list[int] = field(default_factory=list)
    s: list[float] = field(default_factory=list)
    """How far along it [m]; −1 while the force still rises."""

    def add(self, sample: Sample, repeat: int, piece: int, s: float) -> None:
        """Append one cycle."""
        arm = sample.arm
        self.t.append(arm.t)
        self.measured.append(np.nan if arm.F is None else -float(arm.R[:, 2] @ arm.F[:3]))
        self.repeat.append(repeat)
        self.piece.append(piece)
        self.s.append(s)


@dataclass(frozen=True, kw_only=True)
class Followed:
    """What really happened at the cycles that belong to places of pieces in contact; all arrays of M rows."""

    repeat: NDArray[np.int64]
    """Number of the repeat, from 1."""
    t: Array
    """Time [s]."""
    along: Array
    """Length along all pieces in contact, one behind the other [m]."""
    force: Array
    """True normal force [N]."""
    shown: Array
    """Force that was shown there [N]."""
    aside: Array
    """Distance of the true contact from that which was shown, over the surface [m]; NaN where it was lost."""
    ahead: Array
    """Its part along the path [m]."""

    def figures(self) -> dict[str, float]:
        """Force and position over all repeats, and of the worst one."""
        numbers = np.unique(self.repeat)
        each = [_rms(self.force[self.repeat == k] - self.shown[self.repeat == k]) for k in numbers]
        aside = [_rms(self.aside[self.repeat == k]) for k in numbers]
        return {
            "force_rms_N": _rms(self.force - self.shown),
            "force_rms_worst_N": max(each),
            "force_p99_N": float(np.percentile(np.abs(self.force - self.shown), 99.0)),
            "position_rms_mm": 1e3 * _rms(self.aside),
            "position_rms_worst_mm": 1e3 * max(aside),
            "contact_lost_pct": 100.0 * float(np.mean(np.isnan(self.aside))),
            "repeats": len(numbers),
        }


@dataclass(frozen=True, kw_only=True)
class Shown:
    """What was shown on each piece in contact, at the nodes of its length, in the frame of the mould as it stood."""

    point: list[Array]
    """Points of contact [m], (N, 3) each."""
    force: list[Array]
    """Normal force [N], (N,) each."""


def as_cleaned(taught: Taught, tip_radius: float) -> Shown:
    """What was shown as the clean-up has it, from what was measured."""
    contacts = taught.contacts
    return Shown(point=[contact_points(piece, tip_radius) for piece in contacts], force=[p.force for p in contacts])


def as_happened(taught: Taught, truth: Truth, first: int) -> Shown:
    """What really happened in the demonstration, averaged over the cycles that belong to each node.

    Args:
        taught: the cleaned demonstration.
        truth: of the run in which it was shown.
        first: its first cycle in that run.
    """
    force, point = truth.cycle_force(), np.asarray(truth.point)
    points, forces = [], []
    for piece in taught.contacts:
        # Row k of the truth is what happened up to the measurement of cycle k + 1.
        rows = np.arange(piece.samples.start, piece.samples.stop) + first - 1
        nodes: Array = piece.ds * np.arange(len(piece.p), dtype=np.float64)
        there = np.isfinite(point[rows, 0])
        points.append(np.column_stack([_mean_at(nodes, piece.length[there], x) for x in point[rows[there]].T]))
        forces.append(_mean_at(nodes, piece.length, force[rows]))
    return Shown(point=points, force=forces)


def followed(log: ReplayLog, truth: Truth, point: Array, pieces: list[Piece], shown: Shown) -> Followed:
    """Compare every cycle of a replay that belongs to a place with what was shown there.

    Args:
        log: of the replay.
        truth: of its simulation.
        point: its true contacts, in the frame that ``shown`` is in [m], (K, 3), a row a cycle of the truth.
        pieces: what was replayed.
        shown: what it is compared with.
    """
    repeat, piece, s = (np.asarray(x) for x in (log.repeat, log.piece, log.s))
    # The reference of cycle k acts from then on; what comes of it is in the truth at the measurement of cycle k + 1.
    rows = np.searchsorted(np.asarray(truth.time), np.asarray(log.t)) + 1
    kept = (repeat > 0) & (s >= 0.0) & (rows < len(truth.time))
    order = {k: i for i, k in enumerate(k for k, p in enumerate(pieces) if p.contact)}
    kept &= np.isin(piece, list(order))
    force, t = truth.cycle_force(), np.asarray(truth.time)
    parts = []
    offset = 0.0
    for number, i in order.items():
        mine = np.flatnonzero(kept & (piece == number))
        nodes = pieces[number].ds * np.arange(len(pieces[number].p))
        where = np.column_stack([np.interp(s[mine], nodes, x) for x in shown.point[i].T])
        tangent = np.gradient(shown.point[i], nodes, axis=0)
        k = np.clip(np.rint(s[mine] / nodes[1]).astype(int), 0, len(nodes) - 1)
        normal = pieces[number].normal[k]
        off = point[rows[mine]] - where
        off = off - np.einsum("ij,ij->i", off, normal)[:, None] * normal
        ahead = np.einsum("ij,ij->i", off, tangent[k])
        parts.append(
            (repeat[mine], t[rows[mine]], offset + s[mine], force[rows[mine]],
             np.interp(s[mine], nodes, shown.force[i]), np.linalg.norm(off, axis=1), ahead)
        )  # fmt: skip
        offset += float(nodes[-1])
    joined = [np.concatenate(column) for column in zip(*parts, strict=True)]
    by_time = np.argsort(joined[1], kind="stable")
    names = ("repeat", "t", "along", "force", "shown", "aside", "ahead")
    return Followed(**{name: column[by_time] for name, column in zip(names, joined, strict=True)})


def nearest(taught: Taught, along: Along | None) -> tuple[int, float]:
    """Piece and length that belong to a replay by time: those of the demonstration's cycle; −1 where it was free."""
    if along is None:
        return 0, -1.0
    cycle = round(along.s / along.track.ds)
    for number, piece in enumerate(taught.pieces):
        if piece.contact and piece.samples.start <= cycle < piece.samples.stop:
            return number, float(piece.length[cycle - piece.samples.start])
    return 0, -1.0


def seen_from(point: Array, stands: Placement, found: Placement) -> Array:
    """Points in the frame of the mould where it really stands, in the frame where it was found [m], (K, 3)."""
    return np.asarray((stands.points(point) - found.p) @ found.R)


def _mean_at(nodes: Array, length: Array, values: Array) -> Array:
    """Mean of the values that belong to each node, weighted by way, (N,); between nodes without any, linear."""
    nearest, gone = np.rint(length / nodes[1]).astype(np.int64), gone_by(length)
    weight, total = (np.bincount(nearest, x, len(nodes)) for x in (gone, gone * values))
    there = weight > 0.0
    return np.interp(nodes, nodes[there], total[there] / weight[there])


def _rms(values: Array) -> float:
    good = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(good**2))) if len(good) else float("nan")
