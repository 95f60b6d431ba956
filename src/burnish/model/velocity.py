"""Joint velocity from joint positions that come late, twice, or not at all.

The plain difference over the control period, (q_k − q_{k−1})/h, is 0 where a reading is repeated and twice the speed
where one was missed. Holding the last value while nothing changes, without end, makes a standstill impossible.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

import numpy as np

from burnish.core import Array, read_only
from burnish.errors import InputError

TOO_CLOSE = 0.1
"""Two readings closer in time than this share of the window say nothing about a speed: a late one and its successor."""


class Reading(Enum):
    """What a reading was taken for."""

    FRESH = "fresh"
    """It brought news: the velocity is measured."""
    STALE = "stale"
    """It repeats the last one although the arm was moving, or came at once after it: the velocity is held."""
    STILL = "still"
    """It repeats the last one because nothing moves: the velocity is zero, or on its way there."""


class Velocity(NamedTuple):
    """An estimate, and what it rests on."""

    dq: Array
    """Joint velocities [rad/s], (n,)."""
    reading: Reading
    """What the newest reading was taken for."""


@dataclass
class _Memory:
    """What an estimator remembers between two readings."""

    fresh: deque[tuple[float, Array]] = field(default_factory=deque)
    """Readings that brought news, with their times; the first is at least a window older than the last."""
    dq: Array = field(default_factory=lambda: np.zeros(0))
    t: float = -np.inf
    """Time of the newest reading of any kind."""


@dataclass(frozen=True, kw_only=True)
class VelocityFromPositions:
    """Velocity from multi-turn joint positions and their time stamps.

    A reading is fresh as soon as one joint has moved by a step of its encoder: then the velocity is the slope of the
    straight line through the fresh readings of the last ``window``, over their **own** times, so a gap between them
    does no harm; a joint that alone has not moved stands still. If no joint has moved, the last velocity decides:

    - it would not have shown yet, |q̇| · (time without news) below the encoder's step: the joints may as well stand;
    - it would have shown: the reading is stale, and the velocity is held for ``patience``;
    - beyond that the arm has stopped, and the velocity fades to zero over another ``patience``: no jump.

    The estimate lags by half of the time that the line spans: half of ``window`` to ``window``.

    Source: thesis A, eq 3.15–3.16. There the period is fixed, so that a gap doubles the speed, and a reading without
    change always holds the last velocity, so that a standstill is never reached.
    """

    resolution: Array
    """Smallest step of each joint's reading [rad], (n,). JACO2: 1.7e-6 on joints 1–3, 2.5e-6 on 4–6."""
    window: float = 0.015
    """Least time that the line spans [s]; the default is 1.5 periods at 100 Hz. An arm that refreshes its positions on
    a clock of its own, and stamps them when they are read, is off by up to a sixth of its speed (55 Hz behind 100 Hz);
    true time stamps mend that, a wider window hardly does."""
    patience: float = 0.1
    """Longest drop-out that is believed [s]: ten periods at 100 Hz. It is also how long a velocity is held when an arm
    stops within one period and then shows not a single step more, which an arm with fine encoders hardly does."""
    _memory: _Memory = field(init=False, repr=False, compare=False, default_factory=_Memory)

    def __post_init__(self) -> None:
        object.__setattr__(self, "resolution", read_only(self.resolution))
        if self.resolution.ndim != 1 or not (np.isfinite(self.resolution).all() and (self.resolution > 0.0).all()):
            raise InputError(f"VelocityFromPositions: resolution {self.resolution}; expected a step > 0 rad a joint")
        if not (0.0 < self.window < np.inf and 0.0 < self.patience < np.inf):
            raise InputError(
                f"VelocityFromPositions: window {self.window} s, patience {self.patience} s; expected finite times > 0"
            )

    def reset(self, t: float, q: Array) -> None:
        """Begin at rest at the time ``t`` [s] in ``q`` [rad], (n,).

        Raises:
            InputError: if q has another number of joints than ``resolution``, or anything is not finite.
        """
        if q.shape != self.resolution.shape or not np.isfinite(q).all() or not np.isfinite(t):
            raise InputError(
                f"VelocityFromPositions: started at t = {t} s with q = {q}; "
                f"expected finite numbers for {len(self.resolution)} joints"
            )
        self._rest(t, q)

    def update(self, t: float, q: Array) -> Velocity:
        """The velocity after a reading ``q`` [rad], (n,), with the time stamp ``t`` [s]."""
        memory = self._memory
        t_news, q_news = memory.fresh[-1]
        silence = t - t_news
        if t <= memory.t:
            return Velocity(memory.dq, Reading.STALE)
        memory.t = t
        if np.any(np.abs(q - q_news) >= 0.5 * self.resolution):
            if silence < TOO_CLOSE * self.window:
                return Velocity(memory.dq, Reading.STALE)
            memory.fresh.append((t, np.array(q)))
            while len(memory.fresh) > 2 and memory.fresh[1][0] <= t - self.window:
                memory.fresh.popleft()
            memory.dq = _slope(memory.fresh)
            return Velocity(memory.dq, Reading.FRESH)
        if silence >= 2.0 * self.patience or not memory.dq.any():
            self._rest(t, q)
            return Velocity(memory.dq, Reading.STILL)
        would_show = bool(np.any(np.abs(memory.dq) * silence >= self.resolution))
        reading = Reading.STALE if would_show and silence <= self.patience else Reading.STILL
        return Velocity(memory.dq * min(1.0, 2.0 - silence / self.patience), reading)

    def _rest(self, t: float, q: Array) -> None:
        """Remember a standstill: q is the position at t, whenever it was that it last changed."""
        memory = self._memory
        memory.fresh.clear()
        memory.fresh.append((t, np.array(q)))
        memory.dq = np.zeros(len(q))
        memory.t = t


@dataclass(frozen=True, kw_only=True)
class MultiTurn:
    """Multi-turn positions from readings that wrap around at ±π, or anywhere else, once a turn.

    Each joint is taken to have moved by less than half a turn since the reading before.
    """

    _last: list[Array] = field(init=False, repr=False, compare=False, default_factory=list)

    def reset(self, q: Array) -> None:
        """Begin at the position ``q`` [rad], (n,); its turns are kept."""
        self._last[:] = [np.array(q)]

    def update(self, q: Array) -> Array:
        """The position next to the one before that shows as ``q`` [rad], (n,)."""
        before = self._last[0]
        turned = before + (q - before + np.pi) % (2.0 * np.pi) - np.pi
        self._last[0] = turned
        return np.array(turned)


@dataclass(frozen=True, kw_only=True)
class VelocityFromWrappedPositions:
    """`VelocityFromPositions` for readings that wrap around once a turn."""

    positions: VelocityFromPositions
    """What estimates from the unwrapped positions."""
    _turns: MultiTurn = field(init=False, repr=False, compare=False, default_factory=MultiTurn)

    def reset(self, t: float, q: Array) -> None:
        """Begin at rest at the time ``t`` [s] in ``q`` [rad], (n,)."""
        self._turns.reset(q)
        self.positions.reset(t, q)

    def update(self, t: float, q: Array) -> Velocity:
        """The velocity after a wrapped reading ``q`` [rad], (n,), with the time stamp ``t`` [s]."""
        return self.positions.update(t, self._turns.update(q))


def _slope(readings: deque[tuple[float, Array]]) -> Array:
    """Slope of the least-squares line through the readings, (n,) [rad/s]."""
    times = np.array([t for t, _ in readings])
    positions = np.array([q for _, q in readings])
    dt = times - times.mean()
    return np.asarray(dt @ positions / (dt @ dt))
