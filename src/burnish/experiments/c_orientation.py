"""The blog: five ways to say how far a tool is turned away, and a target that turns every second."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from burnish.control import OperationalSpace
from burnish.control.error import OrientationError
from burnish.core import Array
from burnish.experiments.jumps import Jumps, blog_targets
from burnish.rotation import continuous_error, quaternion, quaternion_error, sine_error
from burnish.sim import arms
from burnish.sim.arms import Arm
from burnish.trials.experiment import Experiment, Finding, Trial, nominal
from burnish.trials.record import Record, rms

ORIENTATION = (False, False, False, True, True, True)
KO, KV = 200.0, np.sqrt(600.0)
"""The blog's gains of the orientation [1/s²] and of the joint speeds [1/s]."""
COUNT, EVERY = 8, 1.0
"""Targets, and the time for each [s]."""


def yuan_as_listed(R: Array, R_d: Array) -> Array:
    """The blog's method 4 as it was listed: its matrix S takes the first three numbers of q_d.

    The first of them is the scalar, so it stands where a component of the vector belongs. With S(ε_d) it would be
    method 1.
    """
    Q, Q_d = quaternion(R), quaternion(R_d)
    return np.asarray(Q[0] * Q_d[1:] - Q_d[0] * Q[1:] - np.cross(Q_d[:3], Q[1:]))


METHODS: dict[str, OrientationError] = {
    "methods 1 and 2, sin(θ/2) u": quaternion_error,
    "method 3, sin θ u": sine_error,
    "method 4 as listed": yuan_as_listed,
    "thesis A, θ u": continuous_error,
}


def trials() -> Sequence[Trial]:
    """Every method on both arms with the blog's gains; ours holds the position as well."""
    return [trial for arm in (arms.ideal(0), arms.honest(0)) for trial in _on(arm)]


def _on(arm: Arm) -> list[Trial]:
    name = "ideal" if arm.friction is None else "honest"

    def trial(method: str, law: OperationalSpace) -> Trial:
        source = Jumps(poses=blog_targets(COUNT, shift=False), every=EVERY)
        duration = COUNT * EVERY
        return Trial(name=f"{method}, {name}", law=law, source=source, duration=duration, arm=arm, model=nominal(arm))

    blog = [
        trial(method, OperationalSpace(kp=KO, kd=0.0, joint_damping=KV, mask=ORIENTATION, orientation_error=error))
        for method, error in METHODS.items()
    ]
    ours = OperationalSpace.at_frequency(
        18.0, ki=1500.0, integral=20.0, window=0.05, mask=ORIENTATION, joint_damping=1.0
    )
    return [*blog, replace(trial("ours", ours), ours=True)]


def judge(records: Mapping[str, Record]) -> Sequence[Finding]:
    """What the blog saw."""
    left = {name: remaining(record) for name, record in records.items()}
    first, third, _, angle = METHODS
    good = [left[f"{method}, ideal"] for method in METHODS if "as listed" not in method]
    return [
        Finding(
            claim="The blog: methods 1 to 3 all reach the target within the second.",
            measured="Left at the end of each second, ideal arm, median: "
            + ", ".join(f"{m} {left[f'{m}, ideal']:.1f}°" for m in METHODS if "as listed" not in m)
            + ".",
            holds=max(good) < 1.0,
        ),
        Finding(
            claim="The blog: method 4, as listed, fails.",
            measured=f"Ideal arm: {_failure(records['method 4 as listed, ideal'])}; honest arm: "
            f"{_failure(records['method 4 as listed, honest'])}.",
            holds=all(
                record.stopped is not None or remaining(record) > 5.0
                for name, record in records.items()
                if "as listed" in name
            ),
        ),
        Finding(
            claim="The blog: method 3 converges a bit faster. Near the target sin θ is twice sin(θ/2), so its gain is "
            "twice as high, and so is that of θ u.",
            measured=f"Orientation RMSE on the ideal arm: {_deg(records[f'{first}, ideal']):.2f}° by sin(θ/2), "
            f"{_deg(records[f'{third}, ideal']):.2f}° by sin θ, {_deg(records[f'{angle}, ideal']):.2f}° by θ.",
            holds=_deg(records[f"{third}, ideal"]) < _deg(records[f"{first}, ideal"]),
        ),
        Finding(
            claim="Friction leaves an error with the blog's gains; an integral takes out at least a third of it.",
            measured=f"Honest arm, left at the end of a second, median: {left[f'{first}, honest']:.1f}° by sin(θ/2), "
            f"{left[f'{angle}, honest']:.1f}° by θ, {left['ours, honest']:.1f}° by ours.",
            holds=left["ours, honest"] <= left[f"{angle}, honest"] / 1.5,
        ),
    ]


def _deg(record: Record) -> float:
    return float(np.degrees(rms(record.orientation_error)))


def _failure(record: Record) -> str:
    if record.stopped is not None:
        return f"stopped after {record.time[-1]:.1f} s, turned away by {np.degrees(record.orientation_error[-1]):.0f}°"
    return f"{remaining(record):.0f}° left at the end of each second, median"


def remaining(record: Record) -> float:
    """Angle that is left at the end of the seconds, the median over them [deg]."""
    ends = [record.time.searchsorted(EVERY * (k + 1)) - 2 for k in range(int(record.time[-1] / EVERY + 0.5))]
    return float(np.degrees(np.median(record.orientation_error[ends]))) if ends else np.inf


EXPERIMENT = Experiment(
    title="Orientation errors under a target that turns every second",
    source="Blog, force control of task-space orientation, methods 1 to 4",
    about="""The blog controls the orientation alone, with k_o = 200 and joint damping √600, and lets a target turn once
    a second. Three of its methods worked and one did not, for a reason that it asks its readers for: its matrix S was
    built from the scalar and two of the three components of the vector. The targets here are eight rotations by 3°
    to 6° about random axes from the home orientation, because the wrist of a JACO2 is slower than that of the blog's
    UR5. The position is free and drifts.""",
    trials=trials,
    judge=judge,
)
