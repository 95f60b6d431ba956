"""What came out of an experiment: figures a trial and findings, as they are written to a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, is_dataclass
from math import isfinite
from typing import Any

import numpy as np

from burnish.sim.arms import Arm
from burnish.trials.experiment import Experiment, Finding, Trial
from burnish.trials.figures import Figures, figures
from burnish.trials.record import Record


@dataclass(frozen=True, kw_only=True)
class TrialOutcome:
    """A trial that was run."""

    name: str
    """As in `Trial`."""
    ours: bool
    """Whether the gains are ours."""
    arm: str
    """Which arm, in a word."""
    rate_Hz: float
    """Control rate [Hz]."""
    duration_s: float
    """Time that it lasted [s]."""
    law: str
    """Class of the law."""
    gains: dict[str, Any]
    """Its fields."""
    metrics: Figures
    """What was measured."""
    stopped: str | None
    """Why it ended early, or None."""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """An experiment that was run, or as much of it as there was time for."""

    name: str
    """Of its module."""
    title: str
    source: str
    about: str
    trials: Sequence[TrialOutcome]
    """In the order of the experiment."""
    findings: Sequence[Finding]
    """Empty where trials are missing."""

    def as_json(self) -> dict[str, Any]:
        """For ``results.json``: plain values, null for what is not finite."""
        return {name: _plain(value) for name, value in asdict(self).items()}


def trial_outcome(trial: Trial, record: Record) -> TrialOutcome:
    """The figures of a trial."""
    return TrialOutcome(
        name=trial.name,
        ours=trial.ours,
        arm=arm_name(trial.arm),
        rate_Hz=trial.arm.rate if trial.rate is None else trial.rate,
        duration_s=float(record.time[-1]),
        law=type(trial.law).__name__,
        gains=gains(trial.law),
        metrics=figures(record),
        stopped=record.stopped,
    )


def outcome(name: str, experiment: Experiment, trials: Sequence[Trial], records: Mapping[str, Record]) -> Outcome:
    """What is said of the trials of which there are records; judged when there are all."""
    done = [trial_outcome(trial, records[trial.name]) for trial in trials if trial.name in records]
    return Outcome(
        name=name,
        title=experiment.title,
        source=experiment.source,
        about=" ".join(experiment.about.split()),
        trials=done,
        findings=tuple(experiment.judge(records)) if len(done) == len(trials) else (),
    )


def arm_name(arm: Arm) -> str:
    """Ideal, with rotor inertia or without, or honest."""
    if arm.friction is not None:
        return "honest"
    return "ideal, with rotors" if np.any(arm.plant.armature > 0.0) else "ideal"


def gains(law: object) -> dict[str, Any]:
    """The fields of a law that are not at their defaults, as plain values."""
    assert is_dataclass(law)
    given = {each.name: each.default for each in fields(law) if each.init}
    values = {name: getattr(law, name) for name in given}
    return {name: _plain(value) for name, value in values.items() if not _same(value, given[name])}


def _same(value: object, default: object) -> bool:
    try:
        return bool(np.array_equal(value, default))  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return value is default


def _plain(value: Any) -> Any:
    """What JSON can say of it."""
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, float):
        return value if isfinite(value) else None
    if isinstance(value, dict):
        return {name: _plain(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if is_dataclass(value) and not isinstance(value, type):
        return {"law": type(value).__name__} | gains(value)
    if callable(value):
        return getattr(value, "__name__", type(value).__name__)
    return value
