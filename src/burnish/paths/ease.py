"""A feed at which the surface does not turn the tool too fast for a wrist."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from burnish.core import Array
from burnish.paths.stroke import Stroke
from burnish.trajectory.path import TURN_RATE


def followable(stroke: Stroke) -> Stroke:
    """The stroke with a feed at which the surface turns the tool no faster than `TURN_RATE`."""
    turn = np.linalg.norm(np.gradient(stroke.axes, stroke.arc, axis=0), axis=1)
    return replace(stroke, feed=np.minimum(stroke.feed, TURN_RATE / np.maximum(turn, 1e-9)))


def eased(stroke: Stroke, rim_speed: float) -> Stroke:
    """`followable`, pressed with as much less force as keeps what is removed: h ~ F √(v² + u²)/v at a feed v.

    Args:
        stroke: the stroke.
        rim_speed: u, how fast the tool's own turning rubs the surface [m/s]; 0 for a tool that does not spin, which
            removes the same at any feed.
    """
    slower = followable(stroke)
    return replace(slower, force=stroke.force * _rubbed(stroke.feed, rim_speed) / _rubbed(slower.feed, rim_speed))


def duration(stroke: Stroke) -> float:
    """Time of the stroke by its feed [s], without what turns and ends take."""
    return float(np.trapezoid(1.0 / stroke.feed, stroke.arc))


def _rubbed(feed: Array, rim_speed: float) -> Array:
    """Way that the surface is rubbed for each metre of the path, (N,)."""
    return np.asarray(np.hypot(feed, rim_speed) / feed)
