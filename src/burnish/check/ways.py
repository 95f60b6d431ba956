"""The way of a job in joint space, as an arm at its place would go it, and a refusal that says where on it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from burnish.check.on_mould import refusal
from burnish.check.route import Leg
from burnish.core import Array
from burnish.errors import PlanError
from burnish.model.ik import inverse_kinematics
from burnish.model.model import Model
from burnish.model.tool import PolishingTool
from burnish.paths.stroke import Stroke
from burnish.polish.cell import HOME, READY, Placement, nominal_placement, tool_down
from burnish.polish.feasible import track
from burnish.polish.moves import nearest_turn
from burnish.runtime.limits import Limits
from burnish.surface import DistanceGrid, Mould

JOINT_STEP = 0.05
"""Motion of a joint from one checked pose to the next on the way from and to home [rad]."""
PLACE = "Move or turn the mould, or use a smaller one"
"""What helps against most of what an arm cannot do."""


@dataclass(frozen=True, kw_only=True)
class Workplace:
    """An arm with its tool, and the mould where it is meant to stand."""

    model: Model
    """The arm with the tool in its hand, tool frame at the tip's apex."""
    limits: Limits
    """What the supervisor allows."""
    mould: Mould
    """The mould."""
    grid: DistanceGrid
    """Distance to it, mould frame."""
    placement: Placement
    """Where it is meant to stand."""
    upright: Array
    """Tool rotation about which the tool turns least, base ← tool, (3, 3)."""
    uncertainty: float
    """How far the surface may lie from where it is meant to, before it is found [m]."""
    home: Array = field(default_factory=lambda: HOME)
    """Joint positions before and after [rad], (n,)."""
    ready: Array = field(default_factory=lambda: READY)
    """Joint positions from which the working poses are found [rad], (n,)."""


def jaco2_workplace(
    mould: Mould, grid: DistanceGrid, strokes: Sequence[Stroke], tool: PolishingTool, *, uncertainty: float
) -> Workplace:
    """The JACO2 with a tool, and a mould mounted so that the top of what is worked is where it is meant to be."""
    model = tool.on(Model.jaco2())
    return Workplace(
        model=model,
        limits=Limits.jaco2(),
        mould=mould,
        grid=grid,
        placement=nominal_placement(max(float(stroke.points[:, 2].max()) for stroke in strokes)),
        upright=tool_down(model),
        uncertainty=uncertainty,
    )


@dataclass(frozen=True, kw_only=True)
class Way:
    """A leg with its joint positions."""

    leg: Leg
    """The poses."""
    q: Array
    """Joint positions there [rad], (K, n)."""


@dataclass(frozen=True, kw_only=True)
class Worst:
    """The largest or the least of a quantity, and whose it is."""

    value: float
    """In the unit of the field."""
    what: str
    """Such as ``joint 2``."""


def followed(place: Workplace, legs: Sequence[Leg]) -> list[Way]:
    """The legs in joint space, each from the end of the one before.

    Raises:
        PlanError: where the arm cannot follow, and why.
    """
    model = place.model
    try:
        q = inverse_kinematics(model, legs[0].p[0], legs[0].R[0], place.ready)
    except PlanError as error:
        raise refused(place, legs[0], 0, str(error).split(". ")[0], PLACE) from None
    q = nearest_turn(model.lower, place.home, q)
    ways = []
    for leg in legs:
        found = track(model, leg.p, leg.R, q)
        if found.failure is not None:
            raise refused(place, leg, len(found.q), f"the arm cannot follow, {found.failure}", PLACE)
        q = found.q[-1]
        ways.append(Way(leg=leg, q=found.q))
    return ways


def from_home(place: Workplace, q: Array) -> Way:
    """The way in joint space between home and joint positions ``q``."""
    pieces = max(1, int(np.ceil(np.abs(q - place.home).max() / JOINT_STEP)))
    joints = place.home + np.linspace(0.0, 1.0, pieces + 1)[:, None] * (q - place.home)
    poses = [place.model.kinematics(one) for one in joints]
    leg = Leg(
        name="the way between home and the mould",
        p=np.array([pose[0] for pose in poses]),
        R=np.array([pose[1] for pose in poses]),
        uncertainty=place.uncertainty,
    )
    return Way(leg=leg, q=joints)


def joint_margin(place: Workplace, ways: Iterable[Way], least: float) -> Worst:
    """The least distance from a joint limit [rad].

    Raises:
        PlanError: a joint comes nearer than ``least`` [rad].
    """
    model, found = place.model, Worst(value=np.inf, what="no joint")
    for way in ways:
        short = np.minimum(way.q - model.lower, model.upper - way.q)
        k, joint = (int(i) for i in np.unravel_index(np.argmin(short), short.shape))
        if short[k, joint] < least:
            reason = f"joint {joint + 1} comes within {np.rad2deg(short[k, joint]):.1f}° of its limit"
            raise refused(place, way.leg, k, f"{reason}; expected {np.rad2deg(least):.0f}°", PLACE)
        if short[k, joint] < found.value:
            found = Worst(value=float(short[k, joint]), what=f"joint {joint + 1}")
    return found


def refused(place: Workplace, leg: Leg, k: int, reason: str, remedy: str) -> PlanError:
    """The refusal of a way at one of its poses."""
    point = place.placement.R.T @ (leg.p[k] - place.placement.p)
    along = float(np.linalg.norm(np.diff(leg.p[: k + 1], axis=0), axis=1).sum())
    return refusal(leg.name, point, along, reason, remedy)
