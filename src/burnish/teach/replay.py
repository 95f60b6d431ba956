"""A taught path as a reference: where the tool is to be follows from how far it has come, not from the time."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import sqrt

import numpy as np
from typing_extensions import Self

from burnish.core import Array, Dynamics, ToolReference
from burnish.errors import InputError
from burnish.polish.cell import Placement
from burnish.polish.process import ACCELERATION, SETTLE
from burnish.record.poses_file import Poses
from burnish.rotation import exp, from_quaternion, log
from burnish.teach.cleanup import LEVER, NODE, Piece
from burnish.teach.demonstration import Demonstration
from burnish.trajectory import TimedPath
from burnish.trajectory.path import START_ACCELERATION, TURN_RATE

SPEED_FACTOR = 0.25, 2.0
"""Range of the speed factor."""
SLOWEST = 1e-3
"""Speed at both ends of a track [m/s]: a path in length cannot leave rest at speed 0."""
TURN_ACCELERATION = 0.6
"""Largest angular acceleration of the tool along a piece [rad/s²]: what turns on the spot is not to jerk the wrist."""
PAUSE, RESUME = 0.2, 0.5
"""Time in which a track comes to rest when it is paused, and in which it is up to speed again [s]."""
LEASH = 4e-3, 12e-3
"""Lag along the track from which the reference slows down, and at which it waits [m]."""
NO_LEASH = 1.0, 2.0
"""Lags that no tool comes to [m]: the poses go on without it, as thesis B has them."""
POSES_FEED = 0.02
"""Speed along poses that come without times [m/s]."""
CHECK_PERIOD = 5e-3
"""Time between the nodes of a track that is checked ahead [s]."""


@dataclass(frozen=True, kw_only=True)
class Track:
    """Poses, normals and forces evenly spaced along a path, base frame, and the speed at which each is passed."""

    ds: float
    """Length between nodes [m]."""
    p: Array
    """Tool position [m], (N, 3)."""
    R: Array
    """Tool rotation, base ← tool, (N, 3, 3)."""
    force: Array
    """Force that presses the tool against the normal [N], (N,)."""
    speed: Array
    """Speed along the path [m/s], (N,)."""
    normal: Array | None = None
    """Outward unit normal, (N, 3); None where nothing is pressed."""
    settle: float = 0.0
    """Stand at the start, in whose first half the force rises [s]."""
    leash: tuple[float, float] = LEASH
    """Lag from which the reference slows down, and at which it waits [m]."""
    feed_forward: float = 1.0
    """Share of the path's own acceleration that is asked for; 0 where the poses tremble."""
    slope: Array = field(init=False)
    """Change of position and orientation by length [1, rad/m], (N, 6)."""
    turn: Array = field(init=False)
    """Rotation vector from each node to the next [rad], (N, 3)."""

    def __post_init__(self) -> None:
        if len(self.p) < 3:
            raise InputError(f"a track of {len(self.p)} nodes; expected at least three")
        turn = np.array([log(b @ a.T) for a, b in zip(self.R[:-1], self.R[1:], strict=True)] + [np.zeros(3)])
        object.__setattr__(self, "turn", turn)
        # At the nodes, from the middle of one interval to that of the next.
        spin = 0.5 * (turn + np.vstack([turn[:1], turn[:-1]])) / self.ds
        object.__setattr__(self, "slope", np.column_stack([np.gradient(self.p, self.ds, axis=0), spin]))

    @property
    def length(self) -> float:
        """Of the path [m]."""
        return self.ds * (len(self.p) - 1)

    @classmethod
    def of(cls, piece: Piece, placement: Placement, factor: float = 1.0) -> Self:
        """A piece where the mould stands, ``factor`` times as fast as it was shown, gentle in bends and at its ends."""
        p = placement.points(piece.p)
        return cls(
            ds=piece.ds,
            p=p,
            R=placement.R @ piece.R,
            force=piece.force,
            speed=profile(piece, factor),
            normal=placement.directions(piece.normal) if piece.contact else None,
            settle=SETTLE if piece.contact else 0.0,
        )

    @classmethod
    def by_time(cls, demonstration: Demonstration, placement: Placement, factor: float = 1.0) -> Self:
        """The poses that the operator asked for, as they came in time, and no force: what thesis B replays.

        Its length is time [s], so that its speed is the factor.
        """
        t = demonstration.t
        dt = float(t[-1]) / (len(t) - 1)
        even = dt * np.arange(len(t))
        p = np.column_stack([np.interp(even, t, column) for column in placement.points(demonstration.p_d).T])
        nearest = np.clip(np.rint(np.interp(even, t, np.arange(len(t)))).astype(int), 0, len(t) - 1)
        return cls(
            ds=dt,
            p=p,
            R=placement.R @ demonstration.R_d[nearest],
            force=np.zeros(len(t)),
            speed=np.full(len(t), factor),
            leash=NO_LEASH,
            feed_forward=0.0,
        )

    @classmethod
    def by_poses(cls, poses: Poses, factor: float = 1.0) -> Self:
        """Poses of a file, which has no times: along their length at a constant feed.

        Raises:
            InputError: if they do not move.
        """
        R = np.array([from_quaternion(q) for q in poses.Q])
        turn = np.linalg.norm((R[1:] - R[:-1]).reshape(-1, 9), axis=1) / np.sqrt(2.0)
        steps = np.hypot(np.linalg.norm(np.diff(poses.p, axis=0), axis=1), LEVER * turn)
        length = np.concatenate([[0.0], np.cumsum(steps)])
        if not length[-1] > 3.0 * NODE:
            raise InputError(f"the poses are {1e3 * length[-1]:.3g} mm long; expected a path")
        nodes = np.linspace(0.0, length[-1], int(np.ceil(length[-1] / NODE)) + 1)
        nearest = np.clip(np.searchsorted(length, nodes), 0, len(length) - 1)
        p = np.column_stack([np.interp(nodes, length, column) for column in poses.p.T])
        level = np.full(len(nodes), POSES_FEED * factor)
        speed = _reachable(level, float(nodes[1]), np.full(len(nodes), ACCELERATION))
        return cls(
            ds=float(nodes[1]),
            p=p,
            R=R[nearest],
            force=np.zeros(len(nodes)),
            speed=speed,
            leash=NO_LEASH,
            feed_forward=0.0,
        )

    def timed(self) -> TimedPath:
        """The track as it is passed when nothing holds it up, for a check of reach and joint speed."""
        t = np.concatenate([[0.0], np.cumsum(2.0 * self.ds / (self.speed[1:] + self.speed[:-1]))])
        even = np.arange(0.0, t[-1], CHECK_PERIOD)
        x = np.interp(even, t, np.arange(len(t)))
        k = np.rint(x).astype(int)
        v = self.slope[k] * self.speed[k, None]
        return TimedPath(
            dt=CHECK_PERIOD,
            p=self.p[k],
            R=self.R[k],
            v=v,
            a=np.gradient(v, CHECK_PERIOD, axis=0),
            normal=-self.R[k][:, :, 2] if self.normal is None else self.normal[k],
            force=self.force[k],
        )


@dataclass(kw_only=True)
class Along:
    """The reference on a track: ``ṡ = speed(s) · share``, and p, R, n, f from s alone.

    The share is 1, eased to 0 while paused, and less than 1 while the tool lags: a tool that is held back makes the
    path wait. The force belongs to the place, so it is the same however fast the place is passed.
    """

    track: Track
    """The track."""
    paused: bool = False
    """Whether it shall stand; may be changed at any time."""
    s: float = field(default=0.0, init=False)
    """How far it has come [m]."""
    rate: float = field(default=0.0, init=False)
    """ṡ [m/s]."""
    settled: float = field(default=0.0, init=False)
    """Time that it has stood at the start [s]."""
    _share: float = field(default=1.0, init=False, repr=False)
    _t: float = field(default=0.0, init=False, repr=False)

    def reset(self, arm: Dynamics) -> None:
        """Start from this instant."""
        self._t = arm.t

    def at(self, arm: Dynamics) -> ToolReference:
        """The reference at the instant of ``arm``; at the end it stands still."""
        track = self.track
        dt, self._t = arm.t - self._t, arm.t
        wanted = 0.0 if self.paused else 1.0
        self._share += min(max(wanted - self._share, -dt / PAUSE), dt / RESUME)
        before = self.rate
        if self.settled < track.settle:
            self.settled += dt
        else:
            k = self._node()
            f = self.s / track.ds - k
            # Between nodes the acceleration is constant.
            square = track.speed[k] ** 2 + f * (track.speed[k + 1] ** 2 - track.speed[k] ** 2)
            self.rate = self._share * self._patience(arm, k) * sqrt(float(square))
            self.s = min(self.s + dt * self.rate, track.length)
            if self.s >= track.length:
                self.rate = 0.0
        k = self._node()
        f = self.s / track.ds - k
        growth = (self.rate - before) / dt if dt > 0.0 else 0.0
        slope = track.slope[k] + f * (track.slope[k + 1] - track.slope[k])
        bend = (track.slope[k + 1] - track.slope[k]) / track.ds
        return ToolReference(
            p=track.p[k] + f * (track.p[k + 1] - track.p[k]),
            R=exp(f * track.turn[k]) @ track.R[k],
            v=self.rate * slope,
            a=track.feed_forward * (self.rate**2 * bend + growth * slope),
            normal=None if track.normal is None else track.normal[k],
            force=self._ramp() * float(track.force[k] + f * (track.force[k + 1] - track.force[k])),
        )

    def arrived(self, arm: Dynamics) -> bool:
        """Whether the track is done."""
        return self.s >= self.track.length

    @property
    def standing(self) -> bool:
        """Whether it is paused and has come to rest."""
        return self.paused and self._share <= 0.0

    def _node(self) -> int:
        return min(int(self.s / self.track.ds), len(self.track.p) - 2)

    def _ramp(self) -> float:
        half = 0.5 * self.track.settle
        return 1.0 if half == 0.0 else min(1.0, self.settled / half)

    def _patience(self, arm: Dynamics, k: int) -> float:
        """1, falling to 0 as the tool lags behind along the track."""
        along = self.track.slope[k, :3]
        lag = float(along @ (self.track.p[k] - arm.p)) / max(float(np.linalg.norm(along)), 1e-9)
        soft, hard = self.track.leash
        return min(1.0, max(0.0, (hard - lag) / (hard - soft)))


def profile(piece: Piece, factor: float) -> Array:
    """Speed at each node [m/s]: as shown times ``factor``, slow in bends, turns and at both ends, and reachable."""
    slope, turn = (np.gradient(x.reshape(len(x), -1), piece.ds, axis=0) for x in (piece.p, piece.R))
    # |dR| is √2 dθ.
    bend, twist = (np.linalg.norm(np.gradient(x, piece.ds, axis=0), axis=1) for x in (slope, turn / np.sqrt(2.0)))
    turning = np.linalg.norm(turn, axis=1) / np.sqrt(2.0)
    speed = np.minimum(factor * piece.speed, np.sqrt(ACCELERATION / np.maximum(bend, 1e-9)))
    speed = np.minimum(speed, TURN_RATE / np.maximum(turning, 1e-9))
    speed = np.minimum(speed, np.sqrt(TURN_ACCELERATION / np.maximum(twist, 1e-9)))
    return _reachable(speed, piece.ds, np.minimum(ACCELERATION, TURN_ACCELERATION / np.maximum(turning, 1e-9)))


def _reachable(speed: Array, ds: float, acceleration: Array) -> Array:
    """The speed [m/s] within the acceleration at each node [m/s²], from rest to rest."""
    s = ds * np.arange(len(speed))
    speed = np.minimum(speed, SLOWEST + np.sqrt(2.0 * START_ACCELERATION * np.minimum(s, s[-1] - s)))
    for order in (range(1, len(speed)), range(len(speed) - 2, -1, -1)):
        step = -order.step
        for i in order:
            speed[i] = min(speed[i], sqrt(speed[i + step] ** 2 + 2.0 * acceleration[i] * ds))
    return np.asarray(speed)
