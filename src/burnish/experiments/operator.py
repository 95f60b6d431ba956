"""The operator's motion that every law of the tool is given, and what is measured of a law that follows it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from burnish.core import Array, ToolReference
from burnish.trajectory import HoldPose, Move, Schedule
from burnish.trials.record import Record, rms

WAY = 0.10
"""Along each axis [m]: with `MOVE` 0.125 m/s at most, two thirds of what thesis A lets an operator do."""
TURN = 0.40
"""About each axis [rad]: 0.5 rad/s at most, half of that."""
MOVE = 1.5
"""Time of a move [s]."""
REST = 1.0
"""Time to settle between moves [s]."""
FIRST = 1.0
"""Time before the first move [s]."""
SETTLED = 0.25
"""The last part of a rest, in which what is left of the error counts as steady [s]."""
BAND = 1e-3
"""A tool that stays this near to where it comes to rest has settled [m]; a choice."""

AXES = np.vstack([np.eye(6), np.ones(6) / np.sqrt(3.0)]) * np.repeat([WAY, TURN], 3)
"""The seven excursions: along each axis, about each axis, and along and about all at once."""
LEG = 2.0 * (MOVE + REST)
"""An excursion: there, rest, back, rest [s]."""
DURATION = FIRST + len(AXES) * LEG
"""Of the whole motion [s]."""


def operator_motion() -> Schedule[ToolReference]:
    """Seven excursions from the pose at `reset`, there and back: the same for every law and every arm."""
    parts: list[tuple[float, HoldPose | Move]] = [(FIRST, HoldPose())]
    for axis in AXES:
        for step in (axis, -axis):
            parts += [(MOVE, Move(way=step[:3], turn=step[3:], duration=MOVE)), (REST, HoldPose())]
    return Schedule(parts=parts)


@dataclass(frozen=True, kw_only=True)
class Following:
    """How a law followed the operator's motion."""

    position_mm: float
    """RMS of the position error [mm]."""
    orientation_deg: float
    """RMS of the orientation error [deg]."""
    steady_mm: float
    """RMS of the position error at the end of the rests [mm]."""
    settling_s: float
    """Mean time from the end of a move until the tool stays within 1 mm of where it comes to rest [s]."""
    moved_mm: float
    """Coupling: RMS of how far the point is from where it stood when an orientation-only excursion began [mm]."""
    turned_deg: float
    """Coupling: the same of the orientation in excursions of the position alone [deg]."""
    effort_Nm: float
    """RMS of the joint torques beyond gravity [N·m]."""
    roughness_Nm_s: float
    """RMS of the rate of the joint torques, from cycle to cycle [N·m/s]."""
    step_us: float
    """Median wall time of the law [µs]."""


def following(record: Record) -> Following:
    """The figures of a record of `operator_motion`, as far as it came."""
    t, tau = record.time, np.asarray(record.tau)
    return Following(
        position_mm=1e3 * rms(record.position_error),
        orientation_deg=float(np.rad2deg(rms(record.orientation_error))),
        steady_mm=1e3 * rms(record.position_error[_rests(t, REST - SETTLED)]),
        settling_s=_settling(record),
        moved_mm=1e3 * _left_alone(record, np.asarray(record.p_d) - np.asarray(record.p), range(3, 6)),
        turned_deg=float(np.rad2deg(_left_alone(record, np.asarray(record.turn), range(3)))),
        effort_Nm=float(np.sqrt(np.mean(np.sum(tau**2, axis=1)))),
        roughness_Nm_s=float(np.sqrt(np.mean(np.sum((np.diff(tau, axis=0) / np.diff(t)[:, None]) ** 2, axis=1)))),
        step_us=float(np.median(record.step_us)),
    )


def finished(record: Record) -> bool:
    """Whether the law was not stopped on the way."""
    return record.stopped is None


def _since(t: Array, leg: int) -> Array:
    """Time since the start of an excursion [s], (N,)."""
    return np.asarray(t - FIRST - leg * LEG)


def _rests(t: Array, after: float = 0.0) -> NDArray[np.bool_]:
    """Which instants lie in a rest, this long [s] after its start, (N,)."""
    half = np.mod(_since(t, 0), 0.5 * LEG)
    return np.asarray((t >= FIRST) & (half >= MOVE + after))


def _left_alone(record: Record, error: Array, legs: range) -> float:
    """RMS of the change of an error, (N, 3), since the start of the excursions that do not ask for one."""
    changes = []
    for leg in legs:
        since = _since(record.time, leg)
        during = (since >= 0.0) & (since < LEG)
        if during.any():
            changes.append(np.linalg.norm(error[during] - error[during][0], axis=1))
    return rms(np.concatenate(changes)) if changes else float("nan")


def _settling(record: Record) -> float:
    """Mean over the rests; a rest in which the tool does not settle counts in full."""
    t, p = record.time, np.asarray(record.p)
    times = []
    for half in range(2 * len(AXES)):
        since = _since(t, 0) - half * 0.5 * LEG - MOVE
        rest = (since >= 0.0) & (since < REST)
        if rest.any():
            off = np.linalg.norm(p[rest] - p[rest & (since >= REST - SETTLED)].mean(axis=0), axis=1) > BAND
            times.append(since[rest][np.flatnonzero(off)[-1]] if off.any() else 0.0)
    return float(np.mean(times)) if times else float("nan")
