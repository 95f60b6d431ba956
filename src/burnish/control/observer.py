"""`MomentumSense`: the contact wrench from joint torque sensors by an observer of the momentum."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from burnish.control.wrench import TaredNoise, link_torque
from burnish.core import Array, Dynamics, State, read_only


@dataclass(kw_only=True)
class MomentumSense(TaredNoise):
    """Contact wrench from tared joint torque sensors, by a generalised-momentum observer.

    The sensors sit behind the gears: neither friction nor rotors reach them, so M is that of the links,
    ``ṗ = τ_s − bias + Cᵀq̇ − g + τ_c`` with p = M q̇ and τ_c = Jᵀ F, and

        r = K (p − ∫ (τ_s − bias + Cᵀq̇ − g + r) dt)  →  τ_c,    F = J̄ᵀ r

    with J̄ᵀ the inverse of Jᵀ that Λ damps next to a singularity. Cᵀq̇ = Ṁq̇ − h, and Ṁ is the difference of M over
    the period: M and h are there anyway, and what a difference leaves out is of second order in the way of one
    period. By the trapezoidal rule (means over a period with a bar)

        Δp − ∫ Ṁq̇ dt = M̄ Δq̇,    r ← r + (1 − e^(−K Δt)) (M̄ Δq̇/Δt + h̄ + ḡ + bias − τ̄_s − r),

    which is what is computed: no momentum that grows, so nothing drifts. The mean of τ_s stands in the middle of the
    period like Δq̇/Δt, where positions are differenced for q̇.

    Source: generalised-momentum observer (De Luca and Mattone 2005; Haddadin, De Luca and Albu-Schäffer 2017).
    """

    armature: Array
    """Rotor inertia that the model's M contains [kg·m²], (n,); zero if it contains none."""
    time_constant: float = 0.015
    """1/K [s]."""
    least_touch: float = 1.0
    """[N]: about three times what an honest arm showed in free air on its approaches, at most 0.3 N."""
    _rotors: Array = field(init=False, repr=False)
    _bias: Array | None = field(default=None, init=False, repr=False)
    _r: Array | None = field(default=None, init=False, repr=False)
    _before: tuple[Dynamics, Array] | None = field(default=None, init=False, repr=False)

    def __post_init__(self) -> None:
        self.armature = read_only(self.armature)
        self._rotors = np.diag(self.armature)

    def feel(self, arm: Dynamics, state: State) -> Dynamics:
        """``arm`` with F.

        Raises:
            InputError: if the robot has no joint torque sensors.
        """
        still = arm.h + arm.g - link_torque(state)
        if self._bias is not None:
            still = still + self._bias
        if self._before is None or self._r is None:
            self._r = still
        elif arm.t > self._before[0].t:
            last, was = self._before
            dt = arm.t - last.t
            found = (0.5 * (arm.M + last.M) - self._rotors).dot(arm.dq - last.dq) / dt + 0.5 * (still + was)
            self._r = self._r + (1.0 - np.exp(-dt / self.time_constant)) * (found - self._r)
        self._before = arm, still
        return arm.feeling(self._r.dot(arm.J_bar))

    def tare(self, readings: list[tuple[Dynamics, State]]) -> None:
        """Mean of τ_s − h − g in free air becomes the bias: sensor offsets and errors of the gravity model there."""
        self._bias = np.mean([link_torque(state) - arm.h - arm.g for arm, state in readings], axis=0)
        self._before = None
        self._learn([self.feel(arm, state) for arm, state in readings])
        self._before = None
