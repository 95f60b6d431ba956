"""A piece of work without lifting the tool, and the form in which a plan is written to a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from burnish.core import Array, read_only
from burnish.errors import PlanError

_UNIT = 1e-3
"""Deviation of a normal's length from 1 that a plan read from a file may have."""
_MOST = 1e4
"""Largest number of a stroke in SI units; larger ones are a mistake, and their squares would overflow."""


@dataclass(frozen=True, kw_only=True)
class Stroke:
    """Points of contact in order, mould frame; the tool stays on the surface from the first to the last.

    The centre of a spherical tip of radius r is at ``points + r * normals``.
    """

    points: Array
    """Points of contact, mould frame [m], (N, 3)."""
    normals: Array
    """Outward unit normals of the surface there, (N, 3)."""
    feed: Array
    """Speed of the point of contact over the surface [m/s], (N,)."""
    force: Array
    """Normal force that presses the tool into the surface [N], (N,)."""

    def __post_init__(self) -> None:
        """Copy the arrays and refuse what no arm can follow."""
        for name in ("points", "normals", "feed", "force"):
            try:
                object.__setattr__(self, name, read_only(getattr(self, name)))
            except (TypeError, ValueError, OverflowError):
                raise PlanError(f"stroke: {name} is no array of numbers; expected numbers in rows") from None
        count = len(self.points) if self.points.ndim else 0
        shapes = {"points": (count, 3), "normals": (count, 3), "feed": (count,), "force": (count,)}
        for name, shape in shapes.items():
            found = getattr(self, name)
            if count < 2 or found.shape != shape:
                raise PlanError(f"stroke: {name} has shape {found.shape}; expected {shape} with at least two points")
            if not np.isfinite(found).all():
                raise PlanError(f"stroke: {name} holds a value that is not a finite number")
            if np.abs(found).max() > _MOST:
                raise PlanError(f"stroke: {name} holds a value beyond {_MOST:g}; expected m, m/s and N")
        if np.any(np.abs(np.linalg.norm(self.normals, axis=1) - 1.0) > _UNIT):
            raise PlanError("stroke: a normal is not of length 1; expected outward unit normals")
        if np.any(self.feed <= 0.0) or np.any(self.force < 0.0):
            raise PlanError("stroke: a feed is not positive or a force is negative; expected m/s > 0 and N ≥ 0")

    @property
    def arc(self) -> Array:
        """Distance from the first point along the points of contact [m], (N,)."""
        return np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(self.points, axis=0), axis=1))))

    @property
    def length(self) -> float:
        """Length of the stroke [m]."""
        return float(self.arc[-1])


def as_plan(strokes: Sequence[Stroke]) -> dict[str, list[dict[str, Any]]]:
    """The plan of a job in plain lists, ready for JSON: mould frame, m, m/s, N."""
    return {
        "strokes": [
            {name: getattr(stroke, name).tolist() for name in ("points", "normals", "feed", "force")}
            for stroke in strokes
        ]
    }


def from_plan(plan: Mapping[str, Any]) -> list[Stroke]:
    """The strokes of a plan that was read from a file.

    Raises:
        PlanError: it is not of the form that :func:`as_plan` writes, or a stroke cannot be followed.
    """
    strokes = plan.get("strokes") if isinstance(plan, Mapping) else None
    if not isinstance(strokes, list) or not strokes:
        raise PlanError('the plan has no strokes; expected {"strokes": [{"points": …, "normals": …, …}]}')
    result = []
    for number, stroke in enumerate(strokes):
        names = {"points", "normals", "feed", "force"}
        if not isinstance(stroke, Mapping) or set(stroke) != names:
            raise PlanError(f"stroke {number} of the plan is malformed; expected exactly {', '.join(sorted(names))}")
        try:
            result.append(Stroke(**stroke))
        except PlanError as error:
            raise PlanError(f"plan, {error} (stroke number {number})") from None
    return result
