"""What a recording costs the control loop, and what a killed one loses.

    python benchmarks/recording.py --kills 100 --seed 1 --out benchmarks/results/recording.json

A loop of 1 kHz in a process of its own records samples and keeps the interpreter busy for 0.3 ms a cycle, as a law and
a model do. It is killed (SIGKILL) at a random moment. The time of its last sample is known from memory that both
processes share; what is lost is that time less the last one that `recover` finds.
"""

from __future__ import annotations

import argparse
import mmap
import os
import signal
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, make_reader

sys.path.insert(0, str(Path(__file__).resolve().parent))

from common import machine, write_json

from burnish.core import Array, Dynamics, Sample, ToolReference
from burnish.record.recorder import Recorder
from burnish.record.recover import recover
from burnish.rotation import exp

RATE = 1000.0
BUSY = 3e-4
"""Time of a cycle in which nobody else gets the interpreter [s]."""
JOINTS = ("1", "2", "3", "4", "5", "6")


def samples(count: int, seed: int) -> list[Sample]:
    rng = np.random.default_rng(seed)

    def rows(n: int) -> Array:
        return rng.normal(size=n)

    found = []
    for _ in range(count):
        arm = Dynamics(
            t=0.0,
            q=rows(6),
            dq=rows(6),
            p=rows(3),
            R=exp(rows(3)),
            J=np.zeros((6, 6)),
            dJdq=np.zeros(6),
            M=np.eye(6),
            h=np.zeros(6),
            g=np.zeros(6),
            tau=rows(6),
            F=rows(6),
        )
        normal = np.array([0.0, 0.0, 1.0])
        wanted = ToolReference(p=rows(3), R=exp(rows(3)), v=np.zeros(6), a=np.zeros(6), normal=normal, force=10.0)
        found.append(Sample(arm, wanted, rows(6), rows(6)))
    return found


def at_time(sample: Sample, t: float) -> Sample:
    return sample._replace(arm=Dynamics.of(**(vars(sample.arm) | {"t": t})))


def wait_until(moment: float) -> None:
    left = moment - time.monotonic()
    if left > 0.0:
        time.sleep(left)


def record_for_ever(folder: Path) -> None:
    """The process that is killed."""
    ready = samples(64, 0)
    with (folder / "last").open("r+b") as file, mmap.mmap(file.fileno(), 8) as last:
        recorder = Recorder(folder / "run.mcap", joint_names=JOINTS, metadata={"verb": "benchmark"})
        start = time.monotonic()
        cycle = 0
        while True:
            wait_until(start + cycle / RATE)
            t = time.monotonic() - start
            until = time.perf_counter() + BUSY
            while time.perf_counter() < until:
                pass
            recorder.record(at_time(ready[cycle % 64], t), "pass")
            last[:] = struct.pack("<d", t)
            cycle += 1


def kill_once(after: float) -> dict[str, float]:
    """Start the process, kill it ``after`` its first samples [s]; what it lost, and that the file can be read."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "last").write_bytes(bytes(8))
        environment = os.environ | {"OMP_NUM_THREADS": "1"}
        child = subprocess.Popen([sys.executable, __file__, "--child", name], env=environment)
        deadline = time.monotonic() + 60.0
        while struct.unpack("<d", (folder / "last").read_bytes())[0] == 0.0:
            if child.poll() is not None or time.monotonic() > deadline:
                child.kill()
                raise RuntimeError("the recording process did not start")
            time.sleep(0.01)
        time.sleep(after)
        child.send_signal(signal.SIGKILL)
        child.wait()
        (last,) = struct.unpack("<d", (folder / "last").read_bytes())
        in_order = read_in_order(folder / "run.mcap")
        saved = recover(folder / "run.mcap", folder / "mended.mcap")
        with (folder / "mended.mcap").open("rb") as file:
            indexed = sum(1 for _ in make_reader(file, validate_crcs=True).iter_messages())
        if not indexed == saved.messages >= in_order:
            raise RuntimeError(f"recover saved {saved.messages} messages, readers find {in_order} and {indexed}")
        return {
            "t_s": last,
            "lost_ms": 1e3 * max(0.0, last - 1e-9 * (saved.last or 0)),
            "messages": saved.messages,
        }


def read_in_order(path: Path) -> int:
    """Messages that the reader of the mcap package finds in the file as it was left."""
    count = 0
    with path.open("rb") as file:
        try:
            for _ in NonSeekingReader(file).iter_messages(log_time_order=False):
                count += 1
        except (McapError, struct.error):  # The one at the end of the file, the other inside a record.
            pass
    return count


def cost(seconds: float) -> dict[str, float]:
    """Time of a cycle's own work at 1 kHz [µs], with and without recording it, in turns of a tenth of a second."""
    ready = samples(64, 0)
    taken: dict[bool, list[float]] = {True: [], False: []}
    calls: list[float] = []
    with tempfile.TemporaryDirectory() as name:
        recorder = Recorder(Path(name) / "run.mcap", joint_names=JOINTS, metadata={})
        start = time.monotonic()
        for cycle in range(round(seconds * RATE)):
            wait_until(start + cycle / RATE)
            recording = cycle // 100 % 2 == 0
            sample = at_time(ready[cycle % 64], cycle / RATE)
            begin = time.perf_counter()
            work()
            if recording:
                before = time.perf_counter()
                recorder.record(sample, "pass")
                calls.append(time.perf_counter() - before)
            taken[recording].append(time.perf_counter() - begin)
        recorder.close()
    with_it, without = (1e6 * np.array(taken[key]) for key in (True, False))
    return {
        "cycle_without_median_us": float(np.median(without)),
        "cycle_with_median_us": float(np.median(with_it)),
        "cost_median_us": float(np.median(with_it) - np.median(without)),
        "cycle_without_p99_us": float(np.percentile(without, 99)),
        "cycle_with_p99_us": float(np.percentile(with_it, 99)),
        "record_call_median_us": 1e6 * float(np.median(calls)),
        "cycles": len(with_it) + len(without),
    }


def thread_time(count: int = 20, batches: int = 200) -> float:
    """Processor time of the recorder's thread a sample [µs], chunks of ``count`` samples as at 1 kHz."""
    from burnish.record.recorder import _File

    ready = [(at_time(sample, i / RATE), "pass") for i, sample in enumerate(samples(count, 0))]
    best = float("inf")
    with tempfile.TemporaryDirectory() as name:
        file = _File((Path(name) / "run.mcap").open("wb"), JOINTS, {})
        file.begin()
        for _ in range(batches):
            start = time.thread_time()
            file.write(ready)
            file.flush()
            best = min(best, time.thread_time() - start)
        file.finish({})
    return 1e6 * best / count


def work() -> float:
    """About 0.3 ms of plain Python, the same every time."""
    total = 0.0
    for i in range(4000):
        total += i * 0.5
    return total


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=100, metavar="N", help="processes to kill (default: 100)")
    parser.add_argument("--seconds", type=float, default=20.0, metavar="S", help="of the cost (default: 20)")
    parser.add_argument("--seed", type=int, default=1, metavar="K", help="of the moments (default: 1)")
    parser.add_argument("--out", type=Path, metavar="FILE.json", help="file for the result")
    parser.add_argument("--child", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child is not None:
        record_for_ever(options.child)
    rng = np.random.default_rng(options.seed)
    kills = [kill_once(moment) for moment in rng.uniform(0.2, 0.8, options.kills)]
    lost = [kill["lost_ms"] for kill in kills]
    result: dict[str, Any] = {
        "machine": machine() | {"load": round(os.getloadavg()[0], 1)},
        "kill": {
            "rate_Hz": RATE,
            "kills": len(kills),
            "seed": options.seed,
            "readable": len(kills),
            "lost_ms_median": float(np.median(lost)),
            "lost_ms_max": float(np.max(lost)),
            "lost_ms": [round(value, 2) for value in lost],
        },
        "cost": cost(options.seconds) | {"thread_us_a_sample": thread_time()},
    }
    print(f"kill -9: {len(kills)} times, lost {np.median(lost):.1f} ms (median), {np.max(lost):.1f} ms (most)")
    print(result["cost"])
    if options.out is not None:
        write_json(options.out, result)


if __name__ == "__main__":
    main()
