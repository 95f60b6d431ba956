"""A polishing job made ready from an order, and run to its end with a recording beside it."""

from __future__ import annotations

import hashlib
import platform
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from importlib.metadata import version
from pathlib import Path

import numpy as np

from burnish.check.plan import check
from burnish.check.ways import jaco2_workplace
from burnish.commands.course import LEARNT, Course
from burnish.commands.evaluate import RunLog
from burnish.commands.live import GONE, Done
from burnish.commands.notes import Notes
from burnish.commands.order import SENSES, Order
from burnish.commands.progress import Progress
from burnish.core import Sample
from burnish.errors import InputError
from burnish.model.model import JACO2_URDF
from burnish.model.tool import PolishingTool
from burnish.paths.stroke import Stroke
from burnish.polish.cell import nominal_placement
from burnish.polish.cellsim import SLIDE, TURN, check_size, half_size, simulated_job
from burnish.polish.journal import Journal
from burnish.polish.learn import Learner
from burnish.polish.life import Abrasive
from burnish.polish.passes import Leg
from burnish.polish.process import Job
from burnish.polish.recipe import Recipe
from burnish.record.described import described, fingerprint
from burnish.record.recorder import Recorder
from burnish.sim.paced import Paced
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
    course: Course = field(default_factory=Course)
    """How it is run."""
    spans: list[tuple[int, float, float]] = field(default_factory=list)
    """Pass, start and end of each piece of work [s]."""

    @property
    def late_cycles(self) -> int:
        """Cycles that came late so far: of the simulated clock, and of that on the wall where the arm keeps to it."""
        arm = self.job.rig.robot
        return self.robot.late_cycles + (arm.late_cycles if isinstance(arm, Paced) else 0)

    def metadata(self) -> dict[str, str]:
        """What a reader of the recording needs to know of the run."""
        job = self.job
        return (
            {"verb": "polish"}
            | self.order.as_metadata()
            | self.course.as_metadata()
            | {"mould": self.mould.name}
            | versions()
            | {"python": platform.python_version()}
            | {"model_sha256": model_hash(), "mould_sha256": self.mould.sha256}
            | _with_hash("tool", self.tool)
            | _with_hash("law", job.law)
            | _with_hash("travel", job.travel)
            | _with_hash("limits", job.rig.supervisor.limits)
        )


def prepare(order: Order, mould: Mould, progress: Progress, course: Course | None = None) -> Work:
    """Plan the job and set the arm up.

    Args:
        order: what was asked for.
        mould: the part.
        progress: is told what is being done.
        course: how it is run; the order's force and feed once over the part without it.

    Raises:
        InputError: if the arm cannot do it, or nothing of it is left to do.
    """
    course = Course(recipe=order.recipe) if course is None else course
    tool = course.recipe.tool
    check_size(mould, tool)
    grid = course.grid(mould)
    progress.stage("planning the path")
    planned = course.legs(mould, grid)
    # Where it is touched is the same for what is left of a job, or for its repair, as for all of it.
    strokes = course.touched(planned, mould, grid)
    every = checked(planned, course.recipe, mould, grid, progress, touched=strokes)
    legs = course.left(every)
    if not legs:
        raise InputError("all strokes of the job are done; there is nothing to go on with")
    top = max(float(stroke.points[:, 2].max()) for stroke in strokes)
    log = RunLog()
    job, robot = simulated_job(
        grid,
        strokes,
        order.drawn_arm(),
        rate=order.rate,
        felt=SENSES[order.sensor],
        tool=tool,
        on_phase=lambda phase: log.phases.append((robot.time, phase)),
        stands=course.placed(nominal_placement(top)),
        finder=course.finder(),
    )
    job.legs = legs
    job.abrasive = _abrasive(course, tool)
    job.learner = Learner(gain=LEARNT if course.repeats > 1 else 0.0)
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
        course=course,
    )


def checked(
    legs: list[Leg], recipe: Recipe, mould: Mould, grid: DistanceGrid, progress: Progress, *, touched: list[Stroke]
) -> list[Leg]:
    """The legs with the feed that the arm can follow, once all that can be known before was checked.

    ``touched`` are the strokes along which the mould is touched to find it.

    Raises:
        PlanError: the arm cannot do one of them.
    """
    progress.stage("checking the path")
    # The strokes of a pass that is done again are the very same ones.
    strokes = list({id(leg.path): leg.path for leg in legs}.values())
    points = np.concatenate([stroke.points for stroke in touched])
    place = jaco2_workplace(mould, grid, touched, recipe.tool, uncertainty=SLIDE + TURN * half_size(points))
    plan = check(place, strokes, recipe, touched=touched)
    for note in plan.notes:
        progress.warn(note)
    able = dict(zip(map(id, strokes), plan.strokes, strict=True))
    return [replace(leg, path=able[id(leg.path)]) for leg in legs]


def _abrasive(course: Course, tool: PolishingTool) -> Abrasive:
    """The abrasive in use: a new one, or that of the run before unless it was changed."""
    mark = course.since
    worn = mark is not None and mark.phase != "change"
    return Abrasive(
        most_metres=course.most_metres,
        friction=tool.friction,
        metres=mark.metres if mark is not None and worn else 0.0,
        joules=mark.joules if mark is not None and worn else 0.0,
    )


def drive(
    work: Work,
    path: Path,
    progress: Progress,
    stop: Callable[[int], bool],
    journal: Journal | None = None,
    *,
    gone: Callable[[int], bool] = lambda count: False,
    show: Callable[[Sample, Done], None] = lambda sample, done: None,
) -> float:
    """Run the job to the arm at rest, recorded to a file.

    Args:
        work: the job; it can be run once.
        path: of the recording.
        progress: is told of every cycle.
        stop: asked after each cycle, with its number from 1, whether the job is to end early. That this is the only
            moment makes an interrupted run repeatable.
        journal: is told of every millimetre that is done, if there is one.
        gone: asked as ``stop`` is, whether whoever commands the job is gone: the supervisor then holds the arm.
        show: is shown every cycle.

    Returns:
        The wall time that it took [s].
    """
    job, robot = work.job, work.robot
    start = time.perf_counter()
    done, abandoned = 0.0, False
    notes = Notes(job=job, spans=work.spans, journal=journal)
    with robot, Recorder(path, joint_names=job.rig.model.joint_names, metadata=work.metadata()) as recorder:
        for count, sample in enumerate(job.run(), 1):
            recorder.record(sample, job.phase)
            recorder.catch_up()
            work.log.add(sample)
            notes.add(sample)
            if job.phase == "pass":
                done += robot.period
            share = done / work.expected
            progress.update(job.phase, share)
            if gone(count) and not abandoned:
                abandoned = True
                recorder.end_with(abandoned_after=str(count))
                job.rig.supervisor.stop(GONE)
            if stop(count) and not job.interrupted:
                recorder.end_with(interrupted_after=str(count))
                job.interrupt()
            far = Done(share=min(share, 1.0), stroke=job.stroke, strokes=len(job.legs), late_cycles=work.late_cycles)
            show(sample, far)
        notes.end()
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
    if job.interrupted:
        return "interrupted"
    return "done" if job.pause is None else f"paused: {job.pause}"


def versions() -> dict[str, str]:
    """Of burnish and of what computes for it."""
    return {name: version(name) for name in PACKAGES}


def model_hash() -> str:
    """Fingerprint of the arm's description."""
    return hashlib.sha256(JACO2_URDF.read_bytes()).hexdigest()


def tool_hash(tool: PolishingTool | None = None) -> str:
    """Fingerprint of a tool; of the usual one if none is given."""
    return fingerprint(PolishingTool() if tool is None else tool)


def _with_hash(name: str, thing: object) -> dict[str, str]:
    return {name: described(thing), f"{name}_sha256": fingerprint(thing)}
