"""The laws that the comparison lets follow the operator, with the theses' gains and with ours."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from burnish.control import (
    CartesianVelocity,
    ComputedTorque,
    DynamicNullSpace,
    GeometricNullSpace,
    JacobianTranspose,
    PostureReference,
)
from burnish.core import Controller
from burnish.experiments import a_table_5_3, ours, thesis_a, thesis_b
from burnish.experiments.b_5_2_1 import PartlyComputedTorque
from burnish.model.model import Model
from burnish.sim.arms import Arm
from burnish.trials.experiment import links_only


@cache
def _links() -> Model:
    return links_only()


@dataclass(frozen=True, kw_only=True)
class Contender:
    """A law with the gains of a thesis's robot, and with ours."""

    name: str
    """Of the law."""
    thesis: str = ""
    """A or B; empty where neither has the law."""
    theirs: Callable[[], Controller[Any]] | None = None
    """With the gains of the robot of that thesis; None where there are none."""
    model: Callable[[], Model] = _links
    """What the thesis's law knew."""
    ours: Callable[[Arm], Controller[Any]] | None = None
    """With our gains for an arm; None where the law is not worth having."""
    joints: bool = False
    """Whether it follows the joints."""


HYBRIDS = ("Hybrid", "HybridNullSpace")
"""The laws of thesis B that keep position and orientation apart."""
PLAIN = ("Impedance", "InertiaShapingImpedance", "RedundantImpedance")
"""Those that do not."""
BETTER = "OperationalSpace"
"""The law that is to be better than all of them."""


def _posture(arm: Arm) -> PostureReference:
    speed, kp, ki = (300.0, 120.0, 600.0) if arm.friction is None else (30.0, 7.0, 10.0)
    return PostureReference(
        speed_gain=speed,
        position_kp=kp,
        orientation_kp=kp,
        position_ki=ki,
        orientation_ki=ki,
        position_kd=1.0,
        orientation_kd=1.0,
    )


def _velocity(arm: Arm) -> CartesianVelocity:
    speed, ki = (100.0, 0.0) if arm.friction is None else (25.0, 150.0)
    return CartesianVelocity(speed_gain=speed, integral_gain=ki)


TRANSPOSE_IDEAL: dict[str, Any] = {
    "stiffness": (4000.0, 7.0),
    "integral_stiffness": (5000.0, 7.0),
    "damping": (110.0, 0.5),
}
"""Of the laws by the transposed Jacobian, for this motion and links alone: as much as the wrist bears at 1 kHz."""


def _transpose_gains(arm: Arm) -> dict[str, Any]:
    return TRANSPOSE_IDEAL if arm.friction is None else thesis_a.OURS_HONEST


CONTENDERS = (
    Contender(
        name="ComputedTorque",
        thesis="A",
        theirs=lambda: ComputedTorque(kp=a_table_5_3.KP, kd=a_table_5_3.KD),
        ours=ours.computed_torque,
        joints=True,
    ),
    Contender(
        name="ComputedTorque, M in part",
        thesis="B",
        theirs=lambda: PartlyComputedTorque(kp=np.array(thesis_b.TABLE_5_8_KP), kd=np.array(thesis_b.TABLE_5_8_KD)),
        joints=True,
    ),
    Contender(
        name="PostureReference",
        thesis="A",
        theirs=lambda: PostureReference(
            speed_gain=(60.5, 70.5, 87.5, 90.0, 90.0, 600.0),
            position_kp=80.0,
            orientation_kp=25.0,
            position_ki=20.0,
            orientation_ki=10.0,
            position_kd=5.0,
            orientation_kd=3.5,
        ),
        ours=_posture,
    ),
    Contender(
        name="JacobianTranspose",
        thesis="A",
        theirs=lambda: JacobianTranspose(**thesis_a.TABLE_5_2),
        ours=lambda arm: JacobianTranspose(**_transpose_gains(arm)),
    ),
    Contender(
        name="GeometricNullSpace",
        thesis="A",
        theirs=lambda: GeometricNullSpace(**thesis_a.TABLE_5_2),
        ours=lambda arm: GeometricNullSpace(**_transpose_gains(arm)),
    ),
    Contender(
        name="DynamicNullSpace",
        thesis="A",
        theirs=lambda: DynamicNullSpace(**thesis_a.TABLE_5_2),
        ours=lambda arm: DynamicNullSpace(**_transpose_gains(arm)),
    ),
    Contender(
        name="TaskComputedTorque",
        thesis="B",
        theirs=lambda: thesis_b.task_computed_torque(thesis_b.TABLE_5_9),
        model=thesis_b.enhanced,
        ours=ours.task_computed_torque,
    ),
    Contender(
        name="Impedance",
        thesis="B",
        theirs=lambda: thesis_b.impedance(thesis_b.TABLE_5_10),
        model=thesis_b.enhanced,
        ours=ours.impedance,
    ),
    Contender(
        name="InertiaShapingImpedance",
        thesis="B",
        theirs=lambda: thesis_b.force_sensing(thesis_b.TABLE_5_11),
        model=thesis_b.enhanced,
        ours=ours.force_sensing,
    ),
    Contender(
        name="RedundantImpedance",
        thesis="B",
        theirs=lambda: thesis_b.redundant(thesis_b.TABLE_5_12),
        model=thesis_b.enhanced,
        ours=ours.redundant,
    ),
    Contender(
        name="Hybrid",
        thesis="B",
        theirs=lambda: thesis_b.hybrid(thesis_b.TABLE_5_13),
        model=thesis_b.enhanced,
        ours=ours.hybrid,
    ),
    Contender(
        name="HybridNullSpace",
        thesis="B",
        theirs=lambda: thesis_b.hybrid_null_space(thesis_b.TABLE_5_14),
        model=thesis_b.enhanced,
        ours=ours.hybrid_null_space,
    ),
    Contender(name="CartesianVelocity", ours=_velocity),
    Contender(name=BETTER, ours=ours.operational_space),
)
