"""References that stand still."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from burnish.core import Array, Dynamics, JointReference, ToolReference, read_only


@dataclass(kw_only=True)
class Hold:
    """Hold joint positions: those given, or those at `reset`."""

    q: Array | None = None
    """Joint positions to hold [rad], (n,); None holds where the arm is at `reset`."""
    _reference: JointReference | None = field(default=None, init=False, repr=False)

    def reset(self, arm: Dynamics) -> None:
        """Latch the position."""
        still = np.zeros(len(arm.q))
        self._reference = JointReference(q=read_only(arm.q if self.q is None else self.q), dq=still, ddq=still)

    def at(self, arm: Dynamics) -> JointReference:
        """The same reference at every instant."""
        assert self._reference is not None, "reset comes first"
        return self._reference


@dataclass(kw_only=True)
class HoldPose:
    """Hold a tool pose: the one at `reset`."""

    _reference: ToolReference | None = field(default=None, init=False, repr=False)

    def reset(self, arm: Dynamics) -> None:
        """Latch the pose."""
        self._reference = ToolReference(p=read_only(arm.p), R=read_only(arm.R), v=np.zeros(6), a=np.zeros(6))

    def at(self, arm: Dynamics) -> ToolReference:
        """The same reference at every instant."""
        assert self._reference is not None, "reset comes first"
        return self._reference
