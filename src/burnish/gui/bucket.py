"""`Bucket`: how much of something may come at once, and how fast it may go on."""

from __future__ import annotations

import time
from collections.abc import Callable


class Bucket:
    """Holds ``most`` at first, and is filled at ``rate`` a second."""

    def __init__(self, rate: float, most: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._rate, self._most, self._clock = rate, most, clock
        self._left, self._since = most, clock()

    def take(self) -> bool:
        """Take one out; false if it is empty."""
        now = self._clock()
        self._left = min(self._most, self._left + self._rate * (now - self._since))
        self._since = now
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True
