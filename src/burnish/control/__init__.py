"""A reference to a torque: the control laws; `wrench` says what the tool feels.

The public face gives one name to two things: ``burnish.control`` is this folder of laws, and ``control(rig, source,
law)`` from ``burnish`` is the loop. So the folder can be called, and then is the loop.
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import Any

from burnish.control.adaptive import Adaptive
from burnish.control.force import ForceMotion
from burnish.control.gains import DampingRatio as DampingRatio
from burnish.control.gears import LearntFriction as LearntFriction
from burnish.control.hybrid import Hybrid, HybridNullSpace
from burnish.control.impedance import Impedance, InertiaShapingImpedance, RedundantImpedance
from burnish.control.joint import ComputedTorque, GravityCompensation
from burnish.control.nullspace import DynamicNullSpace, GeometricNullSpace, PostureReference
from burnish.control.observer import MomentumSense as MomentumSense
from burnish.control.operational import OperationalSpace
from burnish.control.secondary import LimitAvoidance as LimitAvoidance
from burnish.control.secondary import Posture as Posture
from burnish.control.task import JacobianTranspose, TaskComputedTorque
from burnish.control.velocity import CartesianVelocity
from burnish.control.wrench import JointSense as JointSense
from burnish.control.wrench import WristSense as WristSense

__all__ = [
    "Adaptive",
    "CartesianVelocity",
    "ComputedTorque",
    "DynamicNullSpace",
    "ForceMotion",
    "GeometricNullSpace",
    "GravityCompensation",
    "Hybrid",
    "HybridNullSpace",
    "Impedance",
    "InertiaShapingImpedance",
    "JacobianTranspose",
    "OperationalSpace",
    "PostureReference",
    "RedundantImpedance",
    "TaskComputedTorque",
]


class _LawsAndLoop(ModuleType):
    def __call__(self, *arguments: Any, **named: Any) -> Any:
        return import_module("burnish.runtime.loop").control(*arguments, **named)


sys.modules[__name__].__class__ = _LawsAndLoop
