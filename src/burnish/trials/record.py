"""What happened in a trial, in columns, and the figures that are drawn from it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from burnish.core import Array, JointReference, Sample
from burnish.model.model import Model
from burnish.rotation import log, rotation_vector_error


@dataclass(kw_only=True)
class Record:
    """A row a cycle; errors of joint references are those of the tool poses that they mean."""

    model: Model
    """Gives the tool pose of a joint reference."""
    t: list[float] = field(default_factory=list)
    q: list[Array] = field(default_factory=list)
    p: list[Array] = field(default_factory=list)
    p_d: list[Array] = field(default_factory=list)
    turn: list[Array] = field(default_factory=list)
    """Orientation error θu, base axes [rad], (3,)."""
    turn_d: list[Array] = field(default_factory=list)
    """Orientation of the reference as a rotation vector, base axes [rad], (3,): tells when it moves."""
    joint_error: list[Array] = field(default_factory=list)
    """q_d − q [rad], (n,); NaN for a tool reference."""
    tau: list[Array] = field(default_factory=list)
    """Torque that was applied, less gravity [N·m], (n,)."""
    step_us: list[float] = field(default_factory=list)
    """Wall time of the law alone [µs]."""
    stopped: str | None = None
    """Why the supervisor ended the trial, or None."""

    def add(self, sample: Sample, step_us: float) -> None:
        """Append one cycle."""
        arm, reference = sample.arm, sample.reference
        if isinstance(reference, JointReference):
            p_d, R_d, _ = self.model.kinematics(reference.q)
            self.joint_error.append(reference.q - arm.q)
        else:
            p_d, R_d = reference.p, reference.R
            self.joint_error.append(np.full(len(arm.q), np.nan))
        self.t.append(arm.t)
        self.q.append(arm.q)
        self.p.append(arm.p)
        self.p_d.append(p_d)
        self.turn.append(rotation_vector_error(arm.R, R_d))
        self.turn_d.append(log(R_d))
        self.tau.append(sample.applied - arm.g)
        self.step_us.append(step_us)

    def __getstate__(self) -> dict[str, Any]:
        """The columns as arrays, without the model: what another process needs of it."""
        columns = {name: value for name, value in vars(self).items() if name not in ("model", "stopped")}
        return {name: np.asarray(value) for name, value in columns.items()} | {"stopped": self.stopped}

    @property
    def time(self) -> Array:
        """Time [s], (N,)."""
        return np.asarray(self.t)

    @property
    def position_error(self) -> Array:
        """|p_d − p| [m], (N,)."""
        return np.asarray(np.linalg.norm(np.asarray(self.p_d) - np.asarray(self.p), axis=1))

    @property
    def orientation_error(self) -> Array:
        """θ [rad], (N,)."""
        return np.asarray(np.linalg.norm(np.asarray(self.turn), axis=1))


def rms(values: Array) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))
