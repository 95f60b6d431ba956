"""The whole way of a job, from home over every stroke and back, as poses: what `moves` and `process` will drive."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from burnish.core import Array
from burnish.paths.stroke import Stroke
from burnish.polish.cell import Placement
from burnish.polish.locate import touch_points
from burnish.polish.moves import CLEARANCE, NEARBY, OVERHEAD
from burnish.rotation import interpolate, log
from burnish.trajectory import TimedPath
from burnish.trajectory.path import tool_rotation

POSE_STEP = 10e-3
"""Motion of the tool from one checked pose to the next [m]."""
POSE_TURN = 0.05
"""Turn of the tool from one checked pose to the next [rad]."""
LOCATED = 1e-3
"""How far a surface lies from where the touches found it [m], as `Moves.find` takes it."""
ABOVE_FIRST = 0.05
"""Height above the first touch to which the arm comes from home [m], as `Moves.find` takes it."""
LIFT = CLEARANCE + 5e-3
"""Height of a lift, besides the uncertainty [m], as `Moves.lift` takes it."""
RISE = 0.05
"""Last rise before the way home [m], as `Job` takes it."""


@dataclass(frozen=True, kw_only=True)
class Leg:
    """A piece of the way: poses close enough to each other to be checked one by one."""

    name: str
    """What it is called in a message."""
    p: Array
    """Position of the tip's apex, base frame [m], (K, 3)."""
    R: Array
    """Rotation, base ← tool, (K, 3, 3)."""
    uncertainty: float
    """How far the surface may lie from where it is believed to be [m]."""
    nodes: NDArray[np.int64] | None = None
    """Of a stroke: the numbers of these poses in its timed path, (K,); None in the air."""


def route(
    strokes: Sequence[Stroke],
    paths: Sequence[TimedPath],
    *,
    placement: Placement,
    upright: Array,
    uncertainty: float,
) -> Iterator[Leg]:
    """The legs in their order: the touches that find the mould, then each stroke and the way to it, and the last rise.

    The way between home and the first and last of these poses is one in joint space.

    Args:
        strokes: along which the mould is touched to find it, mould frame, at least one.
        paths: what is worked, in time, base frame.
        placement: where the mould is meant to stand.
        upright: rotation about which the tool turns least, base ← tool, (3, 3).
        uncertainty: how far the surface may lie from its nominal place before it is found [m].
    """
    points = placement.points(np.concatenate([stroke.points for stroke in strokes]))
    normals = placement.directions(np.concatenate([stroke.normals for stroke in strokes]))
    top = float(points[:, 2].max()) + OVERHEAD
    touches = touch_points(np.concatenate([stroke.points for stroke in strokes]))
    here = (points[touches[0]] + (uncertainty + ABOVE_FIRST) * np.array([0.0, 0.0, 1.0]), upright)
    for number, k in enumerate(touches, 1):
        R = tool_rotation(normals[k], upright)
        above = (points[k] + (uncertainty + CLEARANCE) * normals[k], R)
        name = f"the way to touch {number}"
        yield _air(name, [here, *_across(here, above, top + uncertainty)], uncertainty)
        here = (points[k] + (uncertainty + LIFT) * normals[k], R)
    for number, path in enumerate(paths, 1):
        above = (path.p[0] + (LOCATED + CLEARANCE) * path.normal[0], path.R[0])
        yield _air(f"the way to stroke {number}", [here, *_across(here, above, top + LOCATED)], LOCATED)
        nodes = sparse(path)
        yield Leg(name=f"stroke {number}", p=path.p[nodes], R=path.R[nodes], uncertainty=LOCATED, nodes=nodes)
        here = (path.p[-1] + (LOCATED + LIFT) * path.normal[-1], path.R[-1])
    yield _air("the rise after the last stroke", [here, (here[0] + np.array([0.0, 0.0, RISE]), here[1])], LOCATED)


def sparse(path: TimedPath) -> NDArray[np.int64]:
    """Numbers of the nodes of a path that are one step or one turn apart, first and last included."""
    way = np.linalg.norm(np.diff(path.p, axis=0), axis=1) / POSE_STEP
    turn = np.linalg.norm(np.diff(path.R[:, :, 2], axis=0), axis=1) / POSE_TURN
    run = np.floor(np.concatenate([[0.0], np.cumsum(way + turn)]))
    nodes = np.flatnonzero(np.diff(run, prepend=-1.0) > 0.0)
    return np.unique(np.append(nodes, len(path.p) - 1))


def _across(here: tuple[Array, Array], there: tuple[Array, Array], ceiling: float) -> list[tuple[Array, Array]]:
    """The corners of the way between two poses, as `Moves.across` goes."""
    (p0, R0), (p1, R1) = here, there
    if float(np.linalg.norm(p1[:2] - p0[:2])) <= NEARBY:
        return [there]
    risen = (np.array([p0[0], p0[1], max(p0[2], ceiling)]), R0)
    return [risen, (np.array([p1[0], p1[1], ceiling]), R1), there]


def _air(name: str, corners: Sequence[tuple[Array, Array]], uncertainty: float) -> Leg:
    """Straight lines between corners."""
    p, R = [corners[0][0]], [corners[0][1]]
    for (p0, R0), (p1, R1) in pairwise(corners):
        turn = float(np.linalg.norm(log(R1 @ R0.T)))
        pieces = max(1, int(np.ceil(max(float(np.linalg.norm(p1 - p0)) / POSE_STEP, turn / POSE_TURN))))
        for k in range(1, pieces + 1):
            p.append(p0 + k / pieces * (p1 - p0))
            R.append(interpolate(R0, R1, k / pieces))
    return Leg(name=name, p=np.array(p), R=np.array(R), uncertainty=uncertainty)
