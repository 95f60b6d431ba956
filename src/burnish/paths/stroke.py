"""A piece of work without lifting the tool, and the form in which a plan is written to a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from burnish.core import Array, read_only
from burnish.errors import PlanError
from burnish.paths.tilt import Tilt, tool_axes

_UNIT = 1e-3
"""Deviation of a normal's length from 1 that a plan read from a file may have."""
COLUMNS = ("points", "normals", "feed", "force")
"""Arrays that every stroke has."""
SOFTEST = 0.25
"""Least share of the law's stiffness: half of its frequency. A choice."""
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
    tilt: Tilt = field(default_factory=Tilt)
    """How the tool leans; along the normal unless told otherwise."""
    stiffness: Array | None = None
    """Share of the law's stiffness with which the tool is held, 0.25 to 1, (N,); None: 1 everywhere."""

    def __post_init__(self) -> None:
        """Copy the arrays and refuse what no arm can follow."""
        own = COLUMNS if self.stiffness is None else (*COLUMNS, "stiffness")
        for name in own:
            try:
                object.__setattr__(self, name, read_only(getattr(self, name)))
            except (TypeError, ValueError, OverflowError):
                raise PlanError(f"stroke: {name} is no array of numbers; expected numbers in rows") from None
        count = len(self.points) if self.points.ndim else 0
        for name in own:
            found, shape = getattr(self, name), (count, 3) if name in ("points", "normals") else (count,)
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
        if self.stiffness is not None and not (self.stiffness.min() >= SOFTEST and self.stiffness.max() <= 1.0):
            raise PlanError(f"stroke: a stiffness is out of range; expected a share of {SOFTEST:g} to 1")

    @property
    def arc(self) -> Array:
        """Distance from the first point along the points of contact [m], (N,)."""
        return np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(self.points, axis=0), axis=1))))

    @property
    def length(self) -> float:
        """Length of the stroke [m]."""
        return float(self.arc[-1])

    @property
    def axes(self) -> Array:
        """The tool's axis at each point, a unit vector into the work, mould frame, (N, 3).

        Raises:
            PlanError: the tool leans where the surface faces along the mould's x axis.
        """
        return tool_axes(self.normals, self.tilt)

    def rows(self, which: slice | NDArray[np.bool_]) -> Stroke:
        """The stroke of these points alone, in their order."""
        stiffness = None if self.stiffness is None else self.stiffness[which]
        return replace(self, stiffness=stiffness, **{name: getattr(self, name)[which] for name in COLUMNS})


def as_plan(strokes: Sequence[Stroke]) -> dict[str, list[dict[str, Any]]]:
    """The plan of a job in plain lists, ready for JSON: mould frame, m, m/s, N, rad.

    ``tilt`` is there where the tool leans, and ``stiffness`` where it is not 1 all over.
    """
    return {"strokes": [_as_table(stroke) for stroke in strokes]}


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
        if not isinstance(stroke, Mapping) or set(stroke) - {"tilt", "stiffness"} != set(COLUMNS):
            raise PlanError(
                f"stroke {number} of the plan is malformed; expected {', '.join(COLUMNS)}, "
                "and tilt and stiffness where they are not as usual"
            )
        try:
            result.append(Stroke(**{**stroke, "tilt": _tilt(stroke["tilt"]) if "tilt" in stroke else Tilt()}))
        except PlanError as error:
            raise PlanError(f"plan, {error} (stroke number {number})") from None
    return result


def _as_table(stroke: Stroke) -> dict[str, Any]:
    """A stroke in plain values."""
    table: dict[str, Any] = {name: getattr(stroke, name).tolist() for name in COLUMNS}
    if stroke.tilt.angle != 0.0:
        table["tilt"] = asdict(stroke.tilt)
    if stroke.stiffness is not None:
        table["stiffness"] = stroke.stiffness.tolist()
    return table


def _tilt(table: Any) -> Tilt:
    """The tilt of a stroke that was read from a file."""
    known = isinstance(table, Mapping) and all(type(x) in (int, float) and abs(x) <= 10.0 for x in table.values())
    if not known or set(table) != {"angle", "heading"}:
        raise PlanError("stroke: its tilt is malformed; expected an angle and a heading in rad")
    return Tilt(**table)
