"""Swing all joints by ±20° in 8 s and see how well each law follows, with and without friction compensation.

The motion is a classic test of computed torque. On the ideal arm it is followed almost exactly; gears with friction
are what makes it hard. All in simulation.
"""

import numpy as np

from burnish import ComputedTorque, Limits, Model, Rig, SimRobot, Sine, Supervisor, control
from burnish.model.friction import Friction
from burnish.sim import arms

AMPLITUDE, PERIOD = np.deg2rad(20.0), 8.0


def tracking_error(arm: arms.Arm, friction: Friction | None) -> np.ndarray:
    """Root mean square of q_d − q over one period, a joint each [deg]."""
    model = Model.jaco2().with_armature(arm.armature)
    robot = SimRobot(rate=100.0, plant=arm.plant)
    rig = Rig(robot, model, Supervisor(limits=Limits.of(model)))
    law = ComputedTorque.at_frequency(10.0, friction=friction)
    errors = []
    with robot:
        for sample in control(rig, Sine(amplitude=AMPLITUDE, period=PERIOD), law, until=lambda now: now.t >= PERIOD):
            errors.append(sample.reference.q - sample.arm.q)
    if rig.supervisor.tripped:
        raise SystemExit(f"stopped: {rig.supervisor.event.cause}")
    return np.degrees(np.sqrt(np.mean(np.square(errors), axis=0)))


def main() -> None:
    honest = arms.honest(1)
    runs = {
        "ideal arm": (arms.ideal(0), None),
        "honest arm": (honest, None),
        "honest arm, friction compensated": (honest, honest.friction),
    }
    print("tracking error, RMS over one period [deg]")
    print(f"{'':<36}" + "".join(f"{f'joint {i}':>9}" for i in range(1, 7)))
    for name, (arm, friction) in runs.items():
        print(f"{name:<36}" + "".join(f"{error:>9.3f}" for error in tracking_error(arm, friction)))


if __name__ == "__main__":
    main()
