"""What a run reached, with what earlier runs of the same job took off, and pass by pass."""

from __future__ import annotations

import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from burnish.analysis.metrics import Scalar
from burnish.commands.course import Earlier
from burnish.commands.evaluate import FIRST_SECOND, Evaluation, evaluate
from burnish.commands.work import Work
from burnish.core import Array
from burnish.errors import RecordingError
from burnish.finish.removal import coverage
from burnish.polish.process import SETTLE, Job
from burnish.surface import Mould, WorkingSurface

REMOVED = "removed.npz"
"""What all runs of a job took off so far, in its folder."""
BEFORE = "before.npz"
"""What was taken off before a repair, in its folder."""


def judged(work: Work, folder: Path) -> Evaluation:
    """The figures of a run; those of the surface are of all runs of the job, whose sum is kept in the folder.

    Raises:
        RecordingError: what was kept cannot be read.
    """
    result = evaluate(
        work.log, work.robot.truth, work.mould, work.grid, work.course.recipe, work.tool, work.job.placement.R
    )
    depth = result.removal.removal
    if work.course.runs or work.course.mends:
        depth = depth + removed(folder, work.mould, len(depth), REMOVED)
    keep(folder, depth, work.mould, REMOVED)
    if work.course.plain and not work.course.runs:
        return result
    target = result.removal.target * work.course.repeats
    removal = replace(result.removal, removal=depth, target=target)
    surface = WorkingSurface(vertices=removal.vertices, faces=removal.faces)
    found = coverage(depth, target, surface.areas, removal.evaluated)
    metrics: dict[str, Scalar] = result.metrics | {
        "coverage_pct": found.covered_pct,
        "overpolished_pct": found.overpolished_pct,
        "removal_cv_pct": found.cv_pct,
        "removal_mean_um": 1e6 * found.mean,
    }
    if work.course.mends:
        before = coverage(removed(folder, work.mould, len(depth), BEFORE), target, surface.areas, removal.evaluated)
        metrics |= {"coverage_before_pct": before.covered_pct, "removal_cv_before_pct": before.cv_pct}
    errors = _errors(work, result)
    if len(errors):
        # Passes may have forces of their own, so the error is taken sample by sample.
        metrics |= {
            "force_rms_N": float(np.sqrt(np.mean(errors**2))),
            "force_p99_N": float(np.percentile(np.abs(errors), 99.0)),
        }
    return replace(result, metrics=metrics, removal=removal)


def passes_table(work: Work, result: Evaluation) -> list[tuple[str, ...]]:
    """Pass, path, mean force, force error RMS and stiffness of the contact, in words, a row a pass of this run."""
    rows: list[tuple[str, ...]] = []
    for number in sorted({number for number, _, _ in work.spans}):
        error, force = _errors(work, result, number), _forces(work, result, number)
        stiffness = work.job.drift.stiffness(number)
        path = sum(_done(work.job, k) for k, leg in enumerate(work.job.legs) if leg.number == number)
        rows.append(
            (
                str(number),
                f"{path:.2f}",
                f"{force.mean():.2f}" if len(force) else "–",
                f"{np.sqrt(np.mean(error**2)):.2f}" if len(error) else "–",
                f"{1e-3 * stiffness:.1f}" if np.isfinite(stiffness) else "–",
            )
        )
    return rows


def same_mould(mould: Mould, before: Earlier, folder: Path) -> None:
    """Refuse to go on with another mould.

    Raises:
        RecordingError: its fingerprint differs.
    """
    if mould.sha256 != before.mould_sha256:
        raise RecordingError(
            f"the job of {folder} is on a mould with the fingerprint {before.mould_sha256[:12]}; '{mould.name}' has "
            f"{mould.sha256[:12]}. Give the mould's file with --mould"
        )


def keep(folder: Path, depth: Array, mould: Mould, name: str) -> None:
    """Write what was taken off so far [m], (V,), into a file in the folder of a job."""
    with open(folder / name, "wb") as file:
        np.savez(file, depth=depth, mould_sha256=np.array(mould.sha256))


def removed(folder: Path, mould: Mould, count: int, name: str) -> Array:
    """What the runs of a job took off [m], (count,), as it was kept in its folder.

    Raises:
        RecordingError: it cannot be read, or is of another mould or recipe.
    """
    path = folder / name
    try:
        with np.load(path, allow_pickle=False) as kept:
            depth, sha256 = np.asarray(kept["depth"], dtype=np.float64), str(kept["mould_sha256"])
    except (OSError, ValueError, KeyError, zipfile.BadZipFile) as error:
        raise RecordingError(
            f"{path} cannot be read ({error}): what earlier runs took off is not known, so the surface cannot be judged"
        ) from error
    if sha256 != mould.sha256 or depth.shape != (count,) or not np.isfinite(depth).all():
        raise RecordingError(f"{path} is not of this job; expected {count} depths on the mould {mould.name}")
    return depth


def _done(job: Job, k: int) -> float:
    """Path of a leg that this run worked [m]."""
    leg = job.legs[k]
    new = leg.path.length - leg.lead
    return new if k < job.stroke else min(new, max(0.0, job.worked - leg.begun - leg.lead)) if k == job.stroke else 0.0


def _scored(work: Work, result: Evaluation, number: int | None) -> NDArray[np.int64]:
    """Rows of the series that count: in a pass, after the first second of each piece of work, (K,)."""
    t = result.series.t
    mask = np.zeros(len(t), dtype=bool)
    for n, start, end in work.spans:
        if number is None or n == number:
            mask |= (t >= start + SETTLE + FIRST_SECOND) & (t < end)
    return np.flatnonzero(mask).astype(np.int64)


def _errors(work: Work, result: Evaluation, number: int | None = None) -> Array:
    rows = _scored(work, result, number)
    return np.asarray(result.series.force[rows] - result.series.force_set[rows])


def _forces(work: Work, result: Evaluation, number: int) -> Array:
    return np.asarray(result.series.force[_scored(work, result, number)])
