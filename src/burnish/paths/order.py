"""In which order and direction strokes are run, so that the tool is in the air for a short way.

A tour through the ends of the strokes: from the nearest end to the nearest end first, then pieces of the tour are
turned round while that helps (2-opt, Croes 1958). Between two strokes the tool moves in a straight line here; lifting
and lowering cost the same in any order.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from burnish.core import Array
from burnish.paths.stroke import Stroke

_GAIN = 1e-9
"""Gain below which a change is rounding [m]."""

Tour = tuple[NDArray[np.int64], NDArray[np.bool_]]
"""Numbers of the strokes in order, and which of them are run backwards."""


def ordered(strokes: Sequence[Stroke]) -> list[Stroke]:
    """The same strokes, some run backwards, with an air way that is not longer than in the order given.

    The first stroke may be another one than before: from home the way is nearly the same to all of them.
    """
    if len(strokes) < 2:
        return list(strokes)
    ends = np.array([[stroke.points[0], stroke.points[-1]] for stroke in strokes])
    given: Tour = (np.arange(len(strokes)), np.zeros(len(strokes), dtype=bool))
    tours = [_turned(ends, tour) for tour in (given, _nearest(ends))]
    order, backwards = min(tours, key=lambda tour: _way(ends, tour))
    return [reversed_stroke(strokes[k]) if back else strokes[k] for k, back in zip(order, backwards, strict=True)]


def air_way(strokes: Sequence[Stroke]) -> float:
    """Sum of the distances from the end of each stroke to the start of the next one [m]."""
    return float(sum(np.linalg.norm(after.points[0] - one.points[-1]) for one, after in pairwise(strokes)))


def reversed_stroke(stroke: Stroke) -> Stroke:
    """The same stroke, run the other way."""
    return stroke.rows(slice(None, None, -1))


def _nearest(ends: Array) -> Tour:
    """From the start of the first stroke on, always to the nearest end of those that are left."""
    count = len(ends)
    order, backwards = np.zeros(count, dtype=np.int64), np.zeros(count, dtype=bool)
    left = np.ones(count, dtype=bool)
    left[0] = False
    at = ends[0, 1]
    for k in range(1, count):
        away = np.where(left[:, None], np.linalg.norm(ends - at, axis=2), np.inf)
        order[k], side = np.unravel_index(int(np.argmin(away)), away.shape)
        backwards[k] = side == 1
        left[order[k]] = False
        at = ends[order[k], 1 - int(side)]
    return order, backwards


def _turned(ends: Array, tour: Tour) -> Tour:
    """Turn pieces of a tour round, always the one that gains most, until none gains.

    Turning i … j replaces the ways into i and out of j by those into j's end and out of i's start; at an end of the
    tour there is no such way.
    """
    order, backwards = tour[0].copy(), tour[1].copy()
    count = len(order)
    i, j = np.triu_indices(count)
    while True:
        first = ends[order, backwards.astype(np.int64)]  # where each stroke begins
        last = ends[order, 1 - backwards.astype(np.int64)]
        between = np.linalg.norm(first[None] - last[:, None], axis=2)  # from the end of one to the start of another
        starts = np.linalg.norm(first[None] - first[:, None], axis=2)
        finishes = np.linalg.norm(last[None] - last[:, None], axis=2)
        before, after = np.maximum(i - 1, 0), np.minimum(j + 1, count - 1)
        into = np.where(i > 0, finishes[before, j] - between[before, i], 0.0)
        out = np.where(j < count - 1, starts[i, after] - between[j, after], 0.0)
        best = int(np.argmin(into + out))
        if (into + out)[best] > -_GAIN:
            return order, backwards
        piece = slice(int(i[best]), int(j[best]) + 1)
        order[piece] = order[piece][::-1].copy()
        backwards[piece] = ~backwards[piece][::-1]


def _way(ends: Array, tour: Tour) -> float:
    order, backwards = tour
    side = backwards.astype(np.int64)
    return float(np.linalg.norm(ends[order[1:], side[1:]] - ends[order[:-1], 1 - side[:-1]], axis=1).sum())
