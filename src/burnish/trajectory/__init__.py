"""Time to a reference: things that stand still, cubic motions, sines, an operator's moves, and paths over a surface."""

from burnish.trajectory.cubic import Cubic, CubicPose
from burnish.trajectory.descend import Descend
from burnish.trajectory.euler import EulerCubic
from burnish.trajectory.hold import Hold, HoldPose
from burnish.trajectory.move import Move
from burnish.trajectory.path import SurfacePath, TimedPath
from burnish.trajectory.schedule import Schedule
from burnish.trajectory.sine import Sine

__all__ = [
    "Cubic",
    "CubicPose",
    "Descend",
    "EulerCubic",
    "Hold",
    "HoldPose",
    "Move",
    "Schedule",
    "Sine",
    "SurfacePath",
    "TimedPath",
]
