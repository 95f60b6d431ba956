"""What a cycle of the real arm's driver costs against the stand-in, and whether it leaves memory behind.

The stand-in is the C library of tests/hardware with its arm in another process: there is no cable and no vendor's code
in these figures, only what burnish does. A cycle is `Jaco2.read` and `Jaco2.write` of a torque, without the wait.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import shutil
import sys
import tempfile
from pathlib import Path
from time import perf_counter_ns

import numpy as np
from common import machine, text_table, write_json

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
from hardware.standin import SERIAL, StandIn, Unhurried, build

from burnish.core import Torque
from burnish.hardware.jaco2 import Jaco2
from burnish.hardware.torque_mode import TorqueSetup
from burnish.model.model import Model

GOAL_US = 200.0
"""Most that a cycle may take in the median [µs]."""
GROWTH_KB = 1000
"""Most by which the process may grow after its first tenth [kB]; a float kept a cycle would be 24 MB in a million."""


def resident() -> int:
    """Memory of this process [kB]."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") // 1024


def run(cycles: int) -> tuple[dict[str, np.ndarray], int]:
    """Times of read and of write [µs], and the growth of the process after the first tenth [kB]."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        raise SystemExit("no C compiler: the stand-in cannot be built")
    kept = min(cycles, 20_000)
    times = {"read": np.zeros(kept), "write": np.zeros(kept)}
    before = 0
    with tempfile.TemporaryDirectory() as folder:
        standin = StandIn(Path(folder))
        standin.reset()
        arm = Jaco2(Model.jaco2(), serial=SERIAL, library=build(compiler, Path(folder)), clock=Unhurried())
        noise = np.random.default_rng(0).normal(0.0, 0.02, 997).tolist()
        torque = Torque(np.ones(6))
        with arm:
            # The arm's process sleeps; what it would show is written here.
            arm._torque, standin.memory.mode = TorqueSetup.thesis_a(), 1
            for cycle in range(cycles):
                standin.memory.torque[cycle % 6] = noise[cycle % 997]
                standin.memory.position[cycle % 6] += 1e-3 if cycle % 12 < 6 else -1e-3
                t0 = perf_counter_ns()
                arm.read()
                t1 = perf_counter_ns()
                arm.write(torque)
                t2 = perf_counter_ns()
                times["read"][cycle % kept], times["write"][cycle % kept] = 1e-3 * (t1 - t0), 1e-3 * (t2 - t1)
                if cycle == cycles // 10:
                    before = resident()
            growth = resident() - before
            standin.memory.mode = 0
        standin.stop()
    return times, growth


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cycles", type=int, default=1_000_000, help="how many (default: 1000000)")
    parser.add_argument("--out", type=Path, help="file for the figures, JSON")
    options = parser.parse_args()
    times, growth = run(options.cycles)
    times["cycle"] = times["read"] + times["write"]
    rows = [[name, *(f"{np.percentile(values, share):.1f}" for share in (5, 50, 99))] for name, values in times.items()]
    print(text_table(["µs", "5 %", "median", "99 %"], rows))
    print(f"{options.cycles} cycles; the process grew by {growth} kB after the first tenth")
    median = float(np.median(times["cycle"]))
    if options.out:
        write_json(options.out, {"machine": machine(), "median_us": median, "growth_kB": growth})
    reached = median <= GOAL_US and growth <= GROWTH_KB
    print(f"goal of {GOAL_US:.0f} µs and {GROWTH_KB} kB {'reached' if reached else 'MISSED'}")
    return 0 if reached else 1


if __name__ == "__main__":
    sys.exit(main())
