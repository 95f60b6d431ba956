"""A motion of the tool as the joints have to make it, for laws of the joints."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from burnish.core import Array, Dynamics, JointReference, Source, State, ToolReference
from burnish.model.model import Model
from burnish.rotation import log

ITERATIONS = 2
"""Of Newton a cycle: the pose moves by 1 mm in it, after two what is left is far below a micrometre."""


@dataclass(kw_only=True)
class JointMotion:
    """Joint positions, speeds and accelerations of a tool motion of an arm of six joints, from where they are on.

    By J⁻¹ without damping: for motions that stay away from singularities.
    """

    source: Source[ToolReference]
    """The motion of the tool."""
    model: Model
    """Of the arm's geometry."""
    _q: Array = field(default_factory=lambda: np.zeros(0), init=False, repr=False)

    def reset(self, arm: Dynamics) -> None:
        """Start from this instant, this pose and these joints."""
        self.source.reset(arm)
        self._q = arm.q

    def at(self, arm: Dynamics) -> JointReference:
        """The reference at the instant of ``arm``."""
        wanted = self.source.at(arm)
        for _ in range(ITERATIONS):
            p, R, J = self.model.kinematics(self._q)
            self._q = self._q + np.linalg.solve(J, np.concatenate([wanted.p - p, log(wanted.R @ R.T)]))
        dq = np.asarray(np.linalg.solve(self.model.kinematics(self._q)[2], wanted.v), dtype=np.float64)
        there = self.model.at(State(t=arm.t, q=self._q, dq=dq))
        ddq = np.asarray(np.linalg.solve(there.J, wanted.a - there.dJdq), dtype=np.float64)
        return JointReference(q=self._q, dq=dq, ddq=ddq)
