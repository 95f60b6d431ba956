"""`EnergyTank`: what the terms of a law that are not passive may put into the motion of the arm."""

from __future__ import annotations

from dataclasses import dataclass, field

from burnish.errors import InputError

LOW = 1.0 / 6.0
"""Share of the capacity below which the terms are scaled down; a choice."""


@dataclass(kw_only=True)
class EnergyTank:
    """A store that pays for the terms of a law that could add energy without end: force and integrals.

        α = min(1, T/T_low),    T ← T + Δt (D − α P) within [0, T_max],    T_low = T_max/6

    with P the power of these terms at the velocity against the reference and D what the law's dampers take out there.
    α scales the terms. T starts full, so at every instant, summed over the cycles,

        ∫ α P dt  ≤  T_max + ∫ max(D, 0) dt

    as long as no cycle asks for more than P Δt = T_low. What such terms give back (P < 0) is taken in like the rest.

    Source: the energy tank of unified force-impedance control (Haddadin and Shahriari, IJRR 2024,
    10.1177/02783649241249194), here as a scalar that is bounded in discrete time.
    """

    capacity: float
    """T_max [J]."""
    level: float = field(init=False)
    """T [J]."""

    def __post_init__(self) -> None:
        if not self.capacity > 0.0:
            raise InputError(f"EnergyTank: capacity = {self.capacity} J; expected more than 0")
        self._low = LOW * self.capacity
        self.fill()

    def fill(self) -> None:
        """Full again."""
        self.level = self.capacity

    @property
    def share(self) -> float:
        """α."""
        return 1.0 if self.level > self._low else self.level / self._low

    def add(self, energy: float) -> None:
        """Book a cycle: (D − α P) Δt [J]."""
        self.level = min(max(self.level + energy, 0.0), self.capacity)
