"""`OperatorTwist`: what a hand at a joystick asks of the tool, as a reference that never runs away from the arm."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import exp as decay

import numpy as np

from burnish.core import Array, Dynamics, ToolReference
from burnish.rotation import exp, log
from burnish.runtime.clearance import Clearance
from burnish.runtime.operating import watched
from burnish.teleop.limits import before_end

LINEAR, ANGULAR = 0.10, 0.35
"""Largest speeds that are asked for [m/s, rad/s]."""
SMOOTH = 0.12
"""Time constant of the hand, twice [s]."""
LEASH, TURN_LEASH = 0.02, 0.15
"""How far the reference may be ahead of the tool [m, rad]."""
ROAM = 0.12
"""Distance from the start beyond which the hand comes back [m]."""
SHARE = 0.5
"""Share of the joints' speeds to which the twist is slowed down."""


@dataclass(kw_only=True)
class OperatorTwist:
    """A random twist, changed now and then, smoothed like a hand's, integrated to a pose on a leash."""

    seed: int
    """Of the hand."""
    joint_speed: Array = field(default_factory=lambda: np.radians(np.repeat([36.0, 48.0], 3)))
    """Largest joint speeds [rad/s], (6,)."""
    _clearance: Clearance = field(default_factory=watched, init=False, repr=False)
    _p: Array = field(default_factory=lambda: np.zeros(3), init=False, repr=False)
    _R: Array = field(default_factory=lambda: np.eye(3), init=False, repr=False)
    _twist: Array = field(default_factory=lambda: np.zeros((3, 6)), init=False, repr=False)
    """What is wanted, half smoothed and smoothed."""

    def reset(self, arm: Dynamics) -> None:
        """Start from this tool pose, at rest."""
        self._rng = np.random.default_rng(self.seed)
        self._p, self._R, self._home, self._R_home = arm.p, arm.R, arm.p, arm.R
        self._t = self._change = arm.t
        self._twist = np.zeros((3, 6))

    def at(self, arm: Dynamics) -> ToolReference:
        """The reference at the instant of ``arm``."""
        dt, self._t = arm.t - self._t, arm.t
        if arm.t >= self._change:
            self._change = arm.t + self._rng.uniform(0.3, 1.0)
            self._twist[0] = self._wish()
        # A step that the clock cannot have made moves nothing.
        dt = min(max(dt, 0.0), 0.1) if dt == dt else 0.0
        before, share = self._twist[2].copy(), 1.0 - decay(-dt / SMOOTH)
        self._twist[1] += share * (self._twist[0] - self._twist[1])
        self._twist[2] += share * (self._twist[1] - self._twist[2])
        v = self._twist[2] * self._slower(arm)
        p, R = self._p + dt * v[:3], exp(dt * v[3:]) @ self._R
        self._p, self._R = self._leashed(arm, p, R)
        a = (self._twist[2] - before) / dt if dt > 0.0 else np.zeros(6)
        return ToolReference(p=self._p, R=self._R, v=v, a=a)

    def _wish(self) -> Array:
        """A new twist: often none, else in any direction, home from too far away."""
        if self._rng.uniform() < 0.2:
            return np.zeros(6)
        linear, angular = self._rng.normal(size=(2, 3))
        way, turn = self._home - self._p, log(self._R_home @ self._R.T)
        if float(np.linalg.norm(way)) > ROAM:
            linear = way
        if float(np.linalg.norm(turn)) > 0.5:
            angular = turn
        linear *= LINEAR * self._rng.uniform() / np.linalg.norm(linear)
        angular *= ANGULAR * self._rng.uniform() / np.linalg.norm(angular)
        return np.concatenate([linear, angular])

    def _slower(self, arm: Dynamics) -> float:
        """Share of the twist that the joints can follow, and that brings the arm to rest before it is near itself."""
        J = arm.J
        dq = J.T @ np.linalg.solve(J @ J.T + 1e-4 * np.eye(6), self._twist[2])
        share = min(1.0, SHARE / max(1e-9, float(np.max(np.abs(dq) / self.joint_speed))))
        way, speed = self._clearance.closing(arm, share * dq)
        return share * before_end(way, speed, "the arm itself").share

    @staticmethod
    def _leashed(arm: Dynamics, p: Array, R: Array) -> tuple[Array, Array]:
        """The pose, drawn back to where the tool is near enough."""
        ahead, turn = p - arm.p, log(R @ arm.R.T)
        far, wide = float(np.linalg.norm(ahead)) / LEASH, float(np.linalg.norm(turn)) / TURN_LEASH
        return (
            arm.p + ahead / far if far > 1.0 else p,
            exp(turn / wide) @ arm.R if wide > 1.0 else R,
        )
