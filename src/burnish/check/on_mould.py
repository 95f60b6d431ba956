"""Whether strokes lie on the mould that they are meant for, and ask for what a recipe may ask."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from burnish.core import Array
from burnish.errors import PlanError
from burnish.paths.stroke import Stroke
from burnish.polish.recipe import FEED, FORCE, LEAST_FORCE, SLOWEST_FEED
from burnish.surface import DistanceGrid, Mould

OFF = 0.2e-3
"""Distance from the surface that a point may have [m]: paths are laid to 0.05 mm, and the spring of the tip takes four
times as much."""
COARSE = 0.25
"""The same in spacings of the distance grid, where that is more: it rounds off what is smaller."""
GOUGE = 0.5e-3
"""How deep the tip may cut into the mould beside its point of contact [m]: felt is soft. Half is usual."""
LEAN = float(np.deg2rad(15.0))
"""Angle between a normal and the surface's that a plan may have [rad]: normals are averaged over a disc, and beside an
edge the surface has two."""
GAP = 5e-3
"""Largest distance of two neighbouring points of a stroke [m]."""
SHORTEST = 2e-3
"""Least length of a stroke [m]."""


def refusal(name: str, point: Array, along: float, reason: str, remedy: str) -> PlanError:
    """A refusal in one line: on which piece of the way, where in the mould's frame, why, and what to do."""
    x, y, z = 1e3 * point
    place = f"({x:.1f}, {y:.1f}, {z:.1f}) mm of the mould, {1e3 * along:.0f} mm along"
    return PlanError(f"{name} at {place}: {reason}. {remedy}")


def at_point(number: int, stroke: Stroke, k: int, reason: str, remedy: str) -> PlanError:
    """The refusal of a stroke (from 0) at one of its points."""
    return refusal(f"stroke {number + 1}", stroke.points[k], float(stroke.arc[k]), reason, remedy)


def check_on_mould(
    strokes: Sequence[Stroke], mould: Mould, grid: DistanceGrid, *, tip_radius: float, made_for: str | None
) -> None:
    """Refuse what is no work on this mould.

    Args:
        strokes: mould frame.
        mould: the mould.
        grid: distance to it.
        tip_radius: of the tool [m].
        made_for: fingerprint of the mould that the plan names, if it names one.

    Raises:
        PlanError: there is no stroke; the plan is of another mould; a stroke is too short or torn; a force or a feed is
            out of range; a point is off the surface, or the tip would cut into the mould; a normal points elsewhere.
    """
    if made_for is not None and made_for != mould.sha256:
        raise PlanError(
            f"the plan was made for a mould with the fingerprint {made_for[:12]!r}; '{mould.name}' has "
            f"'{mould.sha256[:12]}'. Plan anew for this mould, or give the one that the plan was made for"
        )
    if not strokes:
        raise PlanError("the plan has no strokes; expected at least one. Choose a smaller tip, inset or slope")
    for number, stroke in enumerate(strokes):
        _check_form(number, stroke)
        _check_values(number, stroke)
        _check_surface(number, stroke, grid, tip_radius)


def _check_form(number: int, stroke: Stroke) -> None:
    """Long enough, with neighbours that are neither alike nor torn apart."""
    steps = np.diff(stroke.arc)
    if len(stroke.points) < 3 or stroke.length < SHORTEST:
        raise at_point(
            number,
            stroke,
            0,
            f"it has {len(stroke.points)} points over {1e3 * stroke.length:.2f} mm; expected at least 3 over "
            f"{1e3 * SHORTEST:g} mm",
            "Leave it out",
        )
    k = int(np.argmin(steps))
    if steps[k] < 1e-9:
        raise at_point(number, stroke, k, "two neighbouring points are the same", "Leave one out")
    k = int(np.argmax(steps))
    if steps[k] > GAP:
        raise at_point(
            number,
            stroke,
            k,
            f"the path is torn, the next point is {1e3 * steps[k]:.1f} mm away; expected {1e3 * GAP:g} mm at most",
            "Make two strokes of it, or add points",
        )


def _check_values(number: int, stroke: Stroke) -> None:
    """Force and feed in the ranges of a recipe; both may be lower in places."""
    for name, unit, values, low, high in (
        ("force", FORCE.unit, stroke.force, LEAST_FORCE, FORCE.high),
        ("feed", FEED.unit, stroke.feed, SLOWEST_FEED, FEED.high),
    ):
        k = int(np.argmax(np.maximum(low - values, values - high)))
        if not low * (1.0 - 1e-9) <= values[k] <= high * (1.0 + 1e-9):
            raise at_point(
                number,
                stroke,
                k,
                f"{name} {values[k]:g} {unit} is out of range; expected {low:g} to {high:g} {unit}",
                f"Change the {name} of the recipe",
            )


def _check_surface(number: int, stroke: Stroke, grid: DistanceGrid, tip_radius: float) -> None:
    """Points on the surface, normals outward, and the tip clear of the mould."""
    distance, gradient = grid.at(stroke.points)
    off = max(OFF, COARSE * grid.spacing)
    k = int(np.argmax(np.abs(distance)))
    if abs(distance[k]) > off:
        raise at_point(
            number,
            stroke,
            k,
            f"the point lies {1e3 * abs(distance[k]):.2f} mm {'above' if distance[k] > 0.0 else 'below'} the surface; "
            f"expected {1e3 * off:.2g} mm at most",
            "Plan anew for this mould and check the unit of its file",
        )
    length = np.maximum(np.linalg.norm(gradient, axis=1), 1e-9)
    lean = np.arccos(np.clip(np.einsum("ij,ij->i", gradient, stroke.normals) / length, -1.0, 1.0))
    k = int(np.argmax(lean))
    if lean[k] > np.pi / 2.0:
        raise at_point(
            number,
            stroke,
            k,
            f"the normal points into the mould, {np.rad2deg(lean[k]):.0f}° from outward",
            "Turn the normals round",
        )
    if lean[k] > LEAN:
        raise at_point(
            number,
            stroke,
            k,
            f"the normal is {np.rad2deg(lean[k]):.0f}° off the surface's; expected {np.rad2deg(LEAN):.0f}° at most",
            "Plan anew for this mould",
        )
    depth = tip_radius - grid.distance(stroke.points + tip_radius * stroke.normals)
    deepest = int(np.argmax(depth))
    if depth[deepest] > max(GOUGE, 2.0 * off):
        raise at_point(
            number,
            stroke,
            deepest,
            f"a tip of {1e3 * tip_radius:g} mm radius would cut {1e3 * depth[deepest]:.2f} mm into the mould",
            "Use a smaller tip, or leave this place out",
        )
