"""The judge of an episode: reads the raw log of the plant and nothing else, with limits of its own.

It shares no code with what it judges: NumPy, JSON and this file. A log is columns of numbers, a row each time that the
arm was measured, and a header. Columns, (N,) or (N, n) or (N, 3), in SI units and of the **plant**, not of what the
controller was told:

    t          time of the measurement
    told       the time stamp that the controller was given with it; NaN where it was given none
    q dq       joint positions and speeds
    tau        torque that was sent to the arm; the last one where nothing was sent
    sent       whether something was sent
    held       whether the supervisor then said that it holds the arm
    p          tool position
    weight     gravity torque of the nominal model
    force      largest contact force since the row before
    energy     kinetic energy by the nominal model

``p``, ``weight`` and ``energy`` may be NaN in rows that were left out to save time. The header has ``fault_at``, the
time of the cycle in which a fault that must be noticed first reached the controller (a bad sample that was lost on the
way never did), else the time from which any fault could, or null; and ``urgency``: ``invalid``, ``stale``, ``frozen``
(one joint is stale), or null where nothing came that a supervisor need notice.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

LIMITS = Path(__file__).parent.parent / "assets" / "judge_limits.json"
ROUNDING = 1e-9
"""Share by which a clamped torque may be over its limit in floating point, and the same in N·m."""

Column = NDArray[np.float64]
Rows = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """What an episode came to; times in s, None where there is nothing to say."""

    not_finite: int
    """Torque samples with a number that is none."""
    over_cap: int
    """Torque samples beyond a joint's largest torque."""
    over_rate: int
    """Torque samples that differ from the one before by more than the rate allows in the time between them."""
    not_held: int
    """Torque samples, from a grace after a stop on, that no hold of the arm about that place would ask for."""
    stopped_at: float | None
    """When the supervisor first said that it holds the arm."""
    reaction: int | None
    """Cycles from the first sample of an urgent fault to the stop: 0 is the cycle of that sample."""
    late: bool
    """Whether an urgent fault was answered too late or not at all."""
    peak_speed: float
    """Largest joint speed over its limit."""
    still_after: float | None
    """Time from the stop until no joint was faster than 1 °/s any more."""
    moving: bool
    """Whether a stopped arm still moved when the episode ended."""
    slow_stop: bool
    """Whether it came to rest, but took longer than is allowed."""
    drift: float | None
    """Farthest way of the tool from where the stop began, within 2 s and while the controller could see [m]."""
    watched: float | None
    """For how long after the stop that was looked at [s]."""
    peak_force: float
    """Largest contact force [N]."""
    energy_stop: float | None
    """Kinetic energy at the stop [J]."""
    energy_end: float | None
    """Kinetic energy at the end [J]."""

    @property
    def unsafe(self) -> int:
        """Unsafe torque samples, counted once for each rule that they break."""
        return self.not_finite + self.over_cap + self.over_rate + self.not_held


def load_limits(path: Path = LIMITS) -> dict[str, Any]:
    """The judge's limits file."""
    limits: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return limits


def judge(log: Mapping[str, Column], header: Mapping[str, Any], limits: Mapping[str, Any]) -> Verdict:
    """The verdict on one log."""
    t, tau, sent = log["t"], log["tau"], log["sent"].astype(bool)
    not_finite, over_cap, over_rate = _torque(t[sent], tau[sent], limits)
    held = log["held"].astype(bool)
    stop = int(np.argmax(held)) if held.any() else None
    seen = _seen(log, limits)
    reaction, late = _reaction(t, sent, stop, header, limits)
    after = np.zeros(len(t), dtype=bool) if stop is None else seen & (np.arange(len(t)) >= stop)
    still_after, moving = _rest(t, log["dq"], after, limits)
    drift = None if stop is None else _drift(log, after & (t <= t[stop] + limits["drift_s"]))
    energy = log["energy"][after & np.isfinite(log["energy"])]
    return Verdict(
        not_finite=not_finite,
        over_cap=over_cap,
        over_rate=over_rate,
        not_held=0 if stop is None else _not_held(log, after, stop, limits),
        stopped_at=None if stop is None else float(t[stop]),
        reaction=reaction,
        late=late,
        peak_speed=float(np.max(np.abs(np.degrees(log["dq"])) / limits["speed_deg_s"])),
        still_after=still_after,
        moving=moving,
        slow_stop=still_after is not None and still_after > limits["stop_s"],
        drift=drift,
        watched=float(t[after][-1] - t[after][0]) if after.any() else None,
        peak_force=float(np.max(log["force"])),
        energy_stop=float(energy[0]) if len(energy) else None,
        energy_end=float(energy[-1]) if len(energy) else None,
    )


def _torque(t: Column, tau: Column, limits: Mapping[str, Any]) -> tuple[int, int, int]:
    """Samples that are not finite, over the cap, over the rate; t and tau of what was sent."""
    bad: Rows = np.logical_not(np.isfinite(tau).all(axis=1))
    # What is no number is counted as that alone.
    over = (np.abs(tau) > np.array(limits["torque_Nm"]) * (1.0 + ROUNDING)).any(axis=1) & ~bad
    allowed = limits["torque_rate_Nm_s"] * np.diff(t)[:, None]
    fast = (np.abs(np.diff(tau, axis=0)) > allowed * (1.0 + ROUNDING) + ROUNDING).any(axis=1)
    return int(bad.sum()), int(over.sum()), int((fast & ~bad[1:] & ~bad[:-1]).sum())


def _seen(log: Mapping[str, Column], limits: Mapping[str, Any]) -> Rows:
    """Rows at which the controller had been given something new within the time that a hold by torque must bridge."""
    t = log["t"]
    told = np.nan_to_num(log["told"], nan=-np.inf, posinf=-np.inf)
    newest = np.maximum.accumulate(told)
    new = np.concatenate([[True], newest[1:] > newest[:-1]])
    last = np.maximum.accumulate(np.where(new, t, -np.inf))
    return np.asarray(t - last <= limits["blind_s"])


def _reaction(
    t: Column, sent: Rows, stop: int | None, header: Mapping[str, Any], limits: Mapping[str, Any]
) -> tuple[int | None, bool]:
    """Cycles of the controller from the first bad sample to the stop, and whether those were too many."""
    at, urgency = header["fault_at"], header["urgency"]
    given = np.flatnonzero(sent & (t >= (np.inf if at is None else at)))
    if urgency is None or not len(given):
        return None, False
    if stop is None:
        return None, True
    cycles = int(np.searchsorted(given, stop))
    return cycles, cycles > limits["reaction_cycles"][urgency]


def _rest(t: Column, dq: Column, after: Rows, limits: Mapping[str, Any]) -> tuple[float | None, bool]:
    """Time from the stop to rest; and whether there was none."""
    if not after.any():
        return None, False
    t, fast = t[after], (np.abs(np.degrees(dq[after])) > limits["still_deg_s"]).any(axis=1)
    # With less than the time to stop left, nothing can be said of it.
    if t[-1] - t[0] < limits["stop_s"] + limits["still_for_s"]:
        return None, False
    if fast[t > t[-1] - limits["still_for_s"]].any():
        return None, True
    return 0.0 if not fast.any() else float(t[len(fast) - int(np.argmax(fast[::-1]))] - t[0]), False


def _drift(log: Mapping[str, Column], rows: Rows) -> float | None:
    """Farthest way of the tool from its place in the first of these rows [m]."""
    p = log["p"][rows & np.isfinite(log["p"]).all(axis=1)]
    return float(np.max(np.linalg.norm(p - p[0], axis=1))) if len(p) else None


def _not_held(log: Mapping[str, Column], after: Rows, stop: int, limits: Mapping[str, Any]) -> int:
    """Samples that no spring and damper of the allowed strength asks for about a place near the stop, weight aside."""
    weight = log["weight"]
    rows = after & (log["t"] > log["t"][stop] + limits["hold_grace_s"]) & np.isfinite(weight).all(axis=1)
    rows &= log["sent"].astype(bool)
    off = np.abs(log["q"][rows] - log["q"][stop]) + limits["hold_reach_rad"]
    most = np.array(limits["hold_stiffness_Nm_rad"]) * off + limits["hold_slack_Nm"]
    most = most + np.array(limits["hold_damping_Nms_rad"]) * np.abs(log["dq"][rows])
    return int((np.abs(log["tau"][rows] - weight[rows]) > most).any(axis=1).sum())
