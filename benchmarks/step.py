"""What a control step costs, on one thread: model, inertia, law, the whole cycle, and the simulated arm under it.

The parts are timed call by call in interleaved rounds on states of a real pass, the physics in that pass itself, so
all of them see the same machine; so are the steps of the peers that `peers.py` has installed. The real-time factors
are those of a whole short job on the plate and of its passes, by the clock on the wall; by the processor's time they
say what they were if no other process took the processor, and undisturbed what they were if nothing slowed it. Beside
them stands by how much a loop of additions that never changes was slowed between the very same cycles: what the
machine's other users took, who share its cores unseen.
"""

from __future__ import annotations

import os

# Before NumPy is loaded: BLAS reads its threads then.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from time import perf_counter_ns
from typing import Any

import numpy as np
from common import machine, text_table, write_json
from peers import PACKAGES, STEP_NAMES, Peer, python_of
from short_job import Replay, TimedRobot, Work, into_pass, real_time_factor

from burnish.control import OperationalSpace
from burnish.core import Array, Dynamics, State, ToolReference
from burnish.runtime.loop import Rig, control
from burnish.runtime.supervisor import Supervisor

PART_NAMES = {
    "model": "Model.at",
    "sense": "WristSense.feel",
    "Lambda": "Lambda",
    "law": "ForceMotion.torque, Lambda given",
    "supervisor": "Supervisor.filter",
    "cycle": "whole cycle without robot",
    "physics": "physics step of 0.5 ms, in contact",
    "operational": "Model.at + OperationalSpace.torque",
} | STEP_NAMES
STATES = 50
"""States of the pass that each round goes through."""
CYCLES = 10
"""Cycles by which the simulated pass goes on in each round."""
GOALS = {100: 10.0, 1000: 3.0}
"""Control rate [Hz] to the least real-time factor of the honest arm."""
MOST_US = 40.0
"""Goal for the model and the operational-space law at the 5th percentile [µs]."""
SUPERVISED_US = 30.0
"""Goal for the supervisor, at the median [µs]."""
FASTER = 3.5
"""Goal for their speed against each peer's step, at the 5th percentile."""


def time_parts(work: Work, rounds: int, peers: Sequence[Peer]) -> dict[str, Array]:
    """Times of each part and of each peer's step [µs], in interleaved rounds."""
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

    # Forth and back, and without a speed limit: the torques do not belong to this motion, and would stop the arm.
    swing = [*states, *states[::-1]] * (rounds // 2 + 1)
    stub = Replay(states=iter([replace(s, t=states[0].t + 0.01 * k) for k, s in enumerate(swing)]))
    supervisor = Supervisor(limits=replace(job.rig.supervisor.limits, speed=np.full(model.n, 1e9)), period=0.01)
    filtered: list[float] = []

    def filtering(arm: Dynamics, torque: Array) -> Array:
        start = perf_counter_ns()
        sent = Supervisor.filter(supervisor, arm, torque)
        filtered.append(perf_counter_ns() - start)
        return sent

    supervisor.filter = filtering  # type: ignore[method-assign]
    rig = Rig(stub, model, supervisor, sense)
    cycle = control(rig, deepcopy(source), deepcopy(law))
    next(cycle)
    found: dict[str, list[float]] = {name: [] for name in PART_NAMES if name not in STEP_NAMES}
    found |= {peer.name: [] for peer in peers}
    free = OperationalSpace.at_frequency(15.0)
    stream = replayed()
    first = sense.feel(model.at(next(stream)), states[0])
    source.reset(first)
    law.reset(first)
    free.reset(first)
    target = ToolReference(p=first.p, R=first.R, v=np.zeros(6), a=np.zeros(6))
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
        for _ in range(STATES):
            state = next(stream)
            start = perf_counter_ns()
            free.torque(model.at(state), target)
            found["operational"].append(perf_counter_ns() - start)
        for peer in peers:
            found[peer.name] += peer.time(STATES)
        if number % 10 == 9:
            print(f"round {number + 1} of {rounds}", file=sys.stderr, flush=True)
    if rig.supervisor.event is not None:
        raise SystemExit(f"step: the supervisor stopped the replay: {rig.supervisor.event.cause}")
    found["physics"], found["supervisor"] = timed.steps, filtered
    # The peers answer in µs.
    return {name: (1.0 if name in STEP_NAMES else 1e-3) * np.array(values) for name, values in found.items()}


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
    """Measure and print; 0 if all goals are met that were measured, 1 if not."""
    cli = parser()
    options = cli.parse_args()
    if options.rounds < 1 or options.pieces < 2:
        cli.error("expected at least 1 round and 2 pieces: the mould is located by touching them")
    work = Work.of(options.pieces)
    parts: dict[str, dict[str, Any]] = {}
    with ExitStack() as stack:
        peers = []
        for name in PACKAGES:
            if python_of(name).exists():
                peers.append(stack.enter_context(Peer(name)))
            else:
                print(f"{name}: left out, not installed; get it with python benchmarks/peers.py {name}")
        timed = time_parts(work, options.rounds, peers)
    for name, values in timed.items():
        p5, median, p99 = np.percentile(values, [5, 50, 99])
        parts[name] = {"p5_us": float(p5), "median_us": float(median), "p99_us": float(p99), "count": len(values)}
    rows = [
        [PART_NAMES[name], *(f"{part[key]:.1f}" for key in ("p5_us", "median_us", "p99_us")), str(part["count"])]
        for name, part in parts.items()
    ]
    print(text_table(["part", "p5 [us]", "median [us]", "p99 [us]", "calls"], rows))
    ours = parts["operational"]["p5_us"]
    ratios = {peer.name: parts[peer.name]["p5_us"] / ours for peer in peers}
    goals = [(PART_NAMES["operational"] + ", p5 [us]", ours, f"≤ {MOST_US:g}", ours <= MOST_US)]
    filtered = parts["supervisor"]["median_us"]
    goals += [(PART_NAMES["supervisor"] + ", median [us]", filtered, f"≤ {SUPERVISED_US:g}", filtered <= SUPERVISED_US)]
    goals += [(f"times faster than {n}, p5", ratio, f"≥ {FASTER:g}", ratio >= FASTER) for n, ratio in ratios.items()]
    print()
    verdicts = [[what, f"{value:.1f}", goal, "met" if met else "missed"] for what, value, goal, met in goals]
    print(text_table(["goal of a step", "found", "goal", "verdict"], verdicts))
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
                f"{f['machine_slowed']:.2f}",
                f"{f['job_undisturbed']:.1f}",
                f"≥ {f['goal']:g}",
                "met" if f["met"] else "missed",
            ]
            for f in factors
        ]
        print()
        heads = [
            "times real time",
            "job",
            "its passes",
            "by processor time",
            "fixed loop slowed",
            "undisturbed",
            "goal",
            "verdict",
        ]
        print(text_table(heads, rows))
    if options.out:
        steps = [{"what": what, "found": value, "goal": goal, "met": met} for what, value, goal, met in goals]
        write_json(options.out, {"machine": machine(), "parts": parts, "steps": steps, "real_time": factors})
    return 0 if all(f["met"] for f in factors) and all(met for *_, met in goals) else 1


if __name__ == "__main__":
    sys.exit(main())
