"""Neighbouring curves joined into one path that the tool follows without lifting, round bends instead of corners."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from burnish.core import Array
from burnish.paths.track import PLAN_PITCH, plan_length

FARTHEST = 3.0
"""Ends are joined if they are at most so many line distances apart."""

_SLANT, _SHARE = 2.5, 1.0 / 6.0
"""Line distances along which a ring goes over into the next one, but at most this share of the ring."""

_PARALLEL = 0.7
"""Least cosine of the angle between two curves that are joined back and forth; more askew, a link had a corner."""

_NARROWEST = 0.5
"""Least distance of two curves that are joined by a half circle, in line distances."""

Free = Callable[[Array], bool]


def joined(levels: Sequence[Sequence[Array]], gap: float, free: Free) -> list[Array]:
    """Join the curves of neighbouring levels, each at most once, where their ends are near and a link has room.

    Args:
        levels: dense curves with their force, (N, 3) each; a closed one ends where it began.
        gap: distance of neighbouring levels in plan [m].
        free: whether the tip may go to all these places (N, 2).

    Returns:
        Dense curves, (N, 3) each; an open curve may run the other way, a ring begins where it suits.
    """
    done: list[Array] = []
    active: list[Array] = []
    for level in levels:
        left = list(level)
        growing = []
        for chain in active:
            following = _following(chain, left, gap, free)
            if following is None:
                done.append(chain)
                continue
            number, longer = following
            del left[number]
            growing.append(longer)
        active = growing + [_opened(curve, 0, gap) if closed(curve) else curve for curve in left]
    return done + active


def closed(curve: Array) -> bool:
    """Whether a curve ends where it began."""
    return len(curve) > 2 and bool(np.allclose(curve[0, :2], curve[-1, :2], atol=1e-9))


def _following(chain: Array, curves: Sequence[Array], gap: float, free: Free) -> tuple[int, Array] | None:
    """The number of the curve that continues a chain, and the chain with it; None if none does."""
    end = chain[-1, :2]
    options: list[tuple[float, int, Array]] = []
    for number, given in enumerate(curves):
        curve = given
        away = np.linalg.norm(curve[:, :2] - end, axis=1)
        if closed(curve):
            near = int(np.argmin(away))
            onward = curve[(near + 4) % (len(curve) - 1), :2] - curve[near, :2]
            if onward @ _heading(chain, -1) < 0.0:
                curve, near = curve[::-1], len(curve) - 1 - near
            options.append(
                (float(away[near]), number, _opened(curve, near + round(_slant(curve, gap) / PLAN_PITCH), gap))
            )
        else:
            options += [(float(away[0]), number, curve), (float(away[-1]), number, curve[::-1])]
    for distance, number, curve in sorted(options, key=lambda option: option[0]):
        if distance > FARTHEST * gap:
            return None
        linked = _linked(chain, curve, gap)
        if linked is not None and free(linked[1][:, :2]):
            return number, np.concatenate(linked)
    return None


def _linked(chain: Array, curve: Array, gap: float) -> tuple[Array, Array, Array] | None:
    """Chain, link and curve, the former and the latter shortened for the link; None if that leaves too little."""
    forward, onward = _heading(chain, -1), _heading(curve, 0)
    if -_PARALLEL < forward @ onward < 0.0:
        return None
    if forward @ onward < 0.0:  # back and forth: a half circle, where both reach equally far
        ahead = float((curve[0, :2] - chain[-1, :2]) @ forward)
        turn = float(np.linalg.norm(curve[0, :2] - chain[-1, :2] - ahead * forward)) / 2.0
        chain, curve = _without_end(chain, turn + max(-ahead, 0.0)), _without_start(curve, turn + max(ahead, 0.0))
        over = curve[0, :2] - chain[-1, :2]  # curves that close up have come nearer to each other by now
        if np.linalg.norm(over) < _NARROWEST * gap or abs(over @ forward) > _PARALLEL * np.linalg.norm(over):
            return None
    elif (curve[0, :2] - chain[-1, :2]) @ forward <= 0.0:
        return None
    if min(plan_length(chain), plan_length(curve)) < gap:
        return None
    return chain, _link(chain, curve), curve


def _link(one: Array, other: Array) -> Array:
    """A cubic from the end of one curve to the start of the other, tangent to both, without those, (N, 3).

    Between opposite directions it is the best cubic for a half circle.
    """
    p, q = one[-1], other[0]
    t, s = _heading(one, -1), _heading(other, 0)
    distance = float(np.linalg.norm(q[:2] - p[:2]))
    handle = distance * (1.0 / 3.0 + (1.0 - t @ s) / 6.0)
    b = np.array([p[:2], p[:2] + handle * t, q[:2] - handle * s, q[:2]])
    u = np.linspace(0.0, 1.0, max(int(np.ceil(2.0 * distance / PLAN_PITCH)), 8) + 1)[1:-1, None]
    xy = (1 - u) ** 3 * b[0] + 3 * u * (1 - u) ** 2 * b[1] + 3 * u**2 * (1 - u) * b[2] + u**3 * b[3]
    return np.column_stack((xy, p[2] + u * (q[2] - p[2])))


def _opened(ring: Array, start: int, gap: float) -> Array:
    """A ring from one of its places on, less the piece in which it goes over into the next one."""
    open_ring = np.roll(ring[:-1], -(start % (len(ring) - 1)), axis=0)
    return _without_end(open_ring, _slant(ring, gap))


def _slant(ring: Array, gap: float) -> float:
    """Length along which a ring goes over into the next one [m]."""
    return min(_SLANT * gap, _SHARE * plan_length(ring))


def _heading(curve: Array, end: int) -> Array:
    """Unit tangent in plan at the start (0) or the end (−1), (2,)."""
    few = min(4, len(curve) - 1)
    way = curve[few, :2] - curve[0, :2] if end == 0 else curve[-1, :2] - curve[-1 - few, :2]
    return np.asarray(way / max(float(np.linalg.norm(way)), np.finfo(float).tiny))


def _without_end(curve: Array, length: float) -> Array:
    arc = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(curve[:, :2], axis=0), axis=1))))
    return curve[: max(int(np.searchsorted(arc, arc[-1] - length, side="right")), 2)]


def _without_start(curve: Array, length: float) -> Array:
    return _without_end(curve[::-1], length)[::-1]
