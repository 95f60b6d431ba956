"""Write a control law of your own and try it on the ideal and on the honest arm, beside one of burnish.

A law is any object with `reset(arm)` and `torque(arm, reference)`. This one is a spring and a damper at the tool that
give way softly: beyond a certain error they pull no harder. All in simulation.
"""

from dataclasses import dataclass

import numpy as np

from burnish import BurnishError, CubicPose, Dynamics, Limits, Model, Rig, SimRobot, Supervisor, ToolReference, control
from burnish.control import OperationalSpace
from burnish.rotation import continuous_error
from burnish.sim import arms


@dataclass(kw_only=True)
class SoftSpring:
    """τ = Jᵀ Λ (a_d + k_p e / (1 + |e|/reach) + k_d (v_d − v) − J̇q̇) + h + g."""

    kp: float
    """Acceleration by error, small errors [1/s²]."""
    kd: float
    """Acceleration by speed [1/s]."""
    reach: float
    """Error from which it hardly pulls harder [m, rad]."""

    def reset(self, arm: Dynamics) -> None:
        """Refuse, before anything moves, gains that make no sense."""
        if not (self.kp > 0.0 and self.kd > 0.0 and self.reach > 0.0):
            raise BurnishError(f"SoftSpring: kp {self.kp}, kd {self.kd}, reach {self.reach}; expected all above 0")

    def torque(self, arm: Dynamics, reference: ToolReference) -> np.ndarray:
        """Joint torques [N·m], gravity included."""
        e = np.concatenate([reference.p - arm.p, continuous_error(arm.R, reference.R)])
        pull = self.kp * e / (1.0 + np.linalg.norm(e) / self.reach)
        a = reference.a + pull + self.kd * (reference.v - arm.v)
        return arm.J.T @ arm.Lambda @ (a - arm.dJdq) + arm.h + arm.g


def errors(law: SoftSpring | OperationalSpace, arm: arms.Arm) -> tuple[float, float]:
    """Position error on the way, RMS, and at the end [mm]."""
    model = Model.jaco2().with_armature(arm.armature)
    robot = SimRobot(rate=arm.rate, plant=arm.plant)
    rig = Rig(robot, model, Supervisor(limits=Limits.of(model)))
    p, R, _ = model.kinematics(rig.read().q)
    there = CubicPose(p=p + [0.05, -0.05, 0.05], R=R, duration=1.6)
    off = []
    with robot:
        for sample in control(rig, there, law, until=lambda now: now.t >= 2.0):
            off.append(np.linalg.norm(sample.reference.p - sample.arm.p))
    if rig.supervisor.event is not None:
        raise SystemExit(f"stopped: {rig.supervisor.event.cause}")
    return 1e3 * float(np.sqrt(np.mean(np.square(off)))), 1e3 * float(off[-1])


def main() -> None:
    laws = {
        "soft spring": SoftSpring(kp=225.0, kd=30.0, reach=0.05),
        "operational space": OperationalSpace(kp=225.0, kd=30.0),
    }
    print(f"{'position error [mm]':<20}{'arm':<10}{'RMS':>8}{'at the end':>12}")
    for name, law in laws.items():
        for arm_name, arm in {"ideal": arms.ideal(0), "honest": arms.honest(0)}.items():
            rms, end = errors(law, arm)
            print(f"{name:<20}{arm_name:<10}{rms:>8.3f}{end:>12.3f}")


if __name__ == "__main__":
    main()
