"""The page of a campaign: what was looked for, what was found, and the episodes to look at first."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from burnish.analysis.page import card, drawing, page, pairs, section, table
from burnish.analysis.plot import SET, TRUE, new_figure, svg
from burnish.campaign.episode import Log
from burnish.campaign.judge import load_limits

SIMULATED = "All figures on this page are simulated: no real arm has moved."
HEADINGS = {
    "episodes": "episodes",
    "stopped": "stopped",
    "unsafe_samples": "unsafe samples",
    "late_reactions": "late",
    "still_moving": "still moving",
    "slow_stops": "slow to rest",
    "overspeed": "too fast",
    "reaction_max_cycles": "reaction [cycles]",
    "stop_max_s": "to rest [s]",
    "peak_speed": "speed/limit",
    "peak_force_N": "force [N]",
    "drift_max_mm": "drift [mm]",
}
"""A column of a table of counts; those from the reaction on are the largest."""
HINT = (
    "Largest figures of all episodes with that fault, in pairs too. Reaction: cycles from the first sample of a fault "
    "that must be noticed to the stop, 0 in the same cycle. To rest: until no joint is faster than 1 °/s. Drift: of "
    "the tool after the stop; a tool that was pressed too hard draws back 20 mm."
)
COLOURS = (TRUE, "#d55e00", "#009e73", "#cc79a7", "#e8a23a", "#56b4e9")
"""Of the joints; told apart by everybody."""


def campaign_html(result: Mapping[str, Any], plots: Mapping[int, str], *, interrupted: bool) -> str:
    """The page as text; ``plots`` has an ``<svg>`` for the number of an episode."""
    title = f"{result['episodes']} episodes, seed {result['seed']}" + (", without faults" if result["nominal"] else "")
    good = result["unsafe_samples"] == 0
    verdict = "No unsafe torque sample" if good else f"{result['unsafe_samples']} unsafe torque samples"
    state = '<span class="verdict interrupted">Interrupted</span>' if interrupted else ""
    header = (
        f'<header><h1>{escape(title)}</h1><span class="verdict {"done" if good else "stopped"}">{verdict}</span>{state}'
        f'<p class="note">{SIMULATED}</p></header>'
    )
    settings = {name: str(result[name])[:16] for name in ("seed", "limits", "judge", "source")}
    return page(
        title,
        [
            header,
            _cards(result),
            section("By fault", counts(result["by_fault"], "fault"), f'<p class="hint">{HINT}</p>'),
            section("By task and rate", counts(result["by_task"], "task"), counts(result["by_rate"], "rate")),
            section("Distributions", table(("figure", "episodes", "median", "99 %", "largest"), _spreads(result))),
            *(_episode(each, plots.get(each["episode"], "")) for each in result["worst"]),
            section("Settings and versions", pairs({**settings, **result["versions"]})),
        ],
    )


def episode_html(header: Mapping[str, Any], wrong: str, plot: str) -> str:
    """The page of one episode."""
    title = f"Episode {header['episode']} of seed {header['seed']}"
    return page(title, [f'<header><h1>{title}</h1><p class="note">{SIMULATED}</p></header>', _episode(
        {**header, "wrong": wrong}, plot)])  # fmt: skip


def counts(rows: Mapping[str, Mapping[str, Any]], name: str) -> str:
    """A table of counts, a row a name."""
    lines = [(each, *(_text(row[column]) for column in HEADINGS)) for each, row in rows.items()]
    return table((name, *HEADINGS.values()), lines)


def plot_log(log: Log) -> str:
    """Joint speeds, torques beyond gravity, contact force and way of the tool over time, as an ``<svg>``."""
    columns, limits = log.columns, load_limits()
    t, known = columns["t"], np.isfinite(columns["energy"])
    figure = new_figure(height=6.0)
    speed, torque, force, way = figure.subplots(4, 1, sharex=True, height_ratios=(2.0, 2.0, 1.0, 1.0))
    for joint, colour in enumerate(COLOURS):
        share = np.degrees(columns["dq"][:, joint]) / limits["speed_deg_s"][joint]
        speed.plot(t, share, color=colour, linewidth=0.9, label=f"joint {joint + 1}")
        off = columns["tau"][known, joint] - columns["weight"][known, joint]
        torque.plot(t[known], off, color=colour, linewidth=0.9)
    force.plot(t, columns["force"], color=TRUE, linewidth=0.9)
    way.plot(t[known], 1e3 * np.linalg.norm(columns["p"][known] - columns["p"][known][0], axis=1), color=TRUE)
    held = columns["held"] > 0.0
    for axes, label in zip(
        (speed, torque, force, way),
        ("speed/limit", "torque − weight [N·m]", "force [N]", "way [mm]"),
        strict=True,
    ):
        axes.set_ylabel(label)
        axes.grid(True, color="#e3e6ea", linewidth=0.6)
        if log.header["fault_at"] is not None:
            axes.axvline(log.header["fault_at"], color="#d55e00", linewidth=0.9)
        if held.any():
            axes.axvline(t[np.argmax(held)], color=SET, linewidth=0.9, linestyle="--")
    speed.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.1, ncols=6)
    way.set_xlabel("time [s]; orange: the fault, dashed: the stop")
    figure.align_ylabels()
    return svg(figure, f"episode {log.header['episode']}")


def _cards(result: Mapping[str, Any]) -> str:
    cards = (
        card("unsafe torque samples", str(result["unsafe_samples"]), ""),
        card("late reactions", str(result["late_reactions"]), ""),
        card("still moving at the end", str(result["still_moving"]), ""),
        card("faster than a joint's limit", str(result["overspeed"]), ""),
        card("false trips", str(result["false_trips"]), f"in {result['faultless_hours']:.2f} h"),
        card("virtual time", f"{result['virtual_hours']:.2f}", "h"),
    )
    return f'<div class="cards">{"".join(cards)}</div>'


def _spreads(result: Mapping[str, Any]) -> list[list[str]]:
    """Rows of the figures of which there is a distribution."""
    rows = {
        "reaction to what is invalid [cycles]": result["reaction_cycles"]["invalid"],
        "reaction to what is stale [cycles]": result["reaction_cycles"]["stale"],
        "reaction to one joint that is stale [cycles]": result["reaction_cycles"]["frozen"],
        "from the stop to rest [s]": result["stop_s"],
        **{f"runaway joint, speed/limit, {rate}": row for rate, row in result["runaway_peak_speed"].items()},
        "drift with an unknown kilogram, 2 s [mm]": result["payload_drift_mm"],
        "unexpected contact, peak [N]": result["contact_peak_N"],
    }
    return [[name, *(_text(row[key]) for key in ("episodes", "p50", "p99", "max"))] for name, row in rows.items()]


def _episode(each: Mapping[str, Any], plot: str) -> str:
    facts = {
        "wrong": each["wrong"] or "nothing",
        "task": each["task"],
        "rate [Hz]": each["rate"],
        "fault": each["text"] or "none",
        "the supervisor said": each["cause"] or "nothing",
        "the law raised": each["trouble"] or "nothing",
    }
    return section(f"Episode {each['episode']}", pairs(facts), drawing(plot) if plot else "")


def _text(value: Any) -> str:
    return "–" if value is None else f"{value:g}"


def markdown(result: Mapping[str, Any], command: str) -> str:
    """The result as a page of text, which ``command`` made."""
    made = (
        f"Made by `{command}`; all simulated. Episodes {result['first_episode']} to {result['last_episode']} of seed "
        f"{result['seed']}, {result['virtual_hours']:.2f} virtual hours, source {result['source'][:16]}."
    )
    found = (
        f"Unsafe torque samples: **{result['unsafe_samples']}**. Late reactions: {result['late_reactions']}. Still "
        f"moving: {result['still_moving']}; slow to rest: {result['slow_stops']}. Faster than a joint's limit: "
        f"{result['overspeed']}. False trips: "
        f"{result['false_trips']} in {result['faultless_hours']:.2f} hours without a fault."
    )
    lines = ["# Fault campaign", "", made, "", found, ""]
    lines += _rows(["figure", "episodes", "median", "99 %", "largest"], _spreads(result))
    rows = [[name, *(_text(row[column]) for column in HEADINGS)] for name, row in result["by_fault"].items()]
    lines += _rows(["fault", *HEADINGS.values()], rows)
    return "\n".join([*lines, HINT, ""])


def _rows(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    rule = ["---", *["---:"] * (len(head) - 1)]
    return ["| " + " | ".join(cells) + " |" for cells in (head, rule, *rows)] + [""]
