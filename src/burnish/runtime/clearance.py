"""`Clearance`: how far the arm's own parts are from each other, as capsules, looked at no oftener than it can change.

A point of the arm moves no faster than the joints before it times its reach from their axes. So a distance that was
found once bounds all that follow, until the joints have moved by enough to bring it down to where it matters; only then
it is computed anew. Most cycles cost one sum over the joints.
"""

from __future__ import annotations

from math import dist, inf, sqrt
from typing import TypeAlias

import numpy as np

from burnish.core import Array, Dynamics
from burnish.runtime.limits import Limits

Point: TypeAlias = list[float]


AHEAD = 0.02
"""Time by which a motion is looked ahead [s]: short against the way to any turn of it."""


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
        self._ends = limits.capsules[:, 1:7].reshape(-1, 2, 3)
        self._radius = limits.capsules[:, 7].tolist()
        self._pairs = [(int(a), int(b)) for a, b in limits.pairs.tolist()]
        # Of Rodrigues' formula; the cross product of a row of the unit matrix with an axis is a row of K.
        unit = limits.axes[:, :3] / np.linalg.norm(limits.axes[:, :3], axis=1, keepdims=True)
        self._K = np.cross(np.eye(3), unit[:, None, :])
        self._K2 = self._K @ self._K
        self._foot = limits.axes[:, 3:]
        self._reach: list[float] = []
        self._seen: list[float] | None = None
        self._left = 0.0

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

    def closing(self, arm: Dynamics, dq: Array) -> tuple[float, float]:
        """The way to where the arm is braked for being near itself [m], and how fast ``dq``, (n,), closes it [m/s].

        Far from there it is inf, and 0.
        """
        distance = self.at(arm)
        if not distance < self._near:
            return inf, 0.0
        then, _ = self._measured(arm.q + AHEAD * dq, arm.p + AHEAD * arm.J[:3].dot(dq))
        return distance - self._slow, (distance - then) / AHEAD

    def measure(self, arm: Dynamics) -> float:
        """The distance as it is [m]."""
        distance, length = self._measured(arm.q, arm.p)
        self._reach = self._reaches(length)
        return distance

    def _measured(self, joints: Array, tip: Array) -> tuple[float, float]:
        """The distance at joint positions [rad] and the tool point there, and the length of the last capsule [m]."""
        q = joints[:, None, None]
        # Each joint turns all that is beyond it about its axis at q = 0: x ↦ foot + E (x − foot), the last one first.
        E = np.eye(3) + np.sin(q) * self._K + (1.0 - np.cos(q)) * self._K2
        shift = self._foot - (E @ self._foot[:, :, None])[:, :, 0]
        R, p = [np.eye(3)], [np.zeros(3)]
        for turn, step in zip(E, shift, strict=True):
            p.append(p[-1] + R[-1].dot(step))
            R.append(R[-1].dot(turn))
        placed = self._ends @ np.array(R)[self._carrier].transpose(0, 2, 1) + np.array(p)[self._carrier][:, None]
        ends = placed.tolist()
        ends[-1][1] = tip.tolist()
        least: float = min(
            segment_distance(*ends[a], *ends[b]) - self._radius[a] - self._radius[b] for a, b in self._pairs
        )
        return least, dist(*ends[-1])

    def _reaches(self, tool: float) -> list[float]:
        """Furthest that a part beyond each joint can be from that joint's axis [m], by the way along the arm.

        ``tool`` is the length of the last capsule.
        """
        reaches: list[float] = []
        far = dist(self._ends[-1][0], self._foot[-1]) + tool
        for joint in range(len(self._foot), 0, -1):
            here = self._foot[joint - 1]
            if reaches:
                far = reaches[-1] + dist(self._foot[joint], here)
            own = [
                dist(end, here) for k, ends in zip(self._carrier, self._ends, strict=True) if k == joint for end in ends
            ]
            reaches.append(max([far, *own]))
        return reaches[::-1]


def segment_distance(a: Point, b: Point, c: Point, d: Point) -> float:
    """Distance of the segments from a to b and from c to d [m].

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
    return sqrt(x * x + y * y + z * z)


def _share(above: float, below: float) -> float:
    """The quotient, within 0 to 1; 0 where a segment is a point, or both are parallel."""
    if below <= 0.0:
        return 0.0
    return 0.0 if above <= 0.0 else 1.0 if above >= below else above / below
