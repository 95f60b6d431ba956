"""The pose motion of thesis A: as it is printed, and as much of it as the arm can follow."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from burnish.control.task import SINGULAR_VALUE
from burnish.core import Array, Controller, read_only
from burnish.model.ik import POSITION_TOLERANCE, ROTATION_TOLERANCE, inverse_kinematics, solve
from burnish.model.model import Model
from burnish.rotation import from_euler_xyz
from burnish.sim import arms
from burnish.sim.arms import Arm
from burnish.sim.robot import HOME
from burnish.trajectory import EulerCubic
from burnish.trials.experiment import Finding, Trial, links_only, nominal, steady
from burnish.trials.record import Record, rms

START = read_only([0.212444, -0.257293, 0.506643, 1.65789, 1.11875, 0.113634])
END = read_only([0.312452, -0.407218, 0.706502, 2.44364, 0.0715527, 0.637327])
"""Position [m] and intrinsic XYZ angles [rad] (eq. 5.2, whose unit says m for all six)."""
DURATION = 16.0
"""Of the motion [s] (eq. 5.2)."""
STAND = 3.0
"""For which the end is held [s]; the thesis's figures show 4."""
STEP = 0.0025
"""Share of the way from one check of the motion to the next."""
TABLE_5_2: dict[str, Any] = {"stiffness": (400.0, 20.0), "integral_stiffness": (150.0, 8.0), "damping": (25.0, 1.5)}
"""Gains of three laws: K, K_i, K_d of position and orientation. The thesis says of no bound for the integral; the laws'
own, 20 N and 5 N·m, is in force, because without one the printed motion winds it up until the arm is stopped."""
OURS_IDEAL: dict[str, Any] = {"stiffness": (1000.0, 5.0), "integral_stiffness": (500.0, 5.0), "damping": (80.0, 0.4)}
"""Our gains of the same three laws for links alone at 1 kHz: the wrist bears little damping."""
OURS_HONEST: dict[str, Any] = {
    "stiffness": (1200.0, 40.0),
    "integral_stiffness": (2500.0, 120.0),
    "integral": (40.0, 10.0),
    "damping": (50.0, 2.5),
}
"""And for the honest arm at 100 Hz: stiffer, and with a faster integral against its friction."""
UNREACHABLE = (
    "The printed motion cannot be followed: from 5.7 to 6.8 s it grazes the wrist singularity and no joint positions "
    "reach it, between there and the end joints 4 and 6 would have to turn by far more than they can, and its end "
    "lies out of reach by about 1.4 mm and 0.4° at best. So it is run as printed, and beside it the nearest motion "
    "that can be followed: the same time along the same way, which ends before the wrist comes near its singularity."
)


@cache
def start_joints() -> Array:
    """Joint positions at the start of the motion: 0.8 mm and 0.2° from the vendor's home pose."""
    return read_only(inverse_kinematics(Model.jaco2(), START[:3], from_euler_xyz(START[3:]), HOME))


def as_printed() -> EulerCubic:
    """The whole motion."""
    return EulerCubic(start=START, end=END, duration=DURATION)


def reachable() -> EulerCubic:
    """The part of the motion that the arm can follow, in the same time."""
    return EulerCubic(start=START, end=START + reachable_share() * (END - START), duration=DURATION)


@cache
def reachable_share() -> float:
    """How far along the printed way the arm can go from its start, 0 to 1.

    Up to there joint positions within the limits follow without a jump, no singular value of J falls below that at
    which the laws damp its inverse, and in 16 s no joint is faster than it may be.
    """
    model, q = Model.jaco2(), start_joints()
    for share in np.arange(STEP, 1.0, STEP):
        x = START + share * (END - START)
        nearer, position, rotation = solve(model, x[:3], from_euler_xyz(x[3:]), q)
        speed = np.abs(nearer - q) / STEP * share * 1.5 / DURATION  # A cubic is 1.5 times as fast as its mean.
        lost = np.linalg.svd(model.kinematics(nearer)[2], compute_uv=False)[-1] < SINGULAR_VALUE
        missed = position > POSITION_TOLERANCE or rotation > ROTATION_TOLERANCE
        if missed or lost or (speed > model.velocity_limit).any():
            return float(share - STEP)
        q = nearer
    return 1.0


def with_rotors(arm: Arm) -> Arm:
    """The arm with the nominal rotor inertia of the honest one: what the thesis's model of the links leaves out."""
    armature = arms.honest(0).armature
    return replace(arm, plant=replace(arm.plant, armature=armature), armature=armature)


def pose_trials(
    theirs: Callable[[], Controller[Any]], ours: Callable[[Arm], Controller[Any]], prefix: str = ""
) -> list[Trial]:
    """A law along both motions: with the thesis's gains and model, and with our gains for an arm.

    The thesis ran at 100 Hz and knew the links only. Its gains are tried at 1 kHz and at 100 Hz on an arm of links
    alone, at 100 Hz with the rotors that every geared arm has, and on the honest arm.
    """
    ideal, honest = arms.ideal(0), arms.honest(0)

    def trial(name: str, source: EulerCubic, arm: Arm, rate: float, law: Controller[Any], model: Model) -> Trial:
        return Trial(
            name=prefix + name,
            law=law,
            source=source,
            duration=DURATION + STAND,
            arm=arm,
            model=model,
            q=start_joints(),
            rate=rate,
            ours=name.endswith("ours"),
        )

    links = links_only()
    return [
        trial("printed, ideal", as_printed(), ideal, 1000.0, theirs(), links),
        trial("printed, honest", as_printed(), honest, 100.0, theirs(), links),
        trial("reachable, ideal", reachable(), ideal, 1000.0, theirs(), links),
        trial("reachable, ideal at 100 Hz", reachable(), ideal, 100.0, theirs(), links),
        trial("reachable, with rotors at 100 Hz", reachable(), with_rotors(ideal), 100.0, theirs(), links),
        trial("reachable, honest", reachable(), honest, 100.0, theirs(), links),
        trial("printed, honest, ours", as_printed(), honest, 100.0, ours(honest), nominal(honest)),
        trial("reachable, ideal, ours", reachable(), ideal, 1000.0, ours(ideal), nominal(ideal)),
        trial("reachable, honest, ours", reachable(), honest, 100.0, ours(honest), nominal(honest)),
    ]


def judge_pose(
    records: Mapping[str, Record], prefix: str = "", displaced: tuple[float, float] | None = None
) -> list[Finding]:
    """What the trials of `pose_trials` show of one law; ``displaced`` is when the thesis saw the position off [s]."""
    of = {name.removeprefix(prefix): record for name, record in records.items() if name.startswith(prefix)}
    printed, followed, mine = of["printed, honest"], of["reachable, honest"], of["reachable, honest, ours"]
    peak = float(printed.time[printed.position_error.argmax()])
    lost, bare, geared = of["printed, ideal"], of["reachable, ideal at 100 Hz"], of["reachable, with rotors at 100 Hz"]
    return [
        Finding(
            claim=f"{prefix}Along the printed motion the position is displaced most"
            + (f" between {displaced[0]:g} and {displaced[1]:g} s, where the thesis saw it." if displaced else "."),
            measured=f"Honest arm: {1e3 * printed.position_error.max():.1f} mm at {peak:.1f} s.",
            holds=displaced[0] <= peak <= displaced[1] if displaced else None,
        ),
        Finding(
            claim=f"{prefix}The thesis calls the steady error acceptable and prints no figure.",
            measured=f"Honest arm, printed motion: {steady_text(printed)}; reachable motion: {steady_text(followed)}.",
            holds=None,
        ),
        Finding(
            claim=f"{prefix}On the ideal arm the printed motion is lost where the wrist becomes singular.",
            measured=_end_text(lost) + f" Turned away by {np.degrees(lost.orientation_error.max()):.0f}° at most.",
            holds=lost.stopped is not None or bool(np.degrees(lost.orientation_error.max()) > 5.0),
        ),
        Finding(
            claim=f"{prefix}At 100 Hz, the thesis's rate, its gains need the rotors' inertia: links alone leave the "
            "wrist about 0.001 kg·m², far too little for a damping that acts only every 10 ms.",
            measured=f"Links alone: {_end_text(bare)} With rotors: {_end_text(geared)}",
            holds=bare.stopped is not None and geared.stopped is None,
        ),
        Finding(
            claim=f"{prefix}Our gains: at most a third of the position error on the honest arm.",
            measured=f"RMSE {1e3 * rms(mine.position_error):.2f} mm, {np.degrees(rms(mine.orientation_error)):.2f}° "
            f"against {1e3 * rms(followed.position_error):.2f} mm, "
            f"{np.degrees(rms(followed.orientation_error)):.2f}° along the reachable motion.",
            holds=mine.stopped is None and rms(mine.position_error) <= rms(followed.position_error) / 3.0,
        ),
    ]


def steady_text(record: Record) -> str:
    """Steady-state errors in words."""
    if record.stopped is not None:
        return f"stopped after {record.time[-1]:.2f} s"
    return f"{_steady_mm(record):.2f} mm and {_steady_deg(record):.2f}°"


def _steady_mm(record: Record) -> float:
    return 1e3 * steady(record.position_error, record.time)


def _steady_deg(record: Record) -> float:
    return float(np.degrees(steady(record.orientation_error, record.time)))


def _end_text(record: Record) -> str:
    """How a trial ended, as a sentence."""
    if record.stopped is not None:
        return f"stopped after {record.time[-1]:.2f} s ({record.stopped})."
    return f"stable, RMSE {1e3 * rms(record.position_error):.2f} mm."
