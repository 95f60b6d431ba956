"""Smooth motion after an operator's hand: velocity, acceleration and jerk never leave their bounds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from ruckig import ControlInterface, InputParameter, OutputParameter, Ruckig, Synchronization

from burnish.core import Array

EASED = 0.02
"""Change of the share of acceleration that is none."""
SAME = 1e-9
"""Change of a target that is none: the last digits of a rotation matrix."""


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
        self.v = np.zeros(n)
        self._ease(1.0)
        self._target = np.zeros(n)
        self.rest()

    def rest(self) -> None:
        """Stand still from now on."""
        self.go_on_with(np.zeros(len(self._target)), np.zeros(len(self._target)))

    def go_on_with(self, v: Array, a: Array) -> None:
        """Take over a velocity and an acceleration that somebody else has changed."""
        self.v = v
        self._in.current_velocity, self._in.current_acceleration = v.tolist(), a.tolist()

    def step(self, target: Array, dt: float, ease: float = 1.0) -> Moved:
        """Follow a target velocity, (n,), for a time [s], 0 or more, with this share of acceleration and jerk."""
        motion, out = self._in, self._out
        before = np.array(motion.current_position)
        # A new target is a new profile, whose phases agree less well than those of one that goes on.
        if np.abs(target - self._target).max() > SAME:
            self._target = target
            motion.target_velocity = target.tolist()
        if abs(ease - self._eased) > EASED:
            self._ease(ease)
        if dt > 0.0:
            self._generator.delta_time = dt
            self._generator.update(motion, out)
            out.pass_to_input(motion)
        way = np.array(motion.current_position) - before
        self.v = np.array(motion.current_velocity)
        return Moved(way, self.v, np.array(motion.current_acceleration))

    def _ease(self, share: float) -> None:
        self._eased = share
        self._in.max_acceleration, self._in.max_jerk = (
            (share * self.acceleration).tolist(),
            (share * self._jerk).tolist(),
        )
