"""What is still to be done of a job: its strokes in passes, less what was skipped or done before a stop."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from burnish.core import Array
from burnish.errors import InputError
from burnish.paths.stroke import Stroke

NODES = 4
"""Points of the shortest piece that can be timed."""
LEAD_IN = 30e-3
"""Way along the path before the place where the work goes on [m]. An arm with friction in its joints lands up to 3 mm
beside the path and needs about a second of motion to be on it."""
LIGHT = 0.6
"""Force on that way [N]: enough for a wrist sensor to feel contact, and 6 % of a usual removal."""
BLEND = 2.5e-3
"""Path over which the force then rises [m]: about what half a contact is wide."""
LEFT_ALONE = 2e-3
"""Rest of a stroke that is not worth another approach [m]: about what half a contact is wide."""


@dataclass(frozen=True, kw_only=True)
class Leg:
    """A stroke, or what is left of it, as one piece of work."""

    number: int
    """Pass it belongs to, from 1."""
    stroke: int
    """Number of the stroke within the pass, from 1."""
    path: Stroke
    """What is to be worked."""
    begun: float = 0.0
    """Path length of the whole stroke at which it begins [m]."""
    lead: float = 0.0
    """How much of it was done before and is passed over lightly, to be on the path where the work goes on [m]."""


def legs_of(passes: Sequence[Sequence[Stroke]]) -> list[Leg]:
    """All strokes of all passes, in order."""
    return [
        Leg(number=n, stroke=k, path=path) for n, strokes in enumerate(passes, 1) for k, path in enumerate(strokes, 1)
    ]


def without(legs: Sequence[Leg], skipped: Collection[int]) -> list[Leg]:
    """The legs less the strokes of these numbers, in every pass.

    Raises:
        InputError: there is no such stroke, or nothing is left.
    """
    known = {leg.stroke for leg in legs}
    strange = sorted(set(skipped) - known)
    if strange:
        raise InputError(
            f"there is no stroke {', '.join(map(str, strange))} to skip; expected numbers from 1 to {max(known)}"
        )
    left = [leg for leg in legs if leg.stroke not in skipped]
    if not left:
        raise InputError(f"all {len(known)} strokes are to be skipped; leave one to be worked")
    return left


def after(legs: Sequence[Leg], number: int, stroke: int, s: float) -> list[Leg]:
    """What is left behind a place of a stroke: the rest of it from path length ``s`` [m] on, and all later legs."""
    rest = [leg for leg in legs if (leg.number, leg.stroke) > (number, stroke)]
    cut = [leg for leg in legs if (leg.number, leg.stroke) == (number, stroke)]
    return [*(piece for leg in cut for piece in _behind(leg, s)), *rest]


def _behind(leg: Leg, s: float) -> list[Leg]:
    """The rest of a leg; nothing where that is not worth an approach."""
    seam = max(0.0, s - leg.begun)
    if leg.path.length - seam < LEFT_ALONE:
        return []
    if seam == 0.0:
        return [leg]
    start = max(0.0, seam - LEAD_IN)
    rest = eased(piece(leg.path, start, leg.path.length), seam - start)
    return [replace(leg, path=rest, begun=leg.begun + start, lead=seam - start)]


def eased(stroke: Stroke, seam: float) -> Stroke:
    """A stroke that is pressed lightly up to ``seam`` [m], and rises to its force within a blend about it."""
    arc = stroke.arc
    at = np.unique(np.concatenate([arc, np.clip(seam + BLEND * np.linspace(-0.5, 0.5, 5), 0.0, arc[-1])]))
    fine = piece(stroke, 0.0, arc[-1], at[np.concatenate([[True], np.diff(at) > 1e-6])])
    share = np.clip((fine.arc - seam) / BLEND + 0.5, 0.0, 1.0)
    light = np.minimum(LIGHT, fine.force)
    return replace(fine, force=light + share * (fine.force - light))


def split(leg: Leg, length: float) -> tuple[Leg, Leg | None]:
    """A leg up to ``length`` [m], and the rest of it; None where the rest is not worth an approach."""
    if leg.path.length - length < LEFT_ALONE:
        return leg, None
    front = replace(leg, path=piece(leg.path, 0.0, length))
    return front, replace(leg, path=piece(leg.path, length, leg.path.length), begun=leg.begun + length)


def piece(stroke: Stroke, first: float, last: float, at: Array | None = None) -> Stroke:
    """The part of a stroke between two path lengths [m], with its own points or those at the lengths ``at``."""
    arc = stroke.arc
    if at is None:
        inner = arc[(arc > first + 1e-6) & (arc < last - 1e-6)]
        at = np.concatenate([[first], inner, [last]])
    if len(at) < NODES:
        at = np.linspace(first, last, NODES)

    def level(values: Array) -> Array:
        return np.interp(at, arc, values)

    normals = np.column_stack([level(column) for column in stroke.normals.T])
    return replace(
        stroke,
        points=np.column_stack([level(column) for column in stroke.points.T]),
        normals=normals / np.linalg.norm(normals, axis=1, keepdims=True),
        feed=level(stroke.feed),
        force=level(stroke.force),
        stiffness=None if stroke.stiffness is None else level(stroke.stiffness),
    )
