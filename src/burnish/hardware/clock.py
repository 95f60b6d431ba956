"""The driver's clock, which a test may replace."""

from __future__ import annotations

import time
from typing import Protocol


class Clock(Protocol):
    """Time that only goes forward [s]."""

    def now(self) -> float:
        """The time since some moment [s]."""

    def wait(self, until: float) -> None:
        """Come back at this time [s], or at once if it has passed."""


class MonotonicClock:
    """The system's monotonic clock: nobody sets it, no time zone moves it."""

    def now(self) -> float:
        """The time since some moment [s]."""
        return time.monotonic()

    def wait(self, until: float) -> None:
        """Sleep until this time [s]."""
        left = until - time.monotonic()
        if left > 0.0:
            time.sleep(left)
