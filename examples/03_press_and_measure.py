"""Come down on a plate, press at three forces, and compare the wrist sensor with the true contact force.

The honest arm starts 8 mm above a plate that is not exactly where it should be. All of it is simulated.
"""

from dataclasses import dataclass

import numpy as np

from burnish import (
    Dynamics,
    ForceMotion,
    HoldPose,
    Limits,
    Model,
    PolishingTool,
    Rig,
    SimRobot,
    Supervisor,
    ToolReference,
    WristSense,
    control,
)
from burnish.analysis.metrics import rms
from burnish.model.ik import inverse_kinematics
from burnish.polish.cell import READY, nominal_placement, tool_down
from burnish.sim import arms
from burnish.sim.scene import Workpiece
from burnish.surface import DistanceGrid, Mould
from burnish.trajectory import Descend

UP = np.array([0.0, 0.0, 1.0])


@dataclass
class Press:
    """A source: stay where the tool is at `reset`, and press along −z with a force [N]."""

    force: float

    def reset(self, arm: Dynamics) -> None:
        self.p, self.R = arm.p, arm.R

    def at(self, arm: Dynamics) -> ToolReference:
        return ToolReference(p=self.p, R=self.R, v=np.zeros(6), a=np.zeros(6), normal=UP, force=self.force)


def main() -> None:
    arm, tool = arms.honest(1), PolishingTool()
    model = tool.on(Model.jaco2()).with_armature(arm.armature)
    placement = nominal_placement(top=20e-3)
    middle = placement.p + 20e-3 * UP
    start = inverse_kinematics(model, middle + 8e-3 * UP, tool_down(model), READY)
    plate = Workpiece(grid=DistanceGrid.of(Mould.load("plate")), p=placement.p, R=placement.R)
    robot = SimRobot(start, rate=arm.rate, plant=arm.plant, tool=tool, workpiece=plate)
    sense = WristSense(mass=tool.mass, com=tool.com, offset=tool.length)
    rig = Rig(robot, model, Supervisor(limits=Limits.of(model)), sense)
    law = ForceMotion(friction=arm.friction)

    def drive(source, seconds: float, touched: float = np.inf) -> list[float]:
        """Run a behaviour for some time, or until it touches; the felt forces along z [N]."""
        end = robot.time + seconds
        samples = control(rig, source, law, until=lambda now: now.t >= end or now.F[2] > touched)
        return [float(sample.arm.F[2]) for sample in samples]

    with robot:
        drive(HoldPose(), 0.5)
        sense.tare([(rig.arm, rig.state)])  # what is felt in free air counts as nothing
        rig.feel()
        drive(Descend(direction=-UP, R=rig.arm.R, speed=5e-3), 4.0, touched=0.8)
        print(f"touched {1e3 * (rig.arm.p[2] - middle[2]):+.2f} mm above where the plate is meant to be")
        print("wanted [N]   felt [N]   true [N]   true, RMS error [N]")
        for wanted in (5.0, 10.0, 15.0):
            felt = drive(Press(force=wanted), 2.5)[-100:]  # the last second, at 100 Hz
            true = robot.truth.force()[1][-2000:]  # and at the 2 kHz of the physics
            print(f"{wanted:10.1f} {np.mean(felt):10.2f} {np.mean(true):10.2f} {rms(true - wanted):12.2f}")


if __name__ == "__main__":
    main()
