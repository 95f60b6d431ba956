"""Lift the tool by 50 mm and let it down again on a spring and a damper: one program, three robots.

    python 02_impedance.py                              the simulated arm
    python 02_impedance.py jaco2 PJ00650019161750001    the arm of this serial number, through its vendor's library
    python 02_impedance.py ros j2n6s300                 the arm of a running kinova-ros driver

Only the constructor differs. Read docs/jaco2-arm.md before you name a real one: it will move.
"""

import argparse

import numpy as np

from burnish import Jaco2, Limits, Model, Rig, SimRobot, Supervisor, TorqueSetup, control
from burnish.control import Impedance
from burnish.core import Robot
from burnish.hardware.ros1 import RosJaco2
from burnish.hardware.ros1_torque import RosTorqueSetup
from burnish.sim import arms
from burnish.trajectory import CubicPose

UP, SECONDS = np.array([0.0, 0.0, 0.05]), 3.0


def chosen(words: list[str] | None, model: Model) -> Robot:
    """The robot that the command line names."""
    parser = argparse.ArgumentParser(
        description=__doc__.partition("\n")[0], formatter_class=argparse.RawDescriptionHelpFormatter
    )
    kinds = parser.add_subparsers(dest="kind", metavar="ROBOT", help="the simulated arm if left out")
    kinds.add_parser("jaco2", help="through Kinova's library").add_argument("serial", help="see 'burnish devices'")
    kinds.add_parser("ros", help="through kinova-ros").add_argument("name", help="kinova_robotName, as j2n6s300")
    options = parser.parse_args(words)
    if options.kind == "jaco2":
        return Jaco2(model, serial=options.serial, torque=TorqueSetup.thesis_a())
    if options.kind == "ros":
        return RosJaco2(model, robot=options.name, torque=RosTorqueSetup())
    return SimRobot(rate=100.0, plant=arms.honest(seed=1).plant)


def lift(robot: Robot, model: Model) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Up and down; times [s], where the tool was and where it should have been [m], (cycles, 3) each."""
    rig = Rig(robot, model, Supervisor(limits=Limits.of(model)))
    law = Impedance(stiffness=(1500.0, 40.0), damping=(120.0, 4.0))
    times, was, wanted = [], [], []
    with robot:
        start = rig.read()
        for p in (start.p + UP, start.p):
            way, end = CubicPose(p=p, R=start.R, duration=SECONDS), rig.arm.t + SECONDS
            for sample in control(rig, way, law, until=lambda arm, end=end: arm.t >= end):
                times.append(sample.arm.t)
                was.append(sample.arm.p)
                wanted.append(sample.reference.p)
    if rig.supervisor.tripped:
        raise SystemExit(f"stopped: {rig.supervisor.event.cause}")
    return np.array(times), np.array(was), np.array(wanted)


def main(words: list[str] | None = None) -> None:
    model = Model.jaco2().with_armature(arms.honest(seed=1).armature)  # an estimate of the rotors' inertia
    times, was, wanted = lift(chosen(words, model), model)
    print("gear friction, and weight that the model does not know, against a spring of 1500 N/m:")
    print(f"{'t [s]':>6}{'wanted [mm]':>13}{'was [mm]':>10}{'apart [mm]':>12}")
    for cycle in range(0, len(was), 60):
        rise, asked = (1e3 * (p[cycle, 2] - was[0, 2]) for p in (was, wanted))
        print(f"{times[cycle]:6.1f}{asked:13.1f}{rise:10.1f}{1e3 * np.linalg.norm(was[cycle] - wanted[cycle]):12.1f}")


if __name__ == "__main__":
    main()
