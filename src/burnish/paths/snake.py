"""Rows of a raster joined into chains: back and forth, round each end in a half circle."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from burnish.core import Array

PATH_PITCH = 0.25e-3
"""Distance of the places along a chain [m]: a half circle of 1 mm radius keeps to 8 µm."""

_FARTHEST = 3.0
"""Ends of neighbouring rows are joined if they differ by at most so many line distances; the longer row
loses the rest."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """A straight piece of a raster line in plan; it runs from start to end, in either direction."""

    y: float
    """Place of the line [m]."""
    start: float
    """x where it begins [m]."""
    end: float
    """x where it ends [m]."""

    @property
    def side(self) -> float:
        """+1 if it runs along +x, −1 along −x."""
        return 1.0 if self.end > self.start else -1.0

    def reversed(self) -> Row:
        """The same row, run the other way."""
        return replace(self, start=self.end, end=self.start)


def chains(lines: Array, rows: Sequence[Sequence[Row]], free: Callable[[Array], bool]) -> Iterable[list[Row]]:
    """Join the rows of neighbouring lines, each at most once, where their ends are near and a turn has room.

    Args:
        lines: y of the lines, rising [m], (L,).
        rows: the rows of each line, all along +x.
        free: whether the tip may go to all these places (N, 2).

    Yields:
        Rows in the order and direction in which they are run; each ends where the next one's turn begins.
    """
    done: list[list[Row]] = []
    active: list[list[Row]] = []
    for number in range(len(lines)):
        left = list(rows[number])
        growing = []
        for chain in active:
            following = _following(chain, left, free)
            if following is None:
                done.append(chain)
                continue
            row, cut = following
            left.remove(row)
            growing.append([*chain[:-1], *cut])
        active = growing + [[row] for row in left]
    yield from done
    yield from active


def _following(
    chain: list[Row], rows: Sequence[Row], free: Callable[[Array], bool]
) -> tuple[Row, tuple[Row, Row]] | None:
    """The row that continues a chain, and the last and the new row cut to where they turn; None if none does."""
    last = chain[-1]
    for row in sorted(rows, key=lambda row: abs(_end(row, last.side) - last.end)):
        if abs(_end(row, last.side) - last.end) > _FARTHEST * abs(row.y - last.y):
            return None
        turn = min(last.side * last.end, last.side * _end(row, last.side)) * last.side
        back = row.reversed() if last.side > 0.0 else row
        cut = replace(last, end=turn), replace(back, start=turn)
        if all(piece.side == before.side for piece, before in zip(cut, (last, back), strict=True)) and free(
            _turn(*cut)
        ):
            return row, cut
    return None


def _end(row: Row, side: float) -> float:
    """x of the end of a row on the side of +x or −x [m]."""
    return max(row.start, row.end) if side > 0.0 else min(row.start, row.end)


def _turn(one: Row, other: Row) -> Array:
    """Half circle from the end of one row to the start of the next, without those, (N, 2)."""
    radius = (other.y - one.y) / 2.0
    angle = np.linspace(0.0, np.pi, max(int(np.ceil(np.pi * abs(radius) / PATH_PITCH)), 8) + 1)[1:-1]
    x = one.end + one.side * abs(radius) * np.sin(angle)
    return np.column_stack((x, one.y + radius * (1.0 - np.cos(angle))))


def plan_view(chain: Sequence[Row]) -> Array:
    """Closely spaced places along a chain and its turns, (N, 2) [m]."""
    pieces = []
    for number, row in enumerate(chain):
        count = int(np.ceil(abs(row.end - row.start) / PATH_PITCH)) + 1
        pieces.append(np.column_stack((np.linspace(row.start, row.end, count), np.full(count, row.y))))
        if number + 1 < len(chain):
            pieces.append(_turn(row, chain[number + 1]))
    return np.concatenate(pieces)
