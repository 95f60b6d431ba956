"""Thesis B's gains, table by table, its laws with them, and the arms and models that they are tried on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from burnish.control import (
    Hybrid,
    HybridNullSpace,
    Impedance,
    InertiaShapingImpedance,
    RedundantImpedance,
    TaskComputedTorque,
)
from burnish.core import Array, Source
from burnish.experiments.operator import DURATION, operator_motion
from burnish.model.model import Model
from burnish.rotation import quaternion_error
from burnish.sim.arms import Arm, ideal
from burnish.trials.experiment import Trial


@dataclass(frozen=True, kw_only=True)
class TaskTable:
    """Gains of x, y, z, about x, about y, about z."""

    k: tuple[float, ...]
    """K [N/m, N·m]: the thesis's orientation error is sin(θ/2), so that half of it acts on a small angle; [1/s²] in a
    computed torque."""
    d: tuple[float, ...]
    """D [N·s/m, N·m·s]; [1/s] in a computed torque."""

    @property
    def small_angle_stiffness(self) -> Array:
        """K per metre and per radian, (6,)."""
        stiffness: Array = np.asarray(self.k) * np.repeat([1.0, 0.5], 3)
        return stiffness


@dataclass(frozen=True, kw_only=True)
class HybridTable:
    """Gains of the position along x, y, z, and of the orientation joint by joint."""

    k: tuple[float, ...]
    """K [N/m]."""
    d: tuple[float, ...]
    """D [N·s/m]."""
    k1: tuple[float, ...]
    """K_1 [1/s]."""
    kp: tuple[float, ...]
    """K_p of the joint speeds [1/s]."""
    kd: tuple[float, ...]
    """K_d of the joint speeds."""


TABLE_5_1_FREQUENCY = (35.0, 10.0, 15.0, 35.0, 30.0, 40.0)
"""ω_n of the joints [rad/s]."""
TABLE_5_1_INTEGRAL = (0.005, 0.005, 0.005, 0.015, 0.005, 0.025)
"""K_i of the joints [1/s³]."""
TABLE_5_2 = TaskTable(k=(300, 300, 450, 350, 350, 350), d=(50, 50, 50, 20, 20, 20))
TABLE_5_3 = TaskTable(k=(100, 100, 200, 20, 20, 20), d=(20, 20, 20, 2, 2, 2))
TABLE_5_4 = TaskTable(k=(200, 200, 350, 180, 180, 180), d=(24, 24, 24, 3, 3, 3))
TABLE_5_5 = TaskTable(k=(200, 200, 400, 180, 180, 180), d=(24, 24, 24, 3.5, 3.5, 3.5))
TABLE_5_6 = HybridTable(k=(600, 600, 600), d=(22, 22, 22), k1=(5, 5, 5, 25, 25, 25), kp=(10,) * 6, kd=(0.02,) * 6)
TABLE_5_7 = HybridTable(k=(200, 200, 400), d=(22, 22, 22), k1=(5, 5, 5, 30, 30, 30), kp=(10,) * 6, kd=(0,) * 6)
TABLE_5_8_KP = (200.0, 300.0, 300.0, 30.0, 30.0, 30.0)
"""K_p of the joints: [1/s²] of the first three, [N·m/rad] of the others."""
TABLE_5_8_KD = (20.0, 20.0, 20.0, 5.0, 5.0, 5.0)
"""K_d of the joints: [1/s], [N·m·s/rad]."""
TABLE_5_9 = TaskTable(k=(200, 200, 200, 150, 150, 150), d=(24, 24, 24, 6, 6, 6))
TABLE_5_10 = TaskTable(k=(200, 200, 200, 25, 25, 25), d=(10, 10, 10, 1.5, 1.5, 1.5))
TABLE_5_11 = TaskTable(k=(150, 150, 150, 15, 15, 15), d=(22, 22, 22, 0.1, 0.1, 0.1))
TABLE_5_12 = TaskTable(k=(150, 150, 150, 20, 20, 20), d=(22, 22, 22, 0.1, 0.1, 0.1))
TABLE_5_13 = HybridTable(k=(500, 500, 500), d=(10, 10, 10), k1=(5, 5, 5, 25, 25, 25), kp=(10,) * 6, kd=(0.3,) * 6)
TABLE_5_14 = HybridTable(k=(150, 150, 150), d=(10, 10, 10), k1=(5, 5, 5, 25, 25, 25), kp=(7.5,) * 6, kd=(0,) * 6)

HAND_INERTIA = 0.1
"""What `enhanced` adds to the hand's inertia about every axis [kg·m²]. The thesis enlarges the last link's inertia and
does not say by how much; this is a choice, of the size of the wrist's rotors."""
MENDING_ARMATURE = 0.005
"""Rotor inertia of joints 4 to 6 [kg·m²] with which D = 3.5 N·m·s is stable at 1 kHz: more than D dt/2 = 0.00175."""


def task_computed_torque(table: TaskTable) -> TaskComputedTorque:
    """Thesis B, 4.2."""
    return TaskComputedTorque(kp=table.k, kd=table.d, orientation_error=quaternion_error)


def impedance(table: TaskTable) -> Impedance:
    """Thesis B, 4.3.1."""
    return Impedance(stiffness=table.k, damping=table.d, orientation_error=quaternion_error)


def force_sensing(table: TaskTable) -> InertiaShapingImpedance:
    """Thesis B, 4.3.2."""
    return InertiaShapingImpedance(stiffness=table.k, damping=table.d, orientation_error=quaternion_error)


def redundant(table: TaskTable) -> RedundantImpedance:
    """Thesis B, 4.3.3."""
    return RedundantImpedance(stiffness=table.k, damping=table.d, orientation_error=quaternion_error)


def hybrid(table: HybridTable) -> Hybrid:
    """Thesis B, 4.4."""
    return Hybrid(**_hybrid_gains(table))


def hybrid_null_space(table: HybridTable) -> HybridNullSpace:
    """Thesis B, 4.4.1."""
    return HybridNullSpace(**_hybrid_gains(table))


@cache
def enhanced() -> Model:
    """What the thesis's laws know: the links, and a hand that is harder to turn than it is."""
    return Model.jaco2().with_payload(1e-6, inertia=HAND_INERTIA * np.eye(3))


def mended() -> Arm:
    """The ideal arm with a little rotor inertia in the wrist, which its controller knows."""
    arm, armature = ideal(0), np.repeat([0.0, MENDING_ARMATURE], 3)
    return replace(arm, plant=replace(arm.plant, armature=armature), armature=armature)


def operated(name: str, law: Any, arm: Arm, model: Model, *, ours: bool = False) -> Trial:
    """A law along the operator's motion."""
    source: Source[Any] = operator_motion()
    return Trial(name=name, law=law, source=source, duration=DURATION, arm=arm, model=model, ours=ours)


def _hybrid_gains(table: HybridTable) -> dict[str, Any]:
    names: Sequence[str] = ("stiffness", "damping", "turn_rate", "speed_gain", "speed_rate_gain")
    gains = (table.k, table.d, table.k1, table.kp, table.kd)
    return dict(zip(names, gains, strict=True)) | {"orientation_error": quaternion_error}
