"""Every goal of finishing, from a mesh to a proven finish: what was found, what was wanted, and what limits the rest.

The short form takes minutes and leaves out what needs many whole jobs; the full one is what stands in results/. Each
part is measured in its own file, finishing_PART.py, which also runs alone. All figures are simulated.

    python benchmarks/finishing.py --short
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import finishing_checks
import finishing_force
import finishing_jobs
import finishing_meshes
import finishing_paths
import finishing_removal
import finishing_run
from common import machine, markdown_table, text_table, write_json, write_text

PARTS = {
    "meshes": finishing_meshes.rows,
    "paths": finishing_paths.rows,
    "checks": finishing_checks.rows,
    "force": finishing_force.rows,
    "removal": finishing_removal.rows,
    "run": finishing_run.rows,
    "jobs": finishing_jobs.rows,
}
RESULTS = Path(__file__).resolve().parent / "results" / "finishing.json"
EXPLAINED = RESULTS.with_name("finishing_explained.md")
"""What limits those that are missed, by hand."""
HEAD = ["part", "what", "found", "goal", "unit", "verdict", "of"]


def cells(row: dict[str, Any]) -> list[str]:
    """One line of the table."""
    found = row["found"]
    said = f"{found:.3g}" if isinstance(found, float) else str(found)
    verdict = "met" if row["met"] else "missed"
    return [row["part"], row["name"], said, str(row["goal"]), row["unit"], verdict, row["note"]]


def markdown(parts: dict[str, Any]) -> str:
    """The results as a page."""
    rows = [{"part": name} | row for name, part in parts.items() for row in part["rows"]]
    missed = sum(not row["met"] for row in rows)
    made = [
        (name, part["form"], part["machine"]["date"], f"{part['seconds']:.0f}", versions(part["machine"]))
        for name, part in parts.items()
    ]
    return "\n".join(
        [
            "# Finishing: goals and what was reached",
            "",
            f"All simulated. {missed} of {len(rows)} goals missed.",
            "",
            markdown_table(HEAD, [cells(row) for row in rows]),
            "",
            EXPLAINED.read_text(encoding="utf-8"),
            "Made by `python benchmarks/finishing.py`, which measures part by part:",
            "",
            markdown_table(["part", "form", "date", "took [s]", "with"], made),
            "",
        ]
    )


def versions(about: dict[str, Any]) -> str:
    """Cores and versions in words."""
    return ", ".join(f"{name} {value}" for name, value in about.items() if name != "date")


def parser() -> argparse.ArgumentParser:
    """The options."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--short", action="store_true", help="the quick form (default: the full one, about two hours)")
    options.add_argument("--only", choices=list(PARTS), action="append", help="this part; may be repeated")
    options.add_argument(
        "--out",
        type=Path,
        default=RESULTS,
        metavar="FILE.json",
        help="results, and the same as a page beside them in FILE.md; parts that are not measured now stay as they are "
        "(default: benchmarks/results/finishing.json)",
    )
    return options


def main() -> int:
    """Measure, print, and write after each part; 0 if all goals are met, 1 if not."""
    options = parser().parse_args()
    parts = json.loads(options.out.read_text(encoding="utf-8"))["parts"] if options.out.exists() else {}
    measured: list[dict[str, Any]] = []
    for name in options.only or PARTS:
        start = time.perf_counter()
        rows = PARTS[name](options.short)
        seconds = time.perf_counter() - start
        measured += [{"part": name} | row for row in rows]
        form = "short" if options.short else "full"
        parts[name] = {"form": form, "seconds": round(seconds), "machine": machine(), "rows": rows}
        parts = {name: parts[name] for name in PARTS if name in parts}
        write_json(options.out, {"parts": parts})
        write_text(options.out.with_suffix(".md"), markdown(parts))
        print(f"{name}: {seconds:.0f} s", file=sys.stderr, flush=True)
    print(text_table(HEAD, [cells(row) for row in measured]))
    return int(not all(row["met"] for row in measured))


if __name__ == "__main__":
    sys.exit(main())
