"""The figures of a trial: how far off it was, how soon it settled, what it disturbed, and what that cost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from burnish.core import Array
from burnish.trials.record import Record, rms

STEADY = 1.0
"""Time at the end over which the steady-state errors are taken [s]."""
SETTLED_SHARE = 0.02
"""Share of a step within which its error counts as settled,"""
SETTLED_POSITION, SETTLED_ORIENTATION = 1e-3, np.deg2rad(0.5)
"""or these errors [m], [rad], whichever is more."""
STILL = 1e-7
"""A reference that moves by less than this a cycle [m, rad] stands."""


@dataclass(frozen=True, kw_only=True)
class Figures:
    """Figures of one trial; None for one that its reference gives no meaning to."""

    position_rmse_mm: float
    """RMS of |p_d − p|."""
    orientation_rmse_deg: float
    """RMS of the angle between the tool and its reference."""
    joint_rmse_mrad: float | None
    """RMS over all joints of q_d − q; None for a reference of the tool."""
    position_steady_mm: float
    """RMS of |p_d − p| over the last second."""
    orientation_steady_deg: float
    """RMS of the angle over the last second."""
    settling_s: float | None
    """From the last change of the reference until position and orientation stay within 2 % of the error that was left
    then, or within 1 mm and 0.5°; None where they never do, or the reference never stands."""
    coupling_position_peak_mm: float | None
    """Largest |p_d − p| while only the orientation of the reference moves; None where it is otherwise."""
    coupling_position_rms_mm: float | None
    """RMS of the same."""
    coupling_orientation_peak_deg: float | None
    """Largest angle while only the position of the reference moves; None where it is otherwise."""
    coupling_orientation_rms_deg: float | None
    """RMS of the same."""
    effort_Nm: float
    """Torque effort: RMS over time of |τ − g|, all joints together."""
    roughness_Nm_s: float
    """RMS over time of |change of τ − g in a cycle| / period, all joints together [N·m/s]."""
    step_median_us: float
    """Wall time of the law in a cycle, median."""
    step_p5_us: float
    """The same, 5th percentile: what it takes when nothing is in the way."""


def figures(record: Record) -> Figures:
    """The figures of a record of at least one cycle."""
    t, e_p, e_o = record.time, record.position_error, record.orientation_error
    joint, tau = np.asarray(record.joint_error), np.asarray(record.tau)
    only_turned, only_shifted = only_orientation_moves(record), only_position_moves(record)
    end = t >= t[-1] - STEADY
    return Figures(
        position_rmse_mm=1e3 * rms(e_p),
        orientation_rmse_deg=float(np.degrees(rms(e_o))),
        joint_rmse_mrad=None if np.isnan(joint).any() else 1e3 * rms(joint),
        position_steady_mm=1e3 * rms(e_p[end]),
        orientation_steady_deg=float(np.degrees(rms(e_o[end]))),
        settling_s=settling(record),
        coupling_position_peak_mm=1e3 * float(e_p.max()) if only_turned else None,
        coupling_position_rms_mm=1e3 * rms(e_p) if only_turned else None,
        coupling_orientation_peak_deg=float(np.degrees(e_o.max())) if only_shifted else None,
        coupling_orientation_rms_deg=float(np.degrees(rms(e_o))) if only_shifted else None,
        effort_Nm=rms(np.linalg.norm(tau, axis=1)),
        roughness_Nm_s=roughness(t, tau),
        step_median_us=float(np.median(record.step_us)),
        step_p5_us=float(np.percentile(record.step_us, 5.0)),
    )


def roughness(t: Array, tau: Array) -> float:
    """RMS of |Δτ|/Δt [N·m/s] over the cycles; 0 for fewer than two."""
    if len(t) < 2:
        return 0.0
    return rms(np.linalg.norm(np.diff(tau, axis=0), axis=1) / np.diff(t))


def only_orientation_moves(record: Record) -> bool:
    """Whether the reference turns in place."""
    shifts, turns = _changes(record)
    return bool(turns.any() and not shifts.any())


def only_position_moves(record: Record) -> bool:
    """Whether the reference shifts without turning."""
    shifts, turns = _changes(record)
    return bool(shifts.any() and not turns.any())


def settling(record: Record) -> float | None:
    """Time from the last change of the reference until both errors stay small [s]; None if they do not."""
    shifts, turns = _changes(record)
    moved = np.flatnonzero(shifts | turns)
    start = int(moved[-1]) + 1 if len(moved) else 0
    t, e_p, e_o = record.time[start:], record.position_error[start:], record.orientation_error[start:]
    if len(t) < 2:
        return None
    large = (e_p > max(SETTLED_POSITION, SETTLED_SHARE * e_p[0])) | (
        e_o > max(float(SETTLED_ORIENTATION), SETTLED_SHARE * e_o[0])
    )
    if large[-1]:
        return None
    late = np.flatnonzero(large)
    return float(t[late[-1] + 1] - t[0]) if len(late) else 0.0


def _changes(record: Record) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Between which cycles the reference shifts, and between which it turns, (N − 1,) each."""

    def moved(values: Array) -> NDArray[np.bool_]:
        return np.asarray(np.abs(np.diff(values, axis=0)).max(axis=1, initial=0.0) > STILL)

    return moved(np.asarray(record.p_d)), moved(np.asarray(record.turn_d))
