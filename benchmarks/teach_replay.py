"""A pass that was shown to the honest arm once, and replayed: force and place by the true contact, seed by seed.

The simulated hand shows it; what really happened then is what each replay is compared with, at the same place of the
path. Judged by the simulator's truth, which no session sees.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from common import comma_numbers, machine, markdown_table, text_table, write_json, write_text

from burnish.commands.order import ARMS
from burnish.model.tool import PolishingTool
from burnish.polish.cell import tool_down
from burnish.polish.cellsim import WristFelt
from burnish.record.described import described
from burnish.record.recorder import Recorder
from burnish.record.recording import Recording
from burnish.surface import DistanceGrid, Mould
from burnish.teach.cleanup import Taught, cleaned
from burnish.teach.demonstration import STORED, Demonstration, placement_text
from burnish.teach.execute import Execute
from burnish.teach.hand import Hand
from burnish.teach.judge import ReplayLog, Shown, as_cleaned, as_happened, followed, nearest
from burnish.teach.replay import Track
from burnish.teach.session import Key
from burnish.teach.simulated import Cell, moved_placement
from burnish.teach.train import Train

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "benchmarks" / "results" / "teach_replay.json"
FORCE, PLACE, MOVED = 1.0, 2.0, 1.2
"""Goals: force RMS [N], position RMS over the surface [mm], and how much more of both on a moved mould."""
SHIFT, TURN = np.array([0.02, -0.015, 0.01]), np.array([0.05, -0.04, 0.3])
"""How the mould was moved, and everybody knows [m, rad]."""
UNKNOWN = np.array([0.0, 0.0, -1.5e-3])
"""How it was moved besides, and nobody knows [m]."""


@dataclass(frozen=True, kw_only=True)
class Showing:
    """One demonstration and what really happened in it."""

    cell: Cell
    demonstration: Demonstration
    taught: Taught
    happened: Shown


def show(cell: Cell, folder: Path) -> Showing:
    """The hand shows its work, recorded as ``burnish teach`` records it."""
    rig, robot = cell.rig()
    hand = Hand.on(cell.grid, cell.placement, tool_down(rig.model), cell.tool.tip_radius)
    train = cell.train(rig, hand, lambda: "hand")
    about = {"verb": "teach", "placement": placement_text(cell.placement), "law": described(train.operator_law)}
    with robot, Recorder(folder / "run.mcap", joint_names=rig.model.joint_names, metadata=about) as recorder:
        for sample in train.run():
            recorder.record(sample, train.phase)
            key = next_key(train, hand)
            if key is not None:
                train.press(key)
        if train.stored is None:
            raise SystemExit(f"teach_replay: nothing was stored: {train.failure or rig.supervisor.event}")
        recorder.end_with(**{STORED: f"{train.stored[0]} {train.stored[1]}"})
    demonstration = Demonstration.of(Recording(folder / "run.mcap"))
    taught = cleaned(demonstration, cell.grid, cell.tool)
    return Showing(
        cell=cell,
        demonstration=demonstration,
        taught=taught,
        happened=as_happened(taught, robot.truth, train.stored[0]),
    )


def next_key(train: Train, hand: Hand) -> Key | None:
    """What an operator would press now."""
    for key in (Key.GO_ON, Key.RECORD):
        if key in train.waits_for:
            return key
    return Key.STORE if Key.STORE in train.waits_for and hand.done else None


def play(session: Execute, note: Callable[[Any], None]) -> str:
    """Run a session to its end; every Enter that it waits for is pressed. Returns why it ended early; empty if not."""
    with session.rig.robot:
        for sample in session.run():
            note(sample)
            if Key.GO_ON in session.waits_for:
                session.press(Key.GO_ON)
    event = session.rig.supervisor.event
    return "" if session.completed else session.failure or (event.cause if event else "cancelled")


def with_force(showing: Showing, cell: Cell, repeats: int) -> dict[str, float]:
    """The figures of a replay with force."""
    rig, robot = cell.rig()
    session, log = cell.hold_force(rig, showing.taught, repeats=repeats, speed=1.0), ReplayLog()

    def note(sample: Any) -> None:
        along = session.along
        on = session.phase == "pass" and along is not None
        s = along.s if on and along is not None and along.settled >= along.track.settle else -1.0
        log.add(sample, session.repeat if on else 0, session.piece, s)

    early = play(session, note)
    if early:
        raise SystemExit(f"teach_replay: a replay with force ended early: {early}")
    point = np.asarray(robot.truth.point)
    figures = followed(log, robot.truth, point, showing.taught.pieces, showing.happened).figures()
    fitted = as_cleaned(showing.taught, cell.tool.tip_radius)
    against_fit = followed(log, robot.truth, point, showing.taught.pieces, fitted).figures()
    return figures | {"force_rms_of_fit_N": against_fit["force_rms_N"]}


def open_loop(showing: Showing, cell: Cell, moved: bool, repeats: int) -> dict[str, float]:
    """The figures of the poses that were asked for, replayed by the impedance that they were shown with."""
    rig, robot = cell.rig()
    at = showing.demonstration.placement
    at = moved_placement(at, SHIFT, TURN) if moved else at
    session, log = cell.open_loop(rig, Track.by_time(showing.demonstration, at), repeats=repeats), ReplayLog()

    def note(sample: Any) -> None:
        # Length is time here; its places are those of the demonstration's cycles.
        along = session.along
        log.add(sample, session.repeat if along is not None else 0, *nearest(showing.taught, along))

    early = play(session, note)
    found = followed(log, robot.truth, np.asarray(robot.truth.point), showing.taught.pieces, showing.happened)
    # As far as it came: what stops it is part of the comparison.
    return found.figures() | {"ended_early": float(bool(early))}


def lower(cell: Cell) -> Cell:
    """The cell with its mould moved a little more than anybody knows."""
    plant = replace(cell.arm.plant, mould_shift=cell.arm.plant.mould_shift + UNKNOWN)
    return replace(cell, arm=replace(cell.arm, plant=plant))


def cases(showing: Showing, repeats: int) -> dict[str, dict[str, float]]:
    """All replays of one demonstration."""
    cell, moved = showing.cell, showing.cell.moved(SHIFT, TURN)
    return {
        "force held": with_force(showing, cell, repeats),
        "force held, mould moved": with_force(showing, moved, repeats),
        "force held, mould moved and 1.5 mm lower than known": with_force(showing, lower(moved), repeats),
        "open loop": open_loop(showing, cell, False, repeats),
        "open loop, mould moved": open_loop(showing, moved, True, repeats),
        "open loop, mould moved and 1.5 mm lower than known": open_loop(showing, lower(moved), True, repeats),
    }


def measure(seed: int, mould_name: str, repeats: int) -> dict[str, dict[str, float]]:
    """One demonstration by one arm, and all replays of it."""
    mould, tool, arm = Mould.load(mould_name, "mm"), PolishingTool(), ARMS["honest"](seed)
    cell = Cell.of(arm, mould, DistanceGrid.of(mould), arm.rate, WristFelt(), tool)
    with TemporaryDirectory(prefix="burnish-teach-") as folder:
        showing = show(cell, Path(folder))
    found = cases(showing, repeats)
    print(f"seed {seed}: done", file=sys.stderr)
    return found


def main() -> None:
    """Measure and write the result."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=comma_numbers, default=[1, 2, 3], help="of the arm (default: 1-3)")
    parser.add_argument("--repeats", type=int, default=5, help="of each replay (default: 5)")
    parser.add_argument("--mould", default="dome", help="bundled mould (default: dome)")
    parser.add_argument("--jobs", type=int, default=2, help="processes (default: 2)")
    parser.add_argument("--dry", action="store_true", help="print the result and write nothing")
    options = parser.parse_args()
    with ProcessPoolExecutor(options.jobs) as pool:
        asked = (options.seeds, [options.mould] * len(options.seeds), [options.repeats] * len(options.seeds))
        runs = {str(seed): found for seed, found in zip(options.seeds, pool.map(measure, *asked), strict=True)}
    rows = table(runs)
    head = ("replay", "force RMS [N]", "of the fit [N]", "position RMS [mm]", "contact lost [%]", "seed")
    print(text_table(head, rows))
    verdict = judge(runs)
    print("\n".join(verdict))
    if not options.dry:
        about = machine()
        write_json(RESULTS, {"about": about, "mould": options.mould, "repeats": options.repeats, "runs": runs})
        write_text(RESULTS.with_suffix(".md"), markdown(head, rows, verdict, about, options))


def table(runs: dict[str, dict[str, dict[str, float]]]) -> list[list[str]]:
    """The worst seed of each case, by force."""
    rows = []
    for case in next(iter(runs.values())):
        seed = max(runs, key=lambda s: runs[s][case]["force_rms_worst_N"])
        found = runs[seed][case]
        fit = found.get("force_rms_of_fit_N")
        place = max(runs[s][case]["position_rms_worst_mm"] for s in runs)
        lost = max(runs[s][case]["contact_lost_pct"] for s in runs)
        rows.append([case, f"{found['force_rms_worst_N']:.2f}", "-" if fit is None else f"{fit:.2f}",
                     f"{place:.2f}", f"{lost:.1f}", seed])  # fmt: skip
    return rows


def judge(runs: dict[str, dict[str, dict[str, float]]]) -> list[str]:
    """Goal by goal, worst seed and worst repeat."""
    force = max(run["force held"]["force_rms_worst_N"] for run in runs.values())
    place = max(run["force held"]["position_rms_worst_mm"] for run in runs.values())
    lines = [f"force RMS {force:.2f} N, goal {FORCE:g} N: {_met(force <= FORCE)}"]
    lines.append(f"position RMS {place:.2f} mm, goal {PLACE:g} mm: {_met(place <= PLACE)}")
    for name, unit, most in (("force_rms_worst_N", "N", force), ("position_rms_worst_mm", "mm", place)):
        moved = max(run["force held, mould moved"][name] for run in runs.values())
        lines.append(
            f"mould moved: {moved:.2f} {unit}, {moved / most:.2f} times that, goal {MOVED:g}: "
            f"{_met(moved <= MOVED * most)}"
        )
    return lines


def markdown(head: Any, rows: Any, verdict: list[str], about: dict[str, Any], options: argparse.Namespace) -> str:
    """The result as a page."""
    versions = ", ".join(f"{name} {value}" for name, value in about.items() if name not in ("date", "cores"))
    angle = np.rad2deg(np.linalg.norm(TURN))
    said = (
        f"All simulated: the honest arm, wrist sensor, 100 Hz, mould '{options.mould}'; {options.repeats} repeats of "
        f"each replay; the worst repeat of the worst of seeds {', '.join(map(str, options.seeds))}. Force and position "
        "are compared with the true contact of the demonstration at the same place of the path. 'Of the fit' is the "
        "distance from the smooth force that the replay holds: the rest is what the demonstration itself trembled."
    )
    lines = [
        "# Teach and replay: what was shown once, and what came of it",
        "",
        said,
        f"Moved: by {1e3 * np.linalg.norm(SHIFT):.0f} mm and {angle:.0f}°, which the replay is told.",
        "",
        markdown_table(head, rows),
        "",
        *(f"- {line}" for line in verdict),
        "",
        f"{about['date']}, {about['cores']} cores, {versions}.",
        "Made by `python benchmarks/teach_replay.py`.",
    ]
    return "\n".join(lines) + "\n"


def _met(good: bool) -> str:
    return "met" if good else "missed"


if __name__ == "__main__":
    main()
