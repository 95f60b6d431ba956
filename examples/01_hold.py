"""Hold the arm still: which law keeps it in place when the model is wrong?

Three arms: one that is exactly as its model says, the same with 100 g in its hand that the
model does not know, and the honest one, whose links weigh up to 10 % more or less than they should and whose gears have
friction. All in simulation.
"""

from dataclasses import replace

import numpy as np

from burnish import (
    ComputedTorque,
    GravityCompensation,
    Hold,
    Limits,
    Model,
    Rig,
    SimRobot,
    Supervisor,
    control,
)
from burnish.sim import arms

SECONDS = 3.0


def drift(arm: arms.Arm, model: Model, law) -> float:
    """How far any joint has moved after SECONDS of holding the pose of the start [deg]."""
    model = model.with_armature(arm.armature)  # what the controller believes
    robot = SimRobot(rate=arm.rate, plant=arm.plant)  # what the arm is
    rig = Rig(robot, model, Supervisor(limits=Limits.of(model)))
    with robot:
        for sample in control(rig, Hold(), law, until=lambda now: now.t >= SECONDS):
            if sample.arm.t == 0.0:
                start = sample.arm.q
    if rig.supervisor.tripped:
        raise SystemExit(f"stopped: {rig.supervisor.event.cause}")
    return float(np.degrees(np.abs(sample.arm.q - start).max()))


def main() -> None:
    laws = {
        "gravity compensation, damped": lambda: GravityCompensation(damping=2.0),
        "computed torque, PD": lambda: ComputedTorque.at_frequency(10.0),
        "computed torque, PID": lambda: ComputedTorque.at_frequency(10.0, ki=200.0),
    }
    ideal, model = arms.ideal(0), Model.jaco2()
    loaded = replace(ideal, plant=replace(ideal.plant, payload=0.1))
    cells = ((ideal, model), (loaded, model), (arms.honest(1), model))
    print(f"{'largest joint motion in 3 s [deg]':<36}{'ideal arm':>14}{'100 g unknown':>14}{'honest arm':>14}")
    for name, law in laws.items():
        print(f"{name:<36}" + "".join(f"{drift(arm, model, law()):>14.3f}" for arm, model in cells))


if __name__ == "__main__":
    main()
