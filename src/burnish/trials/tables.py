"""The result of experiments as tables of text: columns for a page, and a page in Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from burnish.analysis.glossary import figure
from burnish.trials.experiment import Finding
from burnish.trials.figures import Figures
from burnish.trials.outcome import Outcome, TrialOutcome

COLUMNS = {
    "position_rmse_mm": "position RMSE [mm]",
    "orientation_rmse_deg": "orientation RMSE [°]",
    "joint_rmse_mrad": "joint RMSE [mrad]",
    "position_steady_mm": "steady position [mm]",
    "orientation_steady_deg": "steady orientation [°]",
    "settling_s": "settling [s]",
    "coupling_position_peak_mm": "coupling, position peak [mm]",
    "coupling_position_rms_mm": "position RMS [mm]",
    "coupling_orientation_peak_deg": "coupling, orientation peak [°]",
    "coupling_orientation_rms_deg": "orientation RMS [°]",
    "effort_Nm": "effort [N·m]",
    "roughness_Nm_s": "roughness [N·m/s]",
}
"""Metric to heading; what no trial of an experiment has is left out."""
TIMES = {"step_median_us": "step, median [µs]", "step_p5_us": "step, 5 % [µs]"}
"""What depends on the machine; not for a table that is kept."""
HELD = {True: "met", False: "not met", None: "shown"}
"""A finding in a word."""
INTRODUCTION = """\
All figures are simulated. "Ours" are gains, or a law, of ours; all others are those of the source. RMSE and steady
errors are root mean squares over the trial and over its last second; settling is the time from the last change of the
reference until the error stays within 2 % of what it was, or 1 mm and 0.5°; effort is the RMS of |τ − g|, roughness
that of its change in a cycle over the period. A dash is a figure that the reference gives no meaning to, or, for
settling, that the errors stayed larger. Figures of a trial that was stopped are those up to there."""


def columns(outcome: Outcome, *, times: bool) -> dict[str, str]:
    """The metrics that a table of this outcome shows, with their headings."""
    shown = COLUMNS | (TIMES if times else {})
    return {
        name: heading
        for name, heading in shown.items()
        if any(getattr(trial.metrics, name) is not None for trial in outcome.trials)
    }


def cells(trial: TrialOutcome, names: Iterable[str]) -> list[str]:
    """A trial's row under `columns`."""
    return [metric(trial.metrics, name) for name in names]


def metric(figures: Figures, name: str) -> str:
    """A metric for people; a dash where there is none."""
    value = getattr(figures, name)
    return "–" if value is None else figure(float(value))


def score(findings: Sequence[Finding]) -> str:
    """How many of the claims hold."""
    claims = [finding for finding in findings if finding.holds is not None]
    return f"{sum(bool(claim.holds) for claim in claims)} of {len(claims)}" if claims else "–"


def gains_text(trial: TrialOutcome) -> str:
    """Law and gains in a line."""
    return f"{trial.law}: " + ", ".join(f"{name} = {_short(value)}" for name, value in trial.gains.items())


def as_markdown(outcomes: Sequence[Outcome], command: str) -> str:
    """The results as a page, which ``command`` made."""
    lines = ["# Results of the reproduction", "", f"Made by `{command}`. {INTRODUCTION}", ""]
    for each in outcomes:
        shown = columns(each, times=False)
        lines += [f"## {each.name}: {each.title}", "", f"{each.source}. {each.about}", ""]
        lines += _row(["trial", "arm", "rate [Hz]", *shown.values()])
        lines += _row(["---"] * (3 + len(shown)))
        for trial in each.trials:
            lines += _row([trial.name, trial.arm, f"{trial.rate_Hz:g}", *cells(trial, shown)])
        lines.append("")
        lines += [f"- *{t.name}*: stopped after {t.duration_s:.2f} s: {t.stopped}" for t in each.trials if t.stopped]
        lines += [f"- **{HELD[f.holds]}**: {f.claim} {f.measured}" for f in each.findings]
        lines.append("")
    return "\n".join(lines)


def _row(texts: Sequence[str]) -> list[str]:
    return ["| " + " | ".join(text.replace("|", "\\|") for text in texts) + " |"]


def _short(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, list):
        return "(" + ", ".join(map(_short, value)) + ")"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{name}: {_short(each)}" for name, each in value.items()) + "}"
    return str(value)
