"""The blog: control of any of the six degrees of freedom, by the rows of the Jacobian that a mask leaves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from burnish.control import LimitAvoidance, OperationalSpace, Posture
from burnish.core import Array
from burnish.experiments.jumps import Jumps, blog_targets
from burnish.model.model import Model
from burnish.sim import arms
from burnish.sim.arms import Arm
from burnish.sim.robot import HOME
from burnish.trials.experiment import Experiment, Finding, Trial, nominal
from burnish.trials.record import Record, rms

MASKS = {
    "position": (True, True, True, False, False, False),
    "orientation": (False, False, False, True, True, True),
    "position and about z": (True, True, True, False, False, True),
    "height and about x, y": (False, False, True, True, True, False),
}
KP, KV = 300.0, 1.5 * np.sqrt(600.0)
"""The blog's k_p = k_o [1/s²] and k_v [1/s] for position and orientation together."""
COUNT, EVERY = 4, 2.0
"""Targets, and the time for each [s]."""


def trials() -> Sequence[Trial]:
    """Each mask on both arms with the blog's gains, and on the honest one with ours."""
    return [
        trial
        for name, mask in MASKS.items()
        for trial in (
            _trial(name, arms.ideal(0), blog(mask)),
            _trial(name, arms.honest(0), blog(mask)),
            _trial(name, arms.honest(0), ours(mask), ours=True),
        )
    ]


def blog(mask: Sequence[bool]) -> OperationalSpace:
    """Joint damping, and nothing for what the mask leaves free."""
    return OperationalSpace(kp=KP, kd=0.0, joint_damping=float(KV), mask=mask)


def ours(mask: Sequence[bool]) -> OperationalSpace:
    """Damping at the tool, an integral against friction, and the posture with what is left."""
    model = Model.jaco2()
    rest = [Posture.at_frequency(HOME, 4.0), LimitAvoidance(lower=model.lower, upper=model.upper)]
    return OperationalSpace.at_frequency(18.0, ki=1500.0, integral=20.0, window=0.05, mask=mask, null_space=rest)


def _trial(name: str, arm: Arm, law: OperationalSpace, *, ours: bool = False) -> Trial:
    where = "ideal" if arm.friction is None else "honest"
    return Trial(
        name=f"{name}, {where}" + (", ours" if ours else ""),
        law=law,
        source=Jumps(poses=blog_targets(COUNT), every=EVERY),
        duration=COUNT * EVERY,
        arm=arm,
        model=nominal(arm),
        ours=ours,
    )


def judge(records: Mapping[str, Record]) -> Sequence[Finding]:
    """Whether what is controlled arrives, and what becomes of the rest."""
    return [
        _finding("The blog's gains on the ideal arm: what the mask controls arrives (1 mm, 0.5°).", records, "ideal"),
        _finding("The same gains on the honest arm: friction leaves an error.", records, "honest", claimed=False),
        _finding("Ours on the honest arm arrives (1 mm, 0.5°).", records, "honest, ours"),
        Finding(
            claim="What is not controlled is free: under position control the orientation drifts, and the reverse.",
            measured="Ideal arm, the blog's gains: orientation "
            f"{np.degrees(rms(records['position, ideal'].orientation_error)):.1f}° RMS under position control, "
            f"position {1e3 * rms(records['orientation, ideal'].position_error):.0f} mm RMS under orientation control.",
            holds=None,
        ),
    ]


def _finding(claim: str, records: Mapping[str, Record], case: str, *, claimed: bool = True) -> Finding:
    left = {name: controlled_error(records[f"{name}, {case}"], np.asarray(mask)) for name, mask in MASKS.items()}
    return Finding(
        claim=claim,
        measured="Left at the end of each target, RMS: "
        + "; ".join(f"{name} {mm:.2f} mm, {deg:.2f}°" for name, (mm, deg) in left.items())
        + ".",
        holds=all(mm <= 1.0 and deg <= 0.5 for mm, deg in left.values()) if claimed else None,
    )


def controlled_error(record: Record, mask: Array) -> tuple[float, float]:
    """Error of what the mask controls at the end of each target, RMS [mm, deg]; infinite for one that was stopped."""
    if record.stopped is not None:
        return np.inf, np.inf
    ends = [int(record.time.searchsorted(EVERY * (k + 1))) - 3 for k in range(COUNT)]
    e_p, e_o = (np.asarray(record.p_d) - np.asarray(record.p))[ends], np.asarray(record.turn)[ends]
    return (
        1e3 * rms(np.linalg.norm(e_p * mask[:3], axis=1)),
        float(np.degrees(rms(np.linalg.norm(e_o * mask[3:], axis=1)))),
    )


EXPERIMENT = Experiment(
    title="Position, orientation, or some of both",
    source="Blog, controlling position and orientation, control of a subset",
    about="""A mask says which of x, y, z, about x, y and z are controlled; rows of the Jacobian and of the error are
    stripped, and the inertia is that of what is left. The target shifts and turns every 2 s by up to 12 mm and 6°,
    and each trial follows its part of that. The gains are the blog's for position and orientation together; ours damp
    at the tool, integrate, and keep the home posture with what is free.""",
    trials=trials,
    judge=judge,
)
