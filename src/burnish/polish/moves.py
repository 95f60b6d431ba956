"""What the arm does around a mould, whatever the work: cross it, feel for it, find where it stands, lift off."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from math import sqrt

import numpy as np

from burnish.control.force import ForceMotion, with_felt
from burnish.control.joint import ComputedTorque
from burnish.core import Array, Controller, Dynamics, Ref, Sample, Source, State
from burnish.model.ik import inverse_kinematics
from burnish.model.tool import PolishingTool
from burnish.paths.stroke import Stroke
from burnish.polish.cell import READY, Placement
from burnish.polish.feasible import joint_travel_time, travel_time
from burnish.polish.locate import doubt_left, locate, touch_points, untold
from burnish.runtime.loop import Rig, control
from burnish.surface import DistanceGrid
from burnish.trajectory import Cubic, CubicPose, Descend, HoldPose
from burnish.trajectory.path import tool_rotation

APPROACH_SPEED = 5e-3
"""Speed of a guarded approach [m/s]; a stiff tip is slower, see `gently`."""
LIGHT, MASS = 2.75, 15.0
"""Force of a first touch [N] beyond which the approach is slower, and mass that is felt then [kg]: what tips of 10 to
100 kN/m meet at v costs v √(k m) in trials, late readings and rotors included."""
TRAVEL_SPEED = 0.05
"""Largest mean speed in free air [m/s]."""
FREE_SPEED = 0.1
"""Largest speed of the tool on its way from and to home [m/s]; the supervisor brakes it from 0.126 m/s on."""
CLEARANCE = 3e-3
"""Height at which an approach starts above the nearest place where the mould may stand [m]."""
OVERHEAD = 15e-3
"""Height above the mould at which the tool crosses it [m]; a tilted tip of 20 mm hangs 1 mm lower than its apex."""
NEARBY = 5e-3
"""Way so short that the tool need not rise for it [m]."""
SEARCH = 6e-3
"""How far below its nominal place a mould is still looked for [m]."""


def gently(speed: float, tool: PolishingTool) -> float:
    """A speed to touch with [m/s], so much less as a stiff tip makes the touch harder."""
    touch = APPROACH_SPEED * sqrt(with_felt(tool.stiffness) * MASS)
    return speed * min(1.0, LIGHT / touch)


def five_touches(moves: Moves) -> Iterator[Sample]:
    """Find a mould that is nearly in its place: from home to it, and touch it at five points of its upper side."""
    points = np.concatenate([stroke.points for stroke in moves.strokes])
    normals = np.concatenate([stroke.normals for stroke in moves.strokes])
    order = touch_points(points)
    targets = moves.placement.points(points[order])
    outward = moves.placement.directions(normals[order])
    first = targets[0] + (moves.uncertainty + 0.05) * np.array([0.0, 0.0, 1.0])
    q = inverse_kinematics(moves.rig.model, first, moves.upright, READY)
    yield from moves.joints(nearest_turn(moves.rig.model.lower, moves.home, q))
    centres: list[Array] = []
    for p, n in zip(targets, outward, strict=True):
        yield from moves.approach("touch", p, n, tool_rotation(n, moves.upright))
        if moves.stopping:
            return
        centres.append(moves.tip_centre())
        yield from moves.lift(n)
    touched = np.array(centres)
    moves.placement = locate(moves.grid, moves.placement, touched, moves.tool.tip_radius)
    moves.untold = untold(doubt_left(moves.grid, moves.placement, touched, moves.tool.tip_radius))
    # What is left is the error of a touch, not of the mounting.
    moves.uncertainty = 1e-3


@dataclass(kw_only=True)
class Moves:
    """The moves that jobs on a mould share; `phase` says which part of the job the last sample belongs to."""

    rig: Rig
    """Robot, model (tool frame at the tip's apex), supervisor and sense."""
    tool: PolishingTool
    """The tool."""
    grid: DistanceGrid
    """Distance to the mould, in its frame."""
    strokes: list[Stroke]
    """What is to be touched, in the mould's frame."""
    placement: Placement
    """Where the mould stands: nominal at first, located after the touches."""
    upright: Array
    """Tool rotation about which the tool turns least, base ← tool, (3, 3)."""
    law: ForceMotion
    """Law of all motion with the tool."""
    travel: ComputedTorque
    """Law of the motion from and to home."""
    home: Array
    """Joint positions at the start and at the end [rad], (n,)."""
    uncertainty: float
    """How far the surface may lie from its nominal place [m]."""
    finder: Callable[[Moves], Iterator[Sample]] = five_touches
    """How the mould is found; `search.Wide` looks for one that may stand centimetres away."""
    on_phase: Callable[[str], None] = lambda phase: None
    """Called at the start of each phase."""
    phase: str = field(default="start", init=False)
    """The phase of the last sample."""
    failure: str | None = field(default=None, init=False)
    """Why the job gave up, or None."""
    untold: str = field(default="", init=False)
    """What the touches could not tell of where the mould stands, in words."""
    _interrupted: bool = field(default=False, init=False)

    def interrupt(self) -> None:
        """Ask for an early end: the tool lifts off and the arm comes to rest. Safe in a signal handler."""
        self._interrupted = True

    @property
    def interrupted(self) -> bool:
        """Whether somebody asked for an early end."""
        return self._interrupted

    @property
    def stopping(self) -> bool:
        """Whether the job is to end now. Every behaviour then ends before its next cycle."""
        return self._interrupted or self.failure is not None or self.rig.supervisor.tripped

    def find(self) -> Iterator[Sample]:
        """From home to the mould; touch it and take its placement from what was felt."""
        yield from self.finder(self)

    def approach(self, phase: str, p: Array, n: Array, R: Array) -> Iterator[Sample]:
        """Go above a point, tare in free air, and descend along its normal until it is felt."""
        yield from self.across(p + (self.uncertainty + CLEARANCE) * n, R)
        yield from self.tare()
        descent = Descend(direction=-n, R=R, speed=gently(APPROACH_SPEED, self.tool))
        felt = Felt(direction=n, force=self.rig.sense.touch_threshold(n))
        depth = 2.0 * self.uncertainty + CLEARANCE + SEARCH
        yield from self.drive(phase, descent, self.law, lambda arm: felt(arm) or descent.depth(arm) > depth)
        if not self.stopping and not felt.sure:
            self.failure = (
                f"nothing was touched down to {1e3 * (depth - self.uncertainty - CLEARANCE):.0f} mm below where the "
                f"mould is meant to be at ({p[0]:.3f}, {p[1]:.3f}, {p[2]:.3f}) m. Check that it is mounted"
            )

    def lift(self, n: Array) -> Iterator[Sample]:
        """Off the surface along its normal."""
        arm = self.arm()
        yield from self.pose(arm.p + (self.uncertainty + CLEARANCE + 5e-3) * n, arm.R, phase="lift")

    def tare(self) -> Iterator[Sample]:
        """Stand still in free air and take what is felt there as nothing."""
        start = self.arm().t
        readings: list[tuple[Dynamics, State]] = []
        for sample in self.drive("tare", HoldPose(), self.law, lambda arm: arm.t - start > 0.6):
            if sample.arm.t - start > 0.2 and self.rig.state is not None:
                readings.append((sample.arm, self.rig.state))
            yield sample
        if readings:
            self.rig.sense.tare(readings)
            self.rig.feel()

    def across(self, p: Array, R: Array) -> Iterator[Sample]:
        """To a pose next to the mould: up, across above its highest point, and down. A chord would graze a dome."""
        arm = self.arm()
        ceiling = self.ceiling()
        if float(np.linalg.norm(p[:2] - arm.p[:2])) > NEARBY:
            if arm.p[2] < ceiling:
                yield from self.pose(np.array([arm.p[0], arm.p[1], ceiling]), arm.R)
            yield from self.pose(np.array([p[0], p[1], ceiling]), R)
        yield from self.pose(p, R)

    def ceiling(self) -> float:
        """Height above which nothing of the mould can be [m], base frame."""
        tops = [float(self.placement.points(stroke.points)[:, 2].max()) for stroke in self.strokes]
        return max(tops) + self.uncertainty + OVERHEAD

    def pose(self, p: Array, R: Array, phase: str = "move") -> Iterator[Sample]:
        """Straight to a tool pose in free air."""
        arm = self.arm()
        way = float(np.linalg.norm(p - arm.p))
        duration = max(0.8, way / TRAVEL_SPEED, travel_time(self.rig.model, arm.q, p, R))
        motion = CubicPose(p=p, R=R, duration=duration)
        yield from self.drive(phase, motion, self.law, motion.arrived)

    def joints(self, q: Array, phase: str = "move") -> Iterator[Sample]:
        """To joint positions, at most at half of the joint speeds."""
        motion = Cubic(q=q, duration=max(1.0, joint_travel_time(self.rig.model, self.arm().q, q, FREE_SPEED)))
        yield from self.drive(phase, motion, self.travel, motion.arrived)

    def drive(
        self, phase: str, source: Source[Ref], law: Controller[Ref], until: Callable[[Dynamics], bool]
    ) -> Iterator[Sample]:
        """`control`, which ends as soon as the job is stopping."""
        yield from self.always(phase, source, law, lambda arm: self.stopping or until(arm))

    def always(
        self, phase: str, source: Source[Ref], law: Controller[Ref], until: Callable[[Dynamics], bool]
    ) -> Iterator[Sample]:
        """`control` under the name of a phase, stopping or not."""
        self.phase = phase
        self.on_phase(phase)
        yield from control(self.rig, source, law, until=until)

    def arm(self) -> Dynamics:
        """The arm as it was measured last."""
        return self.rig.arm if self.rig.arm is not None else self.rig.read()

    def tip_centre(self) -> Array:
        """Centre of the tip where it touches now, its spring pressed by the force that is felt [m], (3,)."""
        arm = self.arm()
        assert arm.F is not None
        axis = arm.R[:, 2]
        pressed = max(0.0, -float(axis @ arm.F[:3])) / self.tool.stiffness
        return np.asarray(arm.p - (self.tool.tip_radius + pressed) * axis)


@dataclass(kw_only=True)
class Felt:
    """True once the force along ``direction`` has been above ``force`` at two samples in a row."""

    direction: Array
    force: float
    _count: int = field(default=0, init=False)

    @property
    def sure(self) -> bool:
        """Whether it has been felt."""
        return self._count >= 2

    def __call__(self, arm: Dynamics) -> bool:
        """Count this sample."""
        if not self.sure:
            touching = arm.F is not None and float(self.direction @ arm.F[:3]) > self.force
            self._count = self._count + 1 if touching else 0
        return self.sure


def nearest_turn(lower: Array, home: Array, q: Array) -> Array:
    """``q`` with every continuous joint turned by whole turns to where it is nearest to ``home``."""
    turns = np.round((home - q) / (2.0 * np.pi))
    return np.where(np.isfinite(lower), q, q + 2.0 * np.pi * turns)
