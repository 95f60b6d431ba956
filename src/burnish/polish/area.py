"""Where the lines of a raster lie: the workable area of a mould, probed, cut into patches and filled with lines."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from typing_extensions import Self

from burnish.core import Array
from burnish.errors import PlanError
from burnish.polish.patches import Patch, Span, decompose, intervals, overlap
from burnish.polish.reach import Reach
from burnish.polish.snake import Row
from burnish.surface import Mould, top

PITCH, MOST_PLACES = 0.8e-3, 400
"""Wanted distance of the probed places [m], and their greatest number along an axis."""

SPARE = 0.25
"""Share of a step that a patch between two others may be wider than its lines. Three eighths of the width of a
contact still remove evenly; one more line in a narrow patch would remove twice as much."""

MOST_LINES = 1500
"""Lines of the largest raster; finer ones take days to run."""

_JUMP = 12e-3
"""Distance in x that the end of a row may move from row to row within a patch [m]: more than the rows of a round
part do near its top."""

_NARROWEST = 2.5
"""Steps that a row must be long: two half circles and something between them."""


@dataclass(frozen=True, kw_only=True)
class Lines:
    """The lines of one patch."""

    y: Array
    """Their places, rising [m], (L,)."""
    spans: list[Span]
    """The interval of probed places that each belongs to."""


@dataclass(frozen=True, kw_only=True)
class Area:
    """The places of a mould that can be worked, on a grid of probes."""

    reach: Reach
    """What a place must fulfil."""
    x: Array
    """Probed places [m], (nx,)."""
    y: Array
    """Probed rows [m], (ny,)."""
    stretch: Array
    """Length on the surface over length in plan across each row and to the next, (ny, nx); 1 where not workable."""
    least: int
    """Places that an interval must have."""
    patches: list[Patch]
    """Parts of the area whose rows are single intervals."""

    @classmethod
    def probed(cls, reach: Reach, mould: Mould, step: float) -> Self:
        """Probe the whole mould for lines that are a step apart."""
        low, high = mould.vertices[:, :2].min(axis=0), mould.vertices[:, :2].max(axis=0)
        x, y = (_places(low[i], high[i]) for i in (0, 1))
        places = _nodes(x, y)
        good = reach.free(places).reshape(len(y), len(x))
        height = np.where(good, top(reach.grid, places)[:, 2].reshape(good.shape), np.nan)
        slope = np.nan_to_num(np.abs(np.diff(height, axis=0)) / (y[1] - y[0]))
        steepest = np.maximum(np.pad(slope, ((1, 0), (0, 0))), np.pad(slope, ((0, 1), (0, 0))))
        pitch = x[1] - x[0]
        least = int(np.ceil(_NARROWEST * step / pitch))
        patches = decompose(good, least, int(np.ceil(_JUMP / pitch)))
        return cls(reach=reach, x=x, y=y, stretch=np.hypot(1.0, steepest), least=least, patches=patches)

    def lines(self, step: float) -> Iterator[Lines]:
        """The lines of each patch: at its ends, and evenly between them on the surface.

        Raises:
            PlanError: there are too many of them.
        """
        for patch in self.patches:
            low = self._limit(patch, -1) if patch.below is None else self._limit(self.patches[patch.below], 1)
            high = self._limit(patch, 1) if patch.above is None else self._limit(self.patches[patch.above], -1)
            if high < low:
                continue
            length, knots = self._length(patch, low, high)
            inner = patch.below is not None or patch.above is not None
            intervals = int(np.ceil(length[-1] / step - (SPARE if inner else 1e-6)))
            if intervals > MOST_LINES:
                raise PlanError(f"a step of {1e3 * step:.3g} mm makes {intervals} lines; expected {MOST_LINES} at most")
            count = np.arange(intervals + 1)[patch.below is not None : intervals + (patch.above is None)]
            y = np.interp(count * length[-1] / max(intervals, 1), length, knots)
            if len(y):
                row = np.clip(np.searchsorted(self.y, y) - patch.first_row, 0, len(patch.spans) - 1)
                yield Lines(y=y, spans=[patch.spans[i] for i in row])

    def rows(self, lines: Lines, trim: float, step: float) -> list[list[Row]]:
        """For each line the intervals of x that can be worked, shortened at both ends for the half circles."""
        good = self.reach.free(_nodes(self.x, lines.y)).reshape(len(lines.y), len(self.x))
        found = [
            (number, span)
            for number, (row, own) in enumerate(zip(good, lines.spans, strict=True))
            for span in intervals(row, 2)
            if overlap(span, own) > 0
        ]
        number = np.array([n for n, _ in found], dtype=np.int64)
        first, last = np.array([span for _, span in found], dtype=np.int64).reshape(-1, 2).T
        low = self._end(first, -1, lines.y[number]) + trim
        high = self._end(last, 1, lines.y[number]) - trim
        rows: list[list[Row]] = [[] for _ in lines.y]
        for k in np.flatnonzero(high - low >= step / 2.0):
            rows[number[k]].append(Row(y=float(lines.y[number[k]]), start=float(low[k]), end=float(high[k])))
        return rows

    def _length(self, patch: Patch, low: float, high: float) -> tuple[Array, Array]:
        """Greatest length on the surface from ``low`` up to each knot in y, (K,), and the knots [m], (K,)."""
        steepest = np.ones(len(self.y))
        for row, (first, last) in enumerate(patch.spans, start=patch.first_row):
            steepest[row] = self.stretch[row, first : last + 1].max()
        knots = np.concatenate(([low], self.y[(self.y > low) & (self.y < high)], [high]))
        rate = np.interp(
            knots, self.y[patch.first_row : patch.last_row + 1], steepest[patch.first_row : patch.last_row + 1]
        )
        length = np.cumsum((rate[1:] + rate[:-1]) / 2.0 * np.diff(knots))
        return np.concatenate(([0.0], length)), knots

    def _limit(self, patch: Patch, side: int) -> float:
        """The outermost y at which a patch still has its row, on its lower (−1) or upper (+1) side [m]."""
        row, span = (patch.first_row, patch.spans[0]) if side < 0 else (patch.last_row, patch.spans[-1])
        inside, outside = self.y[row], self.y[np.clip(row + side, 0, len(self.y) - 1)]
        near = int(np.ceil(_JUMP / 2.0 / (self.x[1] - self.x[0])))
        for _ in range(11):
            middle = (inside + outside) / 2.0
            found = intervals(self.reach.free(_nodes(self.x, np.array([middle]))), self.least)
            fits = any(abs(one[0] - span[0]) <= near and abs(one[1] - span[1]) <= near for one in found)
            inside, outside = (middle, outside) if fits else (inside, middle)
        return float(inside)

    def _end(self, last: NDArray[np.int64], side: int, y: Array) -> Array:
        """Where exactly the intervals end whose last good places these are [m], (K,)."""
        inside, outside = self.x[last], self.x[np.clip(last + side, 0, len(self.x) - 1)]
        for _ in range(8):
            middle = (inside + outside) / 2.0
            good = self.reach.free(np.column_stack((middle, y)))
            inside, outside = np.where(good, middle, inside), np.where(good, outside, middle)
        return inside


def _places(low: float, high: float) -> Array:
    """Evenly spaced places to probe, symmetric in the interval [m]."""
    count = int(np.clip(np.ceil((high - low) / PITCH), 2, MOST_PLACES))
    return np.linspace(low, high, count + 1)


def _nodes(x: Array, y: Array) -> Array:
    """All places of a grid, line by line, (ny · nx, 2)."""
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
