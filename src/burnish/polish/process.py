"""The job: go there, find the mould by touch, press and rub along each stroke, come back."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from burnish.control.joint import GravityCompensation
from burnish.core import Array, Sample
from burnish.errors import PlanError
from burnish.model.ik import inverse_kinematics
from burnish.polish.cell import READY, Placement
from burnish.polish.feasible import JointPath, follow
from burnish.polish.moves import Moves
from burnish.polish.stroke import Stroke
from burnish.trajectory import CubicPose, Hold, SurfacePath, TimedPath
from burnish.trajectory.path import feed_share, time_path, tool_rotation

ACCELERATION = 0.1
"""Along and across the path [m/s²]: slow in the turns, where friction changes its sign in every joint."""
SLOWEST = 0.67
"""Share of the feed, on the mean, below which a stroke is refused instead of slowed: a crest or a fillet may be."""
SETTLE = 1.0
"""Time from touch to the start of the pass [s]; half of it is the force ramp."""


@dataclass(kw_only=True)
class Job(Moves):
    """One job on one mould; `run` yields its samples, `phase` says which part of it they belong to."""

    stroke: int = field(default=0, init=False)
    """Number of the stroke under work."""
    follower: SurfacePath | None = field(default=None, init=False)
    """The pass under way, for progress."""

    def plan(self) -> tuple[list[TimedPath], JointPath]:
        """The timed strokes at today's placement, checked.

        Raises:
            PlanError: if the arm cannot follow them.
        """
        paths = [timed(stroke, self.placement, self.upright) for stroke in self.strokes]
        reaches = [follow(self.rig.model, path) for path in paths]
        return paths, max(reaches, key=lambda reach: reach.speed_share)

    def working_joints(self) -> Array:
        """Joint positions in the middle of the first stroke, for a picture [rad], (n,)."""
        stroke = max(self.strokes, key=lambda stroke: stroke.length)
        k = len(stroke.points) // 2
        p, n = (
            self.placement.points(stroke.points[k : k + 1])[0],
            self.placement.directions(stroke.normals[k : k + 1])[0],
        )
        return inverse_kinematics(self.rig.model, p, tool_rotation(n, self.upright), READY)

    def run(self) -> Iterator[Sample]:
        """All samples of the job, to the arm at rest."""
        try:
            yield from self.find()
            paths, _ = self.plan() if not self.stopping else ([], None)
            for self.stroke, path in enumerate(paths):
                yield from self._work(path)
        except PlanError as error:
            self.failure = str(error)
        yield from self._end()

    def _work(self, path: TimedPath) -> Iterator[Sample]:
        """Approach the start of a stroke, press, rub along it, lift off."""
        yield from self.approach("approach", path.p[0], path.normal[0], tool_rotation(path.normal[0], self.upright))
        self.follower = SurfacePath(path=path)
        yield from self.drive("pass", self.follower, self.law, self.follower.arrived)
        self.follower = None
        yield from self.lift(path.normal[-1])

    def _end(self) -> Iterator[Sample]:
        """Leave the arm at rest: held by the supervisor, lifted off, or back home."""
        supervisor = self.rig.supervisor
        if supervisor.tripped:
            start = self.arm().t
            yield from self.always("stopped", Hold(), GravityCompensation(), lambda arm: arm.t - start > 1.0)
            return
        early = self.stopping
        arm = self.arm()
        lifted = CubicPose(p=arm.p + 0.05 * np.array([0.0, 0.0, 1.0]), R=arm.R, duration=1.5)
        yield from self.always("retract", lifted, self.law, lifted.arrived)
        if not early:
            yield from self.joints(self.home)
        still = Hold()
        yield from self.always("rest", still, self.travel, lambda arm: float(np.abs(arm.dq).max()) < np.deg2rad(1.0))


def timed(stroke: Stroke, placement: Placement, upright: Array) -> TimedPath:
    """A stroke in time, where the mould stands, with the force ramp at its start.

    Raises:
        PlanError: if the surface turns the tool too fast for the wrist over most of the stroke.
    """
    share = feed_share(stroke.points, stroke.normals, stroke.feed)
    if share < SLOWEST:
        raise PlanError(
            f"the path needs more joint speed than the arm has: over this surface the wrist can follow "
            f"{100 * share:.0f} % of the feed; expected at least {100 * SLOWEST:.0f} %. "
            f"Lower the feed to {1e3 * share * float(np.mean(stroke.feed)):.0f} mm/s"
        )
    path = time_path(
        placement.points(stroke.points),
        placement.directions(stroke.normals),
        stroke.feed,
        stroke.force,
        upright,
        acceleration=ACCELERATION,
    )
    return path.with_ramp(0.5 * SETTLE, 0.5 * SETTLE)
