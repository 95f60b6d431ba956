"""What the figures of a run mean: a label, a unit and one line each, for people."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Meaning(NamedTuple):
    """How a figure is shown."""

    label: str
    unit: str
    text: str


GLOSSARY: dict[str, Meaning] = {
    "force_set_N": Meaning("Set force", "N", "What the tool was asked to press with."),
    "force_rms_N": Meaning("Force error, RMS", "N", "Root mean square of contact force minus set force."),
    "force_mean_N": Meaning("Mean force", "N", "Mean contact force over the pass."),
    "force_p99_N": Meaning("Force error, 99 %", "N", "99 % of the time the force error was smaller than this."),
    "touch_peak_N": Meaning("Touch peak", "N", "Largest force from the first touch until the force ramp began."),
    "contact_lost_pct": Meaning("Contact lost", "%", "Share of the time with less than 0.2 N of contact."),
    "tilt_rms_deg": Meaning("Tilt, RMS", "°", "Angle between the tool and where it was to point, root mean square."),
    "tilt_max_deg": Meaning("Tilt, largest", "°", "Largest angle between the tool and where it was to point."),
    "feed_rms_pct": Meaning("Feed error, RMS", "%", "Root mean square of speed minus feed, relative to the feed."),
    "coverage_pct": Meaning("Coverage", "%", "Share of the evaluated area that lost at least half the target."),
    "overpolished_pct": Meaning("Over-polished", "%", "Share of the area that lost more than 1.5 times the target."),
    "removal_cv_pct": Meaning("Removal, variation", "%", "Standard deviation of the removal over its mean."),
    "removal_mean_um": Meaning("Removal, mean", "µm", "Mean depth that was taken off the evaluated area."),
    "coverage_before_pct": Meaning("Coverage before the repair", "%", "The coverage that the repaired job had left."),
    "removal_cv_before_pct": Meaning("Removal, variation before", "%", "The variation that the repaired job had left."),
    "path_length_m": Meaning("Path length", "m", "Length of the tool path on the surface."),
    "duration_s": Meaning("Duration", "s", "Time on the clock of the arm, from start to end."),
    "realtime_factor": Meaning("Real-time factor", "", "Time on the clock of the arm over the time it took."),
    "cycles": Meaning("Cycles", "", "Control cycles that were run."),
    "late_cycles": Meaning("Late cycles", "", "Control cycles that missed their deadline."),
    "supervisor_events": Meaning("Supervisor events", "", "Times that the supervisor stepped in."),
    "seed": Meaning("Seed", "", "Number from which all random errors of the run were drawn."),
    "mould": Meaning("Mould", "", "The work piece."),
    "arm": Meaning("Arm", "", "How honest the simulated arm is: ideal, or with friction, delay and errors."),
    "sensor": Meaning("Force sensor", "", "Where the controller has its force from: the wrist or the joints."),
    "rate_Hz": Meaning("Control rate", "Hz", "Control cycles a second."),
}
"""The figures of ``metrics.json``, in the order in which a report lists them."""

HEADLINE = ("force_rms_N", "coverage_pct", "touch_peak_N", "tilt_rms_deg", "contact_lost_pct", "removal_cv_pct")
"""The figures that tell most about a run, most telling first; a report shows the first five that it has."""


def figure(value: object) -> str:
    """A value for people: three significant digits, a dash for what is not finite, yes or no."""
    value = value.item() if isinstance(value, np.generic) else value
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return f"{value:,}".replace(",", "\u202f") if abs(value) >= 10_000 else str(value)
    if isinstance(value, float):
        if value != value or value in (float("inf"), float("-inf")):
            return "–"
        size = abs(value)
        if 1e-3 <= size < 1e3:
            return f"{value:.3g}" if size < 100 else f"{value:.4g}"
        return f"{value:.0f}" if 1e3 <= size < 1e5 or size == 0 else f"{value:.3g}"
    return str(value)
