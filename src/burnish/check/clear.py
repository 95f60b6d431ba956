"""Whether an arm with its tool stays clear of singular poses, of what stands around and of itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from burnish.check.collision import (
    SLACK,
    Near,
    Obstacle,
    arm_parts,
    least_between,
    least_to_floor,
    least_to_obstacle,
    mould_obstacles,
    tool_parts,
)
from burnish.check.ways import PLACE, Way, Workplace, Worst, refused
from burnish.core import State
from burnish.errors import PlanError
from burnish.model.tool import PolishingTool

LEVER = 0.2
"""What a turn of the tool counts in the distance to a singularity [m/rad]: about the length of hand and tool."""

BEYOND = 20e-3
"""What is farther than what is asked for by this is not measured [m]."""


@dataclass(frozen=True, kw_only=True)
class Clearances:
    """The least distances over a whole way."""

    around: Near
    """Of the arm and the tool's body from the mould, its stand and the floor."""
    itself: Near | None
    """Of the arm's parts from each other; None where the limits know no shapes of this arm."""


def singularity(place: Workplace, ways: Sequence[Way], least: float) -> float:
    """The least singular value of the Jacobian, turns counted with `LEVER` [m].

    Raises:
        PlanError: it is below ``least`` [m] somewhere.
    """
    weight, found = np.array([1.0, 1.0, 1.0, LEVER, LEVER, LEVER])[:, None], np.inf
    for way in ways:
        J = np.array([place.model.kinematics(q)[2] for q in way.q])
        smallest = np.linalg.svd(weight * J, compute_uv=False)[:, -1]
        k = int(np.argmin(smallest))
        if smallest[k] < least:
            raise refused(
                place,
                way.leg,
                k,
                f"the arm is singular, its joints move the tool one way by {1e3 * smallest[k]:.0f} mm a radian; "
                f"expected {1e3 * least:.0f} mm",
                PLACE,
            )
        found = min(found, float(smallest[k]))
    return found


def carried(place: Workplace, ways: Sequence[Way], most: float) -> Worst:
    """The largest share of a joint's torque that weight alone takes on the ways through the air.

    Raises:
        PlanError: it is more than ``most``.
    """
    model, found = place.model, Worst(value=0.0, what="no joint")
    strongest, rest = np.minimum(model.effort_limit, place.limits.torque), np.zeros(model.n)
    for way in ways:
        share = np.abs([model.at(State(t=0.0, q=q, dq=rest)).g for q in way.q]) / strongest
        k, joint = (int(i) for i in np.unravel_index(np.argmax(share), share.shape))
        if share[k, joint] > most:
            raise refused(
                place,
                way.leg,
                k,
                f"joint {joint + 1} needs {100 * share[k, joint]:.0f} % of its torque to carry arm and tool; expected "
                f"{100 * most:.0f} % at most",
                "Use a lighter tool, or move the mould nearer",
            )
        if share[k, joint] > found.value:
            found = Worst(value=float(share[k, joint]), what=f"joint {joint + 1}")
    return found


def clearances(place: Workplace, ways: Sequence[Way], tool: PolishingTool, least: float) -> Clearances:
    """The least distances over the whole way, strokes and air.

    The tip may touch the mould on a stroke only; in the air it stays as far off as the mould may stand aside.

    Raises:
        PlanError: something comes nearer than ``least`` [m] to what stands around, the tip nearer than the uncertainty,
            or two parts of the arm nearer than the supervisor lets them.
    """
    q = np.concatenate([way.q for way in ways])
    p, R = np.concatenate([way.leg.p for way in ways]), np.concatenate([way.leg.R for way in ways])
    obstacles = mould_obstacles(place.mould, place.placement)
    body, _ = tool_parts(tool, p, R)
    # The last capsule of the limits goes on to the tool point: to the sensor here, where the body begins.
    links = arm_parts(place.limits, q, p - tool.length * R[:, :, 2])
    far = least + BEYOND
    near = [least_to_obstacle(part, obstacle, far) for part in [*links, body] for obstacle in obstacles]
    near += [least_to_floor(part, far) for part in [*links[1:], body]]
    around = min(near, key=lambda one: one.distance)
    if around.distance < least:
        raise _collision(place, ways, around, least, PLACE)
    for way in ways:
        if way.leg.nodes is None:
            _check_tip(place, way, tool, obstacles)
    return Clearances(around=around, itself=_itself(place, ways))


def _itself(place: Workplace, ways: Sequence[Way]) -> Near | None:
    """The least distance of the arm's parts from each other, by the supervisor's shapes and pairs."""
    limits = place.limits
    q, p = np.concatenate([way.q for way in ways]), np.concatenate([way.leg.p for way in ways])
    parts = arm_parts(limits, q, p)
    if not parts or not len(limits.pairs):
        return None
    far = limits.self_slow + BEYOND
    near = [least_between(parts[int(a)], parts[int(b)], far) for a, b in limits.pairs]
    itself = min(near, key=lambda one: one.distance)
    if itself.distance < limits.self_slow:
        raise _collision(place, ways, itself, limits.self_slow, "Move or turn the mould, away from the arm's base")
    return itself


def _check_tip(place: Workplace, way: Way, tool: PolishingTool, obstacles: Sequence[Obstacle]) -> None:
    """Refuse a way through the air on which the tip would touch."""
    _, tip = tool_parts(tool, way.leg.p, way.leg.R)
    far = way.leg.uncertainty + BEYOND
    near = min((least_to_obstacle(tip, obstacle, far) for obstacle in obstacles), key=lambda one: one.distance)
    if near.distance < way.leg.uncertainty - SLACK:
        remedy = "Leave out what lies beside a higher part of the mould, or split the plan"
        raise _collision(place, [way], near, way.leg.uncertainty, remedy)


def _collision(place: Workplace, ways: Sequence[Way], near: Near, least: float, remedy: str) -> PlanError:
    """The refusal of the pose at which two things are too near."""
    pose = near.pose
    for way in ways:
        if pose < len(way.q):
            break
        pose -= len(way.q)
    if near.distance <= 0.0:
        reason = f"the {near.first} runs into the {near.second}"
    else:
        reason = f"the {near.first} comes within {1e3 * near.distance:.1f} mm of the {near.second}"
    return refused(place, way.leg, pose, f"{reason}; expected {1e3 * least:.0f} mm at least", remedy)
