"""What a recipe wants of the surface: an even depth, and an estimate of the roughness that is left."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from burnish.errors import InputError
from burnish.finish.roughness import Grit, Guess, Roughness
from burnish.polish.ranges import Range

_FEED = Range(unit="m/s", low=2e-3, high=0.08)
_RA = Range(unit="m", low=1e-10, high=1e-4)
_FACTOR = Range(unit="", low=1.0, high=10.0)
EVEN: Mapping[str, Range] = {
    "depth": Range(unit="m", low=1e-10, high=1e-3),
    "slowest": _FEED,
    "fastest": _FEED,
}
"""Of the fields of `Even`."""
ROUGHNESS: Mapping[str, Range] = {
    "before": _RA,
    "before_factor": _FACTOR,
    "asymptote": _RA,
    "asymptote_factor": _FACTOR,
    "depth": Range(unit="m", low=1e-9, high=1e-3),
    "depth_factor": _FACTOR,
    "preston_factor": _FACTOR,
}
"""Of the fields of `Smoothing`."""


@dataclass(frozen=True, kw_only=True)
class Even:
    """The same depth everywhere: the feed along the path is fitted to it."""

    depth: float
    """What all passes of the recipe together are to remove [m]."""
    slowest: float = 5e-3
    """Least feed [m/s], 0.002 to 0.08."""
    fastest: float = 0.04
    """Largest feed [m/s], 0.002 to 0.08."""

    def __post_init__(self) -> None:
        for name, allowed in EVEN.items():
            allowed.check(f"even: {name}", getattr(self, name))
        if not self.slowest < self.fastest:
            raise InputError(f"even: slowest {self.slowest:g} m/s is not less than fastest {self.fastest:g} m/s")


@dataclass(frozen=True, kw_only=True)
class Smoothing:
    """The constants of `finish.roughness`, each with the factor up to which it is known (68 %)."""

    before: float
    """Ra of the part before the job [m]."""
    asymptote: float
    """Ra that the grit leaves however long it rubs [m]."""
    depth: float
    """Removal after which Ra has come nearer to that by 1 − 1/e [m]."""
    before_factor: float = 1.2
    """Of a measured part; one that was not has more."""
    asymptote_factor: float = 1.5
    """Of a grit that was tried on a sample; a guess."""
    depth_factor: float = 2.0
    """A guess."""
    preston_factor: float = 2.0
    """Of the recipe's Preston coefficient, and so of every depth; a guess."""

    def __post_init__(self) -> None:
        for name, allowed in ROUGHNESS.items():
            allowed.check(f"roughness: {name}", getattr(self, name))

    def after(self, depth: float) -> Roughness:
        """Ra after a mean removal [m], with its interval.

        Raises:
            InputError: the depth is negative or not finite.
        """
        grit = Grit(
            asymptote=Guess(value=self.asymptote, factor=self.asymptote_factor),
            depth=Guess(value=self.depth, factor=self.depth_factor),
            preston=self.preston_factor,
        )
        return grit.after(Guess(value=self.before, factor=self.before_factor), depth)
