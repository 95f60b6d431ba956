"""The job: go there, find the mould by touch, press and rub along each stroke, come back."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from burnish.control.joint import GravityCompensation
from burnish.core import Array, Sample, ToolReference
from burnish.errors import PlanError
from burnish.finish.dwell import FIRST, RAMP, STAND
from burnish.model.ik import inverse_kinematics
from burnish.paths.stroke import Stroke
from burnish.polish.cell import READY, Placement
from burnish.polish.drift import Drift
from burnish.polish.feasible import JointPath, follow
from burnish.polish.learn import Learner
from burnish.polish.life import Abrasive
from burnish.polish.moves import Moves
from burnish.polish.passes import Leg, legs_of, split
from burnish.trajectory import CubicPose, Hold, SurfacePath, TimedPath
from burnish.trajectory.path import feed_share, time_path, tool_rotation

ACCELERATION = 0.1
"""Along and across the path [m/s²]: slow in the turns, where friction changes its sign in every joint."""
SLOWEST = 0.67
"""Share of the feed, on the mean, below which a stroke is refused instead of slowed: a crest or a fillet may be."""
SETTLE = RAMP + STAND
"""Time from touch to the start of the pass [s]."""


@dataclass(kw_only=True)
class Job(Moves):
    """One job on one mould; `run` yields its samples, `phase` says which part of it they belong to."""

    legs: list[Leg] = field(default_factory=list)
    """What is to be worked, in order; all strokes once if it is left empty."""
    abrasive: Abrasive = field(default_factory=Abrasive)
    """What the tool rubs with; the job pauses where it is worn."""
    learner: Learner = field(default_factory=Learner)
    """Corrects the height of the path from pass to pass."""
    drift: Drift = field(default_factory=Drift)
    """Watches the stiffness of the contact from pass to pass."""
    stroke: int = field(default=0, init=False)
    """Number of the leg under work."""
    follower: SurfacePath | None = field(default=None, init=False)
    """The pass under way, for progress."""
    worked: float = field(default=0.0, init=False)
    """Path length of the stroke under work that is done [m]."""
    located: bool = field(default=False, init=False)
    """Whether the mould was found, and the work has begun."""
    pause: str | None = field(default=None, init=False)
    """Why the job ended before all was worked, though nothing went wrong."""
    _at: Array | None = field(default=None, init=False, repr=False)

    def __post_init__(self) -> None:
        if not self.legs:
            self.legs = legs_of([self.strokes])

    @property
    def leg(self) -> Leg:
        """The leg under work."""
        return self.legs[self.stroke]

    def plan(self) -> tuple[list[TimedPath], JointPath]:
        """The timed legs at today's placement, checked.

        Raises:
            PlanError: if the arm cannot follow them.
        """
        paths = [self._timed(leg) for leg in self.legs]
        reaches = [follow(self.rig.model, path) for path in paths]
        return paths, max(reaches, key=lambda reach: reach.speed_share)

    def working_joints(self) -> Array:
        """Joint positions in the middle of the first stroke, for a picture [rad], (n,)."""
        stroke = max(self.strokes, key=lambda stroke: stroke.length)
        k = len(stroke.points) // 2
        normal, axis = stroke.normals[k : k + 1], stroke.axes[k : k + 1]
        p = self.placement.points(stroke.points[k : k + 1] + self.tool.tip_radius * (normal + axis))[0]
        R = tool_rotation(-self.placement.directions(axis)[0], self.upright)
        return inverse_kinematics(self.rig.model, p, R, READY)

    def run(self) -> Iterator[Sample]:
        """All samples of the job, to the arm at rest."""
        try:
            yield from self.find()
            self.located = not self.stopping
            paths, _ = self.plan() if not self.stopping else ([], None)
            for number, path in enumerate(paths):
                if self.stopping or self.pause is not None:
                    break
                self.stroke = number
                yield from self._leg(path)
        except PlanError as error:
            self.failure = str(error)
        yield from self._end()

    def _timed(self, leg: Leg) -> TimedPath:
        return timed(leg.path, self.placement, self.upright, self.tool.tip_radius)

    def _leg(self, path: TimedPath) -> Iterator[Sample]:
        """A leg as far as the abrasive lasts, with what earlier passes have learnt of the height there."""
        leg = self.leg
        self.worked = leg.begun + leg.lead
        lasts = self.abrasive.lasts(leg)
        if lasts == 0.0:
            self.pause = f"{self.abrasive.says()}: change it"
            return
        leg, rest = split(leg, lasts)
        known = self.learner.corrected(leg)
        if known is not leg:
            path = self._timed(known)
        elif rest is not None:
            path = self._timed(leg)
        yield from self._work(leg, path)
        if rest is not None and not self.stopping:
            self.pause = f"{self.abrasive.says()}: change it"

    def _work(self, leg: Leg, path: TimedPath) -> Iterator[Sample]:
        """Approach the start of a leg, press, rub along it, lift off."""
        yield from self.approach("approach", path.p[0], path.normal[0], path.R[0])
        self.follower, self._at = SurfacePath(path=path), None
        along = reached(leg.path, self.placement, self.upright, self.tool.tip_radius)
        for sample in self.drive("lead-in" if leg.lead else "pass", self.follower, self.law, self.follower.arrived):
            self._rub(sample, leg, along)
            yield sample
            if self.phase == "lead-in" and self.worked > leg.begun + leg.lead:
                self.phase = "pass"
                self.on_phase("pass")
        if not self.stopping:
            self.follower = None
            self.worked = leg.begun + leg.path.length
            self.learner.end(leg)
            yield from self.lift(path.normal[-1])

    def _rub(self, sample: Sample, leg: Leg, along: Array) -> None:
        """Note how far the tool has come, what the abrasive has done, and what the contact says of the height."""
        arm, reference = sample.arm, sample.reference
        assert isinstance(reference, ToolReference), "asked only in a pass"
        assert reference.normal is not None, "asked only in a pass"
        assert self.follower is not None, "asked only in a pass"
        node = min(int(self.follower.share(arm) * self.follower.path.duration / self.follower.path.dt), len(along) - 1)
        speed = float(np.linalg.norm(reference.v[:3]))
        lag = float(reference.v[:3] @ (reference.p - arm.p)) / speed if speed > 1e-4 else 0.0
        force = 0.0 if arm.F is None else float(reference.normal @ arm.F[:3])
        off = float(reference.normal @ (arm.p - reference.p))
        s = max(leg.begun, leg.begun + float(along[node]) - lag)
        self.abrasive.rub(max(0.0, s - self.worked), max(0.0, force))
        self.worked = max(self.worked, s)
        if speed > 1e-4:
            self.learner.add(leg, float(along[node]), off, force - reference.force)
            self.drift.rubbed(leg.number, off)
        else:
            self.drift.pressed(leg.number, self.stroke, off, force)
        self._at = arm.p

    def _left(self, sample: Sample) -> None:
        """What the tool still rubs while it is lifted counts, by the share of the force that is left.

        So a job that goes on at `worked` removes there what is missing, and not twice.
        """
        arm = sample.arm
        if self._at is None or self.follower is None or arm.F is None:
            return
        force, wanted = -float(arm.R[:, 2] @ arm.F[:3]), float(self.leg.path.force.mean())
        way = float(np.linalg.norm((arm.p - self._at)[:2]))
        if force > 0.0:
            self.worked += min(force / wanted, 1.0) * way
            self.abrasive.rub(way, force)
        self._at = arm.p

    def _end(self) -> Iterator[Sample]:
        """Leave the arm at rest: held by the supervisor, lifted off, or back home."""
        supervisor = self.rig.supervisor
        if supervisor.tripped:
            start = self.arm().t
            for sample in self.always("stopped", Hold(), GravityCompensation(), lambda arm: arm.t - start > 1.0):
                self._left(sample)
                yield sample
            return
        early = self.stopping
        arm = self.arm()
        lifted = CubicPose(p=arm.p + 0.05 * np.array([0.0, 0.0, 1.0]), R=arm.R, duration=1.5)
        for sample in self.always("retract", lifted, self.law, lifted.arrived):
            self._left(sample)
            yield sample
        if not early:
            yield from self.joints(self.home)
        still = Hold()
        yield from self.always("rest", still, self.travel, lambda arm: float(np.abs(arm.dq).max()) < np.deg2rad(1.0))


def reached(stroke: Stroke, placement: Placement, upright: Array, tip_radius: float | None = None) -> Array:
    """Path length of a stroke at each node of its `timed` path [m], (N,); 0 while it stands.

    The length rides along in the place of the force, so the same rule times both.
    """
    along = _moving(replace(stroke, force=stroke.arc), placement, upright, tip_radius).force
    stands = len(timed(stroke, placement, upright, tip_radius).p) - len(along)
    return np.concatenate([np.zeros(stands), along])


def timed(stroke: Stroke, placement: Placement, upright: Array, tip_radius: float | None = None) -> TimedPath:
    """A stroke in time, where the mould stands, with the force ramp at its start.

    Args:
        stroke: mould frame.
        placement: where the mould stands.
        upright: rotation about which the tool turns least, base ← tool, (3, 3).
        tip_radius: radius of the tip [m], over which the contact rolls when the tool leans; an upright one needs none.

    Raises:
        PlanError: if the surface turns the tool too fast for the wrist over most of the stroke, or the tool leans and
            no radius is given.
    """
    return _moving(stroke, placement, upright, tip_radius).with_ramp(RAMP, STAND, FIRST)


def _moving(stroke: Stroke, placement: Placement, upright: Array, tip_radius: float | None) -> TimedPath:
    """The same without the ramp."""
    axes = stroke.axes
    if tip_radius is None and stroke.tilt.angle != 0.0:
        raise PlanError("the tool leans over its tip, whose radius is unknown; expected tip_radius in m")
    share = feed_share(stroke.points, axes, stroke.feed)
    if share < SLOWEST:
        raise PlanError(
            f"the path needs more joint speed than the arm has: over this surface the wrist can follow "
            f"{100 * share:.0f} % of the feed; expected at least {100 * SLOWEST:.0f} %. "
            f"Lower the feed to {1e3 * share * float(np.mean(stroke.feed)):.0f} mm/s"
        )
    return time_path(
        placement.points(stroke.points),
        placement.directions(stroke.normals),
        stroke.feed,
        stroke.force,
        upright,
        acceleration=ACCELERATION,
        axes=placement.directions(axes),
        tip_radius=0.0 if tip_radius is None else tip_radius,
        stiffness=stroke.stiffness,
    )
