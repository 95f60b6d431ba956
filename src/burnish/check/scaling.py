"""A feed that the joints can follow: lowered where a joint would be too fast, and nowhere else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import minimum_filter1d

from burnish.core import Array
from burnish.paths.stroke import Stroke

SPARE = 0.95
"""What is aimed at, of the share that is allowed: a mould that is found turned by 2° must not undo the plan."""
WIDEN = 2e-3
"""Length before and after a place that is slowed down with it [m]: a path in time is smoothed over 50 ms."""


def derated(stroke: Stroke, arc: Array, speed: Array, share: Array, allowed: float) -> Stroke:
    """The stroke with its feed lowered where a joint needs more than the allowed share of its speed.

    Joint speed is in proportion to the speed on the path, so the feed becomes ``v · SPARE · allowed / share``.

    Args:
        stroke: the stroke.
        arc: places along it, ascending [m], (N,).
        speed: speed on the path there, as timed [m/s], (N,).
        share: the fastest joint's share of its limit there, (N,).
        allowed: largest share.
    """
    wanted = np.where(share > SPARE * allowed, speed * SPARE * allowed / np.maximum(share, 1e-9), np.inf)
    if not (share > allowed).any():
        return stroke
    # Each place takes the least of the timed nodes around it, so no peak falls between two points of the stroke.
    feed = stroke.feed.copy()
    slot = np.clip(np.searchsorted(stroke.arc, arc), 0, len(feed) - 1)
    np.minimum.at(feed, slot, wanted)
    np.minimum.at(feed, np.maximum(slot - 1, 0), wanted)
    spacing = stroke.length / (len(feed) - 1)
    size = 2 * int(np.ceil(WIDEN / spacing)) + 1
    lowered = np.where(feed < stroke.feed, feed, np.inf)
    return replace(stroke, feed=np.minimum(stroke.feed, minimum_filter1d(lowered, size)))
