"""`Plant`: everything about a simulated arm that its controller does not know."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from burnish.core import Array
from burnish.model.friction import Friction

ENCODER_COUNTS = np.array([3_686_400.0] * 3 + [2_534_400.0] * 3)
"""Position counts a turn behind the gears: 23,040 × 160 and 23,040 × 110 (data sheet, K-75+ and K-58)."""

READINGS = 256
"""Sensor readings, or cycles, whose errors are drawn at once."""


@dataclass(frozen=True, kw_only=True)
class Plant:
    """A drawn arm: its gears, masses, sensors and clock, and where the mould really stands."""

    friction: Friction
    """Coulomb and viscous friction of each joint."""
    armature: Array
    """Rotor inertia reflected through the gears [kg·m²], (n,)."""
    mass_scale: Array
    """True over nominal mass and inertia of links 1…n and, last, the tool, (n + 1,)."""
    encoder_counts: Array | None
    """Position counts a turn, (n,); None reads exactly."""
    torque_bias: Array
    """Offset of the joint torque sensors [N·m], (n,)."""
    torque_noise: float
    """Standard deviation of a joint torque reading [N·m]."""
    wrench_bias: Array
    """Offset of the wrist sensor [N, N·m], (6,)."""
    wrench_noise: Array
    """Standard deviation of a wrist reading [N, N·m], (6,)."""
    delay: float
    """From a measurement to the moment when its command acts, in control periods."""
    jitter: float
    """Extra delay of each command, uniform in [0, jitter] control periods."""
    period_jitter: float
    """Each period is off by a uniform share of ± this."""
    mould_shift: Array
    """True minus nominal position of the mould [m], (3,)."""
    mould_turn: Array
    """Rotation vector from the nominal to the true mould, about its origin [rad], (3,)."""
    seed: int
    """Seed of the draws and of the noise."""
    payload: float = 0.0
    """Mass that hangs at the tool frame [kg], a point."""

    def sensor_errors(self) -> Iterator[Array]:
        """Bias and noise of one reading after the other: of the torque sensors, then of the wrist sensor, (n + 6,)."""
        rng = np.random.default_rng([self.seed, 8])
        bias = np.concatenate([self.torque_bias, self.wrench_bias])
        spread = np.concatenate([np.full(len(self.torque_bias), self.torque_noise), self.wrench_noise])
        while True:
            yield from bias + spread * rng.standard_normal((READINGS, len(bias)))

    def clock_errors(self) -> Iterator[float]:
        """Shares of the jitters, one for each period and each command, uniform in [0, 1)."""
        rng = np.random.default_rng([self.seed, 7])
        while True:
            yield from rng.random(READINGS).tolist()

    @classmethod
    def ideal(cls, n: int = 6, seed: int = 0) -> Plant:
        """Links only, no friction, exact sensors, no delay, the mould where it was drawn."""
        none = np.zeros(n)
        return cls(
            friction=Friction(coulomb=none, viscous=none),
            armature=none,
            mass_scale=np.ones(n + 1),
            encoder_counts=None,
            torque_bias=none,
            torque_noise=0.0,
            wrench_bias=np.zeros(6),
            wrench_noise=np.zeros(6),
            delay=0.0,
            jitter=0.0,
            period_jitter=0.0,
            mould_shift=np.zeros(3),
            mould_turn=np.zeros(3),
            seed=seed,
        )

    @classmethod
    def honest(cls, friction: Friction, armature: Array, seed: int) -> Plant:
        """Nominal gears drawn ±30 % a joint, biased sensors, late commands, wrong masses, a moved mould.

        Args:
            friction: nominal Coulomb and viscous friction.
            armature: nominal rotor inertia [kg·m²], (n,).
            seed: of every draw.
        """
        rng = np.random.default_rng(seed)
        n = len(armature)

        def spread(share: float, size: int = n) -> Array:
            return rng.uniform(1.0 - share, 1.0 + share, size)

        def within(radius: float, axes: Array) -> Array:
            direction = rng.normal(size=3) * axes
            return rng.uniform(0.0, radius) * direction / np.linalg.norm(direction)

        return cls(
            friction=Friction(coulomb=friction.coulomb * spread(0.3), viscous=friction.viscous * spread(0.3)),
            armature=armature * spread(0.3),
            mass_scale=spread(0.1, n + 1),
            encoder_counts=ENCODER_COUNTS,
            torque_bias=rng.uniform(-0.4, 0.4, n),
            torque_noise=0.02,
            wrench_bias=rng.uniform(-1.0, 1.0, 6) * np.array([2.0, 2.0, 2.0, 0.1, 0.1, 0.1]),
            wrench_noise=np.array([0.05, 0.05, 0.05, 0.002, 0.002, 0.002]),
            delay=1.0,
            jitter=0.2,
            period_jitter=0.05,
            mould_shift=within(0.002, np.ones(3)),
            mould_turn=within(np.deg2rad(2.0), np.array([1.0, 1.0, 0.0])),
            seed=seed,
        )
