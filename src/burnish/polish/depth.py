"""The depth that a recipe wants, the law that it follows, and the part of a mould that is judged by it."""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot

import numpy as np
from numpy.typing import NDArray
from typing_extensions import Self

from burnish.core import Array
from burnish.finish.curvature import mean_curvature
from burnish.finish.removal import Coverage, Removal, coverage, workable
from burnish.finish.rubbing import Spindle
from burnish.model.tool import PolishingTool
from burnish.paths.hertz import contact_radius, recommended_step
from burnish.paths.patterns import CrossHatch
from burnish.paths.reach import STEEPEST, Reach
from burnish.polish.recipe import EDGE_BAND, Pass, Recipe
from burnish.surface import Border, DistanceGrid, Mould, WorkingSurface

ROUND = 1.5
"""Radius of the piece of surface whose curvature counts, in radii of the contact."""


@dataclass(frozen=True, kw_only=True)
class Ground:
    """The surface of a mould in triangles that resolve the contact, and which of its vertices count."""

    surface: WorkingSurface
    """Vertices that carry the depth."""
    counted: NDArray[np.bool_]
    """Those that the tip reaches, outside the edge band, (V,)."""

    @classmethod
    def of(cls, mould: Mould, grid: DistanceGrid, recipe: Recipe) -> Self:
        """Of a mould under the tool of a recipe."""
        tool = recipe.tool
        surface = WorkingSurface.of(mould, law_of(recipe).edge(recipe.force))
        reach = Reach(
            grid=grid,
            border=Border.of(mould, STEEPEST),
            tip_radius=tool.tip_radius,
            margin=EDGE_BAND,
            max_slope=STEEPEST,
        )
        return cls(surface=surface, counted=workable(surface, reach))

    def judged(self, depth: Array, target: float) -> Coverage:
        """How even a depth [m], (V,), is over what counts."""
        return coverage(depth, target, self.surface.areas, self.counted)


def law_of(recipe: Recipe) -> Removal:
    """What a contact removes."""
    return Removal(coefficient=recipe.preston, tip_radius=recipe.tool.tip_radius, modulus=recipe.tool.modulus)


def spindle_of(tool: PolishingTool) -> Spindle:
    """How the tip turns."""
    return Spindle(rate=tool.spindle, tip_radius=tool.tip_radius)


def target(recipe: Recipe) -> float:
    """Depth that the passes of a recipe, each done once, are to remove [m].

    Where the recipe names none it is what parallel lines leave on a flat, k F v/(feed · step) for each pass.
    """
    if recipe.even is not None:
        return recipe.even.depth
    return sum(_of_pass(recipe, one) for one in recipe.worked)


def _of_pass(recipe: Recipe, one: Pass) -> float:
    """Depth of one pass on a flat [m]."""
    tool, own = recipe.tool, recipe.of_pass(one)
    step = recommended_step(own.force, tool.tip_radius, 0.0, tool.modulus) if one.step is None else one.step
    times = 2.0 if isinstance(one.pattern, CrossHatch) else 1.0
    radius = float(contact_radius(own.force, tool.tip_radius, 0.0, tool.modulus))
    # Feed and rim lie at any angle to each other.
    speed = hypot(own.feed, spindle_of(tool).speed(radius, one.tilt.angle))
    return times * recipe.preston * own.force / step * (speed / own.feed)


def curvature(recipe: Recipe, surface: WorkingSurface, contacts: Array, normals: Array) -> Array:
    """Mean curvature where the tip touches, for the size of its contact [1/m], (N,)."""
    tool = recipe.tool
    radius = float(contact_radius(recipe.force, tool.tip_radius, 0.0, tool.modulus))
    return mean_curvature(surface, contacts, normals, ROUND * radius)
