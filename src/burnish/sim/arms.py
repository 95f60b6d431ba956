"""The simulated arms that burnish ships: ideal, honest, and honest with stiff gears."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from burnish.core import Array
from burnish.model.friction import Friction
from burnish.model.model import urdf_estimates
from burnish.sim.plant import Plant


@dataclass(frozen=True, kw_only=True)
class Arm:
    """A drawn plant, and the nominal figures that its controller may know."""

    plant: Plant
    """What the arm really is."""
    friction: Friction | None
    """Nominal joint friction; None for an arm without."""
    armature: Array
    """Nominal rotor inertia [kg·m²], (n,)."""
    rate: float
    """Rate at which this arm is driven unless asked otherwise [Hz]."""
    delay: float
    """Nominal time from a measurement to its command's effect, in control periods."""


def ideal(seed: int) -> Arm:
    """The model itself: links only, no friction, exact sensors, 1 kHz."""
    plant = Plant.ideal(seed=seed)
    return Arm(plant=plant, friction=None, armature=plant.armature, rate=1000.0, delay=0.0)


def honest(seed: int) -> Arm:
    """Coulomb friction of 1.0 and 0.4 N·m (joints 1–3 and 4–6), and all the other errors of `Plant.honest`."""
    return _honest(seed, np.repeat([1.0, 0.4], 3))


def honest_stiff(seed: int) -> Arm:
    """`honest` with the Coulomb friction that the data sheet's backdriving torque suggests: 2.0 and 1.0 N·m."""
    return _honest(seed, np.repeat([2.0, 1.0], 3))


def _honest(seed: int, coulomb: Array) -> Arm:
    armature, estimate = urdf_estimates()
    friction = replace(estimate, coulomb=coulomb)
    plant = Plant.honest(friction, armature, seed)
    return Arm(plant=plant, friction=friction, armature=armature, rate=100.0, delay=1.0)
