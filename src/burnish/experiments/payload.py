"""An unknown kilogram at the tool, more or less than the model says, with and without adaptation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from burnish.control import Adaptive, OperationalSpace
from burnish.experiments.ours import FREQUENCY, HONEST_FREQUENCY
from burnish.sim.arms import Arm, honest, ideal
from burnish.trajectory import HoldPose
from burnish.trials.experiment import Experiment, Finding, Trial, nominal, steady
from burnish.trials.record import Record

LOAD = 1.0
"""Mass that the model does not know of, or knows of and is not there [kg]."""
SEEDS = (1, 2, 3)
"""Of the honest arm."""
DURATION = 6.0
"""The error counts in the last second: after 5 s [s]."""
LIMIT = 2e-3
"""Position error that adaptation has to reach [m]."""


def trials() -> Sequence[Trial]:
    """Both loads on the ideal arm and on three honest ones, with adaptation and without."""
    arms = {"ideal": ideal(0)} | {f"honest {seed}": honest(seed) for seed in SEEDS}
    return [
        _trial(f"{name}, {load:+g} kg, {'adaptive' if adapts else 'plain'}", arm, load, adapts)
        for name, arm in arms.items()
        for load in (LOAD, -LOAD)
        for adapts in (False, True)
    ]


def judge(records: Mapping[str, Record]) -> Sequence[Finding]:
    """The error after 5 s; of the honest arms the worst."""
    findings = []
    for arm in ("ideal", "honest"):
        for load in (LOAD, -LOAD):
            plain, adaptive = (
                max(_error(record) for name, record in records.items() if _is(name, arm, load, law))
                for law in ("plain", "adaptive")
            )
            findings.append(
                Finding(
                    claim=f"{arm.capitalize()} arm, {load:+g} kg: ≤ {1e3 * LIMIT:g} mm within 5 s with adaptation.",
                    measured=f"{1e3 * adaptive:.2f} mm; {1e3 * plain:.2f} mm without.",
                    holds=adaptive <= LIMIT,
                )
            )
    return findings


def _trial(name: str, arm: Arm, load: float, adapts: bool) -> Trial:
    """A law without an integral, which would hide the load as well."""
    model = nominal(arm)
    if load > 0.0:
        arm = replace(arm, plant=replace(arm.plant, payload=load))
    else:
        model = model.with_payload(-load)
    frequency = FREQUENCY if arm.friction is None else HONEST_FREQUENCY
    law = OperationalSpace.at_frequency(frequency, friction=arm.friction)
    return Trial(
        name=name,
        law=Adaptive(law=law) if adapts else law,
        source=HoldPose(),
        duration=DURATION,
        arm=arm,
        model=model,
        ours=True,
    )


def _is(name: str, arm: str, load: float, law: str) -> bool:
    return name.startswith(arm) and f", {load:+g} kg, {law}" in name


def _error(record: Record) -> float:
    """Position error after 5 s [m]; infinite where the arm was stopped."""
    return steady(record.position_error, record.time) if record.stopped is None else float("inf")


EXPERIMENT = Experiment(
    title="An unknown payload of ±1 kg",
    source="The blog's adaptive demonstration; the requirement is ours",
    about="""The arm holds its pose with a kilogram that its model does not know of, or without one that its model
    carries. The law is OperationalSpace without an integral, alone and inside Adaptive, which learns mass and first
    moment.""",
    trials=trials,
    judge=judge,
)
