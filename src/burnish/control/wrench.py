"""What the tool feels: the contact wrench from a wrist sensor or from joint torques, tared in free air."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf, sqrt
from typing import Protocol

import numpy as np

from burnish.core import Array, Dynamics, State
from burnish.errors import InputError

GRAVITY = 9.81
SIGMAS = 3.0
"""A force along a direction is a touch from so many standard deviations of the tared noise on."""
SETTLED = 1.0 / 3.0
"""Share of the readings of a tare at its start in which a filter still settles; they do not count as noise."""


class ContactSense(Protocol):
    """Turns a measured state into the contact wrench on the tool."""

    def feel(self, arm: Dynamics, state: State) -> Dynamics:
        """``arm`` with F, the contact wrench [N, N·m], base axes about the tool point."""

    def tare(self, readings: list[tuple[Dynamics, State]]) -> None:
        """Take the mean of these readings, made in free air one after the other, as no contact; learn their noise."""

    def noise(self, direction: Array) -> float:
        """Standard deviation of the felt force along a unit vector, base axes, as the last tare found it [N]."""

    def touch_threshold(self, direction: Array) -> float:
        """Force along a unit vector that counts as a touch when two samples in a row are above it [N]."""


@dataclass(kw_only=True)
class NoSense:
    """An arm that feels nothing: F stays None."""

    def feel(self, arm: Dynamics, state: State) -> Dynamics:
        """``arm`` as it is."""
        return arm

    def tare(self, readings: list[tuple[Dynamics, State]]) -> None:
        """Nothing to tare."""

    def noise(self, direction: Array) -> float:
        """None."""
        return 0.0

    def touch_threshold(self, direction: Array) -> float:
        """Nothing is ever a touch."""
        return inf


@dataclass(kw_only=True)
class TaredNoise:
    """The noise of a sense, learnt where it was tared, and the touch that follows: ``max(3σ, least_touch)``."""

    least_touch: float
    """Least threshold of a touch [N]: what noise does not tell, as errors of the model along an approach."""
    _spread: Array = field(default_factory=lambda: np.zeros((3, 3)), init=False, repr=False)

    def noise(self, direction: Array) -> float:
        """Standard deviation of the felt force along a unit vector, base axes [N]; 0 before the first tare."""
        return sqrt(float(direction @ self._spread @ direction))

    def touch_threshold(self, direction: Array) -> float:
        """Force along a unit vector that counts as a touch when two samples in a row are above it [N]."""
        return max(SIGMAS * self.noise(direction), self.least_touch)

    def _learn(self, felt: Sequence[Dynamics]) -> None:
        """Take the covariance of what was felt in free air as the noise."""
        forces = np.array([arm.F[:3] for arm in felt[int(SETTLED * len(felt)) :] if arm.F is not None])
        self._spread = np.cov(forces, rowvar=False, bias=True)


@dataclass(kw_only=True)
class WristSense(TaredNoise):
    """Contact wrench from a wrist sensor: its reading less the tool's weight and a tared bias.

    F = T (reading − bias − weight(R)) with T to base axes and to the tool point. The sensor's axes are the tool
    frame's, its origin lies ``offset`` behind the tool point.
    """

    mass: float
    """Nominal mass beyond the sensor [kg]."""
    com: float
    """Nominal distance of its centre of mass from the sensor, along the tool's z axis [m]."""
    offset: float
    """Distance from the sensor to the tool point, along the tool's z axis [m]."""
    least_touch: float = 0.5
    """[N]: the tool's weight, 10 % wrong, as it starts to move and turns by some degrees, and the sensor's drift."""
    _bias: Array = field(default_factory=lambda: np.zeros(6), init=False, repr=False)

    def feel(self, arm: Dynamics, state: State) -> Dynamics:
        """``arm`` with F.

        Raises:
            InputError: if the robot has no wrist sensor.
        """
        wrench = self._reading(state) - self._bias - self._weight(arm)
        # Moment about the tool point: less offset·z × force.
        wrench[3] += self.offset * wrench[1]
        wrench[4] -= self.offset * wrench[0]
        # Force and moment as the two rows, turned into base axes.
        return arm.feeling(wrench.reshape(2, 3).dot(arm.R.T).ravel())

    def tare(self, readings: list[tuple[Dynamics, State]]) -> None:
        """Mean of reading − weight, in free air, becomes the bias."""
        self._bias = np.mean([self._reading(state) - self._weight(arm) for arm, state in readings], axis=0)
        self._learn([self.feel(arm, state) for arm, state in readings])

    def _weight(self, arm: Dynamics) -> Array:
        """Weight of the tool in sensor axes, about the sensor's origin [N, N·m], (6,)."""
        x, y, z = arm.R[2].tolist()
        weight = -GRAVITY * self.mass
        lever = self.com * weight
        return np.array((weight * x, weight * y, weight * z, -lever * y, lever * x, 0.0))

    @staticmethod
    def _reading(state: State) -> Array:
        if state.F is None:
            raise InputError("this arm has no wrist sensor; use joint torques (--sensor joint) or fit one")
        return state.F


@dataclass(kw_only=True)
class JointSense(TaredNoise):
    """Contact wrench from tared joint torque sensors, of an arm whose rotor inertia is not known.

    The sensors sit behind the gears, so friction does not reach them: τ_s = M q̈ + h + g − Jᵀ F, with M of the links
    alone. At polishing speeds M q̈ is small against the sensors' noise and is left out; then
    ``F = J⁻ᵀ (h + g + bias − τ_s)`` through a first-order low pass. With the rotor inertia `MomentumSense` keeps it in.
    """

    least_touch: float = 1.5
    """[N]: about three times what M q̈ of a starting and stopping honest arm showed in free air, at most 0.55 N."""
    time_constant: float = 0.03
    """Of the low pass [s]."""
    _bias: Array | None = field(default=None, init=False, repr=False)
    _torque: Array | None = field(default=None, init=False, repr=False)
    _t: float = field(default=0.0, init=False, repr=False)

    def feel(self, arm: Dynamics, state: State) -> Dynamics:
        """``arm`` with F.

        Raises:
            InputError: if the robot has no joint torque sensors.
        """
        residual = self._residual(arm, state)
        if self._bias is not None:
            residual = residual - self._bias
        if self._torque is None:
            self._torque = residual
        else:
            share = 1.0 - np.exp(-(arm.t - self._t) / self.time_constant)
            self._torque = self._torque + share * (residual - self._torque)
        self._t = arm.t
        # Jᵀ F = −(τ_s − h − g): the wrench that these joint torques hold, by the Λ-weighted inverse.
        return arm.feeling(-(arm.J_bar.T @ self._torque))

    def tare(self, readings: list[tuple[Dynamics, State]]) -> None:
        """Mean residual in free air becomes the bias: sensor offsets and errors of the gravity model there."""
        self._bias = np.mean([self._residual(arm, state) for arm, state in readings], axis=0)
        self._torque = None
        self._learn([self.feel(arm, state) for arm, state in readings])
        self._torque = None

    @staticmethod
    def _residual(arm: Dynamics, state: State) -> Array:
        return np.asarray(link_torque(state) - arm.h - arm.g)


def link_torque(state: State) -> Array:
    """Measured joint torques [N·m], (n,).

    Raises:
        InputError: if the robot has no joint torque sensors.
    """
    if state.tau is None:
        raise InputError("this arm has no joint torque sensors; use a wrist sensor (--sensor wrist)")
    return state.tau
