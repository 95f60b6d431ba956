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
from burnish.analysis.render import Camera
from burnish.analysis.report import Event as ReportEvent
from burnish.analysis.report import RunReport, write_report
from burnish.analysis.shape import Shape
from burnish.commands.evaluate import Evaluation, evaluate
from burnish.commands.options import output_folder, relative
from burnish.commands.order import Order
from burnish.commands.progress import Progress
from burnish.commands.work import Work, drive, model_hash, outcome, prepare, versions
from burnish.model.tool import PolishingTool
from burnish.polish.process import Job
from burnish.polish.recipe import EDGE_BAND, MARGIN, PRESTON
from burnish.surface import Mould

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
    """Do the job and write ``run.mcap``, ``metrics.json`` and ``report.html``; nothing when it is refused."""
    order = Order.asked(options)
    folder = output_folder(options.out, "polish")
    with Progress() as progress:
        progress.stage("reading the mould")
        work = prepare(order, Mould.load(order.mould, order.unit), progress)
        folder.mkdir(parents=True, exist_ok=True)
        with _interruptible() as asked:
            wall = drive(work, folder / "run.mcap", progress, lambda count: asked.is_set())
        progress.stage("judging the surface")
        job, robot = work.job, work.robot
        result = evaluate(work.log, robot.truth, work.mould, work.grid, order.recipe, work.tool)
        metrics: dict[str, Scalar] = result.metrics | {
            "path_length_m": sum(stroke.length for stroke in work.strokes),
            "duration_s": robot.time,
            "realtime_factor": robot.time / wall,
            "cycles": len(work.log.t),
            "late_cycles": robot.late_cycles,
            "supervisor_events": int(job.rig.supervisor.tripped),
            "seed": order.seed,
            "mould": work.mould.name,
            "arm": order.arm,
            "sensor": order.sensor,
            "rate_Hz": order.rate,
        }
        write_metrics(folder / "metrics.json", metrics)
        progress.stage("writing the report")
        write_report(_report(work, result, metrics), folder / "report.html")
    _say(job, metrics, folder)
    if job.interrupted:
        return INTERRUPTED
    return STOPPED if job.rig.supervisor.tripped or job.failure else DONE


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
    return RunReport(
        title=f"Polishing {mould.name}: {order.force:g} N at {1e3 * order.feed:g} mm/s",
        outcome=outcome(job),
        metrics=metrics,
        recipe={
            "mould": mould.name,
            "force [N]": order.force,
            "feed [mm/s]": 1e3 * order.feed,
            "strokes": len(job.strokes),
            "path margin [mm]": 1e3 * MARGIN,
            "edge band, not judged [mm]": 1e3 * EDGE_BAND,
            "Preston coefficient [1/Pa], to be calibrated": PRESTON,
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
    print(f"report: {relative(folder / 'report.html')}")
