"""From the log of a job and the truth of its simulation to figures, series and removal."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from burnish.analysis.metrics import PassSeries, Scalar, pass_metrics, tilt_error
from burnish.analysis.mould_map import RemovalField
from burnish.analysis.plot import RunSeries
from burnish.core import Array, Sample, ToolReference
from burnish.finish.removal import Coverage
from burnish.finish.rubbing import Rubbing
from burnish.model.tool import PolishingTool
from burnish.polish.depth import Ground, curvature, law_of, spindle_of, target
from burnish.polish.process import SETTLE
from burnish.polish.recipe import Recipe
from burnish.sim.truth import Truth
from burnish.surface import DistanceGrid, Mould, WorkingSurface

AFTER_TOUCH = 0.05
"""Time after the first touch in which its peak may still come [s]: the lift, or the force ramp, has hardly begun."""
FIRST_SECOND = 1.0
"""Start of each later stroke that is not judged [s], as the first second of the first one is not."""
LOOK = 20
"""Cycles to both sides over which the direction of a path is taken: 0.2 s at 100 Hz."""

NOWHERE = [np.nan, np.nan, np.nan]
"""A direction where there is none."""


@dataclass(kw_only=True)
class RunLog:
    """What the loop saw, a row a cycle, and when each phase began."""

    t: list[float] = field(default_factory=list)
    measured: list[float] = field(default_factory=list)
    wanted: list[float] = field(default_factory=list)
    feed: list[float] = field(default_factory=list)
    axis: list[list[float]] = field(default_factory=list)
    """Where the tool was to point, base frame; NaN where nothing was to be pressed."""
    normal: list[list[float]] = field(default_factory=list)
    """Outward normal of the planned surface, base frame; NaN where nothing was to be pressed."""
    phases: list[tuple[float, str]] = field(default_factory=list)

    def add(self, sample: Sample) -> None:
        """Append one cycle."""
        arm, reference = sample.arm, sample.reference
        self.t.append(arm.t)
        force, wanted, feed, axis, normal = np.nan, 0.0, 0.0, NOWHERE, NOWHERE
        if isinstance(reference, ToolReference):
            n = reference.normal
            if n is not None:
                wanted = reference.force
                axis, normal = reference.R[:, 2].tolist(), n.tolist()
                feed = _along(reference.v.tolist(), normal)
            if arm.F is not None:
                # In the air the tool's own axis stands for the normal.
                force = float((n if n is not None else -arm.R[:, 2]) @ arm.F[:3])
        self.measured.append(force)
        self.wanted.append(wanted)
        self.feed.append(feed)
        self.axis.append(axis)
        self.normal.append(normal)

    def spans(self, *names: str) -> list[tuple[float, float]]:
        """Start and end of every phase of these names [s]."""
        ends = [start for start, _ in self.phases[1:]] + [np.inf]
        return [(start, end) for (start, name), end in zip(self.phases, ends, strict=True) if name in names]


def _along(v: list[float], n: list[float]) -> float:
    """Length of v less its part along n, in plain floats: it is asked for every cycle."""
    across = v[0] * n[0] + v[1] * n[1] + v[2] * n[2]
    return sqrt(max(0.0, v[0] * v[0] + v[1] * v[1] + v[2] * v[2] - across * across))


@dataclass(frozen=True, kw_only=True)
class Evaluation:
    """The result of a run."""

    metrics: dict[str, Scalar]
    """What could be measured of ``metrics.json``."""
    series: RunSeries
    """Over time."""
    removal: RemovalField
    """Over the mould."""
    trace: Array
    """Contact points in the mould's frame [m], (N, 3)."""


def evaluate(
    log: RunLog,
    truth: Truth,
    mould: Mould,
    grid: DistanceGrid,
    recipe: Recipe,
    tool: PolishingTool,
    R_base_mould: Array,
) -> Evaluation:
    """Judge a run by the true contact, at every physics step.

    ``R_base_mould``, (3, 3), is how the job took the mould to stand; so where a tool was to lean is known in the part.
    """
    t, force = truth.force()
    cycle_t = np.asarray(truth.time)
    steps = np.diff(np.concatenate([[0], np.asarray(truth.cycle_step, dtype=np.int64)]))

    def held(values: Array) -> Array:
        """A value a cycle, at every physics step of that cycle."""
        return np.repeat(values, steps)

    # The loop's row k was read at the end of cycle k − 1 and is what cycle k works on.
    row = np.clip(np.searchsorted(np.asarray(log.t), cycle_t, side="left") - 1, 0, None)
    feed, wanted = np.asarray(log.feed)[row], np.asarray(log.wanted)[row]
    tilt = lean_error(log, truth, row, R_base_mould)
    series = RunSeries(
        t=t,
        force=force,
        force_set=held(wanted),
        tilt=held(tilt),
        speed=held(np.where(np.isfinite(tilt), truth.slip, np.nan)),
        feed=held(np.where(wanted > 0.0, feed, np.nan)),
        force_measured=held(np.asarray(log.measured)[row]),
        phases=tuple(log.phases),
    )
    removal, judged = _removal(truth, mould, grid, recipe, tool)
    metrics: dict[str, Scalar] = dict(_pass_figures(log, series, recipe))
    metrics |= {
        "coverage_pct": judged.covered_pct,
        "overpolished_pct": judged.overpolished_pct,
        "removal_cv_pct": judged.cv_pct,
        "removal_mean_um": 1e6 * judged.mean,
    }
    points = np.asarray(truth.point)
    return Evaluation(metrics=metrics, series=series, removal=removal, trace=points[np.isfinite(points[:, 0])])


def lean_error(log: RunLog, truth: Truth, row: NDArray[np.int64], R_base_mould: Array) -> Array:
    """How far the tool's axis is off the commanded one at each cycle, off the normal outside of a pass [rad]."""
    axis, normal = (np.asarray(rows)[row] @ R_base_mould for rows in (log.axis, log.normal))
    error = tilt_error(truth.axis, truth.normal, axis, normal)
    return np.where(np.isfinite(error), error, truth.tilt())


def _pass_figures(log: RunLog, series: RunSeries, recipe: Recipe) -> dict[str, float]:
    """Force, tilt and feed; nothing when no stroke got past its first second."""
    t = series.t
    scored = np.zeros(len(t), dtype=bool)
    for k, (start, end) in enumerate(log.spans("pass")):
        first = start + SETTLE + (FIRST_SECOND if k else 0.0)
        scored |= (t >= first) & (t < end)
    touched = np.zeros(len(t), dtype=bool)
    for start, end in log.spans("touch", "approach"):
        touched |= (t >= start) & (t < end + AFTER_TOUCH)
    if not scored.any() or t[scored][-1] - t[scored][0] <= FIRST_SECOND:
        return {}
    tilt = series.tilt[scored]
    figures = pass_metrics(
        PassSeries(
            t=t[scored],
            force=series.force[scored],
            # Where contact is lost there is no normal; the last one stands.
            tilt=_filled(tilt),
            speed=np.nan_to_num(series.speed[scored]),
            feed=np.maximum(np.nan_to_num(series.feed[scored]), 1e-4),
            force_set=recipe.force,
            feed_set=recipe.feed,
        ),
        series.force[touched],
    )
    return figures.as_dict()


def _removal(
    truth: Truth, mould: Mould, grid: DistanceGrid, recipe: Recipe, tool: PolishingTool
) -> tuple[RemovalField, Coverage]:
    """Preston's depth at every vertex, from the true contact of every cycle, and what it covers."""
    ground = Ground.of(mould, grid, recipe)
    surface = ground.surface
    touching = np.isfinite(np.asarray(truth.point)[:, 0])
    dt = np.diff(np.concatenate([[0.0], truth.time]))[touching]
    depth = law_of(recipe).depth_of(surface, rubbed(truth, surface, recipe, tool), dt)
    wanted = target(recipe)
    field_ = RemovalField(
        vertices=surface.vertices, faces=surface.faces, removal=depth, evaluated=ground.counted, target=wanted
    )
    return field_, ground.judged(depth, wanted)


def rubbed(truth: Truth, surface: WorkingSurface, recipe: Recipe, tool: PolishingTool) -> Rubbing:
    """What the abrasive did at every cycle in contact, with the spindle at the tool's true axis.

    The size of a contact is that of Hertz's law on the surface as it is there, not on a flat: on a crest as round as
    the tip it is a fifth smaller. By the distance of a path that changes no mean depth, only where it goes; a spindle
    upright rubs in proportion to the size.
    """
    touching = np.isfinite(np.asarray(truth.point)[:, 0])
    points, normals, axes = (np.asarray(rows)[touching] for rows in (truth.point, truth.normal, truth.axis))
    slip, force = np.asarray(truth.slip)[touching], truth.cycle_force()[touching]
    round_ = curvature(recipe, surface, points, normals)
    if tool.spindle == 0.0:
        # Without spin only the size of a velocity counts.
        velocity = np.multiply.outer(slip, [1.0, 0.0, 0.0])
        return Rubbing.of(contacts=points, normals=normals, force=force, velocity=velocity, curvature=round_)
    return spindle_of(tool).rubbing(
        contacts=points,
        normals=normals,
        force=force,
        velocity=slip[:, None] * along(points, normals),
        axes=axes,
        curvature=round_,
    )


def along(points: Array, normals: Array) -> Array:
    """Unit tangents of a path that was sampled in time, over `LOOK` samples to both sides, (N, 3)."""
    k = np.arange(len(points))
    way = points[np.minimum(k + LOOK, len(k) - 1)] - points[np.maximum(k - LOOK, 0)]
    way -= np.einsum("ij,ij->i", way, normals)[:, None] * normals
    return np.asarray(way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-9))


def _filled(values: Array) -> Array:
    """NaN replaced by the last number before it, or by the first one."""
    good = np.isfinite(values)
    last = np.maximum.accumulate(np.where(good, np.arange(len(values)), -1))
    first = int(np.argmax(good)) if good.any() else 0
    return np.asarray(values[np.where(last < 0, first, last)])
