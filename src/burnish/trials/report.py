"""The page of a reproduction: what each experiment was, what it gave, and what holds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

from burnish.analysis.page import drawing, page, section, table
from burnish.trials.outcome import Outcome
from burnish.trials.tables import HELD, INTRODUCTION, cells, columns, gains_text, score

TITLE = "The sources' experiments, beside ours"
SIMULATED = "All figures on this page are simulated: no real arm has moved."
CAPTION = (
    "Errors over time, by their extremes in each interval; the scale is logarithmic. A cross: the supervisor stopped "
    "the arm there."
)


def reproduction_html(outcomes: Sequence[Outcome], plots: Mapping[str, str], *, interrupted: bool = False) -> str:
    """The page as text; ``plots`` has an ``<svg>`` for the name of each experiment."""
    state = '<span class="verdict interrupted">Interrupted</span>' if interrupted else ""
    header = f'<header><h1>{TITLE}</h1>{state}<p class="note">{SIMULATED}</p></header>'
    return page(TITLE, [header, _contents(outcomes), *(_part(each, plots.get(each.name, "")) for each in outcomes)])


def _contents(outcomes: Sequence[Outcome]) -> str:
    rows = "".join(
        f'<tr><td><a href="#{escape(each.name)}">{escape(each.title)}</a></td><td>{escape(each.source)}</td>'
        f"<td class=number>{score(each.findings)}</td></tr>"
        for each in outcomes
    )
    head = "<thead><tr><th>experiment</th><th>source</th><th class=number>claims that hold</th></tr></thead>"
    return section(
        "Contents",
        f'<div class="wide"><table>{head}<tbody>{rows}</tbody></table></div>',
        f'<p class="hint">{escape(" ".join(INTRODUCTION.split()))}</p>',
    )


def _part(outcome: Outcome, plot: str) -> str:
    shown = columns(outcome, times=True)
    rows = [(trial.name, trial.arm, f"{trial.rate_Hz:g}", *cells(trial, shown)) for trial in outcome.trials]
    stops = "".join(
        f"<li>{escape(trial.name)}: stopped after {trial.duration_s:.2f} s, {escape(trial.stopped)}</li>"
        for trial in outcome.trials
        if trial.stopped
    )
    gains = table(("trial", "law and gains"), [(trial.name, gains_text(trial)) for trial in outcome.trials])
    inner = section(
        outcome.title,
        f'<p class="hint">{escape(outcome.name)} · {escape(outcome.source)}</p>',
        f"<p>{escape(outcome.about)}</p>",
        _findings(outcome),
        drawing(plot, CAPTION) if plot else "",
        table(("trial", "arm", "rate [Hz]", *shown.values()), rows),
        f"<ul>{stops}</ul>" if stops else "",
        f"<details><summary>Laws and gains</summary>{gains}</details>",
    )
    return f'<div id="{escape(outcome.name)}">{inner}</div>'


def _findings(outcome: Outcome) -> str:
    if not outcome.findings:
        return '<p class="hint">Not judged: trials are missing.</p>'
    colour = {True: "done", False: "stopped", None: "interrupted"}
    rows = "".join(
        f'<tr><td><span class="verdict {colour[each.holds]}" style="white-space:nowrap">{HELD[each.holds]}</span></td>'
        f"<td>{escape(each.claim)}</td><td>{escape(each.measured)}</td></tr>"
        for each in outcome.findings
    )
    head = "<thead><tr><th></th><th>claim</th><th>measured</th></tr></thead>"
    return f'<div class="wide"><table>{head}<tbody>{rows}</tbody></table></div>'
