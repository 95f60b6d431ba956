"""Smooth motion after an operator's hand: velocity, acceleration and jerk never leave their bounds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from ruckig import ControlInterface, InputParameter, OutputParameter, Ruckig, RuckigError, Synchronization

from burnish.core import Array

EASED = 0.02
"""Change of the share of acceleration that is none, and the least share: with less a motion would never end."""
SAME = 1e-9
"""Change of a target that is none: the last digits of a rotation matrix."""
LONGEST = 1.0
"""Longest step that is taken [s]."""
ENDLESS = 100.0
"""A target is heeded up to the velocity that the least share of acceleration brings about in this time [s]: 4 m/s at
2 m/s². The generator refuses motions that last for hours."""


class Moved(NamedTuple):
    """One step of a smooth motion, each (n,)."""

    way: Array
    """How far it went."""
    v: Array
    """Its velocity now."""
    a: Array
    """Its acceleration now."""


class Smooth:
    """Follows a velocity in the least time that acceleration and jerk allow, all axes in phase.

    The generator is asked only for motions that begin within its bounds: an acceleration that is more than a smaller
    share allows is first taken back here, all axes in proportion. From outside them it takes back each axis by itself,
    and may then find no common duration for the rest. Where it finds none all the same, by rounding, the axes go to
    their targets each in its own time, in that cycle, by the same bounds.

    Source: Berscheid and Kröger, "Jerk-limited Real-time Trajectory Generation with Arbitrary Target States", 2021; the
    library `ruckig` of the first author.
    """

    def __init__(self, acceleration: Sequence[float], jerk: Sequence[float]) -> None:
        """At rest; one number an axis, in the axis's unit over s² and s³."""
        n = len(acceleration)
        self._generator = Ruckig(n, 0.01)
        self._out = OutputParameter(n)
        self._in = InputParameter(n)
        self._in.control_interface = ControlInterface.Velocity
        self._in.synchronization = Synchronization.Phase
        self.acceleration, self._jerk = np.array(acceleration), np.array(jerk)
        self._fastest = ENDLESS * EASED * self.acceleration
        self.v = self.a = np.zeros(n)
        self._ease(1.0)
        self._target = np.zeros(n)
        self.rest()

    def rest(self) -> None:
        """Stand still from now on."""
        self.go_on_with(np.zeros(len(self._target)), np.zeros(len(self._target)))

    def go_on_with(self, v: Array, a: Array) -> None:
        """Take over a velocity and an acceleration that somebody else has changed."""
        self.v, self.a = v, a
        self._in.current_velocity, self._in.current_acceleration = v.tolist(), a.tolist()

    def step(self, target: Array, dt: float, ease: float = 1.0) -> Moved:
        """Follow a target velocity, (n,), for a time [s], 0 or more, with this share of acceleration and jerk.

        What is no number changes nothing: the motion goes on to the last target, with the last share.
        """
        # A new target is a new profile, whose phases agree less well than those of one that goes on.
        if np.abs(target - self._target).max() > SAME and np.isfinite(target).all():
            self._target = target
            self._in.target_velocity = target.clip(-self._fastest, self._fastest).tolist()
        if abs(ease - self._eased) > EASED:
            self._ease(min(max(ease, EASED), 1.0))
        way, left = self._within(min(dt, LONGEST))
        if left > 0.0:
            way = way + self._generated(left)
        return Moved(way, self.v, self.a)

    def _within(self, dt: float) -> tuple[Array, float]:
        """Take the acceleration back into its bounds, as far as the time allows; the way, and the time that is left.

        a = a₀ (1 − c t) with the jerk of the axis that needs it longest, until the largest |aᵢ|/bᵢ is 1.
        """
        v, a = self.v, self.a
        over = float((np.abs(a) / self._bound).max())
        if not (over > 1.0 and dt > 0.0):
            return np.zeros(len(v)), dt
        c = 1.0 / float((np.abs(a) / self._jerk).max())
        t = min(dt, (1.0 - 1.0 / over) / c)
        way = v * t + a * (t * t * (0.5 - c * t / 6.0))
        self.go_on_with(v + a * (t * (1.0 - 0.5 * c * t)), a * (1.0 - c * t))
        return way, dt - t

    def _generated(self, dt: float) -> Array:
        """The way by the generator, whose state then is ours."""
        motion, out = self._in, self._out
        before = np.array(motion.current_position)
        self._generator.delta_time = dt
        try:
            self._generator.update(motion, out)
        except RuckigError:
            motion.synchronization = Synchronization.No
            self._generator.update(motion, out)
            motion.synchronization = Synchronization.Phase
        out.pass_to_input(motion)
        self.v, self.a = np.array(motion.current_velocity), np.array(motion.current_acceleration)
        return np.asarray(np.array(motion.current_position) - before)

    def _ease(self, share: float) -> None:
        self._eased, self._bound = share, share * self.acceleration
        self._in.max_acceleration, self._in.max_jerk = self._bound.tolist(), (share * self._jerk).tolist()
