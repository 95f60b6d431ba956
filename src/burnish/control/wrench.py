"""What the tool feels: the contact wrench from a wrist sensor or from joint torques, tared in free air."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from burnish.core import Array, Dynamics, State
from burnish.errors import InputError

GRAVITY = 9.81


class ContactSense(Protocol):
    """Turns a measured state into the contact wrench on the tool."""

    def feel(self, arm: Dynamics, state: State) -> Dynamics:
        """``arm`` with F, the contact wrench [N, N·m], base axes about the tool point."""

    def tare(self, readings: list[tuple[Dynamics, State]]) -> None:
        """Take the mean of these readings, made in free air, as no contact."""


@dataclass(kw_only=True)
class NoSense:
    """An arm that feels nothing: F stays None."""

    def feel(self, arm: Dynamics, state: State) -> Dynamics:
        """``arm`` as it is."""
        return arm

    def tare(self, readings: list[tuple[Dynamics, State]]) -> None:
        """Nothing to tare."""


@dataclass(kw_only=True)
class WristSense:
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
class JointSense:
    """Contact wrench from tared joint torque sensors.

    The sensors sit behind the gears, so friction does not reach them: τ_s = M q̈ + h + g − Jᵀ F, with M of the links
    alone. At polishing speeds M q̈ is small against the sensors' noise and is left out; then
    ``F = J⁻ᵀ (h + g + bias − τ_s)`` through a first-order low pass.
    """

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

    @staticmethod
    def _residual(arm: Dynamics, state: State) -> Array:
        if state.tau is None:
            raise InputError("this arm has no joint torque sensors; use a wrist sensor (--sensor wrist)")
        return np.asarray(state.tau - arm.h - arm.g)
