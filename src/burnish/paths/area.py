"""Where the lines of a raster lie: the workable area of a mould, probed, cut into patches and filled with lines."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import Self

from burnish.core import Array
from burnish.errors import PlanError
from burnish.paths.patches import Patch, Span, decompose, intervals, overlap
from burnish.paths.reach import ROUNDING, Reach
from burnish.paths.snake import Row
from burnish.paths.spacing import Spacing, across_curvature, spacing_for
from burnish.surface import Mould, top

PITCH, MOST_PLACES = 0.8e-3, 400
"""Wanted distance of the probed places [m], and their greatest number along an axis."""

SPARE = 0.25
"""Share of a step that a patch between two others may be wider than its lines. Three eighths of the width of a
contact still remove evenly; one more line in a narrow patch would remove twice as much."""

NARROW = 0.4
"""Steps up to which a patch with nothing beside it gets a single line in its middle, because two would turn on the
spot; and up to which a patch beside another one gets none, because it is worked by the next line of that."""

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
    step: Array
    """Greatest distance to the next one that the bend of the surface allows there [m], (L,)."""
    spans: list[Span]
    """The interval of probed places that each belongs to."""


@dataclass(frozen=True, kw_only=True)
class Area:
    """The places of a mould that can be worked, on a grid of probes along the lines and across them."""

    reach: Reach
    """What a place must fulfil."""
    turn: Array
    """Rotation in plan, mould ← lines, (2, 2)."""
    spacing: Spacing
    """How far apart lines lie."""
    x: Array
    """Probed places along the lines [m], (nx,)."""
    y: Array
    """Probed rows [m], (ny,)."""
    step: Array
    """Greatest distance of lines on the surface [m], (ny, nx)."""
    density: Array
    """Lines that are wanted per length across them in plan [1/m], (ny, nx)."""
    least: int
    """Places that an interval must have."""
    patches: list[Patch]
    """Parts of the area whose rows are single intervals."""

    @classmethod
    def probed(cls, reach: Reach, mould: Mould, step: float | None, force: float, angle: float) -> Self:
        """Probe the whole mould.

        Args:
            reach: what a place must fulfil.
            mould: what to work.
            step: distance of lines on the surface [m], or None for 0.3 of the local width of the contact.
            force: normal force, for that width [N].
            angle: of the lines from the mould's x, about z [rad].
        """
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        corners = mould.vertices[:, :2] @ turn
        low, high = corners.min(axis=0), corners.max(axis=0)
        x, y = (probes(low[i], high[i]) for i in (0, 1))
        places = nodes(x, y) @ turn.T
        good = reach.free(places).reshape(len(y), len(x))
        height = np.where(good, top(reach.grid, places)[:, 2].reshape(good.shape), np.nan)
        slope = np.nan_to_num(np.abs(np.diff(height, axis=0)) / (y[1] - y[0]))
        steepest = np.maximum(np.pad(slope, ((1, 0), (0, 0))), np.pad(slope, ((0, 1), (0, 0))))
        bend = np.zeros(good.shape)
        bend[good] = across_curvature(reach, places[good.ravel()], turn[:, 1])
        spacing = spacing_for(reach, step, force, bend[good])
        steps = spacing.at(bend)
        pitch = x[1] - x[0]
        least = int(np.ceil(_NARROWEST * spacing.typical / pitch))
        return cls(
            reach=reach,
            turn=turn,
            spacing=spacing,
            x=x,
            y=y,
            step=steps,
            density=np.where(good, np.hypot(1.0, steepest), 1.0) / steps,
            least=least,
            patches=decompose(good, least, int(np.ceil(_JUMP / pitch))),
        )

    def free(self, xy: Array, slack: float = ROUNDING) -> NDArray[np.bool_]:
        """`Reach.free` for places (N, 2) along the lines and across them [m]."""
        return self.reach.free(xy @ self.turn.T, slack)

    def lines(self) -> Iterator[Lines]:
        """The lines of each patch: at its ends, and evenly between them on the surface.

        Raises:
            PlanError: there are too many of them.
        """
        for patch in self.patches:
            low = self._limit(patch, -1) if patch.below is None else self._limit(self.patches[patch.below], 1)
            high = self._limit(patch, 1) if patch.above is None else self._limit(self.patches[patch.above], -1)
            if high < low:
                continue
            number, knots = self._numbers(patch, low, high)
            inner = patch.below is not None or patch.above is not None
            if inner and number[-1] < NARROW:
                continue
            intervals = int(np.ceil(number[-1] - (SPARE if inner else 1e-6)))
            if intervals > MOST_LINES:
                raise PlanError(
                    f"a step of {1e3 * self.spacing.typical:.3g} mm makes {intervals} lines; "
                    f"expected {MOST_LINES} at most"
                )
            if not inner and number[-1] < NARROW:
                number, intervals = number - number[-1] / 2.0, 0
            count = np.arange(intervals + 1)[patch.below is not None : intervals + (patch.above is None)]
            y = np.interp(count * number[-1] / max(intervals, 1), number, knots)
            if len(y):
                rows = slice(patch.first_row, patch.last_row + 1)
                row = np.clip(np.searchsorted(self.y, y) - patch.first_row, 0, len(patch.spans) - 1)
                step = np.interp(y, self.y[rows], self._over(patch, self.step, np.min))
                yield Lines(y=y, step=step, spans=[patch.spans[i] for i in row])

    def rows(self, lines: Lines, trim: float) -> list[list[Row]]:
        """For each line the intervals of x that can be worked, shortened at both ends for the half circles."""
        good = self.free(nodes(self.x, lines.y)).reshape(len(lines.y), len(self.x))
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
        for k in np.flatnonzero(high - low >= self.spacing.typical / 2.0):
            rows[number[k]].append(Row(y=float(lines.y[number[k]]), start=float(low[k]), end=float(high[k])))
        return rows

    def _numbers(self, patch: Patch, low: float, high: float) -> tuple[Array, Array]:
        """Lines that are wanted from ``low`` up to each knot in y, (K,), and the knots [m], (K,)."""
        rows = slice(patch.first_row, patch.last_row + 1)
        knots = np.concatenate(([low], self.y[(self.y > low) & (self.y < high)], [high]))
        rate = np.interp(knots, self.y[rows], self._over(patch, self.density, np.max))
        number = np.cumsum((rate[1:] + rate[:-1]) / 2.0 * np.diff(knots))
        return np.concatenate(([0.0], number)), knots

    @staticmethod
    def _over(patch: Patch, values: Array, extreme: Callable[[Array], Any]) -> Array:
        """The extreme of values (ny, nx) over each row of a patch."""
        rows = enumerate(patch.spans, start=patch.first_row)
        return np.array([extreme(values[row, first : last + 1]) for row, (first, last) in rows])

    def _limit(self, patch: Patch, side: int) -> float:
        """The outermost y at which a patch still has its row, on its lower (−1) or upper (+1) side [m]."""
        row, span = (patch.first_row, patch.spans[0]) if side < 0 else (patch.last_row, patch.spans[-1])
        inside, outside = self.y[row], self.y[np.clip(row + side, 0, len(self.y) - 1)]
        near = int(np.ceil(_JUMP / 2.0 / (self.x[1] - self.x[0])))
        for _ in range(11):
            middle = (inside + outside) / 2.0
            found = intervals(self.free(nodes(self.x, np.array([middle]))), self.least)
            fits = any(abs(one[0] - span[0]) <= near and abs(one[1] - span[1]) <= near for one in found)
            inside, outside = (middle, outside) if fits else (inside, middle)
        return float(inside)

    def _end(self, last: NDArray[np.int64], side: int, y: Array) -> Array:
        """Where exactly the intervals end whose last good places these are [m], (K,)."""
        inside, outside = self.x[last], self.x[np.clip(last + side, 0, len(self.x) - 1)]
        for _ in range(8):
            middle = (inside + outside) / 2.0
            good = self.free(np.column_stack((middle, y)))
            inside, outside = np.where(good, middle, inside), np.where(good, outside, middle)
        return inside


def probes(low: float, high: float) -> Array:
    """Evenly spaced places to probe, symmetric in the interval [m]."""
    count = int(np.clip(np.ceil((high - low) / PITCH), 2, MOST_PLACES))
    return np.linspace(low, high, count + 1)


def nodes(x: Array, y: Array) -> Array:
    """All places of a grid, line by line, (ny · nx, 2)."""
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
