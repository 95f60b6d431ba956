"""`Integral`: the integral of an error, with anti-windup; the memory of every law that has an integral gain."""

from __future__ import annotations

import numpy as np

from burnish.core import Array


class Integral:
    """``K_i ∫ e dt`` of a vector error, kept within ±bound, and gathered only while the error is small.

    Two guards against windup: what was gathered never passes ``bound``, so it is gone again as fast as it came once the
    error turns; and an error e adds ``s e`` with s = 1 − (e/window)², 0 beyond the window, so that a step of the
    reference, which is the transient's to mend, leaves the integral as it was. The share s has no jump.
    """

    def __init__(self, gain: Array, bound: Array | float, window: float = np.inf) -> None:
        """K_i, (m,) or (); the bound of K_i ∫e in its unit; the window, above 0, in the unit of e."""
        self._gain = gain
        self._bound = bound
        self._window = window
        self._value: Array = np.zeros(0)
        self._t = 0.0
        self.active = bool(np.any(gain > 0.0))
        """Whether there is a gain at all; without one the integral stays 0."""

    def reset(self, t: float, size: int) -> None:
        """Forget; the clock starts at t [s]."""
        self._value, self._t = np.zeros(size), t

    def add(self, e: Array, t: float) -> Array:
        """Gather the error e at the time t [s]; returns K_i ∫e, bounded."""
        if not self.active:
            return self._value
        dt, self._t = t - self._t, t
        share = np.maximum(1.0 - (e / self._window) ** 2, 0.0)
        grown = self._value + dt * self._gain * share * e
        self._value = np.minimum(np.maximum(grown, -self._bound), self._bound)
        return self._value
