"""A polishing job made ready from an order, and run to its end with a recording beside it."""

from __future__ import annotations

import hashlib
import platform
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from burnish.commands.evaluate import RunLog
from burnish.commands.order import SENSES, Order
from burnish.commands.progress import Progress
from burnish.model.model import JACO2_URDF
from burnish.model.tool import PolishingTool
from burnish.polish.cellsim import check_size, plan_strokes, simulated_job
from burnish.polish.process import Job
from burnish.polish.stroke import Stroke
from burnish.record.described import described, fingerprint
from burnish.record.recorder import Recorder
from burnish.sim.robot import SimRobot
from burnish.surface import DistanceGrid, Mould

PACKAGES = ("burnish", "mujoco", "pin", "numpy", "scipy")
"""What a simulated run depends on, bit by bit."""


@dataclass(frozen=True, kw_only=True)
class Work:
    """A job with all that belongs to it, planned and checked."""

    order: Order
    """What was asked for."""
    mould: Mould
    """The part."""
    grid: DistanceGrid
    """Distance to it."""
    tool: PolishingTool
    """The tool."""
    strokes: list[Stroke]
    """The tool path."""
    job: Job
    """The job."""
    robot: SimRobot
    """The simulated arm that does it."""
    log: RunLog
    """What the loop sees."""
    expected: float
    """Time that the passes will take [s]."""

    def metadata(self) -> dict[str, str]:
        """What a reader of the recording needs to know of the run."""
        job = self.job
        return (
            {"verb": "polish"}
            | self.order.as_metadata()
            | {"mould": self.mould.name}
            | versions()
            | {"python": platform.python_version()}
            | {"model_sha256": model_hash(), "mould_sha256": self.mould.sha256}
            | _with_hash("tool", self.tool)
            | _with_hash("law", job.law)
            | _with_hash("travel", job.travel)
            | _with_hash("limits", job.rig.supervisor.limits)
        )


def prepare(order: Order, mould: Mould, progress: Progress) -> Work:
    """Plan the job and set the arm up.

    Raises:
        InputError: if the arm cannot do it.
    """
    tool = PolishingTool()
    check_size(mould, tool)
    grid = DistanceGrid.of(mould)
    progress.stage("planning the path")
    strokes = plan_strokes(mould, grid, order.recipe, tool)
    log = RunLog()
    job, robot = simulated_job(
        grid,
        strokes,
        order.drawn_arm(),
        rate=order.rate,
        felt=SENSES[order.sensor],
        tool=tool,
        on_phase=lambda phase: log.phases.append((robot.time, phase)),
    )
    paths, _ = job.plan()
    return Work(
        order=order,
        mould=mould,
        grid=grid,
        tool=tool,
        strokes=strokes,
        job=job,
        robot=robot,
        log=log,
        expected=sum(path.duration for path in paths),
    )


def drive(work: Work, path: Path, progress: Progress, stop: Callable[[int], bool]) -> float:
    """Run the job to the arm at rest, recorded to a file.

    Args:
        work: the job; it can be run once.
        path: of the recording.
        progress: is told of every cycle.
        stop: asked after each cycle, with its number from 1, whether the job is to end early. That this is the only
            moment makes an interrupted run repeatable.

    Returns:
        The wall time that it took [s].
    """
    job, robot = work.job, work.robot
    start = time.perf_counter()
    done = 0.0
    with robot, Recorder(path, joint_names=job.rig.model.joint_names, metadata=work.metadata()) as recorder:
        for count, sample in enumerate(job.run(), 1):
            recorder.record(sample, job.phase)
            recorder.catch_up()
            work.log.add(sample)
            if job.phase == "pass":
                done += robot.period
            progress.update(job.phase, done / work.expected)
            if stop(count) and not job.interrupted:
                recorder.end_with(interrupted_after=str(count))
                job.interrupt()
        recorder.end_with(outcome=outcome(job))
    wall = time.perf_counter() - start
    if recorder.error is not None:
        progress.warn(f"the recording ended early: {recorder.error}")
    return wall


def outcome(job: Job) -> str:
    """How the job ended, in words."""
    event = job.rig.supervisor.event
    if event is not None:
        return f"stopped by the supervisor: {event.cause}"
    if job.failure is not None:
        return f"stopped: {job.failure}"
    return "interrupted" if job.interrupted else "done"


def versions() -> dict[str, str]:
    """Of burnish and of what computes for it."""
    return {name: version(name) for name in PACKAGES}


def model_hash() -> str:
    """Fingerprint of the arm's description."""
    return hashlib.sha256(JACO2_URDF.read_bytes()).hexdigest()


def tool_hash() -> str:
    """Fingerprint of the tool."""
    return fingerprint(PolishingTool())


def _with_hash(name: str, thing: object) -> dict[str, str]:
    return {name: described(thing), f"{name}_sha256": fingerprint(thing)}
