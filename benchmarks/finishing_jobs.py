"""Whole jobs: `burnish polish` from the STL file of each bundled mould to its report, by the clock on the wall.

python benchmarks/finishing_jobs.py [--short]

Each in a process of its own, one after the other, by the honest arm as by default. The short form takes the dome alone.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from finishing_defects import stl_in_mm

from burnish.surface import Mould, bundled

MOST = 180.0
"""Goal [s]."""


def polished(name: str, folder: Path) -> dict[str, Any]:
    """A row for one mould: how long its job took, and what it reached."""
    mould, source, out = Mould.load(name), folder / f"{name}.stl", folder / name
    source.write_bytes(stl_in_mm(mould.vertices[mould.faces]))
    start = time.perf_counter()
    command = [sys.executable, "-m", "burnish", "polish", "--mould", str(source), "--out", str(out)]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    seconds = time.perf_counter() - start
    done = ended.returncode == 0 and (out / "report.html").is_file()
    note = "".join(ended.stderr.strip().splitlines()[-1:]) or f"exit status {ended.returncode}"
    if done:
        found = json.loads((out / "metrics.json").read_text(encoding="utf-8"))
        note = (
            f"{found['path_length_m']:.1f} m in {found['duration_s']:.0f} s of the arm's clock, "
            f"{found['force_rms_N']:.2f} N RMS, coverage {found['coverage_pct']:.1f} %"
        )
    return {"name": f"STL to report, {name}", "found": seconds, "goal": MOST, "unit": "s",
            "met": done and seconds <= MOST, "note": note}  # fmt: skip


def rows(short: bool) -> list[dict[str, Any]]:
    """The rows of the table; short: the dome alone."""
    with tempfile.TemporaryDirectory() as folder:
        return [polished(name, Path(folder)) for name in (("dome",) if short else bundled.NAMES)]


def main() -> int:
    """Print the rows, one a line; 0 if all are met, 1 if not."""
    cli = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    cli.add_argument("--short", action="store_true", help="the dome alone")
    found = rows(cli.parse_args().short)
    for one in found:
        print(json.dumps(one, ensure_ascii=False))
    return 0 if all(one["met"] for one in found) else 1


if __name__ == "__main__":
    raise SystemExit(main())
