"""`RoughHand`: a hand at a six-axis mouse that wants one thing after the other, and wants it at once."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import exp

import numpy as np

from burnish.core import Array
from burnish.teleop.device import AT_REST, Reading, six

RELEASED = 0.02
"""Deflection below which the cap counts as let go."""
QUICKEST, SLOWEST = 0.025, 0.05
"""Time constant of the fingers, twice [s]."""
FIRST = 0.1
"""Time for which the cap is left alone first, as every device has to be [s]."""
OFTEN = (0.15, 0.5, 2.0)
"""Mean times for which a hand wants the same [s]."""
ALL_THE_WAY, NOTHING = 0.3, 0.1
"""Share of the wishes that push the cap to its ends, and of those to let go."""
AXES = (1.0, 0.5, 0.2)
"""Share of the axes that a wish is about."""


@dataclass(kw_only=True)
class RoughHand:
    """Pushes the cap to where chance wants it, as fast as fingers do, by a clock of its own."""

    seed: int
    """Of the hand."""
    period: float
    """Time from one reading to the next [s]."""
    longest: float = 10.0
    """For which it wants the same at most [s]."""
    _t: float = field(default=0.0, init=False, repr=False)
    _until: float = field(default=FIRST, init=False, repr=False)
    _lag: float = field(default=SLOWEST, init=False, repr=False)
    _cap: Array = field(default_factory=lambda: np.zeros((3, 6)), init=False, repr=False)
    """Deflections that are wanted, half reached and reached."""

    def __post_init__(self) -> None:
        self._rng = np.random.default_rng(self.seed)

    def read(self) -> Reading:
        """The cap, a period later."""
        self._t += self.period
        if self._t >= self._until:
            self._wish()
        share = 1.0 - exp(-self.period / self._lag)
        self._cap[1] += share * (self._cap[0] - self._cap[1])
        self._cap[2] += share * (self._cap[1] - self._cap[2])
        axes = AT_REST if np.abs(self._cap[2]).max() < RELEASED else six(self._cap[2].tolist())
        return Reading(t=self._t, axes=axes, buttons=(), age=0.0)

    def _wish(self) -> None:
        """Another deflection: some axes or all, partly or to their ends, and now and then none."""
        rng = self._rng
        wanted = rng.uniform(-1.0, 1.0, 6) * (rng.random(6) < rng.choice(AXES))
        if rng.random() < ALL_THE_WAY:
            wanted = np.sign(wanted)
        self._cap[0] = 0.0 if rng.random() < NOTHING else wanted
        self._until = self._t + min(self.longest, rng.exponential(rng.choice(OFTEN)))
        self._lag = rng.uniform(QUICKEST, SLOWEST)
