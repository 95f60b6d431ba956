"""How near the arm and its tool come to the mould, its stand and the floor, and to themselves.

A part is a capsule: the axis from one end to the other, with a radius. A point of the axis between two poses moves no
further than the ends do, so a distance that was found once bounds all that follow, and few have to be computed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import coal
import numpy as np
from numpy.typing import NDArray

from burnish.core import Array
from burnish.model.tool import PolishingTool
from burnish.polish.cell import Placement
from burnish.runtime.clearance import segment_distance
from burnish.runtime.limits import Limits
from burnish.surface import Mould

SLACK = 0.5e-3
"""What a least distance may be too large by [m]: so a plateau is not measured at every pose."""
AROUND = 20e-3
"""How far the stand under a mould reaches beyond it [m]. A guess: a plate on which the mould is clamped."""
NAMES = ("base", "shoulder", "upper arm", "forearm", "wrist", "second wrist", "hand")
"""What the capsules of the JACO2 are called, by the joint that moves them."""
_AHEAD = 1024
"""Poses that are looked ahead at a time."""


@dataclass(frozen=True, kw_only=True)
class Part:
    """A capsule of the arm or of its tool, at all poses."""

    name: str
    """What it is called."""
    ends: Array
    """Both ends of its axis, base frame [m], (K, 2, 3)."""
    radius: float
    """[m]."""


@dataclass(frozen=True, kw_only=True)
class Near:
    """The least distance of two things."""

    distance: float
    """[m], to within `SLACK`; negative where they are in each other, and no more than what was asked for."""
    first: str
    """The one."""
    second: str
    """The other."""
    pose: int
    """Number of the pose."""
    or_more: bool
    """Whether they are farther than what was asked for, and the distance was not measured."""


@dataclass(frozen=True, kw_only=True)
class Obstacle:
    """Triangles that stand still."""

    name: str
    """What it is called."""
    mesh: coal.BVHModelOBBRSS
    """The triangles, base frame."""


def mould_obstacles(mould: Mould, placement: Placement) -> list[Obstacle]:
    """The mould where it stands, and the block under it down to the floor."""
    found = [Obstacle(name="mould", mesh=_mesh(placement.points(mould.vertices), mould.faces))]
    height = float(placement.p[2])
    if height > AROUND:
        low, high = mould.vertices.min(axis=0) - AROUND, mould.vertices.max(axis=0) + AROUND
        corners = np.array(
            [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (-height, 0.0)], dtype=float
        )
        found.append(Obstacle(name="stand under the mould", mesh=_mesh(placement.points(corners), _BOX)))
    return found


def arm_parts(limits: Limits, q: Array, tool_point: Array) -> list[Part]:
    """The capsules of the supervisor's limits at joint positions (K, n); the last one goes on to the tool (K, 3).

    Empty where the limits know no capsules of this arm.
    """
    if not len(limits.capsules):
        return []
    R, p = _joints(limits, q)
    parts = []
    for row in limits.capsules:
        joint = int(row[0])
        ends = np.stack([R[:, joint] @ row[a : a + 3] + p[:, joint] for a in (1, 4)], axis=1)
        parts.append(Part(name=NAMES[joint] if len(NAMES) > joint else f"link {joint}", ends=ends, radius=row[7]))
    parts[-1].ends[:, 1] = tool_point
    return parts


def tool_parts(tool: PolishingTool, p: Array, R: Array) -> tuple[Part, Part]:
    """The body of the tool and its tip, from poses of the tip's apex: base frame [m], (K, 3), (K, 3, 3).

    The body is as long as its centre of mass is far out, twice; the capsule ends flush with it.
    """
    axis = R[:, :, 2]
    sensor, centre = p - tool.length * axis, p - tool.tip_radius * axis
    far = max(2.0 * tool.body_com - tool.body_radius, tool.body_radius)
    body = Part(name="tool's body", ends=np.stack([sensor, sensor + far * axis], axis=1), radius=tool.body_radius)
    return body, Part(name="tip", ends=np.stack([centre, centre], axis=1), radius=tool.tip_radius)


def least_to_obstacle(part: Part, obstacle: Obstacle, far: float) -> Near:
    """The least distance of a part to an obstacle over all poses; ``far`` [m] stands for all that is farther."""
    length = float(np.linalg.norm(part.ends[0, 1] - part.ends[0, 0]))  # the same at all poses: a part is rigid
    # A capsule against a mesh takes the engine 60 times as long as its axis, a triangle without width, against it.
    axis = _mesh(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, length], [0.0, 0.0, 0.5 * length]]), np.array([[0, 1, 2]]))
    still, request = coal.Transform3s.Identity(), coal.DistanceRequest(False)

    def distance(k: int) -> float:
        found = coal.DistanceResult()
        coal.distance(axis, _along(part.ends[k]), obstacle.mesh, still, request, found)
        return float(max(found.min_distance, 0.0)) - part.radius

    least, pose = _least([part], distance, far)
    return Near(distance=least, first=part.name, second=obstacle.name, pose=pose, or_more=least >= far)


def least_between(first: Part, second: Part, far: float) -> Near:
    """The least distance of two parts over all poses; ``far`` [m] stands for all that is farther."""

    def distance(k: int) -> float:
        a, b = first.ends[k].tolist(), second.ends[k].tolist()
        return segment_distance(*a, *b) - first.radius - second.radius

    least, pose = _least([first, second], distance, far)
    return Near(distance=least, first=first.name, second=second.name, pose=pose, or_more=least >= far)


def least_to_floor(part: Part, far: float) -> Near:
    """The least height of a part above the plane z = 0, on which the arm's base stands, or ``far`` [m]."""
    height = part.ends[:, :, 2].min(axis=1) - part.radius
    pose = int(np.argmin(height))
    least = min(float(height[pose]), far)
    return Near(distance=least, first=part.name, second="floor", pose=pose, or_more=least >= far)


def _least(parts: Sequence[Part], distance: Callable[[int], float], far: float) -> tuple[float, int]:
    """The least distance, or ``far``, and its pose, from as few distances as it takes."""
    count = len(parts[0].ends)
    k, least, at = 0, far, 0
    while k < count:
        here = distance(k)
        if here < least:
            least, at = here, k
        moved = sum(np.linalg.norm(p.ends[k + 1 : k + _AHEAD] - p.ends[k], axis=2).max(axis=1) for p in parts)
        nearer = np.flatnonzero(here - moved < least - SLACK)
        k += 1 + (int(nearer[0]) if len(nearer) else len(np.atleast_1d(moved)))
    return float(least), at


def _joints(limits: Limits, q: Array) -> tuple[Array, Array]:
    """What carries each joint's links from q = 0 to q: rotations (K, n + 1, 3, 3) and shifts (K, n + 1, 3)."""
    unit = limits.axes[:, :3] / np.linalg.norm(limits.axes[:, :3], axis=1, keepdims=True)
    S = np.cross(np.eye(3), unit[:, None, :])
    foot = limits.axes[:, 3:]
    angle = q[:, :, None, None]
    turn = np.eye(3) + np.sin(angle) * S + (1.0 - np.cos(angle)) * (S @ S)
    R, p = [np.tile(np.eye(3), (len(q), 1, 1))], [np.zeros((len(q), 3))]
    for joint in range(len(foot)):
        shift = foot[joint] - turn[:, joint] @ foot[joint]
        p.append(p[-1] + np.einsum("kij,kj->ki", R[-1], shift))
        R.append(R[-1] @ turn[:, joint])
    return np.stack(R, axis=1), np.stack(p, axis=1)


def _along(ends: Array) -> coal.Transform3s:
    """The frame with its origin at the first end and its z axis towards the second."""
    z = ends[1] - ends[0]
    length = float(np.linalg.norm(z))
    if length == 0.0:
        return coal.Transform3s(np.eye(3), ends[0])
    z = z / length
    x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
    x /= np.linalg.norm(x)
    return coal.Transform3s(np.column_stack([x, np.cross(z, x), z]), ends[0])


def _mesh(vertices: Array, faces: NDArray[np.int64]) -> coal.BVHModelOBBRSS:
    """Triangles in the engine's tree."""
    mesh = coal.BVHModelOBBRSS()
    mesh.beginModel(len(faces), len(vertices))
    mesh.addVertices(np.array(vertices))
    mesh.addTriangles(np.array(faces, dtype=np.int64))
    mesh.endModel()
    return mesh


_BOX = np.array(
    [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4),
     (1, 5, 7), (1, 7, 3)]
)  # fmt: skip
"""Triangles of a box whose corners are numbered in binary by x, y, z."""
