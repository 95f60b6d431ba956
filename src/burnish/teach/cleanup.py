"""From a demonstration to what can be replayed: pieces by path length, each in contact or free.

Idle ends are trimmed, contacts that were lost for a moment are closed, poses are smoothed over time and then sampled
evenly over the path's length; a path in contact is laid onto the mould, and force and speed are fitted to places.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.signal import savgol_filter

from burnish.core import Array
from burnish.errors import RecordingError
from burnish.model.tool import PolishingTool
from burnish.paths.stroke import Stroke
from burnish.polish.cell import Placement
from burnish.polish.locate import locate
from burnish.rotation import from_quaternion, quaternions
from burnish.surface import DistanceGrid
from burnish.surface.touch import unit
from burnish.teach.demonstration import Demonstration

IDLE_SPEED = 2e-3
"""Speed of the tool below which it stands [m/s]; turning counts by `LEVER`."""
LEVER = 0.1
"""Length that a turn of 1 rad counts [m/rad]: about the distance from the tool's tip to its far end."""
LOST = 0.3
"""A contact lost for less than this is closed, and one that is shorter is none [s]."""
WINDOW = 0.3
"""Time over which poses are smoothed by a parabola [s]: 6 mm at 20 mm/s; a hand corrects itself about as often."""
NODE = 0.5e-3
"""Distance of the nodes of a piece [m]."""
FORCE_SCALE = 2e-3
"""Standard deviation of the weight with which forces nearby count [m]."""
NORMAL_SCALE = 1.5e-3
"""The same of normals and orientations: more than the facets of a fine mesh."""
SHORTEST = 3e-3
"""A piece of contact that is shorter is a touch, not work [m]; a free one is nothing to follow."""
FORCE = 1.5, 20.0
"""Least and greatest force that is replayed [N]: below, contact is soon lost; above, the supervisor is near."""
SPEED = 5e-3, 0.08
"""Least and greatest speed along the surface [m/s]; a hand that rests while it presses is not replayed."""
FREE_SPEED = 5e-3, 0.1
"""The same in free air."""
TOUCHES = 200
"""Most contact poses from which the mould is located."""


@dataclass(frozen=True, kw_only=True)
class Piece:
    """A part of a demonstration that is all contact or all free, sampled evenly over its length; mould frame."""

    contact: bool
    """Whether the tool touches."""
    ds: float
    """Length between the nodes [m]; of a free piece turns count too."""
    p: Array
    """Tool position [m], (N, 3)."""
    R: Array
    """Tool rotation, mould ← tool, (N, 3, 3)."""
    normal: Array
    """Outward unit normal, (N, 3); of a free piece the tool's axis, turned round."""
    force: Array
    """Force that presses the tool against the normal [N], (N,); 0 where it is free."""
    speed: Array
    """Speed by which the length was gone [m/s], (N,)."""
    samples: slice
    """Cycles of the demonstration that it comes from."""
    length: Array
    """Where on the piece each of them lies [m]."""


@dataclass(frozen=True, kw_only=True)
class Taught:
    """What is replayed."""

    demonstration: Demonstration
    """What it was made from."""
    placement: Placement
    """Where the mould stood in the base frame, found from the demonstrated contact; as it was meant to without one."""
    pieces: list[Piece]
    """In order."""

    @property
    def contacts(self) -> list[Piece]:
        """The pieces in contact."""
        return [piece for piece in self.pieces if piece.contact]

    def strokes(self, tip_radius: float) -> list[Stroke]:
        """The pieces in contact as strokes of contact points, mould frame."""
        return [
            Stroke(points=contact_points(piece, tip_radius), normals=piece.normal, feed=piece.speed, force=piece.force)
            for piece in self.contacts
        ]


def cleaned(demonstration: Demonstration, grid: DistanceGrid, tool: PolishingTool) -> Taught:
    """The pieces of a demonstration on a mould.

    Raises:
        RecordingError: if nothing is left of it.
        PlanError: if its contacts do not lie on this mould.
    """
    contact = closed(demonstration.contact, demonstration.t)
    p, Q = smoothed(demonstration)
    if not contact.any():
        raise RecordingError("the demonstration never touches the mould; press the tool against it while recording")
    placement = located(demonstration, contact, grid, tool)
    # From the frame of the mould as it was meant to stand into that of the mould as it stood.
    R_change = placement.R.T @ demonstration.placement.R
    moved = placement.R.T @ (demonstration.placement.p - placement.p)
    p, force = p @ R_change.T + moved, demonstration.F[:, :3] @ R_change.T
    R = R_change @ np.array([from_quaternion(q) for q in Q])
    first, last = busy(p, R, demonstration.t, contact)
    pieces = []
    for samples in runs(contact, first, last):
        rows = (demonstration.t[samples], p[samples], R[samples])
        if contact[samples.start]:
            piece = _contact_piece(*rows, force[samples], samples, grid, tool)
        else:
            piece = _free_piece(*rows, samples)
        if piece is not None:
            pieces.append(piece)
    if not any(piece.contact for piece in pieces):
        raise RecordingError(f"no contact of the demonstration is longer than {1e3 * SHORTEST:g} mm; slide the tool")
    return Taught(demonstration=demonstration, placement=placement, pieces=pieces)


def closed(contact: NDArray[np.bool_], t: Array) -> NDArray[np.bool_]:
    """Contact without the moments in which it was lost, then without the moments in which it was there."""
    result = contact.copy()
    for state in (False, True):
        for run in _equal_runs(result):
            inside = state or (run.start > 0 and run.stop < len(result))
            if result[run.start] == state and inside and t[run.stop - 1] - t[run.start] < LOST:
                result[run] = not state
    return result


def runs(contact: NDArray[np.bool_], first: int, last: int) -> list[slice]:
    """Stretches of equal contact from cycle ``first`` to ``last``, both included."""
    return [slice(run.start + first, run.stop + first) for run in _equal_runs(contact[first : last + 1])]


def smoothed(demonstration: Demonstration) -> tuple[Array, Array]:
    """Positions [m], (N, 3), and quaternions [η, ε], (N, 4), fitted by a parabola over `WINDOW`."""
    Q = quaternions(demonstration.R)
    # The same rotation has two quaternions; neighbours are to be alike.
    sign = np.cumprod(np.where(np.einsum("ij,ij->i", Q[1:], Q[:-1]) < 0.0, -1.0, 1.0))
    Q[1:] *= sign[:, None]
    dt = float(np.median(np.diff(demonstration.t)))
    width = 2 * (max(int(WINDOW / dt), 4) // 2) + 1
    width = min(width, 2 * ((len(Q) - 1) // 2) + 1)
    fitted = savgol_filter(np.column_stack([demonstration.p, Q]), width, 2, axis=0)
    return fitted[:, :3], unit(fitted[:, 3:])


def busy(p: Array, R: Array, t: Array, contact: NDArray[np.bool_]) -> tuple[int, int]:
    """First and last cycle between which the tool moves or touches.

    Raises:
        RecordingError: if it never does.
    """
    moving = np.append(_steps(p, R) > IDLE_SPEED * np.diff(t), False) | contact
    if not moving.any():
        raise RecordingError("the tool stands still in the whole demonstration; teach again")
    return int(np.argmax(moving)), len(moving) - 1 - int(np.argmax(moving[::-1]))


def located(
    demonstration: Demonstration, contact: NDArray[np.bool_], grid: DistanceGrid, tool: PolishingTool
) -> Placement:
    """Where the mould stood, from the tip's centre wherever it touched.

    Raises:
        PlanError: if the contacts do not lie on this mould.
    """
    rows = np.flatnonzero(contact & demonstration.contact)
    rows = rows[:: max(1, len(rows) // TOUCHES)]
    axis = demonstration.R[rows][:, :, 2]
    pressed = np.maximum(0.0, -np.einsum("ij,ij->i", axis, demonstration.F[rows, :3])) / tool.stiffness
    centre = demonstration.p[rows] - (tool.tip_radius + pressed)[:, None] * axis
    return locate(grid, demonstration.placement, demonstration.placement.points(centre), tool.tip_radius)


def on_surface(grid: DistanceGrid, centre: Array, radius: float) -> tuple[Array, Array]:
    """Centres of the tip (N, 3) moved along the gradient onto φ = r, and the outward unit normals there."""
    for _ in range(4):
        distance, gradient = grid.at(centre)
        centre = centre - ((distance - radius) / np.einsum("ij,ij->i", gradient, gradient))[:, None] * gradient
    return centre, unit(grid.at(centre)[1])


def contact_points(piece: Piece, tip_radius: float) -> Array:
    """Where the tip of a piece touches the mould, mould frame [m], (N, 3)."""
    return np.asarray(piece.p - tip_radius * (piece.R[:, :, 2] + piece.normal))


def clear_of(piece: Piece, gap: Array, clear: float) -> Piece | None:
    """A free piece without its ends that are nearer to the mould than ``clear``; None if no way is left.

    Args:
        piece: a free piece.
        gap: distance of the tip from the mould at its nodes [m], (N,).
        clear: wanted distance [m].
    """
    away = np.flatnonzero(gap > clear)
    if len(away) == 0 or (away[-1] - away[0]) * piece.ds < SHORTEST:
        return None
    keep = slice(int(away[0]), int(away[-1]) + 1)
    parts = {name: getattr(piece, name)[keep] for name in ("p", "R", "normal", "force", "speed")}
    return replace(piece, length=piece.length - keep.start * piece.ds, **parts)


def _contact_piece(
    t: Array, p: Array, R: Array, F: Array, samples: slice, grid: DistanceGrid, tool: PolishingTool
) -> Piece | None:
    """A contact laid onto the mould; None if it is no longer than a touch."""
    r = tool.tip_radius
    centre, n = on_surface(grid, p - r * R[:, :, 2], r)
    point = centre - r * n
    length, nodes = _lengths(np.linalg.norm(np.diff(point, axis=0), axis=1), t)
    if nodes is None:
        return None
    R = _rotations(R, length, nodes)
    centre, normal = on_surface(grid, _at(nodes, length, centre), r)
    normal = unit(gaussian_filter1d(normal, NORMAL_SCALE / NODE, axis=0, mode="nearest"))
    pressing = np.einsum("ij,ij->i", F, n)
    return Piece(
        contact=True,
        ds=float(nodes[1]),
        p=centre + r * R[:, :, 2],
        R=R,
        normal=normal,
        force=np.clip(_fitted(length, pressing, nodes), *FORCE),
        speed=_speed(length, t, nodes, SPEED),
        samples=samples,
        length=length,
    )


def _free_piece(t: Array, p: Array, R: Array, samples: slice) -> Piece | None:
    """A way through the air; None if it is none."""
    length, nodes = _lengths(_steps(p, R), t)
    if nodes is None:
        return None
    R = _rotations(R, length, nodes)
    return Piece(
        contact=False,
        ds=float(nodes[1]),
        p=_at(nodes, length, p),
        R=R,
        normal=-R[:, :, 2],
        force=np.zeros(len(nodes)),
        speed=_speed(length, t, nodes, FREE_SPEED),
        samples=samples,
        length=length,
    )


def _lengths(steps: Array, t: Array) -> tuple[Array, Array | None]:
    """Length up to each cycle, standing still left out, and the nodes; None if it is too short to follow."""
    gone = np.where(steps > 0.5 * IDLE_SPEED * np.diff(t), steps, 0.0)
    length = np.concatenate([[0.0], np.cumsum(gone)])
    if length[-1] < SHORTEST:
        return length, None
    return length, np.linspace(0.0, length[-1], int(np.ceil(length[-1] / NODE)) + 1)


def _steps(p: Array, R: Array) -> Array:
    """Length from each cycle to the next, turns included [m], (N − 1,)."""
    # |R₁ − R₀| is √8 sin(θ/2), √2 θ for small steps.
    turn = np.linalg.norm((R[1:] - R[:-1]).reshape(-1, 9), axis=1) / np.sqrt(2.0)
    return np.asarray(np.hypot(np.linalg.norm(np.diff(p, axis=0), axis=1), LEVER * turn))


def _at(nodes: Array, length: Array, values: Array) -> Array:
    """Values of the cycles at the nodes, linear in length, (N, k)."""
    return np.column_stack([np.interp(nodes, length, column) for column in values.T])


def _rotations(R: Array, length: Array, nodes: Array) -> Array:
    """Rotations at the nodes, smoothed over length: a tool may turn where it stands, (N, 3, 3)."""
    Q = quaternions(R)
    sign = np.cumprod(np.where(np.einsum("ij,ij->i", Q[1:], Q[:-1]) < 0.0, -1.0, 1.0))
    Q[1:] *= sign[:, None]
    Q = gaussian_filter1d(_at(nodes, length, Q), NORMAL_SCALE / nodes[1], axis=0, mode="nearest")
    return np.array([from_quaternion(q) for q in unit(Q)])


def _fitted(length: Array, values: Array, nodes: Array) -> Array:
    """Mean of the values about each node, by a normal weight over length, (N,).

    A cycle counts by the way it went, so that one who stands still while the force changes does not count.
    """
    nearest = np.rint(length / nodes[1]).astype(np.int64)
    gone = gone_by(length)
    weight, total = (np.bincount(nearest, x, len(nodes)) for x in (gone, gone * values))
    # Where no cycle fell into a node it borrows from its neighbours.
    weight, total = (gaussian_filter1d(x, FORCE_SCALE / nodes[1], mode="nearest") for x in (weight, total))
    return np.asarray(total / np.maximum(weight, 1e-12))


def gone_by(length: Array) -> Array:
    """Way that belongs to each cycle: half of those before and after it [m], (N,)."""
    return np.gradient(length) + 1e-9


def _speed(length: Array, t: Array, nodes: Array, limits: tuple[float, float]) -> Array:
    """Speed at the nodes from the time that was spent moving about them [m/s], (N,)."""
    pace = np.diff(length) / np.diff(t)
    moving = pace > IDLE_SPEED
    if not moving.any():
        return np.full(len(nodes), limits[0])
    middle = 0.5 * (length[1:] + length[:-1])
    return np.clip(_fitted(middle[moving], pace[moving], nodes), *limits)


def _equal_runs(flags: NDArray[np.bool_]) -> list[slice]:
    """Stretches of equal flags."""
    edges = [0, *(np.flatnonzero(np.diff(flags)) + 1).tolist(), len(flags)]
    return [slice(a, b) for a, b in pairwise(edges) if b > a]
