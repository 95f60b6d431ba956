"""What really happened in a simulated contact: for the judge and the report, never for a controller."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from burnish.core import Array


@dataclass(kw_only=True)
class Truth:
    """The log of a simulated arm: the contact force at every physics step, the rest once a control cycle."""

    timestep: float
    """Physics step [s]."""
    normal_force: list[float] = field(default_factory=list)
    """True contact force along the surface normal at every physics step [N]."""
    cycle_step: list[int] = field(default_factory=list)
    """Number of physics steps done at the end of each cycle."""
    time: list[float] = field(default_factory=list)
    """End of each cycle [s]."""
    point: list[tuple[float, float, float]] = field(default_factory=list)
    """Contact point in the mould's frame [m]; NaN in the air."""
    normal: list[tuple[float, float, float]] = field(default_factory=list)
    """Outward surface normal there, mould's frame; NaN in the air."""
    axis: list[tuple[float, float, float]] = field(default_factory=list)
    """Tool axis (out of the arm), mould's frame."""
    slip: list[float] = field(default_factory=list)
    """Tangential speed of the tip over the surface [m/s]; 0 in the air."""

    def force(self) -> tuple[Array, Array]:
        """Time [s] and true normal force [N] at every physics step."""
        force: Array = np.asarray(self.normal_force, dtype=np.float64)
        return np.asarray(self.timestep * np.arange(1, len(force) + 1), dtype=np.float64), force

    def cycle_force(self) -> Array:
        """True normal force averaged over each cycle [N]."""
        total = np.concatenate([[0.0], np.cumsum(self.normal_force)])
        ends = np.asarray(self.cycle_step)
        starts = np.concatenate([[0], ends[:-1]])
        return np.asarray((total[ends] - total[starts]) / np.maximum(ends - starts, 1))

    def tilt(self) -> Array:
        """Angle between the tool axis and the inward surface normal at each cycle [rad]; NaN in the air."""
        cosine = -np.einsum("ij,ij->i", np.asarray(self.axis), np.asarray(self.normal))
        return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)))
