"""What joints do with the freedom that a task leaves them: keep a posture, keep away from their limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from burnish.control.gains import Gain, above_zero, by_frequency, fit, joints
from burnish.core import Array, Dynamics, read_only
from burnish.errors import InputError


class JointTask(Protocol):
    """Asks for a joint acceleration; the law lets through what disturbs nothing more important."""

    def reset(self, arm: Dynamics) -> None:
        """Refuse, before motion, an arm that this does not fit."""

    def acceleration(self, arm: Dynamics) -> Array:
        """The acceleration asked for [rad/s²], (n,)."""


def total_acceleration(tasks: Sequence[JointTask], arm: Dynamics) -> Array:
    """The sum of what the tasks ask for [rad/s²], (n,)."""
    alpha = np.zeros(len(arm.q))
    for task in tasks:
        alpha += task.acceleration(arm)
    return alpha


@dataclass(kw_only=True)
class Posture:
    """Keep joint positions: α = K_p (q_0 − q) − K_d q̇."""

    q: ArrayLike
    """q_0 [rad], (n,)."""
    kp: Gain
    """K_p [1/s²], (n,) or one number; 0 for a joint that may stand anywhere."""
    kd: Gain
    """K_d [1/s], (n,) or one number: it damps all that the task leaves free."""
    _q: Array = field(init=False, repr=False)
    _kp: Array = field(init=False, repr=False)
    _kd: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._kp, self._kd = joints(self, "kp", self.kp), joints(self, "kd", self.kd)
        self._q = read_only(self.q)
        if self._q.ndim != 1 or not np.isfinite(self._q).all():
            raise InputError(f"Posture: q = {self._q}; expected one finite angle for each joint")

    @classmethod
    def at_frequency(cls, q: ArrayLike, omega: Gain, damping_ratio: float = 1.0) -> Posture:
        """Gains by natural frequency ω [rad/s], (n,) or one number: K_p = ω², K_d = 2 ζ ω."""
        kp, kd = by_frequency(omega, damping_ratio)
        return cls(q=q, kp=kp, kd=kd)

    def reset(self, arm: Dynamics) -> None:
        """Refuse, before motion, an arm that this does not fit."""
        fit(self, arm, q=self._q, kp=self._kp, kd=self._kd)

    def acceleration(self, arm: Dynamics) -> Array:
        """The acceleration asked for [rad/s²], (n,)."""
        return np.asarray(self._kp * (self._q - arm.q) - self._kd * arm.dq)


@dataclass(kw_only=True)
class LimitAvoidance:
    """Keep away from joint limits: α = a [x(d_lower) − x(d_upper)] − K_d q̇ with x = (1 − d/m)₊².

    d is the distance from a limit; the push sets in smoothly at the margin m, grows towards the limit, is a there, and
    grows on beyond as 1 − d/m. A continuous joint has no limit, ±inf, and is not pushed.
    """

    lower: ArrayLike
    """Lower joint limits [rad], (n,), −inf for none: those of `Model`."""
    upper: ArrayLike
    """Upper joint limits [rad], (n,), +inf for none."""
    margin: float = 0.35
    """m [rad]: distance at which the push sets in; 20° is a choice."""
    acceleration_at_limit: float = 40.0
    """a [rad/s²]. From the margin to the limit it takes a speed of √(2 a m / 3), 3 rad/s by default, to 0."""
    kd: Gain = 0.0
    """K_d [1/s], (n,) or one number."""
    _lower: Array = field(init=False, repr=False)
    _upper: Array = field(init=False, repr=False)
    _kd: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._kd = joints(self, "kd", self.kd)
        self._lower, self._upper = read_only(self.lower), read_only(self.upper)
        if self._lower.ndim != 1 or self._lower.shape != self._upper.shape or not (self._lower < self._upper).all():
            raise InputError(
                f"LimitAvoidance: lower {self._lower}, upper {self._upper}; expected two vectors, one below the other"
            )
        for name in ("margin", "acceleration_at_limit"):
            above_zero(self, name, getattr(self, name))

    def reset(self, arm: Dynamics) -> None:
        """Refuse, before motion, an arm that this does not fit."""
        fit(self, arm, lower=self._lower, upper=self._upper, kd=self._kd)

    def acceleration(self, arm: Dynamics) -> Array:
        """The acceleration asked for [rad/s²], (n,)."""
        up = np.maximum(1.0 - (arm.q - self._lower) / self.margin, 0.0)
        down = np.maximum(1.0 - (self._upper - arm.q) / self.margin, 0.0)
        return np.asarray(
            self.acceleration_at_limit * (up * np.minimum(up, 1.0) - down * np.minimum(down, 1.0)) - self._kd * arm.dq
        )
