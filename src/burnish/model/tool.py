"""`PolishingTool`: a felt tip on a spring behind a wrist force sensor; its numbers for model and simulator alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from burnish.core import Array
from burnish.errors import InputError
from burnish.model.model import Model
from burnish.model.spin import SpinningTip

TIP_FRAME = "tip"


@dataclass(frozen=True, kw_only=True)
class PolishingTool:
    """A tool held in the arm's tool frame: sensor, body, and a spherical felt tip that slides along z on a spring.

    All lengths are along the tool's z axis, which points out of the arm towards the work.
    """

    body_mass: float = 0.30
    """Mass beyond the sensor without the tip [kg]; sensor plate, handle and guide, a design value."""
    body_com: float = 0.035
    """Distance of the body's centre of mass from the sensor [m]."""
    body_radius: float = 0.018
    """Radius of the body, a solid cylinder for its inertia and for looks [m]."""
    tip_mass: float = 0.05
    """Mass of the felt tip and its slider [kg]."""
    tip_radius: float = 0.020
    """Radius of the spherical felt tip [m]."""
    length: float = 0.11
    """Distance from the sensor to the apex of the unloaded tip [m]."""
    stiffness: float = 12e3
    """Stiffness of the tip's spring [N/m]; the useful range is 10–30 kN/m: softer loses track, harder bounces."""
    damping_ratio: float = 0.3
    """Damping ratio of the tip on its spring."""
    modulus: float = 2e6
    """Effective contact modulus E* of felt on steel [Pa]; sets the width of a track. A typical value, not measured."""
    friction: float = 0.3
    """Coulomb friction of felt on the work-piece; a typical value, not measured."""
    spindle: float = 0.0
    """Speed of the tip about the tool's z axis, right-handed [rad/s]; 0 does not spin."""

    def __post_init__(self) -> None:
        if not np.isfinite(self.spindle):
            raise InputError(f"PolishingTool: spindle = {self.spindle}; expected a finite number of rad/s")
        for name, value in vars(self).items():
            if name != "spindle" and not (np.isfinite(value) and value > 0.0):
                raise InputError(f"PolishingTool: {name} = {value}; expected a finite number more than 0")

    @property
    def mass(self) -> float:
        """Everything beyond the sensor [kg]."""
        return self.body_mass + self.tip_mass

    @property
    def tip_centre(self) -> float:
        """Distance from the sensor to the centre of the unloaded tip [m]."""
        return self.length - self.tip_radius

    @property
    def com(self) -> float:
        """Distance of the centre of mass of body and tip from the sensor [m]."""
        return (self.body_mass * self.body_com + self.tip_mass * self.tip_centre) / self.mass

    @property
    def damping(self) -> float:
        """Damping of the tip on its spring [N·s/m]."""
        return float(2.0 * self.damping_ratio * np.sqrt(self.stiffness * self.tip_mass))

    @property
    def body_inertia(self) -> Array:
        """Principal inertia of the body about its centre of mass, (3,) [kg·m²]: a cylinder of twice com's height."""
        height = 2.0 * self.body_com
        across = self.body_mass * (3.0 * self.body_radius**2 + height**2) / 12.0
        return np.array([across, across, 0.5 * self.body_mass * self.body_radius**2])

    @property
    def tip_inertia(self) -> Array:
        """Principal inertia of the tip about its centre, a solid sphere, (3,) [kg·m²]."""
        return np.full(3, 0.4 * self.tip_mass * self.tip_radius**2)

    @property
    def spinning(self) -> SpinningTip | None:
        """The tip with its spindle; None if it does not spin."""
        if self.spindle == 0.0:
            return None
        return SpinningTip(spindle=self.spindle, friction=self.friction, radius=self.tip_radius, modulus=self.modulus)

    def on(self, model: Model) -> Model:
        """The model with this tool in its tool frame: both masses, and the tool frame ``tip`` at the apex."""
        with_body = model.with_payload(self.body_mass, (0.0, 0.0, self.body_com), np.diag(self.body_inertia))
        with_tip = with_body.with_payload(self.tip_mass, (0.0, 0.0, self.tip_centre), np.diag(self.tip_inertia))
        return with_tip.with_tool(TIP_FRAME, (0.0, 0.0, self.length))
