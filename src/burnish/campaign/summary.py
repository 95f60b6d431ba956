"""What a campaign came to: counts and figures over its episodes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from burnish.campaign.results import Result, Settings

WORST = 8
"""Episodes that are shown."""
RULES = ("not_finite", "over_cap", "over_rate", "not_held")
"""What makes a torque sample unsafe."""


def summary(results: Iterable[Result], settings: Settings) -> dict[str, Any]:
    """The content of ``campaign.json``: plain numbers, null where there is nothing to say."""
    all_of = sorted(results, key=lambda result: result.episode)
    faultless = [result for result in all_of if result.fault == "none"]
    return {
        "episodes": len(all_of),
        "first_episode": all_of[0].episode if all_of else None,
        "last_episode": all_of[-1].episode if all_of else None,
        **asdict(settings),
        "virtual_hours": round(_hours(all_of), 4),
        "unsafe_samples": sum(result.verdict.unsafe for result in all_of),
        "unsafe": {rule: sum(getattr(result.verdict, rule) for result in all_of) for rule in RULES},
        "false_trips": sum(result.false_trip for result in all_of),
        "faultless_hours": round(_hours(faultless), 4),
        "late_reactions": sum(result.verdict.late for result in all_of),
        "still_moving": sum(result.verdict.moving for result in all_of),
        "slow_stops": sum(result.verdict.slow_stop for result in all_of),
        "overspeed": sum(result.verdict.peak_speed > 1.0 for result in all_of),
        "simulation_failures": sum(result.failed for result in all_of),
        "reaction_cycles": {
            urgency: _spread([r.verdict.reaction for r in all_of if r.urgency == urgency])
            for urgency in ("invalid", "stale", "frozen")
        },
        "stop_s": _spread([result.verdict.still_after for result in all_of]),
        "runaway_peak_speed": {
            f"{rate:g} Hz": _spread([r.verdict.peak_speed for r in all_of if r.kinds == ["runaway"] and r.rate == rate])
            for rate in (100.0, 1000.0)
        },
        "payload_drift_mm": _spread(_millimetres(r for r in all_of if r.kinds == ["payload"])),
        "contact_peak_N": _spread([r.verdict.peak_force for r in all_of if r.kinds == ["sudden_contact"]]),
        "by_fault": _table(all_of, lambda result: result.kinds),
        "by_task": _table(all_of, lambda result: [result.task]),
        "by_rate": _table(all_of, lambda result: [f"{result.rate:g} Hz"]),
        "pairs": sum(len(result.kinds) > 1 for result in all_of),
        "worst": [_line(result) for result in worst(all_of)],
    }


def worst(results: Sequence[Result]) -> list[Result]:
    """The episodes to look at first: unsafe samples, then late, moving, false, fast, far."""
    return sorted(results, key=_badness, reverse=True)[:WORST]


def wrong(result: Result) -> str:
    """What was wrong with an episode, in words; empty for one that was as it should be."""
    verdict = result.verdict
    found = [f"{getattr(verdict, rule)} samples {rule.replace('_', ' ')}" for rule in RULES if getattr(verdict, rule)]
    found += ["answered too late"] * verdict.late + ["still moving"] * verdict.moving
    found += ["slow to rest"] * verdict.slow_stop
    found += ["false trip"] * result.false_trip + ["simulation failed"] * result.failed
    if verdict.peak_speed > 1.0:
        found.append(f"joint at {verdict.peak_speed:.2f} × its speed limit")
    return ", ".join(found)


def _badness(result: Result) -> tuple[float, ...]:
    verdict = result.verdict
    return (
        verdict.unsafe,
        result.failed,
        verdict.late,
        verdict.moving,
        result.false_trip,
        verdict.peak_speed > 1.0,
        verdict.slow_stop,
        verdict.peak_speed,
        -result.episode,
    )


def _table(results: Sequence[Result], names: Callable[[Result], Sequence[str]]) -> dict[str, dict[str, Any]]:
    """Counts for each name; an episode with two faults counts for both."""
    groups: dict[str, list[Result]] = {}
    for result in results:
        for name in names(result):
            groups.setdefault(name, []).append(result)
    return {name: _row(groups[name]) for name in sorted(groups)}


def _row(results: Sequence[Result]) -> dict[str, Any]:
    verdicts = [result.verdict for result in results]
    reactions = [verdict.reaction for verdict in verdicts if verdict.reaction is not None]
    rests = [verdict.still_after for verdict in verdicts if verdict.still_after is not None]
    drifts = _millimetres(results)
    return {
        "episodes": len(results),
        "stopped": sum(verdict.stopped_at is not None for verdict in verdicts),
        "unsafe_samples": sum(verdict.unsafe for verdict in verdicts),
        "late_reactions": sum(verdict.late for verdict in verdicts),
        "still_moving": sum(verdict.moving for verdict in verdicts),
        "slow_stops": sum(verdict.slow_stop for verdict in verdicts),
        "overspeed": sum(verdict.peak_speed > 1.0 for verdict in verdicts),
        "reaction_max_cycles": max(reactions, default=None),
        "stop_max_s": _rounded(max(rests, default=None)),
        "peak_speed": _rounded(max(verdict.peak_speed for verdict in verdicts)),
        "peak_force_N": _rounded(max(verdict.peak_force for verdict in verdicts)),
        "drift_max_mm": _rounded(max(drifts, default=None)),
    }


def _line(result: Result) -> dict[str, Any]:
    names = ("episode", "task", "fault", "text", "rate", "cause", "trouble")
    return {name: getattr(result, name) for name in names} | {"wrong": wrong(result)} | _plain(asdict(result.verdict))


def _plain(values: Mapping[str, Any]) -> dict[str, Any]:
    return {name: _rounded(value) if isinstance(value, float) else value for name, value in values.items()}


def _spread(values: Iterable[float | None]) -> dict[str, Any]:
    """Count, median, 99 % and largest."""
    there = [value for value in values if value is not None]
    if not there:
        return {"episodes": 0, "p50": None, "p99": None, "max": None}
    p50, p99 = np.percentile(there, [50, 99])
    return {
        "episodes": len(there),
        "p50": _rounded(float(p50)),
        "p99": _rounded(float(p99)),
        "max": _rounded(float(max(there))),
    }


def _millimetres(results: Iterable[Result]) -> list[float]:
    return [1e3 * result.verdict.drift for result in results if result.verdict.drift is not None]


def _hours(results: Iterable[Result]) -> float:
    return sum(result.seconds for result in results) / 3600.0


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 4)
