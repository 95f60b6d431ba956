"""What lies between an operator's hand and the arm: from a mouse's event to a reading, a reference, a torque.

    python benchmarks/latency.py --events 1000 --out benchmarks/results/operator.json

The mouse is a serial SpaceMouse that is played on a pseudo-terminal; a real spacenavd reads it and our client reads
the daemon. A time counts from before the bytes are written until after the result that holds them: a reading, the
reference of `Operator` (shaping, modes, limits, smoothing), or the torque of a law. The first two follow as soon as a
look every 0.1 ms finds the event, so they hold next to no waiting; the torque comes from a loop at a control rate,
whose period is taken off (the goal is 1 period + 1 ms). Both processes run at a real-time priority where that is
allowed, as on a robot's computer. What carries bytes through a pseudo-terminal is a kernel thread without one, so on
a busy machine the rows that begin at the event measure other programs; the rows of our own code do not.

What is the machine's own share is measured in the same runs, between the events: how late a sleep ends that waits for
nothing but its time. A cycle that finds an event is taken apart: how late it was woken, and how long it then took.
"""

from __future__ import annotations

import os

# Before NumPy is loaded: BLAS reads its threads then.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import random
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from common import machine, markdown_table, write_json, write_text
from teleop.magellan import Spacenavd

from burnish.control import OperationalSpace
from burnish.core import State
from burnish.model.model import Model
from burnish.polish.cell import HOME
from burnish.runtime.limits import Limits
from burnish.runtime.operating import bounds, watched
from burnish.teleop.device import Device, Reading
from burnish.teleop.modes import Panel
from burnish.teleop.modes_b import ModesB
from burnish.teleop.reference import Operator
from burnish.teleop.shaped import Shaped
from burnish.teleop.spacenav import FULL_SCALE, open_space_nav

ROOT = Path(__file__).resolve().parents[1]
RATES = (100.0, 500.0)
"""Control rates [Hz]."""
POLL = 1e-4
"""Pause between two questions where there is no control rate [s]: without one the kernel holds real-time work up."""
PAUSE = (0.02, 0.04)
"""Time between events [s], drawn evenly so that they fall anywhere into a control period."""
LOST = 1.0
"""An event that has not arrived by then is lost [s]."""
COUNTS = range(100, 250)
"""Pushes that are sent, one after the other: beyond the dead-band, each unlike the one before."""
PRIORITY = 10
"""Any real-time priority is before all that has none."""
GOALS = {"event to reference": 5.0, "event to torque": 1.0}
"""p99 [ms]."""


class Found(NamedTuple):
    """An event that was found; times [s]."""

    latency: float
    """From before it was sent until the cycle that found it was done."""
    idle: float
    """How late a sleep was that waited for nothing but the moment to send it."""
    late: float
    """How late the cycle that found it was woken."""
    took: float
    """What that cycle then took."""


class Watched:
    """A device whose last raw reading is kept."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self.pushed = 0.0

    def read(self) -> Reading:
        reading = self._device.read()
        self.pushed = reading.axes[0]
        return reading


class Bench:
    """The daemon, the client, and an arm at home that an operator pushes to the right."""

    def __init__(self, daemon: Spacenavd, device: Device, seed: int) -> None:
        self.mouse, self.watched, self.random = daemon.mouse, Watched(device), random.Random(seed)
        self.model = Model.jaco2()
        self.state = State(t=0.0, q=HOME, dq=np.zeros(len(HOME)))
        self.arm = self.model.at(self.state)
        self.operator = Operator(
            read=Shaped(device=self.watched).read,  # type: ignore[arg-type]
            panel=Panel(modes=ModesB(fitted=False)),
            bounds=bounds(Limits.jaco2()),
            clearance=watched().closing,
        )
        self.law = OperationalSpace(kp=100.0, kd=20.0)
        self.operator.reset(self.arm)
        self.law.reset(self.arm)
        self.lost = 0

    def look(self) -> None:
        self.watched.read()

    def refer(self) -> None:
        self.operator.at(self._now())

    def refer_at_once(self) -> None:
        before = self.watched.pushed
        self.look()
        if self.watched.pushed != before:
            self.refer()

    def command(self) -> None:
        arm = self.model.at(State(t=time.perf_counter(), q=HOME, dq=np.zeros(len(HOME))))
        self.law.torque(arm, self.operator.at(arm))

    def _now(self) -> Any:
        return type(self.arm).of(**(vars(self.arm) | {"t": time.perf_counter()}))

    def latencies(self, act: Callable[[], None], events: int, period: float = POLL) -> list[Found]:
        """From an event to the end of the first ``act`` that has seen it, for each."""
        found = []
        due = self._rest(act)
        for k in range(events):
            count = COUNTS[k % len(COUNTS)]
            send = time.perf_counter() + self.random.uniform(*PAUSE)
            while due < send:
                due = _cycle(act, due, period)[0]
            idle = _until(send)
            sent = time.perf_counter()
            self.mouse.move(count, 0, 0, 0, 0, 0)
            while self.watched.pushed != count / FULL_SCALE and due < sent + LOST:
                due, late, took = _cycle(act, due, period)
                now = time.perf_counter()
            if self.watched.pushed == count / FULL_SCALE:
                found.append(Found(now - sent, idle, late, took))
            else:
                self.lost += 1
        return found

    def durations(self, act: Callable[[], None], events: int) -> np.ndarray:
        """Time that each ``act`` takes while events arrive [ms]: the share of our own code."""
        due = self._rest(act)
        found = []
        for k in range(events):
            self.mouse.move(COUNTS[k % len(COUNTS)], 0, 0, 0, 0, 0)
            _until(due)
            start = time.perf_counter()
            act()
            found.append(1e3 * (time.perf_counter() - start))
            due = time.perf_counter() + 0.005
        return np.array(found)

    def _rest(self, act: Callable[[], None]) -> float:
        """Let go of the cap and wait until all has come to rest; the time then."""
        self.mouse.move(0, 0, 0, 0, 0, 0)
        until = time.perf_counter() + 0.2
        while time.perf_counter() < until:
            act()
        return until


def _cycle(act: Callable[[], None], due: float, period: float) -> tuple[float, float, float]:
    """Act when it is due: when that is next, how late it was, what it took. A late loop goes on from where it is."""
    late = _until(due)
    start = time.perf_counter()
    act()
    end = time.perf_counter()
    return max(due + period, end), late, end - start


def _until(moment: float) -> float:
    """Sleep until then; how much later it is [s]."""
    left = moment - time.perf_counter()
    if left > 0.0:
        time.sleep(left)
    return max(time.perf_counter() - moment, 0.0)


def real_time() -> int | None:
    """Take a real-time priority, which the daemon inherits; None where that is not allowed."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except PermissionError:
        return None
    return PRIORITY


def column(found: list[Found], name: str) -> np.ndarray:
    """One of the times of every event [ms]."""
    return 1e3 * np.array([getattr(each, name) for each in found])


def figures(times: np.ndarray) -> dict[str, float]:
    return {
        "p50_ms": round(float(np.percentile(times, 50)), 3),
        "p99_ms": round(float(np.percentile(times, 99)), 3),
        "max_ms": round(float(times.max()), 3),
        "events": len(times),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--events", type=int, default=1000, help="of each kind (default %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of the moments of the events (default %(default)s)")
    default = ROOT / "benchmarks" / "results" / "operator.json"
    parser.add_argument(
        "--out", type=Path, default=default, help="result; a page is written beside it (default %(default)s)"
    )
    options = parser.parse_args()
    priority = real_time()
    rows: dict[str, dict[str, float]] = {}
    with Spacenavd() as daemon, open_space_nav(path=daemon.socket) as device:
        bench = Bench(daemon, device, options.seed)
        rows["event to reading"] = figures(column(bench.latencies(bench.look, options.events), "latency"))
        rows["event to reference"] = figures(column(bench.latencies(bench.refer_at_once, options.events), "latency"))
        rows["of these: our reading"] = figures(bench.durations(bench.look, options.events))
        rows["of these: our reading and reference"] = figures(bench.durations(bench.refer, options.events))
        rows["of these: our reading, reference, model and torque"] = figures(
            bench.durations(bench.command, options.events)
        )
        for rate in RATES:
            found = bench.latencies(bench.command, options.events, 1.0 / rate)
            less = column(found, "latency") - 1e3 / rate
            rows[f"event to torque at {rate:g} Hz, less the period"] = figures(less)
            rows[f"at {rate:g} Hz: the machine, an idle sleep's end"] = figures(column(found, "idle"))
            rows[f"at {rate:g} Hz: the cycle was woken late by"] = figures(column(found, "late"))
            rows[f"at {rate:g} Hz: the cycle took"] = figures(column(found, "took"))
        lost = bench.lost
    about = machine() | {"load_average": round(os.getloadavg()[0], 1), "real_time_priority": priority}
    write_json(options.out, {"machine": about, "lost_events": lost, "latency": rows})
    write_text(options.out.with_suffix(".md"), page(rows, about, lost))
    print(page(rows, about, lost))


def page(rows: dict[str, dict[str, float]], about: dict[str, Any], lost: int) -> str:
    """The result for people."""
    lines = []
    for name, row in rows.items():
        goal = next((most for begin, most in GOALS.items() if name.startswith(begin)), None)
        verdict = "-" if goal is None else "met" if row["p99_ms"] <= goal else "missed"
        numbers = [f"{row[key]:.2f}" for key in ("p50_ms", "p99_ms", "max_ms")]
        lines.append([name, *numbers, "-" if goal is None else f"{goal:g}", verdict])
    table = markdown_table(("", "p50 [ms]", "p99 [ms]", "largest [ms]", "goal, p99 [ms]", "verdict"), lines)
    return (
        f"# From an operator's hand to the arm\n\n{(__doc__ or '').split(chr(10) * 2)[2].strip()}\n\n{table}\n\n"
        f"{rows['event to reading']['events']} events each, {lost} lost. {about['cores']} cores at a load average of "
        f"{about['load_average']}, real-time priority {about['real_time_priority']}, Python {about['python']}, "
        f"{about['date']}.\n"
    )


if __name__ == "__main__":
    main()
