"""Time to a reference: things that stand still, cubic motions, sines, and paths over a surface."""

from burnish.trajectory.cubic import Cubic, CubicPose
from burnish.trajectory.descend import Descend
from burnish.trajectory.hold import Hold, HoldPose
from burnish.trajectory.path import SurfacePath, TimedPath
from burnish.trajectory.sine import Sine

__all__ = ["Cubic", "CubicPose", "Descend", "Hold", "HoldPose", "Sine", "SurfacePath", "TimedPath"]
