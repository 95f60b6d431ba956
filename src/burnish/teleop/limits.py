"""How fast the operator may go where the arm is: joint limits, singularities, joint speeds, work space, the arm itself.

All of them are one rule. What is a way d from its end, and closes it at a speed c if the operator's twist is obeyed,
may close it at d/T at most: the twist is scaled by the least of min(1, d/(T c)). The arm slows down, comes to rest at
the end, and leaves it freely. The scale is one number, so the direction stays the operator's.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack

from burnish.core import Array, Dynamics, read_only
from burnish.errors import InputError

BRAKING = 0.4
"""T [s]: from 0.41 rad/s a joint brakes with 1.0 rad/s², a fifth of what an operator may ask of it."""
LENGTH = 0.3
"""Length that makes metres comparable with radians in the Jacobian [m]: about that of a link of a table-top arm."""
SINGULAR = 0.05
"""Smallest singular value of the Jacobian, its linear rows over `LENGTH`, that the operator gets to. On a JACO2 it is
0.25 at home; at 0.05 the full speed would take four times the joint speed that there is."""
JOINT_SPEED = 0.65
"""Share of a joint's speed limit that the operator gets; the supervisor brakes from 0.8."""
OVERSHOT = 0.68
"""The same for the reference on its smooth way from one twist to the next, which need not be a straight one."""
FASTER, SLOWER = 1.5, 5.0
"""What the operator's accelerations may ask of a joint when it is to move faster, and slower [rad/s²]. A joint that
turns round sticks, and catches up with twice the acceleration that is asked: with 2.5 rad/s² it takes the tool past
the speed at which it is stopped. What slows down a supervisor lets pass, and 5 rad/s² bring a joint to rest in about a
tenth of a second."""
DAMPING = 1e-3
"""Of the joint speeds in a singularity, in units of the singular values; elsewhere they are exact to 0.1 %."""
ASIDE = 0.005
"""Share of the fastest joint's speed with which a limit may be closed by the way: next to one, a motion along it would
else be stopped by the last digits of a joint speed."""
EDGE = "edge of the work space"

_SCALE = np.repeat([1.0 / LENGTH, 1.0], 3)


class Slowed(NamedTuple):
    """How far a twist is slowed down."""

    share: float = 1.0
    """What is left of it, in [0, 1]."""
    cause: str = ""
    """Which limit does it; empty where none does."""


def before_end(way: float, speed: float, cause: str) -> Slowed:
    """The rule for one limit: a way [m or rad] that the twist would close at a speed [m/s or rad/s]."""
    reach, way = BRAKING * speed, max(way, 0.0)
    return Slowed(way / reach, cause) if reach > way else Slowed()


class Mobility:
    """How the tool can move where the arm is: J = U diag(s) Vᵀ, with the linear rows over `LENGTH`."""

    def __init__(self, J: Array) -> None:
        self._J = J
        self._U, s, self._Vt, _ = lapack.dgesdd(_SCALE[:, None] * J, full_matrices=0)
        self.smallest = float(s[-1])
        """The smallest singular value σ."""
        self._inverse = (_SCALE[:, None] * self._U * (s / (s * s + DAMPING**2))).dot(self._Vt)

    def joint_speeds(self, twist: Array) -> Array:
        """The joint speeds of a twist by the damped pseudo-inverse [rad/s], (n,)."""
        return np.asarray(twist.dot(self._inverse))

    def smallest_rate(self, dq: Array) -> float:
        """σ̇ = uᵀ J̇ w at joint speeds q̇ [1/s]; u and w are the singular vectors of σ."""
        return float((_SCALE * self._U[:, -1]).dot(jacobian_rate(self._J, dq).dot(self._Vt[-1])))

    def ease(self, before: Array, after: Array, acceleration: Array) -> float:
        """Share of the accelerations [m/s², rad/s²], (6,), with which the twist may change without hurrying a joint."""
        duration = float((np.abs(after - before) / acceleration).max())
        now, then = self.joint_speeds(before), self.joint_speeds(after)
        # Joint by joint: while all together slow down, one may have to start.
        most = np.where(np.abs(then) < np.abs(now), SLOWER, FASTER)
        least = float((np.abs(then - now) / most).max())
        return min(1.0, duration / least) if least > 0.0 else 1.0


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """What the operator shall not reach; arrays are copied."""

    lower: Array
    """Joint positions at which the operator is stopped, (n,) [rad]; −inf for none. Give a margin inside the limits."""
    upper: Array
    """The same above, (n,) [rad]."""
    speed: Array
    """Joint speed limits [rad/s], (n,)."""
    box_low: Array = field(default_factory=lambda: np.full(3, -np.inf))
    """Least coordinates of the tool point, base frame [m], (3,)."""
    box_high: Array = field(default_factory=lambda: np.full(3, np.inf))
    """Largest coordinates of the tool point, base frame [m], (3,)."""

    def __post_init__(self) -> None:
        for name, size in (("lower", None), ("upper", None), ("speed", None), ("box_low", 3), ("box_high", 3)):
            values = read_only(getattr(self, name))
            object.__setattr__(self, name, values)
            if values.shape != ((size,) if size else np.shape(self.lower)) or np.isnan(values).any():
                raise InputError(f"Bounds: {name} = {values}; expected numbers, one a joint or one an axis")
        if not ((self.lower < self.upper).all() and (self.box_low < self.box_high).all() and (self.speed > 0.0).all()):
            raise InputError("Bounds: expected lower < upper, box_low < box_high, and speeds more than 0")

    def slowed(self, arm: Dynamics, here: Mobility, twist: Array) -> Slowed:
        """What of a twist of the tool, base axes [m/s, rad/s], (6,), the arm shall follow where it is."""
        dq = here.joint_speeds(twist)
        slowed, speeds, fastest = Slowed(), dq.tolist(), 0.0
        rows = zip(arm.q.tolist(), speeds, self.lower.tolist(), self.upper.tolist(), self.speed.tolist(), strict=True)
        ways = []
        for joint, (q, speed, lower, upper, limit) in enumerate(rows, 1):
            size = abs(speed)
            if size > fastest:
                fastest = size
            if size * slowed.share > JOINT_SPEED * limit:
                slowed = Slowed(JOINT_SPEED * limit / size, f"speed of joint {joint}")
            ways.append((upper - q if speed > 0.0 else q - lower, size, f"limit of joint {joint}"))
        aside = ASIDE * fastest
        ways.append((here.smallest - SINGULAR, -here.smallest_rate(dq), "singularity"))
        edges = zip(arm.p.tolist(), twist[:3].tolist(), self.box_low.tolist(), self.box_high.tolist(), strict=True)
        ways += [(high - p if v > 0.0 else p - low, abs(v) + aside, EDGE) for p, v, low, high in edges]
        for way, speed, cause in ways:
            reach, way = BRAKING * (speed - aside), max(way, 0.0)
            if reach > way and way / reach < slowed.share:
                slowed = Slowed(way / reach, cause)
        return slowed

    def overshot(self, here: Mobility, twist: Array) -> float:
        """By which factor a twist of the reference, (6,), is too fast for a joint; up to 1 for none."""
        return float((np.abs(here.joint_speeds(twist)) / (OVERSHOT * self.speed)).max())


def jacobian_rate(J: Array, dq: Array) -> Array:
    """J̇ at joint speeds q̇, (6, n), from the geometric Jacobian of a serial arm alone.

        J̇ᵢ = [Ωᵢ × vᵢ + ωᵢ × Vᵢ; Ωᵢ × ωᵢ],    Ωᵢ = Σ_{j ≤ i} ωⱼ q̇ⱼ,    Vᵢ = Σ_{j > i} vⱼ q̇ⱼ

    with the columns [vᵢ; ωᵢ] of J, base axes, joints from the base on. It holds for slides too, whose ω is 0.
    """
    v, w = J[:3], J[3:]
    moving = v * dq
    turning, beyond = (w * dq).cumsum(axis=1), moving[:, ::-1].cumsum(axis=1)[:, ::-1] - moving
    # All three products at once.
    products = _cross(np.concatenate([turning, w, turning], axis=1), np.concatenate([v, beyond, w], axis=1))
    n = J.shape[1]
    return np.concatenate([products[:, :n] + products[:, n : 2 * n], products[:, 2 * n :]])


def _cross(a: Array, b: Array) -> Array:
    """Column by column, (3, k); several times as fast as NumPy's own for so few."""
    (a0, a1, a2), (b0, b1, b2) = a, b
    return np.array([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0])
