"""The figures of one polishing pass, from the series that the run left behind.

The pass is the time with force control on at full set force; its first second, in which the approach dies
away, does not count; everything after it does, the reversals of the tool path included. Samples are taken to
be evenly spaced in time, so a share of the samples is a share of the time.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from burnish.analysis.atomic import write_atomically
from burnish.core import Array, read_only
from burnish.errors import InputError

SETTLING_TIME = 1.0
"""Time after the start of the pass that does not count [s]."""
CONTACT_FORCE = 0.2
"""Contact forces below this are no contact [N]; below the noise of a wrist sensor, far below any set force."""

Scalar = float | int | str | bool


@dataclass(frozen=True, kw_only=True)
class PassSeries:
    """What happened while force control was on at full set force; all arrays (N,)."""

    t: Array
    """Time [s], increasing."""
    force: Array
    """True contact force along the surface normal, positive when the tool presses [N]."""
    tilt: Array
    """Angle between the tool's axis and the commanded one, the inward surface normal if it does not lean [rad]."""
    speed: Array
    """Speed of the tool tangential to the surface [m/s]."""
    feed: Array
    """Commanded feed [m/s], positive; a scalar is taken for all samples."""
    force_set: float
    """Set force [N]."""
    feed_set: float
    """Feed of the recipe [m/s]; the commanded one is lower in turns."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "feed", np.broadcast_to(np.asarray(self.feed, dtype=np.float64), np.shape(self.t)))
        for name in ("t", "force", "tilt", "speed", "feed"):
            values = read_only(getattr(self, name))
            object.__setattr__(self, name, values)
            if values.ndim != 1 or values.shape != self.t.shape:
                raise InputError(f"PassSeries: {name} has shape {values.shape}; expected that of t, {self.t.shape}")
            if not np.isfinite(values).all():
                raise InputError(f"PassSeries: {name} is not finite at sample {int(np.argmin(np.isfinite(values)))}")
        if not (np.diff(self.t) > 0.0).all():
            raise InputError("PassSeries: t does not increase at every sample; sort the samples, drop repeated ones")
        if not (self.feed > 0.0).all():
            raise InputError("PassSeries: the commanded feed is not positive everywhere; leave out pauses")

    def scored(self) -> PassSeries:
        """The part that counts: all after the settling time.

        Raises:
            InputError: if the pass is not longer than the settling time.
        """
        if len(self.t) == 0 or self.t[-1] < self.t[0] + SETTLING_TIME:
            raise InputError(f"the pass is not longer than its settling time of {SETTLING_TIME} s; nothing to score")
        # Half a nanosecond of slack: the border belongs to the score, however it was rounded.
        late = self.t >= self.t[0] + SETTLING_TIME - 5e-10
        series = {name: getattr(self, name)[late] for name in ("t", "force", "tilt", "speed", "feed")}
        return PassSeries(**series, force_set=self.force_set, feed_set=self.feed_set)


@dataclass(frozen=True, kw_only=True)
class PassMetrics:
    """Force, tilt and feed of a pass; the names are those of ``metrics.json``."""

    force_set_N: float
    """Set force."""
    force_rms_N: float
    """Root mean square of F − F_set."""
    force_mean_N: float
    """Mean of F."""
    force_p99_N: float
    """99th percentile of |F − F_set|."""
    touch_peak_N: float
    """Largest F from the first touch until the force ramp begins."""
    contact_lost_pct: float
    """Share of the time with F < 0.2 N."""
    tilt_rms_deg: float
    """Root mean square of the angle between the tool's axis and the commanded one."""
    tilt_max_deg: float
    """Largest such angle."""
    feed_rms_pct: float
    """Root mean square of tangential speed − commanded feed, over the recipe's feed."""

    def as_dict(self) -> dict[str, float]:
        """Name to figure."""
        return {item.name: getattr(self, item.name) for item in fields(self)}


def pass_metrics(series: PassSeries, touch_force: ArrayLike) -> PassMetrics:
    """The figures of a pass.

    Args:
        series: the whole time at full set force; the settling time is cut off here.
        touch_force: true contact force from the first touch until the force ramp begins [N], (K,), K ≥ 1.
    """
    scored = series.scored()
    error = scored.force - scored.force_set
    tilt_deg = np.degrees(scored.tilt)
    return PassMetrics(
        force_set_N=scored.force_set,
        force_rms_N=rms(error),
        force_mean_N=float(np.mean(scored.force)),
        force_p99_N=float(np.percentile(np.abs(error), 99.0)),
        touch_peak_N=touch_peak(touch_force),
        contact_lost_pct=100.0 * float(np.mean(scored.force < CONTACT_FORCE)),
        tilt_rms_deg=rms(tilt_deg),
        tilt_max_deg=float(np.max(np.abs(tilt_deg))),
        feed_rms_pct=100.0 * rms(scored.speed - scored.feed) / scored.feed_set,
    )


def rms(values: ArrayLike) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(np.asarray(values, dtype=np.float64)))))


def touch_peak(touch_force: ArrayLike) -> float:
    """Largest contact force between the first touch and the force ramp [N].

    Raises:
        InputError: if there is no sample, or one that is not finite.
    """
    force = np.asarray(touch_force, dtype=np.float64)
    if force.size == 0 or not np.isfinite(force).all():
        raise InputError("touch_peak: expected at least one sample, all finite; the tool never touched the surface")
    return float(np.max(force))


def tilt(tool_axis: ArrayLike, normal: ArrayLike) -> Array:
    """Angle between the tool's axis and the inward surface normal [rad], (N,), exact also near zero.

    Args:
        tool_axis: unit vectors out of the flange into the work, (N, 3).
        normal: outward unit normals of the surface in the same axes, (N, 3).
    """
    axis, inward = np.asarray(tool_axis, dtype=np.float64), -np.asarray(normal, dtype=np.float64)
    sine = np.linalg.norm(np.cross(axis, inward), axis=-1)
    return np.asarray(np.arctan2(sine, np.sum(axis * inward, axis=-1)))


def tilt_error(tool_axis: ArrayLike, normal: ArrayLike, planned_axis: ArrayLike, planned_normal: ArrayLike) -> Array:
    """Angle between the tool's axis and where it was to point over the surface that is there [rad], (N,).

    The planned axis is carried along by the least turn from the planned normal m to the normal n,
    ``z + w × z + w × (w × z)/(1 + m·n)`` with w = m × n; without a lean this is `tilt`.

    Args:
        tool_axis: unit vectors out of the flange into the work, (N, 3).
        normal: outward unit normals of the surface, (N, 3).
        planned_axis: where the tool was to point over the planned surface, (N, 3).
        planned_normal: outward unit normals of that, less than 180° off, (N, 3); all four in the same axes.
    """
    n, z, m = (np.asarray(rows, dtype=np.float64) for rows in (normal, planned_axis, planned_normal))
    w = np.cross(m, n)
    carried = z + np.cross(w, z) + np.cross(w, np.cross(w, z)) / (1.0 + np.sum(m * n, axis=-1, keepdims=True))
    return tilt(tool_axis, -carried)


def tangential_speed(velocity: ArrayLike, normal: ArrayLike) -> Array:
    """Speed along the surface [m/s], (N,), from velocities [m/s] and unit normals, (N, 3) each."""
    v, n = np.asarray(velocity, dtype=np.float64), np.asarray(normal, dtype=np.float64)
    return np.asarray(np.linalg.norm(v - np.sum(v * n, axis=-1, keepdims=True) * n, axis=-1))


def write_metrics(path: Path | str, metrics: Mapping[str, Scalar]) -> None:
    """Write ``metrics.json``: sorted keys, finite numbers only, whole or not at all.

    Raises:
        InputError: if a figure is not finite, or the file cannot be written.
    """
    plain = {name: value.item() if isinstance(value, np.generic) else value for name, value in metrics.items()}
    for name, value in plain.items():
        if isinstance(value, float) and not math.isfinite(value):
            raise InputError(f"metric {name} is {value}; expected a finite number. Leave out what was not measured")
    text = json.dumps(plain, indent=2, sort_keys=True, ensure_ascii=False, allow_nan=False)
    write_atomically(Path(path), (text + "\n").encode())
