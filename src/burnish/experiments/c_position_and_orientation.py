"""The blog: position and orientation together, and what one does to the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from burnish.control import OperationalSpace
from burnish.experiments.c_masks import COUNT, EVERY, KP, KV, controlled_error
from burnish.experiments.jumps import Jumps, blog_targets
from burnish.sim import arms
from burnish.sim.arms import Arm
from burnish.trials.experiment import Experiment, Finding, Trial, nominal
from burnish.trials.figures import Figures, figures
from burnish.trials.record import Record

MOTIONS = {
    "both": {"shift": True, "turn": True},
    "turns only": {"shift": False, "turn": True},
    "shifts only": {"shift": True, "turn": False},
}
"""What of the target moves."""


def trials() -> Sequence[Trial]:
    """Each motion on both arms, with the blog's gains and with ours."""
    return [
        _trial(motion, arm, mine=mine)
        for arm in (arms.ideal(0), arms.honest(0))
        for motion in MOTIONS
        for mine in (False, True)
    ]


def blog() -> OperationalSpace:
    """k_p = k_o = 300 and k_v = 1.5 √(k_p + k_o)."""
    return OperationalSpace(kp=KP, kd=0.0, joint_damping=float(KV))


def ours() -> OperationalSpace:
    """Damped at the tool, with an integral against friction."""
    return OperationalSpace.at_frequency(15.0, ki=1000.0, integral=20.0, window=0.05)


def _trial(motion: str, arm: Arm, *, mine: bool) -> Trial:
    where = "ideal" if arm.friction is None else "honest"
    return Trial(
        name=f"{motion}, {where}" + (", ours" if mine else ""),
        law=ours() if mine else blog(),
        source=Jumps(poses=blog_targets(COUNT, **MOTIONS[motion]), every=EVERY),
        duration=COUNT * EVERY,
        arm=arm,
        model=nominal(arm),
        ours=mine,
    )


def judge(records: Mapping[str, Record]) -> Sequence[Finding]:
    """Whether the blog's law does both, and how well."""
    of = {name: figures(record) for name, record in records.items()}
    stopped = [name for name, record in records.items() if record.stopped is not None]
    ideal, theirs, mine = of["both, ideal"], of["both, honest"], of["both, honest, ours"]
    left = {name: controlled_error(records[f"both, {name}"], np.ones(6)) for name in ("honest", "honest, ours")}
    return [
        Finding(
            claim="The blog: all six degrees of freedom can be controlled at once.",
            measured=f"Ideal arm: {ideal.position_steady_mm:.2f} mm and {ideal.orientation_steady_deg:.2f}° in the "
            f"last second, settled in {_seconds(ideal)}; stopped trials: {', '.join(stopped) or 'none'}.",
            holds=ideal.settling_s is not None and not stopped,
        ),
        Finding(
            claim="On the honest arm friction keeps the blog's gains from settling; ours, with an integral, settle.",
            measured=f"Settled in {_seconds(theirs)} and in {_seconds(mine)}; left at the end of each target, RMS: "
            f"{left['honest'][0]:.2f} mm and {left['honest'][1]:.2f}° against {left['honest, ours'][0]:.2f} mm and "
            f"{left['honest, ours'][1]:.2f}°.",
            holds=theirs.settling_s is None and mine.settling_s is not None,
        ),
        Finding(
            claim="Coupling: how far the position is off while only the orientation jumps, and the reverse.",
            measured="; ".join(_coupling(where, of) for where in ("ideal", "ideal, ours", "honest", "honest, ours"))
            + ".",
            holds=None,
        ),
    ]


def _coupling(where: str, of: Mapping[str, Figures]) -> str:
    turns, shifts = of[f"turns only, {where}"], of[f"shifts only, {where}"]
    return (
        f"{where}: {turns.coupling_position_peak_mm:.1f} mm at most, {turns.coupling_position_rms_mm:.2f} mm RMS; "
        f"{shifts.coupling_orientation_peak_deg:.2f}° at most"
    )


def _seconds(of: Figures) -> str:
    return "not at all" if of.settling_s is None else f"{of.settling_s:.2f} s"


EXPERIMENT = Experiment(
    title="Position and orientation together",
    source="Blog, controlling position and orientation",
    about="""All six degrees of freedom at once, with the blog's k_p = k_o = 300 and joint damping 1.5 √600, which it
    found by trial. The target jumps every 2 s, by up to 12 mm and 6°. In two further trials only its orientation or
    only its position jumps, which shows how much one disturbs the other.""",
    trials=trials,
    judge=judge,
)
