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
from burnish.commands.order import SENSES, Order
from burnish.commands.progress import Progress
from burnish.core import Sample, ToolReference
from burnish.errors import InputError
from burnish.model.model import JACO2_URDF
from burnish.model.tool import PolishingTool
from burnish.paths.stroke import Stroke
from burnish.polish.cell import nominal_placement
from burnish.polish.cellsim import SLIDE, TURN, check_size, half_size, simulated_job
from burnish.polish.journal import EVERY, Journal, Mark
from burnish.polish.learn import Learner
from burnish.polish.life import Abrasive
from burnish.polish.passes import Leg
from burnish.polish.process import Job
from burnish.polish.recipe import Recipe
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
    course: Course = field(default_factory=Course)
    """How it is run."""
    spans: list[tuple[int, float, float]] = field(default_factory=list)
    """Pass, start and end of each piece of work [s]."""

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
    every = checked(course.legs(mould, grid), course.recipe, mould, grid, progress)
    legs = course.left(every)
    if not legs:
        raise InputError("all strokes of the job are done; there is nothing to go on with")
    # Where it is touched is the same for what is left of a job as for all of it.
    strokes = [leg.path for leg in every]
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


def checked(legs: list[Leg], recipe: Recipe, mould: Mould, grid: DistanceGrid, progress: Progress) -> list[Leg]:
    """The legs with the feed that the arm can follow, once all that can be known before was checked.

    Raises:
        PlanError: the arm cannot do one of them.
    """
    progress.stage("checking the path")
    # The strokes of a pass that is done again are the very same ones.
    strokes = list({id(leg.path): leg.path for leg in legs}.values())
    points = np.concatenate([stroke.points for stroke in strokes])
    place = jaco2_workplace(mould, grid, strokes, recipe.tool, uncertainty=SLIDE + TURN * half_size(points))
    plan = check(place, strokes, recipe)
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
    work: Work, path: Path, progress: Progress, stop: Callable[[int], bool], journal: Journal | None = None
) -> float:
    """Run the job to the arm at rest, recorded to a file.

    Args:
        work: the job; it can be run once.
        path: of the recording.
        progress: is told of every cycle.
        stop: asked after each cycle, with its number from 1, whether the job is to end early. That this is the only
            moment makes an interrupted run repeatable.
        journal: is told of every millimetre that is done, if there is one.

    Returns:
        The wall time that it took [s].
    """
    job, robot = work.job, work.robot
    start = time.perf_counter()
    done = 0.0
    notes = Notes(work=work, journal=journal)
    with robot, Recorder(path, joint_names=job.rig.model.joint_names, metadata=work.metadata()) as recorder:
        for count, sample in enumerate(job.run(), 1):
            recorder.record(sample, job.phase)
            recorder.catch_up()
            work.log.add(sample)
            notes.add(sample)
            if job.phase == "pass":
                done += robot.period
            progress.update(job.phase, done / work.expected)
            if stop(count) and not job.interrupted:
                recorder.end_with(interrupted_after=str(count))
                job.interrupt()
        notes.end()
        recorder.end_with(outcome=outcome(job))
    wall = time.perf_counter() - start
    if recorder.error is not None:
        progress.warn(f"the recording ended early: {recorder.error}")
    return wall


@dataclass(kw_only=True)
class Notes:
    """Tells the journal how far the job is, and the work when each pass was under way."""

    work: Work
    journal: Journal | None
    _last: tuple[int, str, float] = field(default=(-1, "", 0.0), init=False, repr=False)
    _force: list[float] = field(default_factory=list, init=False, repr=False)

    def add(self, sample: Sample) -> None:
        """One cycle."""
        job = self.work.job
        leg, phase, s = self._last
        reference = sample.reference
        if isinstance(reference, ToolReference) and reference.normal is not None and sample.arm.F is not None:
            self._force.append(float(reference.normal @ sample.arm.F[:3]))
        if (job.stroke, job.phase) != (leg, phase):
            if job.phase == "pass":
                self.work.spans.append((job.leg.number, sample.arm.t, sample.arm.t))
            self._mark(job.phase, sample.arm.t)
        elif job.phase == "pass":
            number, start, _ = self.work.spans[-1]
            self.work.spans[-1] = (number, start, sample.arm.t)
            if job.worked - s >= EVERY:
                self._mark(job.phase, sample.arm.t)

    def end(self) -> None:
        """The run is over."""
        job = self.work.job
        unfinished = job.interrupted or job.failure is not None or job.rig.supervisor.tripped
        self._mark("stopped" if unfinished else "change" if job.pause is not None else "done", job.arm().t)

    def _mark(self, phase: str, t: float) -> None:
        job = self.work.job
        self._last = (job.stroke, phase, job.worked)
        force = sum(self._force) / len(self._force) if self._force else 0.0
        self._force.clear()
        if self.journal is not None and job.located:
            self.journal.add(
                Mark(
                    number=job.leg.number,
                    stroke=job.leg.stroke,
                    s=job.worked,
                    phase=phase,
                    force=force,
                    t=t,
                    metres=job.abrasive.metres,
                    joules=job.abrasive.joules,
                )
            )


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


def tool_hash() -> str:
    """Fingerprint of the tool."""
    return fingerprint(PolishingTool())


def _with_hash(name: str, thing: object) -> dict[str, str]:
    return {name: described(thing), f"{name}_sha256": fingerprint(thing)}
