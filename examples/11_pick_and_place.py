"""Take a box from the table with the fingers and put it down on a target 200 mm away.

The honest arm with a KG-3 hand, simulated. The controller knows where the box stands at the start and nothing of its
weight: the integral of the law carries it. Where the box really is, and how hard it is held, is printed and never used.
"""

import numpy as np

from burnish import CubicPose, HoldPose, Limits, Model, Rig, SimRobot, Supervisor, control
from burnish.control import OperationalSpace
from burnish.model.ik import inverse_kinematics
from burnish.polish.cell import READY, tool_down
from burnish.sim import arms
from burnish.sim.hand import CLOSED, Hand
from burnish.sim.things import Box, Table

BOX, TARGET = np.array([0.0, -0.40, 0.045]), np.array([0.19, -0.34, 0.045])
"""The middle of the box at the start, and where it shall be [m]; 45 mm is half its height."""
GRIPPED = np.array([0.0, 0.0, 0.01])
"""From the box's middle to the tool point when it is held: the fingers reach 44 mm below that [m]."""
UP = np.array([0.0, 0.0, 0.10])
OPEN, SHUT = np.zeros(3), np.full(3, CLOSED)


def main() -> None:
    arm = arms.honest(seed=1)
    model = Model.jaco2().with_armature(arm.armature)
    R = tool_down(model)
    upright = R @ np.diag([1.0, -1.0, -1.0])  # z of the box up, its sides across the fingers
    box = Box(name="box", size=np.array([0.05, 0.05, 0.09]), mass=0.3, p=BOX, R=upright)
    start = inverse_kinematics(model, BOX + GRIPPED + UP, R, READY)
    robot = SimRobot(start, rate=arm.rate, plant=arm.plant, hand=Hand(), things=[Table(), box])
    rig = Rig(robot, model, Supervisor(limits=Limits.of(model)))
    law = OperationalSpace.at_frequency(15.0, ki=600.0, friction=arm.friction)
    print(f"{'':<10}{'time [s]':>10}{'off its way, at most [mm]':>27}{'fingers [deg]':>15}{'thumb presses [N]':>19}")

    def drive(what: str, source: CubicPose | HoldPose, seconds: float) -> None:
        """Follow a source for some time, and say how that went."""
        end, off = robot.time + seconds, [0.0]
        for sample in control(rig, source, law, until=lambda now: now.t >= end):
            off.append(float(np.linalg.norm(sample.reference.p - sample.arm.p)))
        if rig.supervisor.tripped:
            raise SystemExit(f"stopped: {rig.supervisor.event.cause}")
        angle, press = np.degrees(robot.fingers().mean()), robot.truth_grip()[0]
        print(f"{what:<10}{robot.time:10.2f}{1e3 * max(off):27.2f}{angle:15.1f}{press:19.1f}")

    def go(what: str, p: np.ndarray, seconds: float) -> None:
        drive(what, CubicPose(p=p + GRIPPED, R=R, duration=seconds), seconds + 0.3)

    with robot:
        go("reach", BOX, 1.5)
        robot.move_fingers(SHUT)
        drive("close", HoldPose(), 1.3)
        if (robot.fingers() > CLOSED - 0.02).any():
            raise SystemExit("the fingers closed on nothing")
        go("lift", BOX + UP, 1.5)
        lifted = robot.truth_pose("box")[0][2] - BOX[2]
        go("carry", TARGET + UP, 2.0)
        go("put down", TARGET, 1.5)
        robot.move_fingers(OPEN)
        drive("open", HoldPose(), 1.2)
        go("leave", TARGET + UP, 1.5)

    p, R_base_box = robot.truth_pose("box")
    tilt = np.degrees(np.arccos(np.clip(R_base_box[2, 2], -1.0, 1.0)))
    print(
        f"the box was lifted by {1e3 * lifted:.0f} mm and stands {1e3 * np.linalg.norm(p - TARGET):.1f} mm from its",
        end=" ",
    )
    print(f"target, {tilt:.1f} deg off upright")


if __name__ == "__main__":
    main()
