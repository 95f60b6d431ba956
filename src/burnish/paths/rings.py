"""Patterns whose lines follow the part: offsets of its border, turns about its middle, distances over its surface.

Each is a field over the workable places. Its lines are curves of equal value, so close that nowhere more than the
step lies between two of them, joined from value to value.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from burnish.core import Array
from burnish.paths.geodesic import distance_over, longest_row
from burnish.paths.hem import INSIDE, directions, hem, room, strokes_along
from burnish.paths.joins import closed, joined
from burnish.paths.raster import check, required
from burnish.paths.reach import Reach
from burnish.paths.sheet import Count, Sheet, level_curves
from burnish.paths.spacing import Spacing, across_curvature, spacing_for
from burnish.paths.stroke import Stroke
from burnish.paths.track import TURN_SLACK, broken, dense
from burnish.surface import Mould

_SHORTEST_PIECE = 2.5
"""Lines that a piece is long at least if it may become a part of a stroke: two half circles and something between."""

_PER_TURN = 180
"""Corners of a turn of a spiral: at 50 mm a chord misses the arc by 8 µm."""


@dataclass(frozen=True, kw_only=True)
class Contour:
    """Offsets of the border, in plan, from the outside in; each ring goes over into the next one."""

    def strokes(self, reach: Reach, mould: Mould, *, step: float | None, feed: float, force: float) -> list[Stroke]:
        """See :class:`Pattern`."""
        check(tip_radius=reach.tip_radius, step=step, feed=feed, force=force)
        sheet = Sheet.of(reach, mould)
        inset = sheet.inset
        across = directions(inset, sheet)
        bend, stretch = np.zeros(inset.shape), sheet.stretch(across)
        bend[sheet.good] = across_curvature(reach, sheet.xy[sheet.good], across[sheet.good])
        spacing = spacing_for(reach, step, force, bend[sheet.good])
        steps = spacing.at(bend)
        curves: list[Array] = []
        for island in sheet.islands():
            counted = island & (inset >= INSIDE)
            if not counted.any() or inset[island].max() < spacing.typical / 2.0:
                continue
            count = Count.of(inset[counted], (stretch / steps)[counted], steps[counted], sheet.pitch)
            # The innermost line is half a spacing from the middle, where it meets itself coming the other way.
            number = np.ceil(count.number[-1] + 0.5 - 1e-6)
            values = count.value(np.arange(number) * count.number[-1] / max(number - 0.5, 0.5))
            field = np.where(sheet.good & ~island, -inset, inset)
            curves += _covered(sheet, field, values, count.step_at(values), spacing, force)
        return required(strokes_along(reach, curves, feed), reach, mould)


@dataclass(frozen=True, kw_only=True)
class Spiral:
    """A spiral from the middle of the largest workable part outwards: it has no reversals; for domes and round pockets.

    Where it leaves the part, as in the corners of a square one, arcs go back and forth.
    """

    def strokes(self, reach: Reach, mould: Mould, *, step: float | None, feed: float, force: float) -> list[Stroke]:
        """See :class:`Pattern`."""
        check(tip_radius=reach.tip_radius, step=step, feed=feed, force=force)
        sheet = Sheet.of(reach, mould)
        islands = sheet.islands()
        if not islands:
            return required([], reach, mould)
        island = islands[0]
        middle = sheet.xy[island & (sheet.inset > 0.98 * sheet.inset[island].max())].mean(axis=0)
        outward = sheet.xy - middle
        radius = np.linalg.norm(outward, axis=2)
        across = outward / np.maximum(radius, 1e-9)[..., None]
        bend = across_curvature(reach, sheet.xy[island], across[island])
        spacing = spacing_for(reach, step, force, bend)
        steps = spacing.at(bend)
        count = Count.of(radius[island], sheet.stretch(across)[island] / steps, steps, sheet.pitch)
        # A turn is a line; it starts half a line from the middle.
        turns = np.arange(0.5, max(count.number[-1], 0.5) + 2.0 / _PER_TURN, 1.0 / _PER_TURN)
        r, angle = count.value(turns), 2.0 * np.pi * turns
        pressed = force / spacing.typical * count.step_at(r)
        path = dense(np.column_stack((middle + r[:, None] * np.column_stack((np.cos(angle), np.sin(angle))), pressed)))
        pieces = broken(reach, path, _SHORTEST_PIECE * spacing.typical)
        number = [int(np.interp(np.linalg.norm(piece[-1, :2] - middle), count.knots, count.number)) for piece in pieces]
        levels = [[p for p, n in zip(pieces, number, strict=True) if n == level] for level in sorted(set(number))]
        return required(
            strokes_along(reach, joined(levels, spacing.typical, room(reach)), feed)
            + hem(reach, mould, step=step, feed=feed, force=force),
            reach,
            mould,
        )


@dataclass(frozen=True, kw_only=True)
class Geodesic:
    """Lines at equal distances on the surface from one along the mould's x, back and forth; for curved patches."""

    def strokes(self, reach: Reach, mould: Mould, *, step: float | None, feed: float, force: float) -> list[Stroke]:
        """See :class:`Pattern`."""
        check(tip_radius=reach.tip_radius, step=step, feed=feed, force=force)
        sheet = Sheet.of(reach, mould)
        fields = [_signed_distance(sheet, island) for island in sheet.islands()]
        known = [np.isfinite(field) for field in fields]
        bends = [
            across_curvature(reach, sheet.xy[own], directions(np.nan_to_num(field), sheet)[own])
            for field, own in zip(fields, known, strict=True)
        ]
        spacing = spacing_for(reach, step, force, np.concatenate([np.empty(0), *bends]))
        curves: list[Array] = []
        for field, own, bend in zip(fields, known, bends, strict=True):
            if not own.any() or np.ptp(field[own]) < spacing.typical:
                continue
            steps = spacing.at(bend)
            count = Count.of(field[own], 1.0 / steps, steps, sheet.pitch)
            number = np.ceil(count.number[-1] - 1e-6)
            values = count.value(np.arange(number + 1) * count.number[-1] / number)
            values[[0, -1]] += [INSIDE, -INSIDE]
            curves += _covered(sheet, field, values, count.step_at(values), spacing, force)
        found = strokes_along(reach, curves, feed) + hem(reach, mould, step=step, feed=feed, force=force)
        return required(found, reach, mould)


def _covered(sheet: Sheet, field: Array, values: Array, steps: Array, spacing: Spacing, force: float) -> list[Array]:
    """Curves of equal value of a field (ny, nx), joined from value to value, each with its force, (N, 3)."""
    levels = []
    for value, step in zip(values.tolist(), steps.tolist(), strict=True):
        pressed = force * step / spacing.typical
        found = [np.column_stack((curve, np.full(len(curve), pressed))) for curve in level_curves(sheet, field, value)]
        levels.append(
            [piece for curve in found for piece in _pieces(sheet.reach, curve, _SHORTEST_PIECE * spacing.typical)]
        )
    return joined(levels, float(np.median(steps)), room(sheet.reach))


def _pieces(reach: Reach, curve: Array, shortest: float) -> list[Array]:
    """`broken`, but a ring that is broken nowhere stays one, and one that is broken is not broken where it begins."""
    if not closed(curve):
        return broken(reach, curve, shortest)
    free = reach.free(curve[:, :2], TURN_SLACK)
    if free.all():
        return [curve]
    return broken(reach, np.roll(curve[:-1], -int(np.argmin(free)), axis=0), shortest)


def _signed_distance(sheet: Sheet, island: NDArray[np.bool_]) -> Array:
    """Distance over the surface from the longest row of an island [m], (ny, nx); negative below it, NaN elsewhere."""
    row = longest_row(island)
    seed = np.zeros(island.shape, dtype=bool)
    seed[row] = island[row]
    distance = distance_over(sheet, island, seed)
    return np.where(np.arange(len(sheet.y))[:, None] < row, -distance, distance)
