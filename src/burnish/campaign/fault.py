"""`Fault`: one thing that goes wrong in an episode, and the law that suffers from it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from burnish.core import Array, Controller, Dynamics
from burnish.sim.faulty import Spell
from burnish.sim.plant import Plant

INVALID, STALE, FROZEN = "invalid", "stale", "frozen"
"""How urgent a fault is: what cannot be a measurement or a torque; nothing new; nothing new of one joint. Others need
not be noticed."""
Rng: TypeAlias = np.random.Generator


@dataclass(frozen=True, kw_only=True)
class Fault:
    """One fault, drawn."""

    text: str
    """What it is, in words."""
    start: float
    """When it begins [s]; 0 for what was wrong from the beginning."""
    urgency: str | None = None
    """`INVALID`, `STALE`, `FROZEN`, or None."""
    reading: tuple[Spell, ...] = ()
    """What it does to measurements."""
    torque: Callable[[Array, Dynamics], Array] | None = None
    """What it does to the law's torque, from `start` on."""
    reference: Callable[[Any, Dynamics], Any] | None = None
    """What it does to what the law is asked for, from `start` on."""
    plant: Callable[[Plant], Plant] | None = None
    """What it does to the arm."""
    believed_payload: float = 0.0
    """Mass that the controller believes to be in the hand, and is not [kg]."""
    plunge: float | None = None
    """Speed at which the tool runs into the mould unawares [m/s]."""
    near_edge: bool = False
    """Whether the tool slides off the mould."""
    near_limit: bool = False
    """Whether the arm starts near a joint limit."""

    def reaches(self, told: float) -> bool:
        """Whether the controller's last cycle, in which it was told this time [s], had the fault in it.

        A reading that was lost on the way brings nobody its fault.
        """
        return any(spell.on for spell in self.reading) if self.reading else told >= self.start


@dataclass(kw_only=True)
class FaultyLaw:
    """A law whose reference and torque go wrong."""

    law: Controller[Any]
    faults: Sequence[Fault]

    def reset(self, arm: Dynamics) -> None:
        """As the law does."""
        self.law.reset(arm)

    def torque(self, arm: Dynamics, reference: Any) -> Array:
        """What is left of the law's torque."""
        on = [fault for fault in self.faults if arm.t >= fault.start]
        for fault in on:
            if fault.reference is not None:
                reference = fault.reference(reference, arm)
        tau = np.array(self.law.torque(arm, reference))
        for fault in on:
            if fault.torque is not None:
                tau = fault.torque(tau, arm)
        return tau


Kind: TypeAlias = Callable[[Rng, float, float], Fault]
"""Draws a fault for its start and the control period [s]."""
