"""Leads at the ends of a stroke: the force rises while the tool is already moving, and falls before it lifts.

A tool that stands while it presses digs in, most of all with a spindle. With a lead it begins with little force and
reaches the whole one on its way, tangential to the surface and on the path itself, so that nothing new has to be
reached. What is missing there is as much as half a lead would do at either end.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from burnish.errors import PlanError
from burnish.paths.stroke import Stroke

LEAD = 3e-3
"""Length of a lead unless told otherwise [m]: less than the radius of a contact, so that what is missing at an end does
not leave the edge band."""

TOUCHING = 0.2
"""Share of the force at the ends: 2 N of 10 N are well above what a touch is felt with."""


def with_leads(stroke: Stroke, length: float = LEAD, touching: float = TOUCHING) -> Stroke:
    """The stroke with a force that rises from a share of its own over the first piece and falls over the last.

    Args:
        stroke: shorter than two leads, it gets two of half its length.
        length: of a lead [m].
        touching: share of the force at the ends, 0 to 1.

    Raises:
        PlanError: a value is out of range.
    """
    if not (0.0 < length < np.inf and 0.0 <= touching <= 1.0):
        raise PlanError(
            f"lead: {length=} m, {touching=}; expected a positive length, and a share of the force from 0 to 1"
        )
    arc = stroke.arc
    way = min(length, arc[-1] / 2.0)
    share = np.minimum(np.minimum(arc, arc[-1] - arc) / way, 1.0)
    return replace(stroke, force=stroke.force * (touching + (1.0 - touching) * share))
