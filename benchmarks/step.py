"""What a control step costs, on one thread: model, inertia, law, the whole cycle, and the simulated arm under it.

The parts are timed call by call in interleaved rounds on states of a real pass, the physics in that pass itself, so
all of them see the same machine. The real-time factors are those of a whole short job on the plate and of its passes,
by the clock on the wall; by the processor's time they say what they were if nothing else ran on the machine.
"""

from __future__ import annotations

import os

# Before NumPy is loaded: BLAS reads its threads then.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import sys
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import perf_counter, perf_counter_ns, process_time
from typing import Any

import numpy as np
from common import machine, pieces_of, text_table, write_json
from typing_extensions import Self

from burnish.core import Array, Command, Sample, State
from burnish.model.tool import PolishingTool
from burnish.polish.cellsim import WristFelt, plan_strokes, simulated_job
from burnish.polish.process import Job
from burnish.polish.recipe import Recipe
from burnish.polish.stroke import Stroke
from burnish.runtime.loop import Rig, control
from burnish.runtime.supervisor import Supervisor
from burnish.sim import arms
from burnish.sim.robot import SimRobot
from burnish.surface import DistanceGrid, Mould

PART_NAMES = {
    "model": "Model.at",
    "sense": "WristSense.feel",
    "Lambda": "Lambda",
    "law": "ForceMotion.torque, Lambda given",
    "cycle": "whole cycle without robot",
    "physics": "physics step of 0.5 ms, in contact",
}
STATES = 50
"""States of the pass that each round goes through."""
CYCLES = 10
"""Cycles by which the simulated pass goes on in each round."""
GOALS = {100: 10.0, 1000: 3.0}
"""Control rate [Hz] to the least real-time factor of the honest arm."""


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


def time_parts(work: Work, rounds: int) -> dict[str, Array]:
    """Times of each part [µs], in interleaved rounds."""
    job, robot = work.job(100.0)
    timed = TimedRobot(robot=robot)
    job.rig.robot = timed
    samples = into_pass(job)
    assert job.follower is not None
    source, law, sense, model = deepcopy(job.follower), deepcopy(job.law), deepcopy(job.rig.sense), job.rig.model
    states: list[State] = []
    for _, _ in zip(range(STATES), samples, strict=False):
        assert job.rig.state is not None
        states.append(job.rig.state)

    def replayed() -> Iterator[State]:
        """The states over and over, on a clock that only runs forward."""
        number = 0
        while True:
            yield replace(states[number % STATES], t=states[0].t + 0.01 * number)
            number += 1

    stub = Replay(states=iter([replace(s, t=states[0].t + 0.01 * k) for k, s in enumerate(states * (rounds + 1))]))
    rig = Rig(stub, model, Supervisor(limits=job.rig.supervisor.limits), sense)
    cycle = control(rig, deepcopy(source), deepcopy(law))
    next(cycle)
    found: dict[str, list[float]] = {name: [] for name in PART_NAMES}
    stream = replayed()
    first = sense.feel(model.at(next(stream)), states[0])
    source.reset(first)
    law.reset(first)
    timed.steps.clear()
    for number in range(rounds):
        for _, _ in zip(range(CYCLES), samples, strict=False):
            pass
        for _ in range(STATES):
            state = next(stream)
            t0 = perf_counter_ns()
            arm = model.at(state)
            t1 = perf_counter_ns()
            arm = sense.feel(arm, state)
            t2 = perf_counter_ns()
            _ = arm.Lambda
            t3 = perf_counter_ns()
            reference = source.at(arm)
            t4 = perf_counter_ns()
            law.torque(arm, reference)
            t5 = perf_counter_ns()
            for name, taken in (("model", t1 - t0), ("sense", t2 - t1), ("Lambda", t3 - t2), ("law", t5 - t4)):
                found[name].append(taken)
        for _ in range(STATES - 1 if number == 0 else STATES):
            start = perf_counter_ns()
            next(cycle)
            found["cycle"].append(perf_counter_ns() - start)
        if number % 10 == 9:
            print(f"round {number + 1} of {rounds}", file=sys.stderr, flush=True)
    found["physics"] = timed.steps
    return {name: 1e-3 * np.array(values) for name, values in found.items()}


def real_time_factor(work: Work, rate: float) -> dict[str, float]:
    """Simulated over wall time of a job and of its passes, without recording and report."""
    job, robot = work.job(rate)
    in_pass, wall_in_pass, last = 0.0, 0.0, perf_counter()
    begin, before, processor = last, 0.0, process_time()
    with robot:
        for _ in job.run():
            now = perf_counter()
            if job.phase == "pass":
                in_pass += robot.time - before
                wall_in_pass += now - last
            last, before = now, robot.time
    if job.failure or job.rig.supervisor.tripped:
        raise SystemExit(f"step: the job ended early: {job.failure or job.rig.supervisor.event}")
    return {
        "rate_Hz": rate,
        "job": robot.time / (perf_counter() - begin),
        "pass": in_pass / wall_in_pass,
        "job_by_processor": robot.time / (process_time() - processor),
        "simulated_s": robot.time,
        "late_cycles": float(robot.late_cycles),
    }


def parser() -> argparse.ArgumentParser:
    """The options."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--rounds", type=int, default=60, metavar="N", help="interleaved rounds (default: 60)")
    options.add_argument(
        "--pieces", type=int, default=2, metavar="N", help="pieces of the plate's path, two lines each (default: 2)"
    )
    options.add_argument("--no-factor", action="store_true", help="leave out the real-time factors")
    options.add_argument(
        "--out", type=Path, metavar="FILE.json", help="file for the result in JSON (default: table on stdout only)"
    )
    return options


def main() -> int:
    """Measure and print; 0 if both real-time factors are reached or left out, 1 if not."""
    cli = parser()
    options = cli.parse_args()
    if options.rounds < 1 or options.pieces < 2:
        cli.error("expected at least 1 round and 2 pieces: the mould is located by touching them")
    work = Work.of(options.pieces)
    parts: dict[str, dict[str, Any]] = {}
    for name, values in time_parts(work, options.rounds).items():
        p5, median, p99 = np.percentile(values, [5, 50, 99])
        parts[name] = {"p5_us": float(p5), "median_us": float(median), "p99_us": float(p99), "count": len(values)}
    rows = [
        [PART_NAMES[name], *(f"{part[key]:.1f}" for key in ("p5_us", "median_us", "p99_us")), str(part["count"])]
        for name, part in parts.items()
    ]
    print(text_table(["part", "p5 [us]", "median [us]", "p99 [us]", "calls"], rows))
    factors: list[dict[str, Any]] = []
    if not options.no_factor:
        for rate, goal in GOALS.items():
            factor = real_time_factor(work, float(rate))
            factors.append(factor | {"goal": goal, "met": factor["job"] >= goal})
            print(f"{rate} Hz: {factor['job']:.1f} x real time", file=sys.stderr, flush=True)
        rows = [
            [
                f"honest arm, {f['rate_Hz']:.0f} Hz",
                f"{f['job']:.1f}",
                f"{f['pass']:.1f}",
                f"{f['job_by_processor']:.1f}",
                f"≥ {f['goal']:g}",
                "met" if f["met"] else "missed",
            ]
            for f in factors
        ]
        print()
        print(text_table(["times real time", "job", "its passes", "job, processor time", "goal", "verdict"], rows))
    if options.out:
        write_json(options.out, {"machine": machine(), "parts": parts, "real_time": factors})
    return 0 if all(f["met"] for f in factors) else 1


if __name__ == "__main__":
    sys.exit(main())
