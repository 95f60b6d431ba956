"""A reference that jumps from pose to pose, as the blog's targets do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from burnish.core import Array, Dynamics, ToolReference
from burnish.model.model import Model
from burnish.rotation import exp
from burnish.sim.robot import HOME


@dataclass(kw_only=True)
class Jumps:
    """Tool poses, each held for the same time; the last one for ever."""

    poses: Sequence[tuple[Array, Array]]
    """Position [m] and rotation, base ← tool, of each."""
    every: float
    """Time from one to the next [s]."""
    _t0: float = field(default=0.0, init=False, repr=False)

    def reset(self, arm: Dynamics) -> None:
        """Start with the first."""
        self._t0 = arm.t

    def at(self, arm: Dynamics) -> ToolReference:
        """The pose of now, without motion."""
        k = min(int((arm.t - self._t0) / self.every + 1e-9), len(self.poses) - 1)
        p, R = self.poses[k]
        return ToolReference(p=p, R=R, v=np.zeros(6), a=np.zeros(6))


def blog_targets(count: int, *, shift: bool = True, turn: bool = True) -> list[tuple[Array, Array]]:
    """Poses about the home pose, up to 12 mm and 3° to 6° away about random axes, drawn once.

    Far less than the blog's, whose arm may turn its joints about four times as fast as a JACO2.
    """
    rng = np.random.default_rng(4)
    p, R, _ = Model.jaco2().kinematics(HOME)
    shifts = rng.uniform(-0.007, 0.007, (count, 3)) * shift
    axes = rng.normal(size=(count, 3))
    angles = np.radians(rng.uniform(3.0, 6.0, count)) * turn / np.linalg.norm(axes, axis=1)
    return [(p + s, exp(angle * axis) @ R) for s, axis, angle in zip(shifts, axes, angles, strict=True)]
