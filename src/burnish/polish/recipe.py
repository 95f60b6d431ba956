"""The recipe of a job: what a user chooses, with its ranges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from burnish.errors import InputError

MARGIN = 3e-3
"""The path's inset from the border of the part [m]: the mould may have slid 2 mm, and the tip must not fall."""
EDGE_BAND = 6e-3
"""Band along the border that is not judged [m]: the inset, 2 mm for a mould that slid, and the end of a track."""
PRESTON = 1e-11
"""Removal per pressure and distance [1/Pa]. A placeholder to be calibrated on the real felt, paste and steel: no
trustworthy figure is published. All percentages are free of it."""


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """What to do on the mould."""

    force: float = 10.0
    """Contact force [N], 2 to 20."""
    feed: float = 0.02
    """Speed along the path [m/s], 0.005 to 0.08."""

    def __post_init__(self) -> None:
        for name, unit, low, high in (("force", "N", 2.0, 20.0), ("feed", "m/s", 0.005, 0.08)):
            value = getattr(self, name)
            if not (np.isfinite(value) and low <= value <= high):
                raise InputError(f"{name} {value:g} {unit} is out of range; expected {low:g} to {high:g} {unit}")
