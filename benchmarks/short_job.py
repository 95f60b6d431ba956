"""A short job of the honest arm on the plate, to time the parts of a control cycle and the whole of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from time import perf_counter, perf_counter_ns, process_time

import numpy as np
from common import pieces_of
from typing_extensions import Self

from burnish.core import Array, Command, Sample, State, Torque
from burnish.model.tool import PolishingTool
from burnish.paths.stroke import Stroke
from burnish.polish.cellsim import WristFelt, plan_strokes, simulated_job
from burnish.polish.process import Job
from burnish.polish.recipe import Recipe
from burnish.sim import arms
from burnish.sim.robot import SimRobot
from burnish.surface import DistanceGrid, Mould


@dataclass(kw_only=True)
class Replay:
    """A robot that costs nothing: it hands out recorded states and takes any command."""

    states: Iterator[State]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        """Nothing to leave."""

    def read(self) -> State:
        """The next recorded state."""
        return next(self.states)

    def write(self, command: Command) -> Array:
        """Applied as it is."""
        assert isinstance(command, Torque)
        return command.tau


@dataclass(kw_only=True)
class TimedRobot:
    """The simulated arm, with the time of its physics steps [ns] while it touches."""

    robot: SimRobot
    steps: list[float] = field(default_factory=list)

    def __enter__(self) -> Self:
        self.robot.__enter__()
        return self

    def __exit__(self, *exception: object) -> None:
        self.robot.__exit__(*exception)

    def read(self) -> State:
        """As the robot does; what the sensors cost is shared among the steps."""
        force = self.robot.truth.normal_force
        before, start = len(force), perf_counter_ns()
        state = self.robot.read()
        taken = perf_counter_ns() - start
        if len(force) > before and force[-1] > 0.0:
            self.steps.append(taken / (len(force) - before))
        return state

    def write(self, command: Command) -> Array:
        """As the robot does."""
        return self.robot.write(command)


@dataclass(frozen=True, kw_only=True)
class Work:
    """A short job on the plate."""

    mould: Mould
    grid: DistanceGrid
    tool: PolishingTool
    strokes: list[Stroke]

    @classmethod
    def of(cls, pieces: int) -> Work:
        """Pieces of the plate's tool path, spread over it."""
        mould, tool = Mould.load("plate", "mm"), PolishingTool()
        grid = DistanceGrid.of(mould)
        strokes = pieces_of(plan_strokes(mould, grid, Recipe(), tool), pieces)
        return cls(mould=mould, grid=grid, tool=tool, strokes=strokes)

    def job(self, rate: float) -> tuple[Job, SimRobot]:
        """The job of an honest arm."""
        arm = arms.honest(1)
        return simulated_job(
            self.grid, self.strokes, arm, rate=rate, felt=WristFelt(), tool=self.tool, on_phase=lambda phase: None
        )


def into_pass(job: Job) -> Iterator[Sample]:
    """The samples of a job, gone on to where the force has settled."""
    samples = job.run()
    start = None
    for sample in samples:
        if job.phase == "pass":
            start = sample.arm.t if start is None else start
            if sample.arm.t - start > 1.5:
                return samples
    raise SystemExit(f"step: the job did not reach a pass: {job.failure or job.rig.supervisor.event}")


PACE_EVERY = 100
"""Cycles of the job from one run of the fixed loop to the next."""


def fixed_loop() -> float:
    """Time of additions that fit into the nearest cache and never change [s]: what the machine gives right now."""
    start, total = perf_counter(), 0
    for i in range(2000):
        total += i * i
    return perf_counter() - start


def real_time_factor(work: Work, rate: float) -> dict[str, float]:
    """Simulated over wall time of a job and of its passes, without recording and report.

    ``machine_slowed`` is the mean time of a fixed loop, run between the cycles and not counted as theirs, over its
    quickest twentieth: what other users of the machine take from it. ``job_undisturbed`` is what the job had been if
    every cycle had taken what the quickest twentieth of its phase's cycles took.
    """
    job, robot = work.job(rate)
    taken: dict[str, list[float]] = {}
    loops: list[float] = []
    in_pass, in_loops, loops_processor = 0.0, 0.0, 0.0
    begin, before, processor = perf_counter(), 0.0, process_time()
    last = begin
    with robot:
        for number, _ in enumerate(job.run()):
            now = perf_counter()
            taken.setdefault(job.phase, []).append(now - last)
            if job.phase == "pass":
                in_pass += robot.time - before
            before = robot.time
            last = perf_counter()
            if number % PACE_EVERY == 0:
                used = process_time()
                loops.append(fixed_loop())
                loops_processor += process_time() - used
                in_loops, last = in_loops + perf_counter() - last, perf_counter()
    if job.failure or job.rig.supervisor.tripped:
        raise SystemExit(f"step: the job ended early: {job.failure or job.rig.supervisor.event}")
    undisturbed = sum(len(times) * float(np.percentile(times, 5)) for times in taken.values())
    return {
        "rate_Hz": rate,
        "job": robot.time / (last - begin - in_loops),
        "pass": in_pass / sum(taken["pass"]),
        "job_by_processor": robot.time / (process_time() - processor - loops_processor),
        "machine_slowed": float(np.mean(loops) / np.percentile(loops, 5)),
        "job_undisturbed": robot.time / undisturbed,
        "simulated_s": robot.time,
        "late_cycles": float(robot.late_cycles),
    }
