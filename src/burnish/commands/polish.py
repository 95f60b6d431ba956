"""``burnish polish``: plan, find, press, rub, report."""

from __future__ import annotations

import argparse
import platform
import signal
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from threading import Event
from types import FrameType
from typing import Any

import numpy as np

from burnish.analysis.arm_picture import arm_shapes, mould_shapes, trace_shape
from burnish.analysis.metrics import Scalar, write_metrics
from burnish.analysis.part import PartReport, write_part
from burnish.analysis.render import Camera
from burnish.analysis.report import Event as ReportEvent
from burnish.analysis.report import RunReport, write_report
from burnish.analysis.shape import Shape
from burnish.commands.course import Course, unfinished
from burnish.commands.entered import entered
from burnish.commands.evaluate import Evaluation
from burnish.commands.judged import judged, passes_table, same_mould
from burnish.commands.live import watched
from burnish.commands.mending import Worn, wishes
from burnish.commands.options import output_folder, relative
from burnish.commands.order import Order
from burnish.commands.progress import Progress
from burnish.commands.seat import paced
from burnish.commands.work import Work, drive, model_hash, outcome, prepare, versions
from burnish.errors import InputError
from burnish.model.tool import PolishingTool
from burnish.polish.journal import NAME, Journal
from burnish.polish.process import Job
from burnish.polish.recipe import EDGE_BAND, MARGIN
from burnish.record.described import fingerprint
from burnish.surface import Mould, bundled

DONE, STOPPED, INTERRUPTED = 0, 3, 130
FORCE_LINE = (
    "force error {force_rms_N:.2f} N RMS, {force_p99_N:.2f} N in 99 % of the time; touch {touch_peak_N:.1f} N; "
    "tilt {tilt_rms_deg:.2f}° RMS"
)
SURFACE_LINE = (
    "coverage {coverage_pct:.1f} %, over-polished {overpolished_pct:.1f} %, removal ±{removal_cv_pct:.0f} %; "
    "{path_length_m:.1f} m in {duration_s:.0f} s, {realtime_factor:.1f} × real time; all simulated"
)


def run(options: argparse.Namespace) -> int:
    """Do the job, or what is left of it; nothing is written when it is refused."""
    mending = None
    if options.repair is not None:
        worn = Worn.asked(options)
        order, mould, folder = worn.order, worn.mould, output_folder(options.out, "repair")
        _new(folder)
        with Progress() as progress:
            mending = worn.mending(progress)
        print(mending.says)
        if not mending.course.strokes:
            return DONE
        course = mending.course
    elif options.resume is None:
        course = Course.asked(options)
        order, folder = Order.asked(options), output_folder(options.out, "polish")
        _new(folder)
        mould = order.part()
    else:
        folder = Path(options.resume)
        before = unfinished(folder)
        course, mould_file = before.course, None if options.mould in bundled.NAMES else options.mould
        order = Order.recorded(before.order, mould_file)
        mould = order.part()
        same_mould(mould, before, folder)
    with watched(options) as live, Progress(live.tell) as progress:
        for sentence in mould.warnings:
            progress.warn(sentence)
        work = prepare(order, mould, progress, course)
        paced(work.job.rig, work.robot, options.pace)
        folder.mkdir(parents=True, exist_ok=True)
        if mending is not None:
            mending.begin(folder, mould)
        recording = folder / ("run.mcap" if not course.runs else f"run-{course.runs + 1}.mcap")
        about = {"order": order.as_metadata(), "course": course.as_record(), "mould_sha256": mould.sha256}
        with Journal(folder / NAME, about) as journal, _interruptible() as asked:
            wall = drive(
                work,
                recording,
                progress,
                lambda count: asked.is_set() or live.told_to_end(),
                journal,
                gone=lambda count: live.gone(),
                show=lambda sample, done: live.show(sample, work.job, done),
            )
        if journal.error is not None:
            progress.warn(f"the journal ended early: {journal.error}; the job cannot go on from it")
        progress.stage("judging the surface")
        result = judged(work, folder)
        metrics = result.metrics | _figures(work, wall)
        write_metrics(folder / "metrics.json", metrics)
        progress.stage("writing the report")
        report = _report(work, result, metrics)
        write_report(report, folder / "report.html")
        write_part(_part(work, result, report), folder / "part.html")
        for sentence in work.job.drift.warnings():
            progress.warn(sentence)
    entered(folder, mould=order.mould, unit=order.unit, recipe=options.recipe)
    _say(work.job, metrics, folder)
    if work.job.interrupted or work.job.pause is not None:
        return INTERRUPTED
    return STOPPED if work.job.rig.supervisor.tripped or work.job.failure else DONE


def _figures(work: Work, wall: float) -> dict[str, Scalar]:
    """What a run is, beside what it reached."""
    order, robot = work.order, work.robot
    return {
        "path_length_m": sum(leg.path.length - leg.lead for leg in work.job.legs),
        "duration_s": robot.time,
        "realtime_factor": robot.time / wall,
        "cycles": len(work.log.t),
        "late_cycles": work.late_cycles,
        "supervisor_events": int(work.job.rig.supervisor.tripped),
        "seed": order.seed,
        "mould": work.mould.name,
        "arm": order.arm,
        "sensor": order.sensor,
        "rate_Hz": order.rate,
    }


def _new(folder: Path) -> None:
    """Refuse to write over a job that could go on.

    Raises:
        InputError: the folder has a journal.
    """
    if (folder / NAME).exists():
        raise InputError(
            f"--out {folder} holds a job already; go on with it by --resume {folder}, or choose another folder"
        )


@contextmanager
def _interruptible() -> Iterator[Event]:
    """The first Ctrl-C asks the job to end; the arm lifts off and comes to rest. The second one ends the program."""
    before = signal.getsignal(signal.SIGINT)
    asked = Event()

    def ask(number: int, frame: FrameType | None) -> None:
        signal.signal(signal.SIGINT, before)
        asked.set()

    signal.signal(signal.SIGINT, ask)
    try:
        yield asked
    finally:
        signal.signal(signal.SIGINT, before)


def _report(work: Work, result: Evaluation, metrics: dict[str, Scalar]) -> RunReport:
    order, job, tool, mould = work.order, work.job, work.tool, work.mould
    supervisor = job.rig.supervisor
    events = () if supervisor.event is None else (ReportEvent(t=supervisor.event.t, cause=supervisor.event.cause),)
    shapes, camera = _picture(job, mould, result, tool)
    limits = supervisor.limits
    recipe, course = work.course.recipe, work.course
    verb = "Repairing" if course.mends else "Polishing"
    return RunReport(
        title=f"{verb} {mould.name}: {order.force:g} N at {1e3 * order.feed:g} mm/s",
        outcome=outcome(job),
        metrics=metrics,
        recipe=wishes(course)
        | {
            "mould": mould.name,
            "force [N]": order.force,
            "feed [mm/s]": 1e3 * order.feed,
            "strokes": len(course.strokes) if course.mends else len(job.strokes),
            "path margin [mm]": 1e3 * MARGIN,
            "edge band, not judged [mm]": 1e3 * EDGE_BAND,
            "Preston coefficient [1/Pa], to be calibrated": recipe.preston,
            "tip radius [mm]": 1e3 * tool.tip_radius,
            "tip spring [kN/m]": 1e-3 * tool.stiffness,
            "felt modulus [MPa]": 1e-6 * tool.modulus,
            "tool force limit [N]": limits.tool_force,
            "torque rate limit [N·m/s]": limits.torque_rate,
        },
        versions=versions()
        | {"python": platform.python_version(), "model": model_hash()[:16], "mould": mould.sha256[:16]},
        seed=order.seed,
        simulated=True,
        series=result.series,
        removal=result.removal,
        shapes=tuple(shapes),
        camera=camera,
        events=events,
    )


def _part(work: Work, result: Evaluation, report: RunReport) -> PartReport:
    """What the customer of this part gets to read."""
    recipe = work.course.recipe
    return PartReport(
        part=work.mould.name,
        part_sha256=work.mould.sha256,
        outcome=report.outcome,
        metrics=report.metrics,
        passes=passes_table(work, result),
        recipe=wishes(work.course)
        | {
            "contact force [N]": recipe.force,
            "feed [mm/s]": 1e3 * recipe.feed,
            "passes": 1 if work.course.mends else work.course.repeats * max(1, len(recipe.passes)),
            "abrasive": recipe.grit or "not stated",
            "strokes left out on request": ", ".join(map(str, sorted(work.course.skipped))) or "none",
        },
        trace=dict(report.versions)
        | {"limits": fingerprint(work.job.rig.supervisor.limits)[:16], "seed": str(work.order.seed)},
        remarks=(*work.job.drift.warnings(), work.job.abrasive.says() + "."),
        untold=work.job.untold,
        target_um=1e6 * result.removal.target,
        run=report,
        roughness=None if recipe.roughness is None else recipe.roughness.after(_mean(report.metrics)),
        mends=work.course.mends,
    )


def _mean(metrics: Mapping[str, Scalar]) -> float:
    """Mean removal of a run [m]."""
    return 1e-6 * float(metrics["removal_mean_um"])


def _picture(job: Job, mould: Mould, result: Evaluation, tool: PolishingTool) -> tuple[list[Shape], Camera]:
    """The arm over the mould in the middle of its work, and a camera close to them."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = job.placement.R, job.placement.p
    height = float(job.placement.p[2] + mould.vertices[:, 2].min())
    shapes = mould_shapes(mould.vertices, mould.faces, pose, result.removal, height)
    if len(result.trace) > 1:
        shapes.append(trace_shape(job.placement.points(result.trace) + 4e-4 * job.placement.R[:, 2]))
    arm = arm_shapes(job.rig.model, job.working_joints(), tool)
    corners = np.concatenate([shape.vertices[::5] for shape in (*arm, shapes[0])])
    return [*arm, *shapes], Camera.framing(corners, (1.0, -0.55, 0.55))


def _say(job: Job, metrics: Mapping[str, Any], folder: Path) -> None:
    """The result in a few lines, for a terminal."""
    ending = outcome(job)
    print(f"{ending[:1].upper()}{ending[1:]}.")
    if "force_rms_N" in metrics:
        print(FORCE_LINE.format(**metrics))
        print(SURFACE_LINE.format(**metrics))
    if job.untold:
        print(f"the touches could not tell: {job.untold}; there the mould is taken as planned")
    print(f"report: {relative(folder / 'report.html')}")
