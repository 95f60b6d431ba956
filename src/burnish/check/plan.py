"""Whether an arm can do a plan, from home over every stroke and back, decided before anything moves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from burnish.check.clear import Clearances, carried, clearances, singularity
from burnish.check.demand import Demand, demand
from burnish.check.on_mould import at_point, check_on_mould
from burnish.check.route import route, sparse
from burnish.check.scaling import derated
from burnish.check.ways import PLACE, Way, Workplace, Worst, followed, from_home, joint_margin
from burnish.core import Array
from burnish.paths.ease import followable
from burnish.paths.stroke import Stroke
from burnish.polish.feasible import track
from burnish.polish.process import SLOWEST, timed
from burnish.polish.recipe import Bounds, Recipe
from burnish.trajectory import TimedPath
from burnish.trajectory.path import feed_share

ALIKE = 0.999
"""Share of a feed that counts as all of it."""
ROUNDS = 6
"""Times that a stroke is timed anew before it is given up."""


@dataclass(frozen=True, kw_only=True)
class CheckedPlan:
    """A plan that the arm can do, with feeds that its joints can follow."""

    strokes: tuple[Stroke, ...]
    """The strokes, mould frame."""
    duration: float
    """Time of the strokes, without the ways between them [s]."""
    speed: Worst
    """Joint speed, in shares of its limit."""
    torque: Worst
    """Joint torque, in shares of its limit."""
    joint_margin: Worst
    """Least distance from a joint limit [rad]."""
    singularity: float
    """Least motion of the tool for a turn of the joints by 1 rad [m]."""
    clearances: Clearances
    """Least distances of arm and tool."""
    notes: tuple[str, ...]
    """What was changed or could not be checked, one sentence each."""

    @property
    def length(self) -> float:
        """Length of all strokes [m]."""
        return sum(stroke.length for stroke in self.strokes)


@dataclass(frozen=True, kw_only=True)
class _Timed:
    """A stroke in time, and what it asks of the joints."""

    stroke: Stroke
    path: TimedPath
    demand: Demand


def check(
    place: Workplace,
    strokes: Sequence[Stroke],
    recipe: Recipe,
    *,
    made_for: str | None = None,
    touched: Sequence[Stroke] = (),
) -> CheckedPlan:
    """Refuse a plan that cannot be done, or lower its feed where that is enough; nothing moves.

    The way is that of `Job`: from home to the touches, over every stroke, and back. It is followed pose by pose, each
    from the solution of the one before, 10 mm or 0.05 rad apart; distances are those at these poses, to within 0.5 mm.

    Args:
        place: the arm, the tool and the mould.
        strokes: mould frame.
        recipe: its tool, and its limits.
        made_for: fingerprint of the mould that the plan names, if it names one.
        touched: strokes along which the mould is touched to find it, where those are others.

    Raises:
        PlanError: names the stroke, the place, the reason and the remedy.
    """
    tool, bounds = recipe.tool, recipe.limits
    check_on_mould(strokes, place.mould, place.grid, tip_radius=tool.tip_radius, made_for=made_for)
    slow = [_turned(bounds, number, stroke) for number, stroke in enumerate(strokes)]
    paths = [timed(stroke, place.placement, place.upright, tool.tip_radius) for stroke in slow]
    found_by = touched or strokes
    legs = route(found_by, paths, placement=place.placement, upright=place.upright, uncertainty=place.uncertainty)
    ways = followed(place, list(legs))
    margin = joint_margin(place, ways, bounds.joint_margin)
    singular = singularity(place, ways, bounds.singularity)
    passes = [way for way in ways if way.leg.nodes is not None]
    done = [
        _scaled(place, recipe, number, asked, stroke, path, way)
        for number, (asked, stroke, path, way) in enumerate(zip(strokes, slow, paths, passes, strict=True))
    ]
    torques = [_torque(bounds, number, one) for number, one in enumerate(done)]
    torques.append(carried(place, [way for way in ways if way.leg.nodes is None], bounds.joint_torque))
    whole = [from_home(place, ways[0].q[0]), *ways, from_home(place, ways[-1].q[-1])]
    clear = clearances(place, whole, tool, bounds.clearance)
    result = tuple(one.stroke for one in done)
    return CheckedPlan(
        strokes=result,
        duration=sum(one.path.duration for one in done),
        speed=max((_worst(one.demand.speed) for one in done), key=lambda worst: worst.value),
        torque=max(torques, key=lambda worst: worst.value),
        joint_margin=margin,
        singularity=singular,
        clearances=clear,
        notes=tuple(_notes(recipe, strokes, result, clear)),
    )


def _turned(bounds: Bounds, number: int, stroke: Stroke) -> Stroke:
    """The stroke, with a lower feed where the surface turns the tool too fast over most of it.

    Over a crest or a fillet alone the timing slows down by itself.

    Raises:
        PlanError: that is too little of the feed.
    """
    share = feed_share(stroke.points, stroke.axes, stroke.feed)
    if share < bounds.least_feed:
        k = int(np.argmin(followable(stroke).feed / stroke.feed))
        reason = (
            f"the surface turns the tool too fast, the wrist's joints can follow {100 * share:.0f} % of the feed; "
            f"expected {100 * bounds.least_feed:.0f} % at least"
        )
        remedy = f"Lower the feed to {1e3 * share / bounds.least_feed * float(np.mean(stroke.feed)):.2g} mm/s"
        raise at_point(number, stroke, k, reason, remedy)
    return stroke if share >= SLOWEST else followable(stroke)


def _scaled(
    place: Workplace, recipe: Recipe, number: int, asked: Stroke, stroke: Stroke, path: TimedPath, way: Way
) -> _Timed:
    """A stroke with the feed that the joints can follow.

    Raises:
        PlanError: that is too little of the feed that was asked for.
    """
    bounds, tool = recipe.limits, recipe.tool
    nodes, q = sparse(path), way.q
    for _ in range(ROUNDS):
        found = demand(place.model, path, nodes, q, limits=place.limits, tool=tool)
        share = found.speed.max(axis=1)
        _check_feed(bounds, number, asked, stroke, found)
        if share.max() <= bounds.joint_speed:
            return _Timed(stroke=stroke, path=path, demand=found)
        arc = _arc(stroke, path)[found.nodes]
        speed = np.linalg.norm(path.v[found.nodes, :3], axis=1)
        stroke = derated(stroke, arc, speed, share, bounds.joint_speed)
        path = timed(stroke, place.placement, place.upright, recipe.tool.tip_radius)
        nodes = sparse(path)
        again = track(place.model, path.p[nodes], path.R[nodes], way.q[0])
        if again.failure is not None:
            raise at_point(number, asked, 0, f"the arm cannot follow at a lower feed, {again.failure}", PLACE)
        q = again.q
    k = int(np.argmin(np.abs(stroke.arc - arc[int(np.argmax(share))])))
    reason = f"a joint needs {100 * share.max():.0f} % of its speed after {ROUNDS} lower feeds"
    raise at_point(number, asked, k, f"{reason}; expected {100 * bounds.joint_speed:.0f} %", PLACE)


def _check_feed(bounds: Bounds, number: int, asked: Stroke, stroke: Stroke, found: Demand) -> None:
    """Refuse a stroke that had to be slowed down too much."""
    left = stroke.feed / followable(asked).feed
    k = int(np.argmin(left))
    if left[k] < bounds.least_feed:
        reason = (
            f"the feed of {1e3 * asked.feed[k]:.3g} mm/s is too fast for the arm, it can follow {100 * left[k]:.0f} % "
            f"of it, where {_worst(found.speed).what} is the fastest; expected {100 * bounds.least_feed:.0f} % at least"
        )
        remedy = f"Lower the feed to {1e3 * stroke.feed[k] / bounds.least_feed:.2g} mm/s, or move the mould"
        raise at_point(number, asked, k, reason, remedy)


def _torque(bounds: Bounds, number: int, one: _Timed) -> Worst:
    """The largest share of a joint's torque on a stroke.

    Raises:
        PlanError: it is too much.
    """
    worst, torque = _worst(one.demand.torque), one.demand.torque.max(axis=1)
    if worst.value > bounds.joint_torque:
        node = int(one.demand.nodes[int(np.argmax(torque))])
        k = int(np.argmin(np.abs(one.stroke.arc - _arc(one.stroke, one.path)[node])))
        reason = (
            f"{worst.what} needs {100 * worst.value:.0f} % of its torque, pressing with {one.path.force[node]:.3g} N; "
            f"expected {100 * bounds.joint_torque:.0f} % at most"
        )
        raise at_point(number, one.stroke, k, reason, "Lower the force, use a lighter tool, or move the mould nearer")
    return worst


def _arc(stroke: Stroke, path: TimedPath) -> Array:
    """Where on the stroke each node of its path is [m], (N,)."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path.p, axis=0), axis=1))])
    return np.asarray(along * stroke.length / along[-1])


def _worst(shares: Array) -> Worst:
    """The largest of shares (N, n), and its joint."""
    joint = int(np.argmax(shares.max(axis=0)))
    return Worst(value=float(shares[:, joint].max()), what=f"joint {joint + 1}")


def _notes(recipe: Recipe, asked: Sequence[Stroke], done: Sequence[Stroke], clear: Clearances) -> Iterator[str]:
    """What was changed, and what could not be checked."""
    feed, least = min(recipe.of_pass(one).feed for one in recipe.worked), [float(one.feed.min()) for one in asked]
    slow = [value for value in least if value < ALIKE * feed]
    if slow and recipe.even is None:
        yield (
            f"{len(slow)} of {len(asked)} strokes are planned slower than the recipe says, down to "
            f"{1e3 * min(slow):.2g} mm/s: along a fillet the wrist can do no more, and a repair has a feed of its own"
        )
    turned = [followable(stroke) for stroke in asked]
    left = np.concatenate(
        [np.minimum(1.0, after.feed / before.feed) for before, after in zip(turned, done, strict=True)]
    )
    if left.min() < 1.0:
        yield (
            f"the feed was lowered over {100 * np.mean(left < 1.0):.0f} % of the path, to {100 * left.min():.0f} % at "
            "least, so that no joint is too fast"
        )
    slowed = [n for n, (before, after) in enumerate(zip(asked, done, strict=True), 1) if before is not after]
    if slowed and left.min() == 1.0:
        yield (f"the feed of {len(slowed)} strokes was lowered where the surface turns the tool too fast for the wrist")
    if clear.itself is None:
        yield "the limits know no shapes of this arm: its links were not checked against themselves and the mould"
