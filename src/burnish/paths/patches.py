"""A probed area cut into patches whose rows are single intervals, so that each can be worked back and forth.

Going up in y, a patch ends where its row splits round a hole or a pocket, where it merges with another one, or
where its end jumps. There the wider row belongs to its own patch; the narrower patch continues from it and has no
row of its own at that place.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Span = tuple[int, int]
"""First and last good place of a row."""


@dataclass(kw_only=True)
class Patch:
    """Rows that lie on top of each other; grows while the area is swept."""

    first_row: int
    """Number of its lowest row."""
    spans: list[Span]
    """The interval of each row."""
    below: int | None = field(default=None)
    """Number of the wider patch that it continues from; None where it has an end of its own."""
    above: int | None = field(default=None)
    """Number of the wider patch that continues it; None where it has an end of its own."""

    @property
    def last_row(self) -> int:
        """Number of its highest row."""
        return self.first_row + len(self.spans) - 1


def decompose(good: NDArray[np.bool_], least: int, jump: int) -> list[Patch]:
    """Patches of the places that are good.

    Args:
        good: whether each place can be worked, rows first, (ny, nx).
        least: places that an interval must have to count.
        jump: places by which the end of a row may move to the next one of its patch.
    """
    patches: list[Patch] = []
    active: list[int] = []
    for number, row in enumerate(good):
        spans = intervals(row, least)
        parents = [[c for c in active if overlap(patches[c].spans[-1], span) > 0] for span in spans]
        children = {c: sum(c in group for group in parents) for c in active}
        active = []
        for span, group in zip(spans, parents, strict=True):
            if len(group) == 1 and children[group[0]] == 1 and _near(patches[group[0]].spans[-1], span, jump):
                patches[group[0]].spans.append(span)
                active.append(group[0])
                continue
            patch = Patch(first_row=number, spans=[span])
            only = [c for c in group if children[c] == 1]
            if len(group) == 1 and (not only or _width(span) < _width(patches[only[0]].spans[-1])):
                patch.below = group[0]
            for c in only if patch.below is None else []:
                patches[c].above = len(patches)
            active.append(len(patches))
            patches.append(patch)
    return patches


def intervals(row: NDArray[np.bool_], least: int) -> list[Span]:
    """Runs of at least so many good places."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], row.astype(np.int8), [0]))))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a >= least]


def overlap(one: Span, other: Span) -> int:
    """Number of places that two intervals share; not positive if none."""
    return min(one[1], other[1]) - max(one[0], other[0]) + 1


def _near(one: Span, other: Span, jump: int) -> bool:
    return abs(one[0] - other[0]) <= jump and abs(one[1] - other[1]) <= jump


def _width(span: Span) -> int:
    return span[1] - span[0]
