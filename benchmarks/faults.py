"""The fault campaign and ten virtual hours of nominal work: runs ``burnish campaign`` twice and keeps what it found.

What is done is not done again, so a run that was cut off goes on where it was; after a change of the package choose
another folder with --runs, or delete the old one. Two campaigns that were run apart, by ``burnish campaign``, are put
together with --made; the page says of which source each was. All figures are of the simulated plant, by an independent
judge.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from common import machine, markdown_table, text_table, write_json, write_text

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "benchmarks" / "results" / "campaign.json"
RUNS = ROOT / "runs" / "faults"
HOUR = 120
"""Nominal episodes of 30 s in an hour."""
HEAD = ("goal", "wanted", "found", "verdict")


def campaign(folder: Path, words: Sequence[str]) -> dict[str, Any]:
    """What ``burnish campaign`` says with these options; ends this program if that was interrupted or refused."""
    command = [sys.executable, "-m", "burnish", "campaign", "--out", str(folder), *words]
    status = subprocess.run(command, cwd=ROOT, check=False).returncode
    if status not in (0, 1):
        sys.exit(status)
    return said(folder)


def said(folder: Path) -> dict[str, Any]:
    """What a campaign that was run found."""
    found: dict[str, Any] = json.loads((folder / "campaign.json").read_text(encoding="utf-8"))
    return found


def goals(faults: Mapping[str, Any], nominal: Mapping[str, Any]) -> list[tuple[str, str, str, str]]:
    """Each goal, what was found, and whether it is met; a dash where nothing was measured."""
    hours = nominal["faultless_hours"]
    runaway, reaction = faults["runaway_peak_speed"], faults["reaction_cycles"]
    rows = [
        ("unsafe torque samples", 0.0, float(faults["unsafe_samples"] + nominal["unsafe_samples"])),
        ("cycles from the first invalid sample to the stop, largest", 1.0, reaction["invalid"]["max"]),
        ("cycles from the first stale sample to the stop, largest", 2.0, reaction["stale"]["max"]),
        ("cycles from the first stale sample of one joint to the stop, largest", 2.0, reaction["frozen"]["max"]),
        ("urgent faults answered late, or not", 0.0, float(faults["late_reactions"])),
        ("runaway joint at 100 Hz, speed/limit, largest", 1.0, runaway["100 Hz"]["max"]),
        ("runaway joint at 1 kHz, speed/limit, largest", 1.0, runaway["1000 Hz"]["max"]),
        ("drift in 2 s with an unknown kilogram, 99 % [mm]", 50.0, faults["payload_drift_mm"]["p99"]),
        ("stopped arms that did not come to rest", 0.0, float(faults["still_moving"])),
        (f"false trips in {hours:.1f} h of nominal work", max(1.0, hours / 10.0), float(nominal["false_trips"])),
    ]
    return [
        (name, f"≤ {most:g}", "–" if value is None else f"{value:.4g}", verdict(value, most))
        for name, most, value in rows
    ]


def verdict(value: float | None, most: float) -> str:
    """In a word."""
    return "–" if value is None else "met" if value <= most else "missed"


def markdown(rows: Sequence[Sequence[str]], faults: Mapping[str, Any], pages: Sequence[str], command: str) -> str:
    """The result as a page: the goals, then what each campaign wrote of itself."""
    about = machine()
    versions = ", ".join(f"{name} {value}" for name, value in about.items() if name not in ("date", "cores"))
    summary = (
        f"All simulated: {faults['episodes']} random episodes with faults, then nominal work. "
        f"{faults['unsafe_samples']} unsafe torque samples."
    )
    made = f"{about['date']}, {about['cores']} cores, {versions}. Made by `{command}`."
    lines = ["# Faults: goals and what was reached", "", summary, "", markdown_table(HEAD, rows), "", made, ""]
    return "\n".join(lines) + "\n" + "\n".join(page.replace("# Fault campaign", "## A campaign") for page in pages)


def parser() -> argparse.ArgumentParser:
    """The options."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--episodes", type=int, default=20_000, metavar="N", help="with faults (default: 20000)")
    options.add_argument("--hours", type=float, default=10.0, metavar="H", help="of nominal work (default: 10)")
    options.add_argument("--seed", type=int, default=0, metavar="S", help="of both campaigns (default: 0)")
    options.add_argument("--jobs", type=int, default=2, metavar="J", help="processes (default: 2)")
    options.add_argument(
        "--made", type=Path, nargs=2, metavar=("FAULTS", "NOMINAL"), help="folders of both campaigns, run before"
    )
    options.add_argument("--runs", type=Path, default=RUNS, metavar="DIR", help="the runs (default: runs/faults)")
    options.add_argument(
        "--out",
        type=Path,
        default=RESULTS,
        metavar="FILE.json",
        help="result, and the same as a page beside it (default: benchmarks/results/campaign.json)",
    )
    return options


def main() -> int:
    """Run, judge and write; 0 if all goals are met, 1 if not."""
    options = parser().parse_args()
    if options.made is None:
        common = ["--seed", str(options.seed), "--jobs", str(options.jobs)]
        folders = [options.runs / "faults", options.runs / "nominal"]
        faults = campaign(folders[0], ["--episodes", str(options.episodes), *common])
        hours = max(1, round(HOUR * options.hours))
        nominal = campaign(folders[1], ["--nominal", "--episodes", str(hours), *common])
        words = f"--episodes {options.episodes} --hours {options.hours:g} --seed {options.seed}"
    else:
        folders, words = options.made, "--made FAULTS NOMINAL"
        faults, nominal = (said(folder) for folder in folders)
    rows = goals(faults, nominal)
    print(text_table(HEAD, rows))
    pages = [(folder / "campaign.md").read_text(encoding="utf-8") for folder in folders]
    command = f"python benchmarks/faults.py {words}"
    write_json(options.out, {"machine": machine(), "goals": rows, "faults": faults, "nominal": nominal})
    write_text(options.out.with_suffix(".md"), markdown(rows, faults, pages, command))
    return int(any(row[-1] == "missed" for row in rows))


if __name__ == "__main__":
    sys.exit(main())
