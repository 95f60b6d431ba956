"""How long an abrasive lasts: path or work of friction that it may do before it is changed."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from burnish.errors import InputError
from burnish.polish.passes import Leg

SHORTEST = 10e-3
"""Path for which an abrasive is not put to the surface any more [m]."""


@dataclass(kw_only=True)
class Abrasive:
    """The abrasive in use: what it may do, and what it has done."""

    most_metres: float = inf
    """Path that it may do [m]."""
    most_joules: float = inf
    """Work of friction µ F ds that it may do [J]."""
    friction: float = 0.3
    """µ of the tip on the surface."""
    metres: float = 0.0
    """Path that it has done [m]."""
    joules: float = 0.0
    """Work that it has done [J]."""

    def __post_init__(self) -> None:
        for name, value, unit in (("metres", self.most_metres, "m"), ("joules", self.most_joules, "J")):
            if not value > 0.0:
                raise InputError(f"the abrasive's life is {value:g} {unit}; expected more than 0")
            if getattr(self, name) < 0.0:
                raise InputError(f"the abrasive has done {getattr(self, name):g} {unit}; expected 0 or more")

    def rub(self, way: float, force: float) -> None:
        """It was drawn over a way [m] with a normal force [N]."""
        self.metres += way
        self.joules += self.friction * force * way

    def left(self, force: float) -> float:
        """Path that it may still do at this force [m]."""
        by_work = (self.most_joules - self.joules) / (self.friction * force) if force > 0.0 else inf
        return max(0.0, min(self.most_metres - self.metres, by_work))

    def lasts(self, leg: Leg) -> float:
        """How much of a leg it lasts for [m]: all, a part, or nothing where that part is not worth an approach."""
        left = self.left(float(leg.path.force.max()))
        if left >= leg.path.length - leg.lead:
            return leg.path.length
        # Over the lead-in it is hardly pressed.
        return leg.lead + left if left >= SHORTEST else 0.0

    @property
    def limited(self) -> bool:
        """Whether there is a limit at all."""
        return min(self.most_metres, self.most_joules) < inf

    def says(self) -> str:
        """What it has done of what it may, in words."""
        parts = [f"{self.metres:.2f} m" + (f" of {self.most_metres:g} m" if self.most_metres < inf else "")]
        parts.append(f"{self.joules:.1f} J" + (f" of {self.most_joules:g} J" if self.most_joules < inf else ""))
        return "the abrasive has done " + " and ".join(parts)
