"""Friction of the joints: what a moving, or a starting, gear takes from the torque."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from burnish.core import Array, read_only
from burnish.errors import InputError


@dataclass(frozen=True, kw_only=True)
class Friction:
    """Coulomb, viscous and Stribeck friction with a breakaway torque, smooth at zero speed.

    tau_friction = [F_c + (F_s − F_c) exp(−(q̇/v_s)²)] tanh(q̇/v_0) + F_v q̇, with F_s the breakaway torque.

    It has the sign of q̇: the plant is M q̈ + h + g + tau_friction = tau + Jᵀ F, so adding ``torque(dq)`` to a
    command compensates it. Next to q̇ = 0 it is a damper of slope F_s/v_0 + F_v instead of a jump: a joint creeps
    under a load where a real one sticks, and a simulation of a light joint needs steps well below I v_0/F_s.

    Source: own; neither thesis models friction, and no measured figure for the JACO2 is published.
    """

    coulomb: Array
    """Torque of sliding friction F_c [N·m], (n,), not negative."""
    viscous: Array
    """Torque per speed F_v [N·m·s/rad], (n,), not negative."""
    breakaway: Array | None = None
    """Torque at the onset of motion F_s [N·m], (n,), at least F_c; None is F_c, that is no Stribeck effect."""
    stribeck_velocity: float = 0.05
    """Speed v_s over which breakaway falls to Coulomb friction [rad/s]; a guess of the size usual for such gears."""
    transition_velocity: float = 0.005
    """Speed v_0 over which the sign turns [rad/s]; a choice, well below v_s so that breakaway is nearly reached."""
    _extra: Array = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for name in ("coulomb", "viscous", "breakaway"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, read_only(getattr(self, name)))
        breakaway = self.coulomb if self.breakaway is None else self.breakaway
        if self.coulomb.ndim != 1 or not self.coulomb.shape == self.viscous.shape == breakaway.shape:
            raise InputError(
                f"Friction: coulomb, viscous and breakaway have shapes {self.coulomb.shape}, {self.viscous.shape} and "
                f"{breakaway.shape}; expected vectors with one number a joint"
            )
        values = np.concatenate((self.coulomb, self.viscous, breakaway))
        if not (np.isfinite(values).all() and (values >= 0.0).all()):
            raise InputError("Friction: found a negative number or one that is not finite; expected 0 or more")
        if not (breakaway >= self.coulomb).all():
            raise InputError(f"Friction: breakaway {breakaway} is below coulomb {self.coulomb}; expected at least that")
        if not (0.0 < self.transition_velocity < np.inf and 0.0 < self.stribeck_velocity < np.inf):
            raise InputError(
                f"Friction: transition_velocity {self.transition_velocity} rad/s, stribeck_velocity "
                f"{self.stribeck_velocity} rad/s; expected finite speeds above 0"
            )
        object.__setattr__(self, "_extra", read_only(breakaway - self.coulomb))

    def torque(self, dq: Array) -> Array:
        """Torque that friction takes at the joint velocity ``dq`` [rad/s], (n,) [N·m], of the sign of dq."""
        sliding = self.coulomb
        if self.breakaway is not None:
            sliding = sliding + self._extra * np.exp(-((dq / self.stribeck_velocity) ** 2))
        return np.asarray(sliding * np.tanh(dq / self.transition_velocity) + self.viscous * dq)
