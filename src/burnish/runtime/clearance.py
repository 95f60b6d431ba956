"""`Clearance`: how far the arm's own parts are from each other, as capsules, looked at no oftener than it can change.

A point of the arm moves no faster than the joints before it times its reach from their axes. So a distance that was
found once bounds all that follow, until the joints have moved by enough to bring it down to where it matters; only then
it is computed anew. Most cycles cost one sum over the joints.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from math import dist, inf, sqrt
from typing import TypeAlias

import numpy as np

from burnish.core import Array, Dynamics
from burnish.runtime.limits import Limits

Point: TypeAlias = list[float]
Gap: TypeAlias = tuple[float, int, int, float, tuple[float, float, float], float]
"""The distance of two capsules, their numbers, the share along the second one's axis, and of both axes what lies
between their nearest points."""
CLOSE = 1e-6
"""Way below which there is none [m]."""
UNTURNED = np.eye(4)


class Clearance:
    """The least distance of the pairs of capsules of `Limits`."""

    def __init__(self, limits: Limits, near: float | None = None) -> None:
        """Nothing is known until the first look; without pairs nothing is ever near.

        Args:
            limits: what the arm consists of, and how near is too near.
            near: distance from which on it matters [m]; `Limits.self_slow` without it.
        """
        self._near = limits.self_slow if near is None else near
        self._slow = limits.self_slow
        self._carrier = limits.capsules[:, 0].astype(int).tolist()
        ends, radius = limits.capsules[:, 1:7].reshape(-1, 2, 3), limits.capsules[:, 7].tolist()
        # Of each pair first what is nearer to the base.
        pairs = [sorted(map(int, pair), key=lambda k: self._carrier[k]) for pair in limits.pairs.tolist()]
        self._pairs = [(a, b, radius[a] + radius[b]) for a, b in pairs]
        # Of Rodrigues' formula; the cross product of a row of the unit matrix with an axis is a row of K.
        unit = limits.axes[:, :3] / np.linalg.norm(limits.axes[:, :3], axis=1, keepdims=True)
        K, foot = np.cross(np.eye(3), unit[:, None, :]), limits.axes[:, 3:]
        self._sine, self._versine = _turn_about(K, foot), _turn_about(K @ K, foot)
        self._ends = np.concatenate([ends, np.ones((len(ends), 2, 1))], axis=2).transpose(0, 2, 1)
        self._way = [dist(a, b) for a, b in pairwise(foot)]
        self._own = [
            max((dist(end, here) for k, two in zip(self._carrier, ends, strict=True) if k == joint for end in two),
                default=0.0)
            for joint, here in enumerate(foot, 1)
        ]  # fmt: skip
        self._to_tool = dist(ends[-1][0], foot[-1]) if self._pairs else 0.0
        self._reach: list[float] = []
        self._seen: list[float] | None = None
        self._left = 0.0
        self._gaps: list[Gap] = []

    def at(self, arm: Dynamics) -> float:
        """The distance [m], or a bound of it that is not near; negative where two parts run into each other."""
        if not self._pairs:
            return inf
        q = arm.q.tolist()
        if self._seen is not None:
            moved = 0.0
            for now, then, reach in zip(q, self._seen, self._reach, strict=True):
                moved += reach * (now - then if now > then else then - now)
            if moved < self._left:
                return self._near + self._left - moved
        self._seen = q
        distance = self.measure(arm)
        self._left = distance - self._near
        return distance

    def closing(self, arm: Dynamics) -> Callable[[Array], tuple[float, float]]:
        """The way to where the arm is braked for being near itself [m], and how fast q̇, (n,), closes it [m/s]: by q̇.

        Of all the pairs that are near, that which gets there first. Far from there it is inf, and 0.

            ḋ = uᵀ (ẋ − ẏ) = Σᵢ q̇ᵢ uᵀ (vᵢ + ωᵢ × (x − p))

        with the nearest points x and y of a pair, u from y to x, the columns [vᵢ; ωᵢ] of J, and the joints i that move
        x and not y: what moves both changes no distance between them.
        """
        if not self.at(arm) < self._near:
            return lambda dq: (inf, 0.0)
        rows = []
        for distance, a, b, share, (x, y, z), apart in self._gaps:
            if not distance < self._near or apart == 0.0:
                continue
            (x0, y0, z0), (x1, y1, z1) = self._placed[b]
            px, py, pz = self._tip
            rx, ry, rz = x0 + share * (x1 - x0) - px, y0 + share * (y1 - y0) - py, z0 + share * (z1 - z0) - pz
            x, y, z = -x / apart, -y / apart, -z / apart
            moving = slice(self._carrier[a], self._carrier[b])
            along = np.array((x, y, z, ry * z - rz * y, rz * x - rx * z, rx * y - ry * x))
            rows.append((distance - self._slow, moving, along.dot(arm.J[:, moving])))
        return partial(_first, rows)

    def measure(self, arm: Dynamics) -> float:
        """The distance as it is [m]."""
        ends, tip = self._place(arm.q), arm.p.tolist()
        ends[-1][1] = tip
        self._placed, self._tip, self._gaps, least = ends, tip, [], inf
        for a, b, thick in self._pairs:
            _, share, between, apart = nearest(*ends[a], *ends[b])
            self._gaps.append((apart - thick, a, b, share, between, apart))
            if apart - thick < least:
                least = apart - thick
        self._reach = self._reaches(dist(*ends[-1]))
        return least

    def _place(self, q: Array) -> list[list[Point]]:
        """Both ends of the axis of each capsule, base frame [m]; the last one ends where it does at q = 0."""
        turns = (np.sin(q)[:, None, None] * self._sine) + ((1.0 - np.cos(q))[:, None, None] * self._versine)
        pose, poses = UNTURNED, [UNTURNED]
        # Each joint turns all that is beyond it about its axis at q = 0: x ↦ foot + E (x − foot).
        for turn in turns:
            pose = pose + pose.dot(turn)
            poses.append(pose)
        placed: list[list[Point]] = (
            (np.array([poses[k] for k in self._carrier]) @ self._ends)[:, :3].transpose(0, 2, 1).tolist()
        )
        return placed

    def _reaches(self, tool: float) -> list[float]:
        """Furthest that a part beyond each joint can be from that joint's axis [m], by the way along the arm.

        ``tool`` is the length of the last capsule.
        """
        far = max(self._to_tool + tool, self._own[-1])
        reaches = [far]
        for way, own in zip(self._way[::-1], self._own[-2::-1], strict=True):
            far = max(far + way, own)
            reaches.append(far)
        return reaches[::-1]


def _turn_about(K: Array, foot: Array) -> Array:
    """What a turn adds to a pose, (n, 4, 4), of x ↦ K (x − foot)."""
    turn = np.zeros((len(K), 4, 4))
    turn[:, :3, :3], turn[:, :3, 3] = K, -(K @ foot[:, :, None])[:, :, 0]
    return turn


def segment_distance(a: Point, b: Point, c: Point, d: Point) -> float:
    """Distance of the segments from a to b and from c to d [m]."""
    return nearest(a, b, c, d)[3]


def nearest(a: Point, b: Point, c: Point, d: Point) -> tuple[float, float, tuple[float, float, float], float]:
    """Where the segments from a to b and from c to d are nearest: the shares of both, x − y [m], and its length [m].

    Source: Ericson, Real-Time Collision Detection, 5.1.9.
    """
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = d[0] - c[0], d[1] - c[1], d[2] - c[2]
    rx, ry, rz = a[0] - c[0], a[1] - c[1], a[2] - c[2]
    uu, vv, uv = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz, ux * vx + uy * vy + uz * vz
    ur, vr = ux * rx + uy * ry + uz * rz, vx * rx + vy * ry + vz * rz
    square = uu * vv - uv * uv
    s = _share(uv * vr - ur * vv, square)
    t = _share(uv * s + vr, vv)
    # With t at an end, s is the nearest to that end; else it is what it was.
    s = _share(uv * t - ur, uu)
    x, y, z = rx + s * ux - t * vx, ry + s * uy - t * vy, rz + s * uz - t * vz
    return s, t, (x, y, z), sqrt(x * x + y * y + z * z)


def _share(above: float, below: float) -> float:
    """The quotient, within 0 to 1; 0 where a segment is a point, or both are parallel."""
    if below <= 0.0:
        return 0.0
    return 0.0 if above <= 0.0 else 1.0 if above >= below else above / below


def _first(rows: list[tuple[float, slice, Array]], dq: Array) -> tuple[float, float]:
    """Of pairs, each its way, its joints and ∂d/∂q, that which gets there first at q̇, (n,): the way, and how fast."""
    first, way, speed = (False, -inf), inf, 0.0
    for left, moving, row in rows:
        closes = -float(row.dot(dq[moving]))
        # Where none closes, that which is nearest.
        urgent = (True, closes / max(left, CLOSE)) if closes > 0.0 else (False, -left)
        if urgent > first:
            first, way, speed = urgent, left, closes
    return way, speed
