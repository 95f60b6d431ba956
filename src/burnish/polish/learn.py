"""What a pass teaches the next one: how high the surface really lies along each stroke."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import sqrt

import numpy as np

from burnish.core import Array
from burnish.polish.passes import Leg

BIN = 1e-3
"""Path over which readings are averaged [m]."""
SMOOTH = 8e-3
"""Standard deviation of the smoothing along the path [m], forwards and backwards alike: no lag, and no stick-slip."""
MOST = 1.5e-3
"""Largest correction [m]; a mould that is further off is to be found again."""
WORSE = 1.02
"""Force error by that of the best pass above which a correction is undone."""


@dataclass(kw_only=True)
class _Known:
    """What is known of one stroke."""

    offset: Array
    """Correction in use, a value a bin [m]."""
    best: Array
    """The one of the best pass so far."""
    error: float = np.inf
    """Force error of that pass, RMS [N]."""
    closed: bool = False
    """Whether a correction was undone, after which nothing more is tried."""


@dataclass(kw_only=True)
class Learner:
    """Corrects the height of a stroke from pass to pass; with a gain of 0 it changes nothing.

        o_{k+1}(s) = (1 − forgetting) o_k(s) + gain · smooth(h_k(s) − mean h_k)

    with h_k the measured height of the tool over the path of pass k. The force law holds the force whatever the height
    is, by its integral; but a path that rises where the surface falls makes it work for that, by D_n times the wrong
    normal speed. So the correction takes over what the integral had to do. A pass whose force error is more than that
    of the best one undoes its correction, and ends the learning on this stroke: never the noise of friction.
    """

    gain: float = 0.0
    """Share of what was measured that is taken over."""
    forgetting: float = 0.05
    """Share of the correction that is forgotten from pass to pass."""
    undone: int = field(default=0, init=False)
    """Corrections that were undone."""
    _known: dict[int, _Known] = field(default_factory=dict, init=False, repr=False)
    _rows: list[tuple[float, float, float]] = field(default_factory=list, init=False, repr=False)

    def add(self, leg: Leg, s: float, height: float, error: float) -> None:
        """A reading: path length of the leg [m], height over its path [m], force error [N]."""
        if self.gain > 0.0:
            self._rows.append((leg.begun + s, height, error))

    def end(self, leg: Leg) -> None:
        """A leg is done: judge its correction, and make the next one."""
        rows, self._rows = np.array(self._rows), []
        if len(rows) < 10:
            return
        count = int((leg.begun + leg.path.length) / BIN) + 1
        known = self._known.setdefault(leg.stroke, _Known(offset=np.zeros(count), best=np.zeros(count)))
        if known.closed or len(known.offset) != count:
            return
        error = sqrt(float(np.mean(rows[:, 2] ** 2)))
        if error > WORSE * known.error:
            known.offset, known.closed = known.best, True
            self.undone += 1
            return
        if error < known.error:
            known.best, known.error = known.offset, error
        bins = np.clip((rows[:, 0] / BIN).astype(int), 0, count - 1)
        readings = np.bincount(bins, minlength=count)
        height = np.bincount(bins, rows[:, 1], minlength=count) / np.maximum(readings, 1)
        seen = np.flatnonzero(readings)
        height = np.interp(np.arange(count), seen, height[seen])
        learnt = (1.0 - self.forgetting) * known.offset + self.gain * smoothed(height - height.mean())
        known.offset = np.clip(learnt, -MOST, MOST)

    def corrected(self, leg: Leg) -> Leg:
        """The leg with the correction of its stroke; the leg itself where there is none."""
        known = self._known.get(leg.stroke)
        if known is None or not known.offset.any():
            return leg
        at = (leg.begun + leg.path.arc) / BIN - 0.5
        offset = np.interp(at, np.arange(len(known.offset)), known.offset)
        return replace(leg, path=replace(leg.path, points=leg.path.points + offset[:, None] * leg.path.normals))


def smoothed(values: Array) -> Array:
    """A symmetric bell over the values, ends mirrored: it shifts nothing."""
    half = int(3.0 * SMOOTH / BIN)
    bell = np.exp(-0.5 * (np.arange(-half, half + 1) * BIN / SMOOTH) ** 2)
    padded = np.pad(values, half, mode="reflect") if len(values) > half else np.pad(values, half, mode="edge")
    return np.convolve(padded, bell / bell.sum(), mode="valid")
