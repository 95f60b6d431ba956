"""`LearntFriction`: how much of its nominal friction each joint really has, learnt while the arm moves."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from burnish.core import Array
from burnish.errors import InputError
from burnish.model.friction import Friction


@dataclass(kw_only=True)
class LearntFriction:
    """Nominal friction τ_f times a share σ for every joint, which a law that compensates it learns on the way.

        τ = σ τ_f(q̇_d),    σ̇_j = κ M_jj/F_j² · τ_f,j(q̇_d) s_j,    |σ_j − 1| ≤ most,    s = J̄ (ṽ + ω e)

    with F the nominal Coulomb friction and s how far each joint is behind the plan. M_jj/F_j² makes the rate the same
    for light and heavy joints, with little friction and with much. A joint whose F is 0 keeps its share.

    What is learnt belongs to the gears and not to a motion, so it outlives the `reset` of a law: one of these is for
    one arm, for as long as it runs. With M constant and the real share within the bound, learning adds no more than
    ½ Σ F² most²/(κ M) to the motion along s: about 0.1 J with gears of 1.0 and 0.4 N·m.

    Source: the adaptation of Slotine and Li (IJRR 6(3), 1987, 10.1177/027836498700600303) with the friction of the
    planned motion as the only regressor; weight and bound are ours.
    """

    nominal: Friction
    """τ_f."""
    rate: float = 5.0
    """κ [1/s²]; found by trial: a share is learnt in some seconds, and at twenty times that the wrist would ring."""
    most: float = 0.5
    """How far a share may come from 1."""
    shares: Array = field(init=False)
    """σ, (n,)."""

    def __post_init__(self) -> None:
        for name in ("rate", "most"):
            if not 0.0 <= getattr(self, name) < np.inf:
                raise InputError(f"LearntFriction: {name} = {getattr(self, name)}; expected a finite number from 0 on")
        F = self.nominal.coulomb
        self.shares = np.ones_like(F)
        self._weight = self.rate * np.divide(1.0, F * F, out=np.zeros_like(F), where=F > 0.0)

    def torque(self, dq: Array) -> Array:
        """Torque that friction takes at the joint velocity ``dq`` [rad/s], (n,) [N·m], of the sign of dq."""
        return np.asarray(self.shares * self.nominal.torque(dq))

    def learn(self, dq: Array, s: Array, M: Array, dt: float) -> None:
        """Learn from a cycle of ``dt`` [s]; a joint of which something is no number keeps its share.

        Args:
            dq: planned joint velocity, at which friction was compensated [rad/s], (n,).
            s: how far each joint is behind [rad/s], (n,).
            M: mass matrix [kg·m²], (n, n).
            dt: length of the cycle [s].
        """
        grown = self.shares + dt * self._weight * M.diagonal() * self.nominal.torque(dq) * s
        learnt = np.clip(grown, 1.0 - self.most, 1.0 + self.most)
        # What outlives a reset must outlive a broken reading too.
        self.shares = np.where(np.isfinite(learnt), learnt, self.shares)
