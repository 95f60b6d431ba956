"""What is said of a law of thesis B that follows the operator on the ideal arm."""

from __future__ import annotations

from burnish.experiments.operator import Following, following
from burnish.trials.experiment import Finding
from burnish.trials.record import Record

TOOL_MOTION = (
    "The thesis moved the tool by hand in all six degrees of freedom and printed the figures without numbers; here a "
    "scripted operator does, the same for every law: 0.1 m along each axis and back, 0.4 rad about each, then both at "
    "once, in 1.5 s each with 1 s of rest. v_d and a_d are fed forward where the law has a place for them; h and J̇q̇, "
    "which the thesis drops, are kept as each law's documentation says. Its orientation error is sin(θ/2)."
)
POSITION_MM, ORIENTATION_DEG, STEADY_MM = 2.0, 1.0, 0.1
"""What our gains have to reach on the ideal arm."""


def judge_ours(record: Record) -> Finding:
    """Our gains, on the ideal arm at 1 kHz."""
    f = following(record)
    return Finding(
        claim=f"Our gains on the ideal arm: RMSE ≤ {POSITION_MM:g} mm and ≤ {ORIENTATION_DEG:g}°, steady ≤ "
        f"{STEADY_MM:g} mm.",
        measured=in_words(record),
        holds=record.stopped is None
        and f.position_mm <= POSITION_MM
        and f.orientation_deg <= ORIENTATION_DEG
        and f.steady_mm <= STEADY_MM,
    )


def judge_stable(record: Record, claim: str) -> Finding:
    """Whether the law came to the end."""
    return Finding(claim=claim, measured=in_words(record), holds=record.stopped is None)


def judge_unstable(record: Record, claim: str) -> Finding:
    """Whether the law was stopped, as is claimed."""
    return Finding(claim=claim, measured=in_words(record), holds=record.stopped is not None)


def in_words(record: Record) -> str:
    """How the law followed, or how it ended."""
    if record.stopped is not None:
        return f"Stopped after {record.time[-1]:.2f} s: {record.stopped}."
    return text(following(record))


def text(f: Following) -> str:
    """The figures of following in a sentence."""
    return (
        f"RMSE {f.position_mm:.3g} mm and {f.orientation_deg:.3g}°, {f.steady_mm:.2g} mm at rest; turning moves it by "
        f"{f.moved_mm:.2g} mm, moving turns it by {f.turned_deg:.2g}°."
    )
