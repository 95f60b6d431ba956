"""`Swing`: a hold that drives a joint instead of braking it is made softer, until it brakes.

A spring and a damper on readings that are late without saying so pull at the wrong time. What such a hold looks like
from inside is a joint that swings to and fro and does not get slower from turn to turn, whatever the delay is.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from burnish.core import Array

SWINGS = np.radians(3.0)
"""Joint speed from which a turn counts as a swing [rad/s]; less is rounding, or friction that lets go."""
FAST = np.radians(15.0)
"""Joint speed from which one swing that does not die says as much as two slower ones [rad/s]."""
DIES = 0.8
"""Share of the last swing's speed that the next one may reach; a hold that brakes leaves far less."""
IN_A_ROW = 2
"""Slow swings in a row that do not die before the hold gets softer: one alone may be a load that begins to fall."""
SOFTER = 0.5
"""Factor on the hold's stiffness and damping then, and at each further one."""


@dataclass(kw_only=True)
class Swing:
    """What is left of each joint's hold, from the stop on."""

    share: Array
    """Factor on the joint's stiffness and damping, (n,), from 1 on."""
    _now: Array = field(init=False, repr=False)
    """Fastest speed since the joint last turned, with its sign [rad/s]."""
    _before: Array = field(init=False, repr=False)
    """Size of that of the swing before; inf if there was none [rad/s]."""
    _more: Array = field(init=False, repr=False)
    """Swings in a row that did not die, a fast one counted twice."""

    def __post_init__(self) -> None:
        n = len(self.share)
        self._now, self._before, self._more = np.zeros(n), np.full(n, np.inf), np.zeros(n)

    def at(self, dq: Array) -> Array:
        """The share that is left at joint speeds ``dq`` [rad/s], (n,), the next ones of a held arm."""
        turned = dq * self._now < 0.0
        fastest = np.abs(self._now)
        swung = turned & (fastest > SWINGS)
        grows = swung & (fastest > DIES * self._before)
        more = self._more + np.where(self._before > FAST, 2, 1)
        self._more = np.where(turned, np.where(grows, more, 0), self._more)
        self.share = np.where(swung & (self._more >= IN_A_ROW), SOFTER * self.share, self.share)
        self._before = np.where(swung, fastest, self._before)
        faster = turned | (np.abs(dq) > fastest)
        self._now = np.where(faster, dq, self._now)
        return self.share
