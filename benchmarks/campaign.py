"""All polishing goals, each case by its worst seed: runs ``burnish polish`` and reads what it wrote.

A case and seed that is done is not done again, so a campaign that was cut off goes on where it was; after a change
of the package start it with --fresh. All figures are of the true contact in simulation.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from cases import CASES, DEVIATION, DONE, FORCE, HEAD, STOPPED, Case, Metrics, Row, judge
from common import comma_numbers, line_distance, machine, markdown_table, text_table, write_json, write_text

from burnish.model.tool import PolishingTool
from burnish.polish.cellsim import plan_strokes
from burnish.polish.recipe import PRESTON, Recipe
from burnish.surface import DistanceGrid, Mould

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "benchmarks" / "results" / "polish.json"
RUNS = ROOT / "runs" / "campaign"


class Campaign:
    """Runs what is not there yet."""

    def __init__(self, folder: Path, total: int, keep: bool) -> None:
        self._folder, self._total, self._keep = folder, total, keep
        self._lock = threading.Lock()
        self._count = 0
        self._stop = threading.Event()
        self.source = source_hash()

    def run(self, case: Case, seed: int) -> Metrics | None:
        """The metrics of one run; None if it failed."""
        folder = self._folder / case.slug / f"seed-{seed}"
        start = time.perf_counter()
        fresh = not (folder / "metrics.json").exists()
        if fresh and not self._stop.is_set():
            self._polish(case, seed, folder)
        metrics = read_run(folder)
        with self._lock:
            self._count += 1
            took = f"{time.perf_counter() - start:.0f} s" if fresh else "done before"
            said = "FAILED, see " + str(folder.with_suffix(".part") / "log.txt")
            if metrics is not None:
                rms = metrics.get("force_rms_N")
                said = "nothing to score" if rms is None else f"force RMS {rms:.2f} N"
                said += f", coverage {metrics.get('coverage_pct', float('nan')):.1f} %"
            print(
                f"[{self._count}/{self._total}] {case.name}, seed {seed}: {said} ({took})", file=sys.stderr, flush=True
            )
        return metrics

    def stop(self) -> None:
        """Start nothing more."""
        self._stop.set()

    def _polish(self, case: Case, seed: int, folder: Path) -> None:
        """Into a draft folder, so that a run that was cut off is not taken for one that is done."""
        draft = folder.with_suffix(".part")
        shutil.rmtree(draft, ignore_errors=True)
        draft.mkdir(parents=True)
        with (draft / "log.txt").open("w") as log:
            status = subprocess.run(
                case.command(seed, draft.absolute()),
                cwd=ROOT,
                env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
                stdout=log,
                stderr=subprocess.STDOUT,
                check=False,
            ).returncode
        if status not in (DONE, STOPPED) or not (draft / "metrics.json").exists():
            return
        if not self._keep:
            (draft / "run.mcap").unlink(missing_ok=True)
        write_json(draft / "run.json", {"exit_status": status, "source": self.source})
        shutil.rmtree(folder, ignore_errors=True)
        draft.rename(folder)


def read_run(folder: Path) -> Metrics | None:
    """The metrics of a run that is done, with its exit status and the hash of its source."""
    try:
        metrics: dict[str, Any] = json.loads((folder / "metrics.json").read_text(encoding="utf-8"))
        if (folder / "run.json").exists():
            metrics |= json.loads((folder / "run.json").read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None
    return metrics


def source_hash() -> str:
    """Of all files of the package, so that results of two versions are not taken for one."""
    digest = hashlib.sha256()
    for path in sorted((ROOT / "src" / "burnish").rglob("*")):
        if path.is_file() and "__pycache__" not in path.parts:
            digest.update(str(path.relative_to(ROOT)).encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def expected_depth(mould_name: str, feed: float) -> float:
    """Preston's depth h = k F v/(feed step) of parallel tracks, v = feed, with the path's own line distance [m]."""
    mould, recipe = Mould.load(mould_name, "mm"), Recipe(force=FORCE, feed=feed)
    strokes = plan_strokes(mould, DistanceGrid.of(mould), recipe, PolishingTool())
    return PRESTON * FORCE / line_distance(strokes)


def with_deviation(metrics: Metrics | None, depth: float) -> Metrics | None:
    """The metrics with how far the mean removal is off the expected depth [%]."""
    if metrics is None or "removal_mean_um" not in metrics:
        return metrics
    return {**metrics, "preston_deviation_pct": 100.0 * (1e-6 * metrics["removal_mean_um"] / depth - 1.0)}


def markdown(rows: Sequence[Row], about: Mapping[str, Any], seeds: Sequence[int], warning: str) -> str:
    """The result as a page."""
    missed = sum(row.verdict == "missed" for row in rows)
    versions = ", ".join(f"{name} {value}" for name, value in about.items() if name not in ("date", "cores", "source"))
    summary = (
        f"All simulated; the worst of seeds {', '.join(map(str, seeds))} (the ideal arm draws nothing: once), "
        f"{FORCE:g} N, by the true contact force. {missed} of {sum(row.verdict != '-' for row in rows)} goals missed."
    )
    lines = [
        "# Polishing: goals and what was reached",
        "",
        summary,
        "",
        *([warning, ""] if warning else []),
        markdown_table(HEAD, [row.cells() for row in rows]),
        "",
        f"{about['date']}, {about['cores']} cores, {versions}, source {about['source']}.",
        "Made by `python benchmarks/campaign.py`.",
    ]
    return "\n".join(lines) + "\n"


def parser() -> argparse.ArgumentParser:
    """The options."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--short", action="store_true", help="the dome at 20 mm/s by the honest arm alone, one seed")
    options.add_argument(
        "--seeds", type=comma_numbers, default=[1, 2, 3, 4, 5], metavar="LIST", help="as 1,2 or 1-5 (default: 1-5)"
    )
    options.add_argument("--only", default="", metavar="TEXT", help="cases whose name holds this (default: all)")
    options.add_argument("--jobs", type=int, default=2, metavar="N", help="runs at a time (default: 2)")
    options.add_argument("--fresh", action="store_true", help="do again what is done")
    options.add_argument("--keep", action="store_true", help="keep the recordings; up to 0.5 GB a run of the ideal arm")
    options.add_argument("--runs", type=Path, default=RUNS, metavar="DIR", help="the runs (default: runs/campaign)")
    options.add_argument(
        "--out",
        type=Path,
        metavar="FILE.json",
        help="result, and the same as a page beside it in FILE.md (default: benchmarks/results/polish.json, "
        "for a part of the campaign part.json beside the runs)",
    )
    return options


def main() -> int:
    """Run, judge and write; 0 if all goals are met, 1 if not."""
    cli = parser()
    options = cli.parse_args()
    seeds: list[int] = options.seeds[:1] if options.short else options.seeds
    cases = CASES[:1] if options.short else [case for case in CASES if options.only in case.name]
    if not cases or not seeds or options.jobs < 1:
        cli.error(f"nothing to run; the cases are: {'; '.join(case.name for case in CASES)}")
    complete = len(cases) == len(CASES) and seeds == [1, 2, 3, 4, 5]
    out = options.out or (RESULTS if complete else options.runs / "part.json")
    todo = [(case, seed) for case in cases for seed in (seeds if case.seeded else seeds[:1])]
    if options.fresh:
        for case, seed in todo:
            shutil.rmtree(options.runs / case.slug / f"seed-{seed}", ignore_errors=True)
    campaign = Campaign(options.runs, len(todo), options.keep)
    with ThreadPoolExecutor(options.jobs) as pool:
        try:
            found = list(pool.map(lambda pair: campaign.run(*pair), todo))
        except KeyboardInterrupt:
            campaign.stop()
            raise
    depths = {c.slug: expected_depth(c.mould, c.feed) for c in cases if DEVIATION in c.goals}
    runs: dict[str, dict[int, Metrics | None]] = {case.slug: {} for case in cases}
    for (case, seed), metrics in zip(todo, found, strict=True):
        runs[case.slug][seed] = with_deviation(metrics, depths[case.slug]) if case.slug in depths else metrics
    rows = [row for case in cases for row in judge(case, runs[case.slug])]
    sources = {str(metrics.get("source")) for metrics in found if metrics is not None}
    warning = ""
    if sources - {campaign.source}:
        warning = "**Some runs are of an older state of the package; start with `--fresh` for one result.**"
    print(text_table(HEAD, [row.cells() for row in rows]))
    if warning:
        print(warning)
    about = machine() | {"source": campaign.source}
    write_json(out, {"machine": about, "older_runs": bool(warning), "rows": [vars(row) for row in rows], "runs": runs})
    write_text(out.with_suffix(".md"), markdown(rows, about, seeds, warning))
    return int(any(row.verdict == "missed" for row in rows))


if __name__ == "__main__":
    sys.exit(main())
