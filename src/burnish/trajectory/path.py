"""A path over a surface: positions with normals to a timed tool reference that keeps its twist exact."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from math import sqrt

import numpy as np

from burnish.core import Array, Dynamics, ToolReference
from burnish.errors import InputError


def tool_rotations(normals: Array, R0: Array) -> Array:
    """The rotations nearest to R0 whose z axes point into the surface: the least turn from z₀ to −n, (N, 3, 3).

    Functions of the normal alone, so the same spot is always met in the same pose:
    ``R = (I + S(w) + S(w)²/(1 + c)) R₀`` with w = z₀ × z and c = z₀·z.

    Raises:
        InputError: if a normal, (N, 3), faces away from the tool by more than 170°.
    """
    z0, z = R0[:, 2], -normals
    c = z @ z0
    if np.any(c < -0.985):
        raise InputError("the surface faces away from the tool's working side by more than 170°")
    w = np.cross(z0, z)
    S = np.zeros((len(z), 3, 3))
    S[:, 2, 1], S[:, 0, 2], S[:, 1, 0] = w.T
    S -= np.swapaxes(S, 1, 2)
    return np.asarray((np.eye(3) + S + S @ S / (1.0 + c)[:, None, None]) @ R0)


def tool_rotation(normal: Array, R0: Array) -> Array:
    """`tool_rotations` of one normal, (3,)."""
    return np.asarray(tool_rotations(normal[None], R0)[0])


@dataclass(frozen=True, kw_only=True)
class TimedPath:
    """A tool path sampled evenly in time: pose, twist, acceleration, normal and force at every node."""

    dt: float
    """Time between nodes [s]."""
    p: Array
    """Tool position, base frame [m], (N, 3)."""
    R: Array
    """Tool rotation, base ← tool, (N, 3, 3)."""
    v: Array
    """Twist, base axes [m/s, rad/s], (N, 6)."""
    a: Array
    """Acceleration, base axes [m/s², rad/s²], (N, 6)."""
    normal: Array
    """Outward unit normal, base axes, (N, 3)."""
    force: Array
    """Wanted contact force [N], (N,)."""
    stiffness: Array | None = None
    """Share of the law's stiffness with which the tool is held, (N,); None: 1 everywhere."""

    @cached_property
    def motion(self) -> Array:
        """Position, twist and acceleration side by side, (N, 15): one row holds what is interpolated."""
        return np.column_stack([self.p, self.v, self.a])

    @property
    def duration(self) -> float:
        """Time from the first to the last node [s]."""
        return self.dt * (len(self.p) - 1)

    def with_ramp(self, ramp: float, settle: float, start: float = 0.0) -> TimedPath:
        """This path after a stand in which the force rises from ``start`` [N] in ``ramp`` and holds for ``settle`` [s].

        A path that begins with no more than ``start`` has nothing to wait for, and is left as it is.
        """
        if self.force[0] <= (1.0 + ALIKE) * start:
            return self
        still, rise = round((ramp + settle) / self.dt), round(ramp / self.dt)
        share = np.minimum(np.arange(still) / max(rise, 1), 1.0)

        def stand(values: Array) -> Array:
            return np.concatenate([np.repeat(values[:1], still, axis=0), values])

        def rest(values: Array) -> Array:
            return np.concatenate([np.zeros((still, values.shape[1])), values])

        return TimedPath(
            dt=self.dt,
            p=stand(self.p),
            R=stand(self.R),
            v=rest(self.v),
            a=rest(self.a),
            normal=stand(self.normal),
            force=np.concatenate([start + share * (self.force[0] - start), self.force]),
            stiffness=None if self.stiffness is None else stand(self.stiffness),
        )


def time_path(
    points: Array,
    normals: Array,
    feed: Array,
    force: Array,
    R0: Array,
    *,
    acceleration: float,
    dt: float = 5e-3,
    axes: Array | None = None,
    tip_radius: float = 0.0,
    stiffness: Array | None = None,
) -> TimedPath:
    """Time a path: as fast as its feed, slower where it bends and where the tool turns, from rest to rest.

    The tip is a sphere; a tool that leans by its axis z still touches c with it, and so its apex is at c + r (n + z).

    Args:
        points: contact points, base frame [m], (N, 3).
        normals: outward unit normals, (N, 3).
        feed: wanted speed at each point [m/s], (N,).
        force: wanted contact force at each point [N], (N,).
        R0: tool rotation about which the tool turns least, (3, 3).
        acceleration: bound of the tangential and of the centripetal acceleration [m/s²].
        dt: time between the nodes of the result [s].
        axes: the tool's axis at each point, unit vectors into the surface, (N, 3); None: along the normal.
        tip_radius: r, radius of the tip [m]; of no account without ``axes``.
        stiffness: share of the law's stiffness at each point, (N,); None: 1 everywhere.

    Raises:
        InputError: if the points are no path.
    """
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if len(points) < 3 or np.any(steps < 1e-9):
        raise InputError("a path needs at least three points, no two neighbours alike")
    s = np.concatenate([[0.0], np.cumsum(steps)])
    axes = -normals if axes is None else axes
    speed = _speed(points, axes, s, feed, acceleration)
    # Between two points the acceleration is constant: the mean speed is the mean of both ends.
    t = np.concatenate([[0.0], np.cumsum(2.0 * steps / (speed[1:] + speed[:-1]))])
    nodes = np.arange(0.0, t[-1] + dt, dt)
    k = np.clip(np.searchsorted(t, nodes, side="right") - 1, 0, len(s) - 2)
    rest = np.clip(nodes - t[k], 0.0, None)
    rate = (speed[k + 1] - speed[k]) / (t[k + 1] - t[k])
    at = np.clip(s[k] + speed[k] * rest + 0.5 * rate * rest**2, 0.0, s[-1])
    c, n, z = (
        _smooth(np.column_stack([np.interp(at, s, rows[:, i]) for i in range(3)]), dt, window)
        for rows, window in ((points, ROUNDED), (normals, TURNED), (axes, TURNED))
    )
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    p, R = c + tip_radius * (n + z), tool_rotations(-z, R0)
    # Over two nodes the tool turns by less than 0.01 rad, where sin θ u is θ u to 1e-7.
    turn = R[2:] @ np.swapaxes(R[:-2], 1, 2)
    omega = np.zeros_like(p)
    omega[1:-1] = _axial(turn) / (2.0 * dt)
    v = np.column_stack([np.gradient(p, dt, axis=0), omega])
    return TimedPath(
        dt=dt,
        p=p,
        R=R,
        v=v,
        a=np.gradient(v, dt, axis=0),
        normal=n,
        force=np.interp(at, s, force),
        stiffness=None if stiffness is None else np.interp(at, s, stiffness),
    )


def feed_share(points: Array, axes: Array, feed: Array) -> float:
    """Mean speed over the path by its feed, where the turning of the tool alone slows it down, 0 to 1.

    Arguments as for `time_path`.
    """
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    return float(np.trapezoid(1.0 / feed, s) / np.trapezoid(1.0 / _turning(axes, s, feed), s))


@dataclass(kw_only=True)
class SurfacePath:
    """Follow a timed path from its start; the source of references for a pass over a surface."""

    path: TimedPath
    """The path."""
    ahead: float = 0.0
    """Look this much ahead [s]: what the arm does late is asked for early."""
    _t0: float = field(default=0.0, init=False, repr=False)

    def reset(self, arm: Dynamics) -> None:
        """Start the clock."""
        self._t0 = arm.t

    def at(self, arm: Dynamics) -> ToolReference:
        """The reference at the instant of ``arm``, linear between nodes; at the end it stands still."""
        path = self.path
        x = (arm.t - self._t0 + self.ahead) / path.dt
        last = len(path.p) - 2
        if x >= last + 1:
            return ToolReference(
                p=path.p[-1],
                R=path.R[-1],
                v=ZERO6,
                a=ZERO6,
                normal=path.normal[-1],
                force=float(path.force[-1]),
                stiffness=1.0 if path.stiffness is None else float(path.stiffness[-1]),
            )
        k = min(int(x), last)
        f = x - k
        here = path.motion[k]
        between = here + f * (path.motion[k + 1] - here)
        near = k + 1 if f > 0.5 else k
        return ToolReference(
            p=between[:3],
            R=path.R[near],
            v=between[3:9],
            a=between[9:],
            normal=path.normal[near],
            force=float(path.force[k]),
            stiffness=1.0 if path.stiffness is None else float(path.stiffness[k]),
        )

    def arrived(self, arm: Dynamics) -> bool:
        """Whether the path is done."""
        return arm.t - self._t0 + self.ahead >= self.path.duration

    def share(self, arm: Dynamics) -> float:
        """Share of the path that is done, 0 to 1."""
        return min(1.0, max(0.0, (arm.t - self._t0) / self.path.duration))


ZERO6 = np.zeros(6)
ALIKE = 1e-6
"""Share by which two forces may differ and count as one: what rounding leaves."""


TURN_RATE = 0.3
"""Largest angular speed of the tool on a path [rad/s]: over a fillet the wrist sets the pace, not the feed."""
ROUNDED, TURNED = 0.05, 0.15
"""Time over which the place of the tool and its axis are averaged [s]. Where a plane goes over into a fillet the tool
has to begin to turn at once, with `TURN_RATE`; within 0.05 s the first joint would be too fast for it."""
START_ACCELERATION = 0.02
"""From rest and to rest [m/s²]: stuck joints break away one after the other, and slowly is gently."""


def _speed(points: Array, axes: Array, s: Array, feed: Array, acceleration: float) -> Array:
    """Speed at each point [m/s]: below the feed, slow in bends and turns, reachable, and gentle at both ends."""
    tangent = np.gradient(points, s, axis=0)
    curvature = np.linalg.norm(np.gradient(tangent, s, axis=0), axis=1)
    speed = np.minimum(feed, np.sqrt(acceleration / np.maximum(curvature, 1e-9)))
    speed = np.minimum(speed, _turning(axes, s, feed))
    # A path in arc length cannot leave rest at speed 0: 1 mm/s is as good.
    speed = np.minimum(speed, 1e-3 + np.sqrt(2.0 * START_ACCELERATION * np.minimum(s, s[-1] - s)))
    steps = np.diff(s)
    for i in range(1, len(s)):
        speed[i] = min(speed[i], sqrt(speed[i - 1] ** 2 + 2.0 * acceleration * steps[i - 1]))
    for i in range(len(s) - 2, -1, -1):
        speed[i] = min(speed[i], sqrt(speed[i + 1] ** 2 + 2.0 * acceleration * steps[i]))
    return np.asarray(speed)


def _turning(axes: Array, s: Array, feed: Array) -> Array:
    """The feed where the tool turns slowly enough, less over crests and fillets [m/s]."""
    turn = np.linalg.norm(np.gradient(axes, s, axis=0), axis=1)
    return np.asarray(np.minimum(feed, TURN_RATE / np.maximum(turn, 1e-9)))


def _axial(R: Array) -> Array:
    """sin θ u of rotations (N, 3, 3), (N, 3)."""
    return 0.5 * np.column_stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]])


def _smooth(values: Array, dt: float, window: float) -> Array:
    """Moving average over ``window`` seconds, ends held: rounds the corners that sampling leaves."""
    half = max(1, round(0.5 * window / dt))
    padded = np.concatenate([np.repeat(values[:1], half, 0), values, np.repeat(values[-1:], half, 0)])
    total = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(padded, axis=0)])
    return np.asarray((total[2 * half + 1 :] - total[: -2 * half - 1]) / (2 * half + 1))
