"""The goals of polishing, case by case, and the verdict on what was reached."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

DONE, STOPPED = 0, 3
FORCE = 10.0

Metrics = Mapping[str, Any]


@dataclass(frozen=True, kw_only=True)
class Goal:
    """A figure of ``metrics.json`` and what it must reach; no limit only reports it."""

    name: str
    label: str
    limit: float | None = None
    at_least: bool = False
    """Whether the figure must be at least the limit; otherwise its size is at most that."""

    def worst(self, runs: Mapping[int, Metrics]) -> tuple[float, int] | None:
        """The worst value and its seed; None if any run lacks it."""
        if not runs or any(self.name not in metrics for metrics in runs.values()):
            return None
        values = [(float(metrics[self.name]), seed) for seed, metrics in sorted(runs.items())]
        return min(values) if self.at_least else max(values, key=lambda pair: abs(pair[0]))

    def met(self, value: float) -> bool:
        """Whether a value is good enough."""
        if self.limit is None:
            return True
        return value >= self.limit if self.at_least else abs(value) <= self.limit

    @property
    def text(self) -> str:
        """The goal for a table."""
        return "-" if self.limit is None else f"{'≥' if self.at_least else '≤'} {self.limit:g}"


@dataclass(frozen=True, kw_only=True)
class Case:
    """One set of options of ``burnish polish``, and its goals."""

    name: str
    mould: str
    arm: str
    goals: tuple[Goal, ...]
    sensor: str = "wrist"
    feed: float = 0.02
    seeded: bool = True
    """Whether the seed matters; one without errors to draw is run once."""

    def command(self, seed: int, folder: Path) -> list[str]:
        """The command line."""
        options = {"mould": self.mould, "arm": self.arm, "sensor": self.sensor, "force": FORCE, "feed": self.feed}
        words = [word for name, value in options.items() for word in (f"--{name}", str(value))]
        return [sys.executable, "-m", "burnish", "polish", *words, "--seed", str(seed), "--out", str(folder)]

    @property
    def slug(self) -> str:
        """Its folder."""
        return f"{self.mould}_{self.arm}_{self.sensor}_{1e3 * self.feed:g}"


def force_goals(rms: float | None) -> tuple[Goal, ...]:
    """Force RMS with a limit, its 99th percentile without."""
    return Goal(name="force_rms_N", label="force RMS [N]", limit=rms), Goal(name="force_p99_N", label="force p99 [N]")


COVERED = (
    Goal(name="coverage_pct", label="coverage [%]", limit=98.0, at_least=True),
    Goal(name="overpolished_pct", label="over-polished [%]", limit=3.0),
)
SEEN = (
    Goal(name="coverage_pct", label="coverage [%]", at_least=True),
    Goal(name="overpolished_pct", label="over-polished [%]"),
)
TILT = Goal(name="tilt_rms_deg", label="tilt RMS [deg]")
DEVIATION = Goal(name="preston_deviation_pct", label="Preston depth off by [%]", limit=2.0)
FULL = (
    Goal(name="force_rms_N", label="force RMS [N]", limit=0.5),
    Goal(name="force_p99_N", label="force p99 [N]", limit=2.0),
    Goal(name="contact_lost_pct", label="contact lost [%]", limit=0.1),
    Goal(name="touch_peak_N", label="touch peak [N]", limit=3.0),
    Goal(name="tilt_rms_deg", label="tilt RMS [deg]", limit=1.0),
    Goal(name="tilt_max_deg", label="tilt max [deg]", limit=3.0),
    *COVERED,
)
CASES = (
    Case(name="dome, honest, 20 mm/s", mould="dome", arm="honest", goals=FULL),
    Case(
        name="dome, honest, 40 mm/s", mould="dome", arm="honest", feed=0.04, goals=(*force_goals(0.9), TILT, *COVERED)
    ),
    Case(
        name="dome, honest-stiff, 40 mm/s",
        mould="dome",
        arm="honest-stiff",
        feed=0.04,
        goals=(*force_goals(1.5), TILT, *SEEN),
    ),
    Case(
        name="plate, honest, 20 mm/s",
        mould="plate",
        arm="honest",
        goals=(*force_goals(None), TILT, *COVERED, DEVIATION),
    ),
    Case(
        name="plate, ideal, 20 mm/s",
        mould="plate",
        arm="ideal",
        seeded=False,
        goals=(*force_goals(None), TILT, *COVERED, DEVIATION),
    ),
    Case(
        name="dome, ideal, 20 mm/s", mould="dome", arm="ideal", seeded=False, goals=(*force_goals(None), TILT, *COVERED)
    ),
    Case(
        name="dome, honest, joint torques, 20 mm/s",
        mould="dome",
        arm="honest",
        sensor="joint",
        goals=(*force_goals(None), TILT, *COVERED),
    ),
    Case(name="mould, honest, 20 mm/s", mould="mould", arm="honest", goals=(*force_goals(None), TILT, *COVERED)),
)


@dataclass(frozen=True, kw_only=True)
class Row:
    """One line of the result."""

    case: str
    figure: str
    worst: float | None
    seed: int | None
    goal: str
    verdict: str
    """met, missed, or - where there is no goal."""

    def cells(self) -> list[str]:
        """For a table."""
        worst = "none" if self.worst is None else f"{self.worst:.2f}"
        return [self.case, self.figure, worst, "-" if self.seed is None else str(self.seed), self.goal, self.verdict]


HEAD = ["case", "figure", "worst", "seed", "goal", "verdict"]


def judge(case: Case, runs: Mapping[int, Metrics | None]) -> list[Row]:
    """The rows of a case from the metrics of each seed, None for a run that wrote none.

    A goal is missed as well if a run lacks its figure, and by a case in which the supervisor stopped the arm.
    """
    found = {seed: metrics for seed, metrics in runs.items() if metrics is not None}
    whole = len(found) == len(runs)
    rows = []
    for goal in case.goals:
        worst = goal.worst(found) if whole else None
        value, seed = worst if worst is not None else (None, None)
        good = value is not None and goal.met(value)
        verdict = ("met" if good else "missed") if goal.limit is not None else "-"
        rows.append(Row(case=case.name, figure=goal.label, worst=value, seed=seed, goal=goal.text, verdict=verdict))
    ended = [
        seed for seed, metrics in sorted(runs.items()) if metrics is None or metrics.get("exit_status", DONE) != DONE
    ]
    rows.append(
        Row(
            case=case.name,
            figure="runs stopped or failed",
            worst=float(len(ended)),
            seed=ended[0] if ended else None,
            goal="≤ 0",
            verdict="missed" if ended else "met",
        )
    )
    return rows
