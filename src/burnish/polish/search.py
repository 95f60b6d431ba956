"""Find a mould that may stand centimetres away: touch it where the guesses differ most, until they agree.

Guesses of where it stands are drawn over the whole doubt. Each touch pulls every guess onto what was felt, and those
that would have stood in the tip's free way are dropped. The next touch goes to where the guesses that are left
disagree most, from above or, at its sides, level with the upper edge; so the first ones find height, sides and yaw,
and the later ones make the fit well conditioned, without a rule for any shape.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from burnish.core import Array, Sample
from burnish.errors import InputError, PlanError
from burnish.model.ik import inverse_kinematics, solve
from burnish.polish.cell import READY, Placement
from burnish.polish.guesses import Doubt, Guesses
from burnish.polish.locate import GATE, TOUCH_DOUBT, untold
from burnish.polish.moves import APPROACH_SPEED, CLEARANCE, Felt, Moves, gently, nearest_turn
from burnish.surface import DistanceGrid
from burnish.trajectory import Descend

MOST_TOUCHES = 12
"""Guarded moves after which the search ends, those that met nothing included."""
COUNT = 250
"""Guesses that are kept."""
ROUNDS = 6
"""How often new guesses are drawn when too few are left."""
AGREED = 0.12e-3
"""Spread of the guesses where they differ most, at which they agree [m]; about what a touch is good for."""
LEAST_TOUCHES = 8
"""Guarded moves that are made at least: two more than there are unknowns, so that the residual means something."""
WRONG = 1e-3
"""What a guess may be off at a touch, or stand in a way that was free, before it is dropped [m]."""
MISSED = 0.15
"""Share of the guesses that a next touch may miss."""
HASTE = 10e-3
"""Speed of a guarded move over a way of more than `LONG` [m/s]."""
LONG = 12e-3
"""Way over which nobody wants to creep [m]."""
OFF = 8e-3
"""Way off the surface after a touch [m]."""
LEVEL = 3e-3
"""Height of the tip's centre over the upper edge at a touch from the side [m]: low enough to push sideways, high enough
to stay off the table with half a tip."""


@dataclass(frozen=True, kw_only=True)
class Line:
    """A guarded move that could be made."""

    start: Array
    """Centre of the tip at its start, base frame [m], (3,)."""
    way: Array
    """Unit vector, base axes, (3,)."""
    far: float
    """How far it goes at most [m]."""


@dataclass(frozen=True, kw_only=True)
class Found:
    """Where the mould stands, and how well that is known."""

    placement: Placement
    """The best fit."""
    residual: float
    """What is left at the worst touch [m]."""
    touches: int
    """Guarded moves that were made."""
    spread: Array
    """Standard deviation of shift and turn at the touched places, base axes [m, rad], (6,)."""

    @property
    def untold(self) -> str:
        """What the touches cannot tell, in words; empty if nothing."""
        return untold(self.spread)


@dataclass(kw_only=True)
class Search:
    """What is known so far of where a mould stands."""

    grid: DistanceGrid
    """Distance to the mould, in its frame; wide enough for a tip beside it."""
    radius: float
    """Of the tip [m]."""
    nominal: Placement
    """Where it is meant to stand."""
    doubt: Doubt
    """How far it may stand from there."""
    points: Array
    """Points of its upper side where it may be touched, its frame [m], (N, 3)."""
    seed: int = 0
    """Of the guesses."""
    guesses: Guesses = field(init=False)
    """Those that explain everything so far."""
    centres: list[Array] = field(default_factory=list, init=False)
    """Centre of the tip at each touch, base frame [m]."""
    made: int = field(default=0, init=False)
    """Guarded moves so far."""
    _free: list[Array] = field(default_factory=list, init=False, repr=False)

    def __post_init__(self) -> None:
        room = min(float(self.grid.values[[0, -1]].min()), float(self.grid.values[:, [0, -1]].min()))
        if not room > self.radius:
            raise InputError(
                f"the grid ends {1e3 * room:.0f} mm beside the mould; a tip of {1e3 * self.radius:g} mm that feels for "
                "its sides needs more: DistanceGrid.of(mould, aside=0.03)"
            )
        self._rng = np.random.default_rng(self.seed)
        self.guesses = Guesses.drawn(self.nominal, self.doubt, COUNT, self._rng)
        low, high = self.points.min(axis=0), self.points.max(axis=0)
        self._low, self._high, self._pivot = low, high, 0.5 * (low + high)

    def lines(self) -> list[Line]:
        """Guarded moves to choose from: down onto the upper side, and level from every side, by the middle guess."""
        place = self.guesses.one(self.guesses.middle())
        away = float(np.linalg.norm(self._high - self._low)) + 2.0 * self.doubt.slide
        top = float(place.points(self.points)[:, 2].max())
        rise = 2.0 * self.doubt.height + 0.5 * away * self.doubt.tilt + self.radius + CLEARANCE
        pick = self.points[:: max(1, len(self.points) // 30)]
        lines = [
            Line(start=np.array([x, y, top + rise]), way=np.array([0.0, 0.0, -1.0]), far=rise + self._drop())
            for x, y, _ in place.points(pick)
        ]
        return lines if not self.centres else [*lines, *self._level(place, away)]

    def _drop(self) -> float:
        """How deep under the highest point it is worth to feel: never as deep as the table [m]."""
        return max(1e-3, min(float(self._high[2]) - self.radius, 0.5 * float(self._high[2])))

    def _level(self, place: Placement, away: float) -> list[Line]:
        """From the sides, at three places of each, at the height of the upper edge there."""
        lines = []
        for axis in (0, 1):
            other = 1 - axis
            for sign in (-1.0, 1.0):
                for share in (-0.7, 0.0, 0.7):
                    edge = self._pivot.copy()
                    edge[axis] = self._high[axis] if sign > 0 else self._low[axis]
                    edge[other] += share * 0.5 * (self._high - self._low)[other]
                    edge[2] = self.points[np.argmin(np.linalg.norm((self.points - edge)[:, :2], axis=1)), 2] + LEVEL
                    out = sign * place.R[:, axis] * [1.0, 1.0, 0.0]
                    out /= np.linalg.norm(out)
                    start = place.points(edge[None])[0] + away * out
                    lines.append(Line(start=start, way=-out, far=away + 0.5 * float(np.ptp(self.points[:, axis]))))
        return lines

    def next(self) -> list[Line]:
        """The guarded moves that would tell most, best first, cut to where the guesses expect the surface."""
        ranked = []
        for line in self.lines():
            t = self.guesses.met(self.grid, line.start, line.way, self.radius, line.far)
            hit = np.isfinite(t)
            missed = 1.0 - float(hit.mean())
            if not hit.any() or (self.centres and missed > MISSED):
                continue
            low, high = float(t[hit].min()), float(t[hit].max())
            back = min(low, CLEARANCE + 2e-3)
            begin = low - back
            cut = Line(start=line.start + begin * line.way, way=line.way, far=min(high + 4e-3, line.far) - begin)
            if self._clear(cut.start):
                # Before anything is felt no height is known, and the surest touch is the best one.
                ranked.append((-missed if not self.centres else float(t[hit].std()), cut))
        return [line for _, line in sorted(ranked, key=lambda pair: -pair[0])]

    def spread(self) -> float:
        """How far the guesses differ where they differ most [m]."""
        worst = 0.0
        for line in self.lines():
            t = self.guesses.met(self.grid, line.start, line.way, self.radius, line.far)
            hit = np.isfinite(t)
            if hit.mean() > 1.0 - MISSED:
                worst = max(worst, float(t[hit].std()))
        return worst

    def _clear(self, start: Array) -> bool:
        """Whether no guess stands where the tip comes down to a start."""
        column = start + np.linspace(0.0, 0.06, 5)[:, None] * [0.0, 0.0, 1.0]
        return bool(self.guesses.gaps(self.grid, column, self.radius).min() > 1e-3)

    def felt(self, way: Array, centre: Array | None) -> None:
        """A guarded move went along these centres of the tip (N, 3), and felt the mould at the last one, or nowhere.

        Raises:
            PlanError: no guess explains all that was felt.
        """
        self.made += 1
        reach = way if centre is None else way[np.linalg.norm(way - centre, axis=1) > WRONG]
        self._free += [reach[:: max(1, len(reach) // 12)]] if len(reach) else []
        if centre is not None:
            self.centres.append(centre)
        scale, good = self.doubt.scale(), None
        fresh = self.guesses
        for _ in range(ROUNDS):
            agreed = self._agreeing(self._fitted(fresh, scale))
            good = agreed if good is None else good.with_more(agreed)
            if len(good) >= COUNT // 2:
                break
            more = Guesses.drawn(self.nominal, self.doubt, COUNT, self._rng)
            fresh = more if len(good) < 8 else good.near(COUNT // 2, self._rng).with_more(more)
        assert good is not None
        if not len(good):
            raise PlanError(
                f"the touched points do not fit the mould anywhere within {1e3 * self.doubt.slide:.0f} mm and "
                f"{np.rad2deg(self.doubt.yaw):.0f}° of where it is meant to stand, to {1e3 * WRONG:.0f} mm. "
                "Check that this mould is mounted, and how"
            )
        self.guesses = good.kept(np.arange(len(good)) < COUNT)

    def _fitted(self, guesses: Guesses, scale: Array) -> Guesses:
        if not self.centres:
            return guesses
        noise = TOUCH_DOUBT * self._rng.normal(size=(len(guesses), len(self.centres)))
        return guesses.pulled(self.grid, np.array(self.centres), self.radius, scale, noise)

    def _agreeing(self, guesses: Guesses) -> Guesses:
        """Those that pass through every touch, stand in no free way, and are within the doubt."""
        good = np.ones(len(guesses), dtype=bool)
        if self.centres:
            good &= np.abs(guesses.gaps(self.grid, np.array(self.centres), self.radius)).max(axis=1) < WRONG
        if self._free:
            good &= guesses.gaps(self.grid, np.concatenate(self._free), self.radius).min(axis=1) > -WRONG
        # The middle of the mould, not its origin: a turn about the middle moves nothing.
        pivot = np.einsum("kij,j->ki", guesses.R, self._pivot) + guesses.p
        meant = self.nominal.points(self._pivot[None])[0]
        slack = 1.2
        good &= np.linalg.norm((pivot - meant)[:, :2], axis=1) < slack * self.doubt.slide + 5e-3
        turn = guesses.R @ self.nominal.R.T
        good &= np.abs(np.arctan2(turn[:, 1, 0], turn[:, 0, 0])) < slack * self.doubt.yaw
        good &= turn[:, 2, 2] > np.cos(2.0 * self.doubt.tilt)
        return guesses.kept(good)

    def found(self) -> Found:
        """The best fit of all touches.

        Raises:
            PlanError: a touch lies further than 0.5 mm off the located surface.
        """
        centres = np.array(self.centres)
        start = self.guesses.kept(np.arange(len(self.guesses)) == self.guesses.middle())
        # Nearly without a prior: the middle guess alone fills in what the touches leave open.
        fit = start.pulled(self.grid, centres, self.radius, self.doubt.scale(), np.zeros((1, len(centres))))
        worst = float(np.abs(fit.gaps(self.grid, centres, self.radius)).max())
        if not worst <= GATE:
            raise PlanError(
                f"the touched points do not fit the mould: {1e3 * worst:.1f} mm is left at one; expected at most "
                f"{1e3 * GATE:.1f} mm. Check that this mould is mounted, and how"
            )
        spread = self.guesses.offsets()
        middle = np.einsum("kij,j->ki", self.guesses.R, self._pivot) + self.guesses.p
        return Found(
            placement=fit.one(0),
            residual=worst,
            touches=self.made,
            spread=np.concatenate([middle.std(axis=0), spread[:, 3:].std(axis=0)]),
        )

    def done(self) -> bool:
        """Whether the guesses agree, or there have been touches enough."""
        return self.made >= MOST_TOUCHES or (self.made >= LEAST_TOUCHES and self.spread() < AGREED)


@dataclass(kw_only=True)
class Wide:
    """Finds a mould for a job: up to twelve guarded moves over the whole doubt."""

    doubt: Doubt = field(default_factory=Doubt)
    """How far it may stand from where it is meant to."""
    found: Found | None = field(default=None, init=False)
    """The result, once there is one."""

    def __call__(self, moves: Moves) -> Iterator[Sample]:
        """From home to the mould, touch it until it is found; the job's placement is then where it stands."""
        points = np.concatenate([stroke.points for stroke in moves.strokes])
        search = Search(
            grid=moves.grid, radius=moves.tool.tip_radius, nominal=moves.placement, doubt=self.doubt, points=points
        )
        moves.uncertainty = self.doubt.height + self.doubt.tilt * 0.5 * float(np.ptp(points[:, :2], axis=0).max())
        above = moves.placement.points(0.5 * (points.min(axis=0) + points.max(axis=0))[None])[0]
        above[2] = moves.ceiling() + 0.02
        q = inverse_kinematics(moves.rig.model, above, moves.upright, READY)
        yield from moves.joints(nearest_turn(moves.rig.model.lower, moves.home, q))
        while not search.done() and not moves.stopping:
            line = reachable(moves, search.next())
            yield from _feel(moves, search, line)
        if moves.stopping:
            return
        self.found = search.found()
        moves.placement, moves.untold = self.found.placement, self.found.untold
        moves.uncertainty = 1e-3


def reachable(moves: Moves, lines: list[Line]) -> Line:
    """The first line whose both ends the arm reaches with the tool upright.

    Raises:
        PlanError: there is none.
    """
    axis = moves.upright[:, 2]
    for line in lines:
        for centre in (line.start, line.start + line.far * line.way):
            _, position, rotation = solve(moves.rig.model, centre + moves.tool.tip_radius * axis, moves.upright, READY)
            if position > 1e-4 or rotation > 1e-3:
                break
        else:
            return line
    raise PlanError(
        f"none of the {len(lines)} touches that would tell where the mould stands is within the arm's reach; "
        "move the mould nearer to the base, or say more exactly where it stands"
    )


def _feel(moves: Moves, search: Search, line: Line) -> Iterator[Sample]:
    """One guarded move, and what it tells."""
    R, r = moves.upright, moves.tool.tip_radius
    yield from moves.across(line.start + r * R[:, 2], R)
    yield from moves.tare()
    speed = gently(APPROACH_SPEED if line.far < LONG else HASTE, moves.tool)
    descent = Descend(direction=line.way, R=R, speed=speed)
    felt = Felt(direction=-line.way, force=moves.rig.sense.touch_threshold(-line.way))
    way: list[Array] = []

    def ended(arm: object) -> bool:
        way.append(moves.tip_centre())
        return felt(moves.arm()) or descent.depth(moves.arm()) > line.far

    yield from moves.drive("touch", descent, moves.law, ended)
    if moves.stopping:
        return
    search.felt(np.array(way), moves.tip_centre() if felt.sure else None)
    arm = moves.arm()
    yield from moves.pose(arm.p - OFF * line.way, arm.R, phase="lift")
