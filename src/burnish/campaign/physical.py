"""Faults of the arm itself, and of what it touches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from burnish.campaign.commanded import not_finite
from burnish.campaign.fault import Fault, Rng
from burnish.model.friction import Friction


def late_commands(rng: Rng, start: float, period: float) -> Fault:
    """Commands act up to three cycles late and unevenly; an arm that is later has to be refused before it moves."""
    delay, jitter = float(rng.uniform(1.0, 2.0)), float(rng.uniform(0.2, 1.0))
    return Fault(
        text=f"commands {delay:.1f} to {delay + jitter:.1f} cycles late",
        start=0.0,
        plant=lambda plant: replace(plant, delay=delay, jitter=jitter),
    )


def jitter(rng: Rng, start: float, period: float) -> Fault:
    """Cycles of uneven length."""
    share = float(rng.uniform(0.1, 0.6))
    return Fault(
        text=f"periods ± {100 * share:.0f} %", start=0.0, plant=lambda plant: replace(plant, period_jitter=share)
    )


def payload(rng: Rng, start: float, period: float) -> Fault:
    """A kilogram in the hand that nobody knew of, all masses a tenth more; then the law breaks."""
    return replace(
        not_finite(rng, start, period),
        text="+1 kg, masses × 1.1, then the law breaks",
        plant=lambda plant: replace(plant, payload=1.0, mass_scale=np.full(7, 1.1)),
    )


def missing_payload(rng: Rng, start: float, period: float) -> Fault:
    """The controller believes in a kilogram that is not there; then the law breaks."""
    return replace(not_finite(rng, start, period), text="−1 kg, then the law breaks", believed_payload=1.0)


def wrong_model(rng: Rng, start: float, period: float) -> Fault:
    """Masses up to 30 % off, rotors by half to double."""
    masses, rotors = rng.uniform(0.7, 1.3, 7), rng.uniform(0.5, 2.0, 6)
    return Fault(
        text="masses up to 30 % off, rotors × 0.5 to 2",
        start=0.0,
        plant=lambda plant: replace(plant, mass_scale=masses, armature=plant.armature * rotors),
    )


def friction(rng: Rng, start: float, period: float) -> Fault:
    """No friction at all, or three times as much."""
    factor = float(rng.choice([0.0, 3.0]))
    return Fault(
        text=f"friction × {factor:g}",
        start=0.0,
        plant=lambda plant: replace(
            plant,
            friction=Friction(coulomb=factor * plant.friction.coulomb, viscous=factor * plant.friction.viscous),
        ),
    )


def sudden_contact(rng: Rng, start: float, period: float) -> Fault:
    """The tool runs into the mould at up to 0.15 m/s."""
    speed = float(rng.uniform(0.03, 0.15))
    return Fault(text=f"runs into the mould at {speed:.2f} m/s", start=0.0, plunge=speed)


def contact_lost(rng: Rng, start: float, period: float) -> Fault:
    """The tool slides over the edge of the mould."""
    return Fault(text="slides over the edge", start=0.0, near_edge=True)
