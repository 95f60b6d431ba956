"""Thesis A, table 5.3 and figure 5.4: computed torque along a sine of every joint."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from burnish.control import ComputedTorque
from burnish.core import Dynamics, JointReference, State
from burnish.experiments.thesis_a import with_rotors
from burnish.model.model import Model
from burnish.sim import arms
from burnish.sim.arms import Arm
from burnish.sim.robot import HOME
from burnish.trajectory import Sine
from burnish.trials.experiment import Experiment, Finding, Trial, links_only, nominal
from burnish.trials.figures import figures
from burnish.trials.record import Record, rms

AMPLITUDE, PERIOD = np.radians(20.0), 8.0
"""Eq. 5.3."""
KP = (32.5, 40.5, 55.0, 65.0, 70.0, 850.0)
KD = (12.25, 15.25, 22.5, 28.5, 30.5, 150.0)
"""Table 5.3 [1/s²], [1/s]."""


@dataclass(kw_only=True)
class PositionsOnly:
    """A sine of which the law is told the position alone, as eq. 4.18 has it: ``w = K_p (q_d − q) − K_d q̇``."""

    sine: Sine = field(default_factory=lambda: sine())

    def reset(self, arm: Dynamics) -> None:
        """Start the sine."""
        self.sine.reset(arm)

    def at(self, arm: Dynamics) -> JointReference:
        """Its position, as if it stood."""
        still = np.zeros(len(arm.q))
        return JointReference(q=self.sine.at(arm).q, dq=still, ddq=still)


def sine() -> Sine:
    """Eq. 5.3."""
    return Sine(amplitude=AMPLITUDE, period=PERIOD)


def trials() -> Sequence[Trial]:
    """The thesis's gains as printed and with the reference's speed, and ours."""
    ideal, honest = arms.ideal(0), arms.honest(0)

    def trial(name: str, arm: Arm, rate: float, model: Model, source: Sine | PositionsOnly) -> Trial:
        ours = name.endswith("ours")
        law = ComputedTorque.at_frequency(10.0, ki=300.0, friction=arm.friction) if ours else theirs()
        return Trial(
            name=name, law=law, source=source, duration=2.0 * PERIOD, arm=arm, model=model, rate=rate, ours=ours
        )

    links = links_only()
    return [
        trial("as printed, ideal", ideal, 1000.0, links, PositionsOnly()),
        trial("as printed, ideal at 100 Hz", ideal, 100.0, links, PositionsOnly()),
        trial("as printed, with rotors at 100 Hz", with_rotors(ideal), 100.0, links, PositionsOnly()),
        trial("as printed, honest", honest, 100.0, links, PositionsOnly()),
        trial("with speed, ideal", ideal, 1000.0, links, sine()),
        trial("with speed, honest", honest, 100.0, links, sine()),
        trial("with speed, rotors in the model, honest", honest, 100.0, nominal(honest), sine()),
        trial("ideal, ours", ideal, 1000.0, nominal(ideal), sine()),
        trial("honest, ours", honest, 100.0, nominal(honest), sine()),
    ]


def theirs() -> ComputedTorque:
    """Table 5.3."""
    return ComputedTorque(kp=KP, kd=KD)


def judge(records: Mapping[str, Record]) -> Sequence[Finding]:
    """What the thesis says of figure 5.4, and what its odd gain of joint 6 means."""
    error = {name: 1e3 * rms(np.asarray(record.joint_error)) for name, record in records.items()}
    mine, source = error["honest, ours"], error["with speed, rotors in the model, honest"]
    rough = {name: figures(record).roughness_Nm_s for name, record in records.items()}
    lag = np.asarray(KD) / np.asarray(KP)
    home = links_only().at(State(t=0.0, q=HOME, dq=np.zeros(6)))
    stiffness = np.diag(home.M) * KP
    return [
        Finding(
            claim="As printed the law brakes the wanted speed as well, so the joints must trail by K_d/K_p = "
            f"{lag.min():.2f} to {lag.max():.2f} s. Figure 5.4 shows no such lag: the speed was fed forward.",
            measured=f"Ideal arm: {error['as printed, ideal']:.0f} mrad as printed, "
            f"{error['with speed, ideal']:.2f} mrad with the reference's speed.",
            holds=error["with speed, ideal"] < 0.1 * error["as printed, ideal"],
        ),
        Finding(
            claim="Why joint 6 needed a gain of 850: M of the links is ten times as small there as at joint 5, and the "
            "gain makes up for it. What the two joints share, rotor inertia and friction, is not in that M.",
            measured="K_p M of joints 1 to 6 at home: " + ", ".join(f"{k:.2f}" for k in stiffness) + " N·m/rad.",
            holds=bool(0.5 < stiffness[5] / stiffness[4] < 2.0),
        ),
        Finding(
            claim="The thesis: the joints follow relatively well (taken as 50 mrad). With the links alone in M they do "
            "not on the honest arm: these stiffnesses do not overcome its friction of 1.0 and 0.4 N·m.",
            measured=f"Honest arm: {error['with speed, honest']:.0f} mrad, of the sine's 247 mrad.",
            holds=error["with speed, honest"] <= 50.0,
        ),
        Finding(
            claim="With the nominal rotors in M they follow, and K_d = 150 1/s on joint 6 then chatters at 100 Hz.",
            measured=f"{source:.0f} mrad; roughness {rough['with speed, rotors in the model, honest']:.0f} N·m/s "
            f"against {rough['honest, ours']:.0f} N·m/s of ours.",
            holds=source <= 50.0 and rough["with speed, rotors in the model, honest"] > 10.0 * rough["honest, ours"],
        ),
        Finding(
            claim="Ours, with friction compensation and an integral: at most a third of the error on the honest arm.",
            measured=f"{mine:.1f} mrad against {source:.1f} mrad.",
            holds=records["honest, ours"].stopped is None and mine <= source / 3.0,
        ),
    ]


EXPERIMENT = Experiment(
    title="Computed torque along a sine of every joint",
    source="Thesis A, 4.2 and 5.4, table 5.3, figure 5.4",
    about="""All six joints swing by 20° in 8 s about their start, to see whether the mass matrix is right. The thesis
    found that they follow, and wondered why joint 6 needed K_p = 850. Its pre-defined start is not printed; here it is
    the home pose. Its law, eq. 4.18, is run as printed and with the reference's speed.""",
    trials=trials,
    judge=judge,
)
