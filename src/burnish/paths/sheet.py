"""The workable places of a mould on a regular grid in plan, and curves of equal value of a field over them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from contourpy import contour_generator
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, label
from scipy.spatial import cKDTree
from typing_extensions import Self

from burnish.core import Array
from burnish.errors import PlanError
from burnish.paths.area import MOST_LINES, nodes, probes
from burnish.paths.reach import Reach
from burnish.paths.track import PLAN_PITCH, dense, plan_length
from burnish.surface import Mould, laid

ROUND = 0.6e-3
"""Standard deviation over which corners of a level curve are rounded along it [m]: a corner of 90° becomes an arc of
about 1 mm, and a ring of 10 mm radius shrinks by 0.02 mm."""

HAIRPIN, _WINDOW = float(np.deg2rad(110.0)), 4
"""Turn over a millimetre, of as many places, from which a level curve is cut [rad]."""


@dataclass(frozen=True, kw_only=True)
class Sheet:
    """Probed places of a mould; arrays over them are (ny, nx)."""

    reach: Reach
    """What a place must fulfil."""
    x: Array
    """[m], (nx,)."""
    y: Array
    """[m], (ny,)."""
    good: NDArray[np.bool_]
    """Where the tip can work."""
    normal: Array
    """Outward unit normals of the surface, (ny, nx, 3); NaN where there is none."""
    height: Array
    """Of the surface [m]; NaN where there is none."""

    @classmethod
    def of(cls, reach: Reach, mould: Mould) -> Self:
        """Probe the whole mould."""
        low, high = mould.vertices[:, :2].min(axis=0), mould.vertices[:, :2].max(axis=0)
        x, y = (probes(low[i], high[i]) for i in (0, 1))
        xy = nodes(x, y)
        shape = (len(y), len(x))
        touch = laid(reach.grid, xy, reach.tip_radius)
        return cls(
            reach=reach,
            x=x,
            y=y,
            good=reach.free(xy).reshape(shape),
            normal=touch.normal.reshape(*shape, 3),
            height=touch.contact[:, 2].reshape(shape),
        )

    @property
    def xy(self) -> Array:
        """The probed places [m], (ny, nx, 2)."""
        return nodes(self.x, self.y).reshape(len(self.y), len(self.x), 2)

    @property
    def pitch(self) -> float:
        """Larger distance of neighbouring places along an axis [m]."""
        return float(max(self.x[1] - self.x[0], self.y[1] - self.y[0]))

    @cached_property
    def inset(self) -> Array:
        """Distance in plan to where the workable places end, negative beyond [m]."""
        distance = cKDTree(self._ends()).query(self.xy)[0] if self.good.any() else np.full(self.good.shape, np.inf)
        return np.where(self.good, distance, -distance)

    def islands(self) -> list[NDArray[np.bool_]]:
        """The connected parts of what can be worked, the largest first."""
        number, count = label(self.good)
        parts = [number == k + 1 for k in range(count)]
        return sorted(parts, key=lambda part: -int(part.sum()))

    def stretch(self, across: Array) -> Array:
        """Length on the surface over length in plan in the directions ``across`` (ny, nx, 2)."""
        with np.errstate(invalid="ignore"):
            rise = np.einsum("yxi,yxi->yx", self.normal[..., :2], across) / self.normal[..., 2]
        return np.asarray(np.nan_to_num(np.hypot(1.0, rise), nan=1.0))

    def _ends(self) -> Array:
        """Places between neighbours of which one is good and one is not, where exactly it changes, (E, 2) [m]."""
        good, xy = self.good, self.xy
        inside, outside = [], []
        for axis in (0, 1):
            one, other = (np.take(good, np.arange(a, good.shape[axis] - 1 + a), axis) for a in (0, 1))
            p, q = (np.take(xy, np.arange(a, good.shape[axis] - 1 + a), axis) for a in (0, 1))
            for first, second, a, b in ((one, other, p, q), (other, one, q, p)):
                inside.append(a[first & ~second])
                outside.append(b[first & ~second])
        good_end, bad_end = np.concatenate(inside), np.concatenate(outside)
        for _ in range(8):
            middle = (good_end + bad_end) / 2.0
            free = self.reach.free(middle)[:, None]
            good_end, bad_end = np.where(free, middle, good_end), np.where(free, bad_end, middle)
        return good_end


def level_curves(sheet: Sheet, field: Array, value: float) -> list[Array]:
    """Dense curves along which a field (ny, nx) has a value, (N, 2) each; a closed one ends where it began.

    Their corners are rounded, hairpins that are left cut, and what is shorter than a millimetre or two is left out.
    """
    generator = contour_generator(x=sheet.x, y=sheet.y, z=np.ma.masked_invalid(field))
    found = [np.asarray(line, dtype=np.float64) for line in generator.lines(value)]
    return [part for line in found if plan_length(line) > 4.0 * ROUND for part in _parted(rounded(dense(line)))]


def rounded(curve: Array) -> Array:
    """A dense curve (N, 2) with round corners; its ends stay, a closed one stays closed."""
    sigma = ROUND / PLAN_PITCH
    closed = bool(np.allclose(curve[0], curve[-1], atol=1e-9))
    if closed:
        ring = gaussian_filter1d(_even(curve)[:-1], sigma, axis=0, mode="wrap")
        return np.concatenate((ring, ring[:1]))
    # Odd about its ends: they stay, and the curve leaves them as it did.
    even, wing = _even(curve), int(4 * sigma)
    wing = min(wing, len(even) - 1)
    head, tail = 2.0 * even[0] - even[wing:0:-1], 2.0 * even[-1] - even[-2 : -wing - 2 : -1]
    return np.asarray(gaussian_filter1d(np.concatenate((head, even, tail)), sigma, axis=0)[wing : wing + len(even)])


def _parted(curve: Array) -> list[Array]:
    """A curve (N, 2) cut where it turns round on the spot, as along a ridge of a distance; whole if it does not."""
    ring = bool(np.allclose(curve[0], curve[-1], atol=1e-9))
    around = np.concatenate((curve[-1 - _WINDOW : -1], curve, curve[1 : 1 + _WINDOW])) if ring else curve
    way = around[_WINDOW:] - around[:-_WINDOW]
    before, after = way[:-_WINDOW], way[_WINDOW:]
    cosine = np.einsum("ij,ij->i", before, after) / np.maximum(
        np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1), np.finfo(float).tiny
    )
    sharp = np.flatnonzero(cosine < np.cos(HAIRPIN)) + (0 if ring else _WINDOW)
    if not len(sharp):
        return [curve]
    if ring:
        curve, sharp = np.roll(curve[:-1], -int(sharp[0]), axis=0), sharp - sharp[0]
    parts = np.split(curve, sharp)
    return [part for part in parts if len(part) > 2 * _WINDOW]


def _even(curve: Array) -> Array:
    """The same curve in equal pieces of about the pitch."""
    arc = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))))
    s = np.linspace(0.0, arc[-1], int(np.ceil(arc[-1] / PLAN_PITCH)) + 1)
    return np.column_stack([np.interp(s, arc, curve[:, i]) for i in range(curve.shape[1])])


@dataclass(frozen=True, kw_only=True)
class Count:
    """How many lines lie between the least value of a field and each value."""

    knots: Array
    """Values of the field, rising, (K,)."""
    number: Array
    """Lines from the first knot on, (K,)."""
    step: Array
    """Least distance of lines that the bend of the surface asks for at each knot [m], (K,)."""

    @classmethod
    def of(cls, values: Array, rate: Array, step: Array, pitch: float) -> Self:
        """Count over N places.

        Args:
            values: of the field, (N,).
            rate: lines per unit of the field that are wanted at each place, (N,).
            step: distance of lines that is wanted there [m], (N,).
            pitch: of the places, in units of the field.

        Raises:
            PlanError: there are too many lines.
        """
        low, high = float(values.min()), float(values.max())
        knots = np.linspace(low, high, max(int((high - low) / pitch), 1) + 1)
        # A place speaks for the knots on both of its sides.
        below = np.clip(np.searchsorted(knots, values, side="right") - 1, 0, len(knots) - 2)
        most, least = np.zeros(len(knots)), np.full(len(knots), np.inf)
        for knot in (below, below + 1):
            np.maximum.at(most, knot, rate)
            np.minimum.at(least, knot, step)
        number = np.concatenate(([0.0], np.cumsum((most[1:] + most[:-1]) / 2.0 * np.diff(knots))))
        if number[-1] > MOST_LINES:
            least_step = 1e3 * float(step.min())
            raise PlanError(
                f"a step of {least_step:.3g} mm makes {number[-1]:.0f} lines; expected {MOST_LINES} at most"
            )
        return cls(knots=knots, number=number, step=least)

    def value(self, number: Array) -> Array:
        """The values at these numbers of lines."""
        return np.interp(number, self.number, self.knots)

    def step_at(self, value: Array) -> Array:
        """The distance of lines at these values [m]."""
        return np.interp(value, self.knots, self.step)
