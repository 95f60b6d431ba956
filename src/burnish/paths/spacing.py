"""How far apart neighbouring tracks lie, and with which force each is pressed, from how the surface bends across them.

A tip of radius r on a surface that bends with κ across the track touches it with 1/R = 1/r + κ; its contact has the
radius a = (3FR/4E*)^⅓, and the tracks lie s = 0.3 · 2a apart. Closer tracks would remove more at the same force: the
mean depth is h ∝ F/s. So the force follows the spacing, F/s the same everywhere, and both go with the root of R:

    s = s₀ √(R/R₀),   F = F₀ √(R/R₀)

with s₀ and R₀ where the surface bends as most of it does. There the force is that of the recipe.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from typing_extensions import Self

from burnish.core import Array
from burnish.paths.hertz import recommended_step
from burnish.paths.reach import EDGE, Reach
from burnish.surface import laid

BENT_OVER = 1.5e-3
"""Half of the length over which the bend of the surface is taken [m]: less than the radius of a contact, and more
than the facets of a fine mesh and the rounding of edges by the distance grid."""

HOLLOWEST = 0.8
"""Curvature of a hollow by that of the tip up to which Hertz is believed; a rule of thumb for which tip fits."""

LEAST, MOST = 0.5, 1.25
"""Bounds of spacing and force in those where the surface bends as most of it does. On a flat part the lower one is that
of a ridge of a third of the tip's radius; beyond the upper one tracks were 0.4 of a flat's contact apart."""


class Spacing(Protocol):
    """A rule for the distance of neighbouring tracks."""

    @property
    def typical(self) -> float:
        """The distance at which a track is pressed with the whole force [m]."""

    def at(self, curvature: Array) -> Array:
        """Greatest distance of tracks [m] where the surface bends so across them [1/m], convex positive.

        Where the bend is NaN, because nobody knows it, it counts as that of most of the surface.
        """


@dataclass(frozen=True, kw_only=True)
class Even:
    """The same distance everywhere."""

    typical: float
    """Distance of tracks [m]."""

    def at(self, curvature: Array) -> Array:
        """That distance."""
        return np.full(np.shape(curvature), self.typical)


@dataclass(frozen=True, kw_only=True)
class Hertzian:
    """0.3 of the local width of the contact."""

    typical: float
    """Distance where the surface bends with ``curvature`` [m]."""
    curvature: float
    """How most of the surface bends [1/m], convex positive."""
    tip_radius: float
    """Radius of the tip [m]."""

    @classmethod
    def of(cls, reach: Reach, force: float, curvature: Array) -> Self:
        """The rule for a force [N] and what is known of the surface's bend across the tracks [1/m], (N,)."""
        known = curvature[np.isfinite(curvature)]
        most = float(np.median(known)) if len(known) else 0.0
        most = max(most, -HOLLOWEST / reach.tip_radius)
        step = recommended_step(force, reach.tip_radius, most, reach.modulus)
        return cls(typical=step, curvature=most, tip_radius=reach.tip_radius)

    def at(self, curvature: Array) -> Array:
        """s₀ √(R/R₀)."""
        known = np.where(np.isfinite(curvature), curvature, self.curvature)
        hollow = np.maximum(known, -HOLLOWEST / self.tip_radius)
        share = np.sqrt((1.0 / self.tip_radius + self.curvature) / (1.0 / self.tip_radius + hollow))
        return np.asarray(self.typical * np.clip(share, LEAST, MOST))


def spacing_for(reach: Reach, step: float | None, force: float, curvature: Array) -> Spacing:
    """The rule for a step that the user chose [m], or for that of Hertz if he left it open."""
    return Hertzian.of(reach, force, curvature) if step is None else Even(typical=step)


def across_curvature(reach: Reach, xy: Array, across: Array) -> Array:
    """Normal curvature of the surface at places (N, 2) [m] in the directions ``across`` (N, 2) in plan [1/m], (N,).

    κ = Δn · Δp/|Δp|² over 3 mm, convex positive; NaN where the surface ends within that, so that nobody knows.
    """
    ends = [xy + side * BENT_OVER * across for side in (-1.0, 1.0)]
    one, other = (laid(reach.grid, end, reach.tip_radius) for end in ends)
    way, turn = other.contact - one.contact, other.normal - one.normal
    length = np.einsum("ij,ij->i", way, way)
    with np.errstate(invalid="ignore"):  # no surface, or a direction of length 0 where a field has its top
        known = (length > BENT_OVER**2) & (length < 36.0 * BENT_OVER**2)
    for end in ends:  # the grid rounds a border off
        known &= reach.border.distance(end) > EDGE * reach.grid.spacing
    return np.asarray(np.where(known, np.einsum("ij,ij->i", turn, way) / np.where(known, length, 1.0), np.nan))
