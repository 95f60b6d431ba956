"""The checks of one cycle, in their order: what is measured, how it moves, where it is, what it feels, what is asked.

Each says what it found and the limit, or nothing. A comparison with NaN is written so that it fails. One comparison of
all joints at once finds most cycles calm, well inside every limit; only else are the joints looked at one by one.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from math import degrees, inf, isfinite, sqrt
from operator import eq

import numpy as np
from scipy.linalg import lapack

from burnish.core import Array, Dynamics
from burnish.runtime.clearance import Clearance
from burnish.runtime.limits import Limits
from burnish.runtime.machine import Cause

JUMP = np.radians(2.0)
"""Difference between where a joint is and where its speed would have brought it that no motion explains [rad]."""
BELIEVABLE_SPEED = 5.0
"""Joint speed that no such arm reaches [rad/s]: degrees taken for radians, or garbage."""
BELIEVABLE_TORQUE = 4.0
"""Measured over largest joint torque that no sensor of the arm can show."""
LATE = 1.5
"""Time between two samples, in periods, from which a cycle counts as late."""
LATE_IN_A_ROW, LATE_OF_HUNDRED = 3, 5
BACK = 0.05
"""By which a clock may go back before it counts as another clock [s]; what is less is a reading come late."""
PAUSE = 0.5
"""Longest time between two samples in which a joint may have moved on [s]; beyond, the clock has leapt."""
STALE = 2
"""Samples without a newer measurement, of the arm or of one joint, that stop the arm."""
NOTICEABLE = 1e-3
"""Change of a measured torque that tells a live sensor, or an arm that moves, from an exact one at rest [N·m]."""
LYING, LYING_FOR = np.radians(10.0), 5
"""Difference of a joint speed from that of the positions [rad/s] that stops the arm, and after how many cycles."""
MODEL_ERROR = 1.25
"""Factor on a predicted acceleration: what a wrong model may hide."""
SLOW = 0.8
"""Share of a joint's speed limit from which it is braked."""
NEARLY = 0.9
"""Share of the allowed tool speed from which the tool is braked."""
LONGEST = 0.05
"""Longest period that is looked ahead [s]: after a pause the next cycle is a usual one again."""
UNSEEN, UNSEEN_MOST = 0.3, 0.5
"""Time in which is learnt what of a predicted acceleration does not come, friction above all [s], and the largest share
of a prediction that is taken off for it: in the one direction only, and never so much that a torque counts as none."""
AHEAD = 2.0
"""Cycles by which a joint's speed is predicted: a command that is sent now is felt one or two cycles later."""


@dataclass(kw_only=True)
class Guards:
    """The checks and what they remember of the cycles before."""

    limits: Limits
    period: float | None = None
    """Nominal time between two samples [s]; without it nothing is late."""
    calm: bool = field(default=False, init=False)
    """Whether all joints were well inside every limit in the last cycle: nothing to soften."""
    fresh: bool = field(default=True, init=False)
    """Whether the last state was newer than the one before."""
    hurry: float = field(default=0.0, init=False)
    """Where the tool's speed is between `NEARLY` (0) and all (1) of what is allowed."""
    distance: float = field(default=inf, init=False)
    """Of the arm from itself [m], or a bound of it that is not near."""
    _t: float = field(default=-inf, init=False, repr=False)
    _q: list[float] | None = field(default=None, init=False, repr=False)
    _stale: int = field(default=0, init=False, repr=False)
    _said: Dynamics | None = field(default=None, init=False, repr=False)
    _tau: list[float] | None = field(default=None, init=False, repr=False)
    _repeats: list[int] = field(default_factory=list, init=False, repr=False)
    _lies: list[int] = field(default_factory=list, init=False, repr=False)
    _broken: int = field(default=0, init=False, repr=False)
    _forth: list[float] = field(default_factory=list, init=False, repr=False)
    """Predicted less found accelerations of joints that go forth, smoothed [rad/s²]."""
    _back: list[float] = field(default_factory=list, init=False, repr=False)
    """The same of joints that go back: friction turns round with a joint, at once."""
    _expected: tuple[float, list[float], list[float]] = field(default=(-inf, [], []), init=False, repr=False)
    """Time, joint speeds and predicted accelerations of the last command."""
    _late: deque[bool] = field(default_factory=lambda: deque(maxlen=100), init=False, repr=False)

    def __post_init__(self) -> None:
        limits = self.limits
        low, high = limits.within(limits.hard_margin, 1.0 / 30.0)
        self._hard = list(zip(low.tolist(), high.tolist(), strict=True))
        low, high = limits.within(limits.soft_margin, 0.1)
        rows = (low, high, SLOW * limits.speed, BELIEVABLE_TORQUE * limits.torque)
        self._calm_rows = list(zip(*(row.tolist() for row in rows), strict=True))
        self._speed = limits.speed.tolist()
        self._still = np.zeros(len(low)).tolist()
        self._never = self._lies = self._repeats = [0] * len(low)
        self._forth, self._back = self._still.copy(), self._still.copy()
        # Whatever the arm weighs, it is no more than all of what it meets.
        light = limits.impact_force / sqrt(limits.impact_stiffness * limits.impact_mass)
        self._surely = NEARLY * min(limits.free_speed, light, limits.tool_speed)
        self._clearance = Clearance(limits)
        self._box = list(zip("xyz", limits.box_low.tolist(), limits.box_high.tolist(), strict=True))

    def state(self, arm: Dynamics) -> Cause | None:
        """What is wrong with what was measured: finite → length → freshness → plausibility → place → contact."""
        self.calm, self.fresh = self._calm(arm), arm.t > self._t
        cause = (None if self.calm else self._finite(arm)) or self._fresh(arm)
        if cause is None and self.fresh:
            if not self.calm:
                cause = self._plausible(arm) or self._joints(arm)
            cause = cause or self._alive(arm) or self._tool(arm)
            self.calm = self.calm and self.hurry == 0.0 and self.distance >= self.limits.self_slow
        if self._broken == 0 and isfinite(arm.t):
            self._t = arm.t if arm.t > self._t or self._t - arm.t > BACK else self._t
            self._q = arm.q.tolist()
        return cause

    def _calm(self, arm: Dynamics) -> bool:
        """Whether the measured joints are finite, believable, slow, and far from their limits."""
        n = len(self._still)
        if not (isfinite(arm.t) and len(arm.q) == len(arm.dq) == n and (arm.tau is None or len(arm.tau) == n)):
            return False
        q = arm.q.tolist()
        before, dt = (q, 0.0) if self._q is None else (self._q, min(arm.t - self._t, PAUSE))
        off = min(LYING * dt, JUMP)
        tau = self._still if arm.tau is None else arm.tau.tolist()
        rows = zip(q, before, arm.dq.tolist(), tau, self._calm_rows, strict=True)
        for q_i, before_i, dq, tau_i, (low, high, slow, most) in rows:
            moved = q_i - before_i - dq * dt
            if not (low <= q_i <= high and -slow <= dq <= slow and -most <= tau_i <= most and -off <= moved <= off):
                return False
        self._broken, self._lies = 0, self._never
        return True

    def command(self, torque: Array) -> Cause | None:
        """What is wrong with what the law asks."""
        if torque.shape != self.limits.torque.shape:
            return Cause(f"the control law gave a torque of shape {torque.shape}; expected {self.limits.torque.shape}")
        if not finite(torque):
            return Cause("the control law gave a torque that is not finite")
        return None

    def ahead(self, arm: Dynamics, sent: Array, period: float) -> Cause | None:
        """Whether a joint would be too fast by the time when this torque can have been taken back.

        That is two cycles, and then half of the time in which the rate clamp can undo what accelerates the joint. What
        did not come of the accelerations before is taken off: a law that makes up for friction speeds up no joint.
        """
        free = sent - arm.h
        free -= arm.g
        if arm.F is not None:
            free += arm.F.dot(arm.J)
        _, ddq, info = lapack.dposv(arm.M, free, lower=1)
        if info != 0:
            return Cause("the mass matrix of the model is not positive definite", fault=True)
        horizon, undo = AHEAD * min(period, LONGEST), 0.5 * MODEL_ERROR / self.limits.torque_rate
        speeds, expected = arm.dq.tolist(), ddq.tolist()
        self._learn(arm.t, speeds, expected)
        rows = zip(expected, speeds, arm.M.diagonal().tolist(), self._speed, strict=True)
        for i, (ddq_i, now, inertia, limit) in enumerate(rows):
            then = now + MODEL_ERROR * ddq_i * (horizon + undo * inertia * abs(ddq_i))
            if -limit <= then <= limit:
                continue
            unseen = self._forth[i] if ddq_i > 0.0 else self._back[i]
            if unseen * ddq_i > 0.0:
                most = UNSEEN_MOST * ddq_i
                ddq_i -= unseen if abs(unseen) < abs(most) else most
                then = now + MODEL_ERROR * ddq_i * (horizon + undo * inertia * abs(ddq_i))
            # What brakes a joint that is too fast is let through.
            if not (-limit <= then <= limit or abs(then) <= abs(now)):
                return Cause(f"joint {i + 1} would reach {abs(then):.2f} rad/s; the limit is {limit:.2f} rad/s")
        return None

    def _learn(self, t: float, dq: list[float], ddq: list[float]) -> None:
        """What of the accelerations that were predicted a cycle ago did not come."""
        before, dq_before, ddq_before = self._expected
        self._expected = t, dq, ddq
        dt = t - before
        if not 0.0 < dt <= LONGEST:
            self._forth, self._back = self._still.copy(), self._still.copy()
            return
        share, rate = dt / UNSEEN, 1.0 / dt
        for i, (now, then, ddq_then) in enumerate(zip(dq, dq_before, ddq_before, strict=True)):
            unseen = self._forth if (now or ddq_then) > 0.0 else self._back
            unseen[i] += share * (ddq_then - rate * (now - then) - unseen[i])

    def _finite(self, arm: Dynamics) -> Cause | None:
        self._broken += 1
        if not arm.q.shape == arm.dq.shape == (arm.q if arm.tau is None else arm.tau).shape == self.limits.speed.shape:
            return Cause(f"the state has {len(arm.q)} joints; the limits have {len(self.limits.speed)}", fault=True)
        if isfinite(arm.t) and finite(arm.q) and finite(arm.dq) and (arm.tau is None or finite(arm.tau)):
            self._broken = 0
            return None
        if self._broken > 2:
            return Cause("the measured state is not finite for three cycles", fault=True)
        return Cause("the measured state is not finite")

    def _fresh(self, arm: Dynamics) -> Cause | None:
        if self._t - arm.t > BACK:
            return Cause(f"the clock of the readings went back by {self._t - arm.t:.3g} s")
        self._stale = 0 if self.fresh else self._stale + 1
        if self._stale >= STALE:
            return Cause(f"the state is stale: nothing newer than t = {self._t:.3f} s for {self._stale} cycles")
        if self.period is not None and isfinite(self._t) and self._stale == 0:
            gap = arm.t - self._t
            self._late.append(gap > LATE * self.period)
            if self._late[-1] and (sum(self._late) >= LATE_OF_HUNDRED or self._last_late() >= LATE_IN_A_ROW):
                return Cause(f"cycles are late: {1e3 * gap:.1f} ms; expected {1e3 * self.period:.1f} ms")
        return None

    def _last_late(self) -> int:
        """How many of the last cycles in a row were late."""
        count = 0
        for late in reversed(self._late):
            if not late:
                break
            count += 1
        return count

    def _plausible(self, arm: Dynamics) -> Cause | None:
        limits, speeds = self.limits, arm.dq.tolist()
        if arm.tau is not None:
            for i, (tau, most) in enumerate(zip(arm.tau.tolist(), limits.torque.tolist(), strict=True)):
                if abs(tau) > BELIEVABLE_TORQUE * most:
                    return Cause(f"joint {i + 1} reports {tau:.3g} N·m; no more than {most:.1f} N·m is possible")
        for i, (dq, limit) in enumerate(zip(speeds, limits.speed.tolist(), strict=True)):
            if abs(dq) > max(BELIEVABLE_SPEED, 2.0 * limit):
                return Cause(f"joint {i + 1} reports {abs(dq):.3g} rad/s; expected radians, and less")
            if abs(dq) > limit:
                return Cause(f"joint {i + 1} moved at {abs(dq):.2f} rad/s; the limit is {limit:.2f} rad/s")
        if self._q is not None:
            dt = min(arm.t - self._t, PAUSE)
            for i, (q, before, dq) in enumerate(zip(arm.q.tolist(), self._q, speeds, strict=True)):
                if abs(q - before - dq * dt) > JUMP + abs(dq) * dt:
                    return Cause(f"joint {i + 1} jumped by {degrees(q - before):.1f}° within {1e3 * dt:.0f} ms")
            moved = zip(arm.q.tolist(), self._q, speeds, self._lies, strict=True)
            self._lies = [n + 1 if abs(q - before - dq * dt) > LYING * dt else 0 for q, before, dq, n in moved]
            if max(self._lies) >= LYING_FOR:
                i = self._lies.index(max(self._lies))
                found = degrees((float(arm.q[i]) - self._q[i]) / dt)
                return Cause(
                    f"joint {i + 1} reports {degrees(speeds[i]):.0f} °/s, and its position moves at {found:.0f} °/s"
                )
        return None

    def _alive(self, arm: Dynamics) -> Cause | None:
        """A joint that says the very same again and again, while the others do not: noise alone makes that unlikely."""
        before, tau_before, self._said = self._said, self._tau, arm
        self._tau = None if arm.tau is None else arm.tau.tolist()
        # Of two readings with noise no two numbers are alike.
        if before is None or self._tau is None or tau_before is None or not any(map(eq, self._tau, tau_before)):
            self._repeats = self._never
            return None
        assert arm.tau is not None
        assert before.tau is not None
        # No torque at all is what an exact sensor reads of a joint that carries nothing.
        same = (arm.q == before.q) & (arm.dq == before.dq) & (arm.tau == before.tau) & (arm.tau != 0.0)
        if not (np.abs(arm.tau - before.tau) > NOTICEABLE).any():
            same[:] = False
        self._repeats = [n + 1 if s else 0 for n, s in zip(self._repeats, same.tolist(), strict=True)]
        if max(self._repeats) < STALE:
            return None
        return Cause(f"joint {self._repeats.index(max(self._repeats)) + 1} reports the same for {STALE + 1} cycles")

    def _joints(self, arm: Dynamics) -> Cause | None:
        for i, (q, (low, high)) in enumerate(zip(arm.q.tolist(), self._hard, strict=True)):
            if not low <= q <= high:
                left = min(q - float(self.limits.lower[i]), float(self.limits.upper[i]) - q)
                return Cause(f"joint {i + 1} is {degrees(left):.1f}° from its limit", fault=left < 0.0)
        return None

    def _tool(self, arm: Dynamics) -> Cause | None:
        """Where the tool is, what it feels, and how fast it and the arm are."""
        limits = self.limits
        for p, (axis, low, high) in zip(arm.p.tolist(), self._box, strict=True):
            if not low <= p <= high:
                return Cause(f"the tool left its work space: {axis} = {p:.3f} m; expected {low:.3f} to {high:.3f} m")
        self.distance = self._clearance.at(arm)
        if not self.distance > limits.self_stop:
            found, least = 1e3 * self.distance, 1e3 * limits.self_stop
            return Cause(f"the arm is {found:.0f} mm from hitting itself; expected more than {least:.0f} mm")
        if arm.F is not None:
            fx, fy, fz, *_ = arm.F.tolist()
            force = sqrt(fx * fx + fy * fy + fz * fz)
            if not force <= limits.tool_force:
                return Cause(f"the tool force reached {force:.1f} N; the limit is {limits.tool_force:.0f} N")
        self.hurry = 0.0
        if self._surely < inf:
            vx, vy, vz, *_ = arm.v.tolist()
            speed = sqrt(vx * vx + vy * vy + vz * vz)
            if not speed <= self._surely:
                allowed = allowed_speed(limits, arm, arm.v[:3])
                if not speed <= allowed:
                    return Cause(f"the tool moved at {speed:.2f} m/s; the limit is {allowed:.2f} m/s")
                self.hurry = max(0.0, (speed / allowed - NEARLY) / (1.0 - NEARLY))
        if limits.energy < inf:
            energy = 0.5 * float(arm.dq.dot(arm.M.dot(arm.dq)))
            if not energy <= limits.energy:
                return Cause(f"the arm's kinetic energy reached {energy:.2f} J; the limit is {limits.energy:.2f} J")
        return None


def allowed_speed(limits: Limits, arm: Dynamics, v: Array) -> float:
    """Speed along ``v``, (3,), at which the tool meets somebody with no more than the allowed force [m/s].

    v = F/√(k μ), 1/μ = 1/m + 1/m_head, with the mass m that is felt along the motion (`mobility`). Source: ISO/TS
    15066, A.3.6, which takes half of the moving parts' mass for m.
    """
    most = min(limits.free_speed, limits.tool_speed)
    if limits.impact_force == inf:
        return most
    _, lightness = mobility(arm, v)
    reduced = 1.0 / (lightness + 1.0 / limits.impact_mass)
    return min(most, limits.impact_force / sqrt(limits.impact_stiffness * reduced))


def mobility(arm: Dynamics, v: Array) -> tuple[Array, float]:
    """Acceleration of the joints, M⁻¹ Jᵀ u, and of the tool, uᵀ J M⁻¹ Jᵀ u, by a newton along ``v`` = |v| u, (3,).

    The latter is one over the mass that is felt there [1/kg], rotors of M included; 0 if M is no mass matrix.
    """
    along = v.dot(arm.J[:3]) / sqrt(float(v.dot(v)))
    _, ddq, info = lapack.dposv(arm.M, along, lower=1)
    return ddq, float(along.dot(ddq)) if info == 0 else 0.0


def finite(values: Array) -> bool:
    """Whether all values are finite."""
    return all(map(isfinite, values.tolist()))
