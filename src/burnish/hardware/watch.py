"""`Watch`: whether a reading of the arm can be believed, and the state that follows from it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from burnish.core import Array, State, read_only
from burnish.model.velocity import MultiTurn, VelocityFromPositions

MOST_TURNS = 30.0
"""No joint turns further than this: the arm's software stops it at 27.7 turns."""
TORQUE_SHARE = 2.0
"""A torque beyond this multiple of the actuator's peak is no measurement. One was seen that read −1.07e8 N·m."""
JUMP = np.deg2rad(2.0)
"""What a joint may be off from the fastest it can have moved [rad]."""
REPEATS = 2
"""Readings in a row that may repeat the one before to the last bit. The arm refreshes at 50 to 60 Hz at its worst, and
then a reader at 100 Hz sees each reading twice, or three times where the clocks drift past each other."""
RESOLUTION = 2.0 * np.pi / np.array([3_686_400.0] * 3 + [2_534_400.0] * 3)
"""Step of the encoders behind the gears [rad]: 23,040 × 160 and 23,040 × 110 counts a turn."""


@dataclass(kw_only=True)
class Watch:
    """Turns readings into states, or says what is wrong with them; nothing bad gets into its memory."""

    speed: Array
    """Largest joint speeds [rad/s], (6,)."""
    effort: Array
    """Largest joint torques [N·m], (6,)."""
    limited: Array
    """Which joints have limits, (6,) of bool: they stand within one turn, from 0 to 2π."""
    _turns: MultiTurn = field(default_factory=MultiTurn, init=False, repr=False)
    _velocity: VelocityFromPositions = field(
        default_factory=lambda: VelocityFromPositions(resolution=RESOLUTION), init=False, repr=False
    )
    _q: Array = field(default_factory=lambda: np.zeros(6), init=False, repr=False)
    _t: float = field(default=0.0, init=False, repr=False)
    _seen: tuple[bytes, bytes] = field(default=(b"", b""), init=False, repr=False)
    _repeats: int = field(default=0, init=False, repr=False)
    shift: Array = field(default_factory=lambda: np.zeros(6), init=False, repr=False)
    """Our angle minus the reported one [rad], (6,): whole turns."""

    def begin(self, t: float, reported: Array) -> None:
        """Start at rest with these reported angles [rad], (6,)."""
        self._q = np.where(self.limited, reported % (2.0 * np.pi), reported)
        self._t = t
        self.shift = read_only(self._q - reported)
        self._turns.reset(self._q)
        self._velocity.reset(t, self._q)
        self._repeats = 0

    def look(self, t: float, reported: Array, tau: Array) -> State | str:
        """The state at ``t`` [s] from reported angles [rad] and torques [N·m], (6,); or why there is none."""
        cause = self._implausible(reported, tau)
        if cause is not None:
            return cause
        seen = reported.tobytes(), tau.tobytes()
        self._repeats = self._repeats + 1 if seen == self._seen else 0
        self._seen = seen
        if self._repeats > REPEATS:
            return f"{self._repeats + 1} readings in a row are the same to the last bit, noise included"
        q = self._turns.update(reported)
        off = np.abs(q - self._q) - 1.5 * self.speed * (t - self._t)
        if np.any(off > JUMP):
            self._turns.reset(self._q)
            joint = int(np.argmax(off))
            jump_deg = np.rad2deg(q - self._q)[joint]
            return f"the angle of joint {joint + 1} jumped by {jump_deg:.1f}° between two readings"
        self._q, self._t = q, t
        self.shift = q - reported
        return State(t=t, q=q, dq=self._velocity.update(t, q).dq, tau=tau)

    def _implausible(self, reported: Array, tau: Array) -> str | None:
        """What no arm can measure."""
        if not (np.isfinite(reported).all() and np.isfinite(tau).all()):
            return "a measured angle or torque is not a number"
        if np.any(np.abs(reported) > 2.0 * np.pi * MOST_TURNS):
            return f"a measured angle is {np.rad2deg(np.abs(reported).max()):.3g}°, beyond {MOST_TURNS:.0f} turns"
        if np.any(np.abs(tau) > TORQUE_SHARE * self.effort):
            joint = int(np.argmax(np.abs(tau) / self.effort))
            return f"the measured torque of joint {joint + 1} is {tau[joint]:.3g} N·m, which it cannot have"
        return None
