"""Sentences and figures for people: what the arm does, what a run reached, each with its unit."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite, pi

from burnish.runtime.machine import Mode

NO_EMERGENCY_STOP = (
    "Stop, or the key Esc, asks the program to end the job: it is no emergency stop. "
    "In danger press the red button at the arm."
)
"""Stands beside the stop."""
MODES = {
    Mode.IDLE: ("not connected", "gray"),
    Mode.POSITION: ("stands by itself", "gray"),
    Mode.ARMING: ("being made ready", "blue"),
    Mode.TORQUE: ("moves under torque", "green"),
    Mode.HOLD: ("held by the supervisor", "red"),
    Mode.FAULT: ("fault, held by the supervisor", "red"),
}
"""The supervisor's state in plain words, and its colour."""
PHASES = {
    "start": "about to start",
    "move": "moves",
    "approach": "approaches the mould",
    "touch": "touches the mould to find it",
    "lift": "lifts off",
    "tare": "weighs its tool",
    "lead-in": "takes up the path again",
    "pass": "polishes",
    "retract": "draws back",
    "stop": "comes to rest",
    "stopped": "is held",
    "home": "waits at home",
    "ready": "waits over the mould",
    "to ready": "goes over the mould",
    "to home": "goes home",
    "record free": "is led through the air, recorded",
    "record contact": "is led over the mould, recorded",
}
"""What the arm does, by the phase of its job."""
ENDED = {
    0: "done",
    2: "refused",
    3: "stopped by the supervisor",
    130: "ended early by the operator",
}
"""How a process ended, by its exit status."""


def phase(name: str) -> str:
    """What the arm does."""
    return next((words for key, words in PHASES.items() if name == key or name.startswith(f"{key} ")), name)


def ending(code: int) -> str:
    """How a process ended."""
    return ENDED.get(code, f"lost (its process was ended by signal {-code})" if code < 0 else f"failed with {code}")


def refusal(said: str) -> str:
    """What a verb had to say last, without its name; empty if it said nothing."""
    lines = [line.strip() for line in said.splitlines() if line.strip().startswith("burnish: ")]
    return lines[-1].removeprefix("burnish: ") if lines else ""


def number(value: float, unit: str, digits: int = 1) -> str:
    """A figure with its unit; a dash where there is none."""
    return f"{value:.{digits}f} {unit}".rstrip() if isfinite(value) else f"– {unit}".rstrip()


def degrees(radians: float) -> float:
    """An angle for people [°]."""
    return 180.0 / pi * radians


def duration(seconds: float) -> str:
    """A time in minutes and seconds."""
    if not isfinite(seconds):
        return "–"
    whole = round(seconds)
    return f"{whole} s" if whole < 60 else f"{whole // 60} min {whole % 60:02d} s"


def size_in_mm(sides: tuple[float, ...]) -> str:
    """A part's size."""
    return " × ".join(f"{1e3 * side:.0f}" for side in sides) + " mm"


FIGURES = (
    ("force_set_N", "set force", "N", 1, 1.0),
    ("force_rms_N", "force error, RMS", "N", 2, 1.0),
    ("force_p99_N", "force error, in 99 % of the time below", "N", 2, 1.0),
    ("touch_peak_N", "highest touch", "N", 1, 1.0),
    ("tilt_rms_deg", "tilt error, RMS", "°", 2, 1.0),
    ("coverage_pct", "covered", "%", 1, 1.0),
    ("overpolished_pct", "polished too much", "%", 1, 1.0),
    ("removal_cv_pct", "spread of the removal", "%", 1, 1.0),
    ("removal_mean_um", "removed on average", "µm", 3, 1.0),
    ("contact_lost_pct", "contact lost", "%", 2, 1.0),
    ("path_length_m", "path", "m", 2, 1.0),
    ("duration_s", "time of the arm", "s", 0, 1.0),
    ("late_cycles", "late cycles", "", 0, 1.0),
)
"""Of metrics.json: name, words, unit, digits, factor."""


def figures(metrics: Mapping[str, object]) -> list[tuple[str, str]]:
    """What a run reached, in words and with units, for a table."""
    rows = []
    for name, words, unit, digits, factor in FIGURES:
        value = metrics.get(name)
        if isinstance(value, int | float) and not isinstance(value, bool):
            rows.append((words, number(factor * float(value), unit, digits)))
    return rows


def compared(left: Mapping[str, object], right: Mapping[str, object]) -> list[tuple[str, str, str]]:
    """Two runs side by side: what, the one, the other."""
    rows = []
    for name, words, unit, digits, factor in FIGURES:
        cells = []
        for metrics in (left, right):
            value = metrics.get(name)
            good = isinstance(value, int | float) and not isinstance(value, bool)
            cells.append(number(factor * float(value), unit, digits) if good else "–")  # type: ignore[arg-type]
        if cells != ["–", "–"]:
            rows.append((words, cells[0], cells[1]))
    return rows
