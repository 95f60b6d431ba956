"""burnish: operational-space force control for robot arms, honest simulation, and surface finishing.

The names below are loaded when they are first used, so that ``import burnish`` and ``burnish --help`` stay quick.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from burnish.control import ComputedTorque, ForceMotion, GravityCompensation, JointSense, WristSense
    from burnish.core import Dynamics, JointReference, Sample, State, ToolReference, Torque
    from burnish.errors import BurnishError
    from burnish.hardware.jaco2 import Jaco2
    from burnish.hardware.torque_mode import TorqueSetup
    from burnish.model.friction import Friction
    from burnish.model.ik import inverse_kinematics
    from burnish.model.model import Model
    from burnish.model.tool import PolishingTool
    from burnish.runtime.loop import Rig, control
    from burnish.runtime.supervisor import Limits, Supervisor
    from burnish.sim.robot import SimRobot
    from burnish.trajectory import Cubic, CubicPose, Hold, HoldPose, Sine

__version__ = "0.1.0"

_HOMES = {
    "BurnishError": "errors",
    "ComputedTorque": "control",
    "Cubic": "trajectory",
    "CubicPose": "trajectory",
    "Dynamics": "core",
    "ForceMotion": "control",
    "Friction": "model.friction",
    "GravityCompensation": "control",
    "Hold": "trajectory",
    "HoldPose": "trajectory",
    "Jaco2": "hardware.jaco2",
    "JointReference": "core",
    "JointSense": "control",
    "Limits": "runtime.supervisor",
    "Model": "model.model",
    "PolishingTool": "model.tool",
    "Rig": "runtime.loop",
    "Sample": "core",
    "SimRobot": "sim.robot",
    "Sine": "trajectory",
    "State": "core",
    "Supervisor": "runtime.supervisor",
    "ToolReference": "core",
    "Torque": "core",
    "TorqueSetup": "hardware.torque_mode",
    "WristSense": "control",
    "control": "control",
    "inverse_kinematics": "model.ik",
}

__all__ = [
    "BurnishError",
    "ComputedTorque",
    "Cubic",
    "CubicPose",
    "Dynamics",
    "ForceMotion",
    "Friction",
    "GravityCompensation",
    "Hold",
    "HoldPose",
    "Jaco2",
    "JointReference",
    "JointSense",
    "Limits",
    "Model",
    "PolishingTool",
    "Rig",
    "Sample",
    "SimRobot",
    "Sine",
    "State",
    "Supervisor",
    "ToolReference",
    "Torque",
    "TorqueSetup",
    "WristSense",
    "control",
    "inverse_kinematics",
]


def __getattr__(name: str) -> Any:
    """Load a public name from its home."""
    if name not in _HOMES:
        raise AttributeError(f"module 'burnish' has no attribute '{name}'")
    home = import_module(f"burnish.{_HOMES[name]}")
    value = home if name == "control" else getattr(home, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
