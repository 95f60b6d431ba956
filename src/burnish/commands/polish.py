"""``burnish polish``: plan, find, press, rub, report."""

from __future__ import annotations

import argparse
import hashlib
import platform
import signal
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

from burnish.analysis.arm_picture import arm_shapes, mould_shapes, trace_shape
from burnish.analysis.metrics import Scalar, write_metrics
from burnish.analysis.render import Camera
from burnish.analysis.report import Event, RunReport, write_report
from burnish.analysis.shape import Shape
from burnish.commands.evaluate import Evaluation, RunLog, evaluate
from burnish.commands.options import output_folder, relative
from burnish.commands.progress import Progress
from burnish.errors import InputError
from burnish.model.model import JACO2_URDF
from burnish.model.tool import PolishingTool
from burnish.polish.cellsim import JointFelt, WristFelt, check_size, plan_strokes, simulated_job
from burnish.polish.process import Job
from burnish.polish.recipe import EDGE_BAND, MARGIN, PRESTON, Recipe
from burnish.runtime.recorder import Recorder
from burnish.sim import arms
from burnish.sim.robot import SimRobot
from burnish.surface import DistanceGrid, Mould

DONE, STOPPED, INTERRUPTED = 0, 3, 130
ARMS = {"ideal": arms.ideal, "honest": arms.honest, "honest-stiff": arms.honest_stiff}
SENSES: dict[str, WristFelt | JointFelt] = {"wrist": WristFelt(), "joint": JointFelt()}
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
    recipe = Recipe(force=options.force, feed=options.feed)
    if options.seed < 0:
        raise InputError(f"seed {options.seed} is negative; expected 0 or more")
    arm = ARMS[options.arm](options.seed)
    rate = arm.rate if options.rate is None else options.rate
    if not 50.0 <= rate <= 1000.0:
        raise InputError(f"rate {rate:g} Hz is out of range; expected 50 to 1000 Hz")
    folder = output_folder(options.out, "polish")
    tool = PolishingTool()
    with Progress() as progress:
        progress.stage("reading the mould")
        mould = Mould.load(options.mould, options.unit)
        check_size(mould, tool)
        grid = DistanceGrid.of(mould)
        progress.stage("planning the path")
        strokes = plan_strokes(mould, grid, recipe, tool)
        log = RunLog()
        job, robot = simulated_job(
            grid,
            strokes,
            arm,
            rate=rate,
            felt=SENSES[options.sensor],
            tool=tool,
            on_phase=lambda phase: log.phases.append((robot.time, phase)),
        )
        paths, _ = job.plan()
        folder.mkdir(parents=True, exist_ok=True)
        expected = sum(path.duration for path in paths)
        with _interruptible(job):
            wall = _drive(job, robot, log, folder / "run.mcap", _metadata(options, mould), expected, progress)
        progress.stage("judging the surface")
        result = evaluate(log, robot.truth, mould, grid, recipe, tool)
        metrics: dict[str, Scalar] = result.metrics | {
            "path_length_m": sum(stroke.length for stroke in strokes),
            "duration_s": robot.time,
            "realtime_factor": robot.time / wall,
            "cycles": len(log.t),
            "late_cycles": robot.late_cycles,
            "supervisor_events": int(job.rig.supervisor.tripped),
            "seed": options.seed,
            "mould": mould.name,
            "arm": options.arm,
            "sensor": options.sensor,
            "rate_Hz": rate,
        }
        write_metrics(folder / "metrics.json", metrics)
        progress.stage("writing the report")
        write_report(_report(job, robot, mould, result, metrics, options, tool), folder / "report.html")
    _say(job, metrics, folder)
    if job.interrupted:
        return INTERRUPTED
    return STOPPED if job.rig.supervisor.tripped or job.failure else DONE


def _drive(
    job: Job, robot: SimRobot, log: RunLog, path: Path, metadata: dict[str, str], expected: float, progress: Progress
) -> float:
    """Run the job to the arm at rest; returns the wall time that it took [s]."""
    start = time.perf_counter()
    done = 0.0
    with robot, Recorder(path, joint_names=job.rig.model.joint_names, metadata=metadata) as recorder:
        for sample in job.run():
            recorder.record(sample, job.phase)
            log.add(sample)
            if job.phase == "pass":
                done += robot.period
            progress.update(job.phase, done / expected)
    wall = time.perf_counter() - start
    if recorder.error is not None:
        progress.warn(f"the recording ended early: {recorder.error}")
    return wall


@contextmanager
def _interruptible(job: Job) -> Iterator[None]:
    """The first Ctrl-C asks the job to end; the arm lifts off and comes to rest. The second one ends the program."""
    before = signal.getsignal(signal.SIGINT)

    def ask(number: int, frame: FrameType | None) -> None:
        signal.signal(signal.SIGINT, before)
        job.interrupt()

    signal.signal(signal.SIGINT, ask)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _outcome(job: Job) -> str:
    event = job.rig.supervisor.event
    if event is not None:
        return f"stopped by the supervisor: {event.cause}"
    if job.failure is not None:
        return f"stopped: {job.failure}"
    return "interrupted" if job.interrupted else "done"


def _metadata(options: argparse.Namespace, mould: Mould) -> dict[str, str]:
    """What a reader of the recording needs to know of the run."""
    asked = {name: str(getattr(options, name)) for name in ("mould", "arm", "sensor", "force", "feed", "seed")}
    return asked | _versions() | {"mould_sha256": mould.sha256, "model_sha256": _model_hash()}


def _versions() -> dict[str, str]:
    packages = {name: version(name) for name in ("burnish", "mujoco", "pin", "numpy", "scipy")}
    return packages | {"python": platform.python_version()}


def _model_hash() -> str:
    return hashlib.sha256(JACO2_URDF.read_bytes()).hexdigest()


def _report(
    job: Job,
    robot: SimRobot,
    mould: Mould,
    result: Evaluation,
    metrics: dict[str, Scalar],
    options: argparse.Namespace,
    tool: PolishingTool,
) -> RunReport:
    supervisor = job.rig.supervisor
    events = () if supervisor.event is None else (Event(t=supervisor.event.t, cause=supervisor.event.cause),)
    shapes, camera = _picture(job, mould, result, tool)
    limits = supervisor.limits
    return RunReport(
        title=f"Polishing {mould.name}: {options.force:g} N at {1e3 * options.feed:g} mm/s",
        outcome=_outcome(job),
        metrics=metrics,
        recipe={
            "mould": mould.name,
            "force [N]": options.force,
            "feed [mm/s]": 1e3 * options.feed,
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
        versions=_versions() | {"model": _model_hash()[:16], "mould": mould.sha256[:16]},
        seed=options.seed,
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
    outcome = _outcome(job)
    print(f"{outcome[:1].upper()}{outcome[1:]}.")
    if "force_rms_N" in metrics:
        print(FORCE_LINE.format(**metrics))
        print(SURFACE_LINE.format(**metrics))
    print(f"report: {relative(folder / 'report.html')}")
