"""The error of a tool pose as one vector, with any of the orientation errors of `burnish.rotation`."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from burnish.core import Array, Dynamics, ToolReference

OrientationError: TypeAlias = Callable[[Array, Array], Array]
"""(R, R_d) → (3,), base axes, pointing towards the target. The laws' own is `continuous_error`; `quaternion_error` is
half of it for small angles, so gains that were tuned with it (thesis B's) are to be halved, or used with it."""


def pose_error(arm: Dynamics, reference: ToolReference, orientation_error: OrientationError) -> Array:
    """e = [p_d − p; e_o] [m, rad], (6,), base axes, towards the target."""
    e = np.empty(6)
    e[:3] = reference.p - arm.p
    e[3:] = orientation_error(arm.R, reference.R)
    return e
