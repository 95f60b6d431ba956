"""Every goal of finishing, from a mesh to a proven finish: what was found, what was wanted, and what limits the rest.

The short form takes minutes and leaves out what needs many whole jobs; the full one is what stands in results/. Each
part is measured in its own file, finishing_PART.py, which also runs alone. All figures are simulated.

    python benchmarks/finishing.py --short
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import Any

import finishing_checks
import finishing_force
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
}
RESULTS = Path(__file__).resolve().parent / "results" / "finishing.json"
HEAD = ["part", "what", "found", "goal", "unit", "verdict", "what limits it"]


def cells(row: dict[str, Any]) -> list[str]:
    """One line of the table."""
    found = row["found"]
    said = f"{found:.3g}" if isinstance(found, float) else str(found)
    verdict = "met" if row["met"] else "missed"
    return [row["part"], row["name"], said, str(row["goal"]), row["unit"], verdict, row["note"]]


def markdown(rows: list[dict[str, Any]], about: dict[str, Any], form: str) -> str:
    """The result as a page."""
    missed = sum(not row["met"] for row in rows)
    versions = ", ".join(f"{name} {value}" for name, value in about.items() if name not in ("date", "cores"))
    return "\n".join(
        [
            "# Finishing: goals and what was reached",
            "",
            f"All simulated. {missed} of {len(rows)} goals missed.",
            "",
            markdown_table(HEAD, [cells(row) for row in rows]),
            "",
            f"{about['date']}, {about['cores']} cores, {versions}.",
            f"Made by `python benchmarks/finishing.py{form}`.",
            "",
        ]
    )


def parser() -> argparse.ArgumentParser:
    """The options."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--short", action="store_true", help="the quick form (default: the full one, about two hours)")
    options.add_argument("--only", choices=list(PARTS), action="append", help="this part; may be repeated")
    options.add_argument(
        "--out",
        type=Path,
        metavar="FILE.json",
        help="result, and the same as a page beside it in FILE.md (default: benchmarks/results/finishing.json for the "
        "full form, else no file)",
    )
    return options


def main() -> int:
    """Measure, print and write; 0 if all goals are met, 1 if not."""
    options = parser().parse_args()
    rows: list[dict[str, Any]] = []
    for part in options.only or PARTS:
        start = time.perf_counter()
        rows += [{"part": part} | row for row in PARTS[part](options.short)]
        print(f"{part}: {time.perf_counter() - start:.0f} s", file=sys.stderr, flush=True)
    print(text_table(HEAD, [cells(row) for row in rows]))
    complete = not options.short and not options.only
    out = options.out or (RESULTS if complete else None)
    if out is not None:
        form = (" --short" if options.short else "") + "".join(f" --only {part}" for part in options.only or [])
        about = machine()
        write_json(out, {"machine": about, "rows": rows})
        write_text(out.with_suffix(".md"), markdown(rows, about, form))
    return int(not all(row["met"] for row in rows))


if __name__ == "__main__":
    sys.exit(main())
