"""What the arm is at when something goes wrong: it holds, tracks, is operated, or presses and slides."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any, Protocol

import numpy as np

from burnish.campaign.blocks import Block, dome, plate
from burnish.campaign.operator import RoughHand
from burnish.control.force import ForceMotion
from burnish.control.joint import ComputedTorque
from burnish.control.operational import OperationalSpace
from burnish.core import Array, Controller, Dynamics, Sample, Source, State
from burnish.errors import PlanError
from burnish.model.ik import inverse_kinematics
from burnish.model.model import Model
from burnish.model.tool import PolishingTool
from burnish.paths.stroke import Stroke
from burnish.polish.cell import HOME, READY, Placement, nominal_placement, tool_down
from burnish.polish.cellsim import WristFelt, law_for
from burnish.polish.moves import Felt
from burnish.polish.process import timed
from burnish.rotation import exp
from burnish.runtime.loop import Rig, control
from burnish.runtime.operating import operator
from burnish.sim.arms import Arm
from burnish.sim.scene import Workpiece
from burnish.teleop.modes import Panel
from burnish.teleop.modes_b import BASE, MIXED, TOOL, ModesB
from burnish.teleop.reference import Pace
from burnish.trajectory import Descend, Hold, HoldPose, Sine, SurfacePath
from burnish.trajectory.path import tool_rotation

SPREAD = 0.35
"""How far from home a task in the air may start, each joint [rad]."""
ROOM = np.deg2rad(25.0)
"""Distance from the joint limits at which it starts [rad]."""
TOOL_SPEED = 0.12
"""Largest speed of the tool in a task that is tracked [m/s]; half of what stops the arm."""
APPROACH_SPEED = 5e-3
"""Of a guarded approach [m/s], as in polishing."""
TARE_TIME = 0.2
"""For which the tool stands in the air before it presses [s]."""
LED = 18.0
"""Natural frequency with which the tool follows a hand [rad/s]."""
DEPTH = 8e-3
"""After which an approach gives up [m]."""

Wrap = Callable[[Controller[Any]], Controller[Any]]
"""Puts the faults of a controller around a law."""


class Task(Protocol):
    """Something that the arm is at."""

    q: Array
    """Joint positions at the start [rad], (n,)."""
    workpiece: Workpiece | None
    """What lies under the tool."""

    def run(self, rig: Rig, wrap: Wrap) -> Iterator[Sample]:
        """Its cycles, for as long as they are asked for."""


@dataclass(kw_only=True)
class InAir:
    """A law along a source, and nothing to touch."""

    q: Array
    source: Source[Any]
    law: Controller[Any]
    workpiece: Workpiece | None = None

    def run(self, rig: Rig, wrap: Wrap) -> Iterator[Sample]:
        """All cycles."""
        yield from control(rig, self.source, wrap(self.law))


@dataclass(kw_only=True)
class Operated:
    """A hand that leads the tool through the air, as ``burnish teleop`` lets it."""

    q: Array
    law: Controller[Any]
    hand: RoughHand
    modes: ModesB
    """Which of the operator's axes are the base's and which the tool's."""
    workpiece: Workpiece | None = None

    def run(self, rig: Rig, wrap: Wrap) -> Iterator[Sample]:
        """All cycles."""
        panel = Panel(modes=self.modes)
        moved = operator(read=self.hand.read, panel=panel, supervisor=rig.supervisor, pace=Pace.near_people())
        yield from control(rig, moved, wrap(self.law))


@dataclass(kw_only=True)
class PressAndSlide:
    """Tare, come down until the mould is felt, press, and rub along a path."""

    q: Array
    workpiece: Workpiece | None
    law: ForceMotion
    stroke: Stroke
    """Path in the mould's frame."""
    upright: Array
    """Tool rotation about which the tool turns least, base ← tool, (3, 3)."""
    approach: float = APPROACH_SPEED
    """Speed of the approach [m/s]."""
    blind: bool = False
    """Whether the approach takes no notice of what it meets."""

    def run(self, rig: Rig, wrap: Wrap) -> Iterator[Sample]:
        """All cycles; a held arm stays where it is in them."""
        assert self.workpiece is not None, "there is something to press on"
        law, place = wrap(self.law), Placement(p=self.workpiece.p, R=self.workpiece.R)
        yield from self._tare(rig, law)
        point, normal = place.points(self.stroke.points[:1])[0], place.directions(self.stroke.normals[:1])[0]
        down = Descend(direction=-normal, R=tool_rotation(normal, self.upright), speed=self.approach)
        felt = Felt(direction=normal, force=rig.sense.touch_threshold(normal))
        deep = 8.0 * DEPTH if self.blind else DEPTH
        yield from self._drive(rig, down, law, lambda arm: (felt(arm) and not self.blind) or down.depth(arm) > deep)
        assert rig.arm is not None
        # One touch tells the height; the tilt is left to the force.
        there = Placement(p=place.p + rig.arm.p - point, R=place.R)
        yield from control(rig, SurfacePath(path=timed(self.stroke, there, self.upright)), law)

    def _tare(self, rig: Rig, law: Controller[Any]) -> Iterator[Sample]:
        readings: list[tuple[Dynamics, State]] = []
        for sample in self._drive(rig, HoldPose(), law, lambda arm: arm.t > TARE_TIME):
            if rig.state is not None:
                readings.append((sample.arm, rig.state))
            yield sample
        rig.sense.tare(readings)
        rig.feel()

    @staticmethod
    def _drive(
        rig: Rig, source: Source[Any], law: Controller[Any], until: Callable[[Dynamics], bool]
    ) -> Iterator[Sample]:
        """A behaviour that a held arm does not leave."""
        yield from control(rig, source, law, until=lambda arm: not rig.supervisor.tripped and until(arm))


@dataclass(frozen=True, kw_only=True)
class Setting:
    """What a task is drawn for."""

    arm: Arm
    """The drawn arm."""
    rate: float
    """Control rate [Hz]."""
    duration: float
    """Time that the task must fill [s]."""
    near_edge: bool = False
    """Whether the path leads over the edge of the mould."""
    plunge: float | None = None
    """Speed of an approach that does not look for the mould [m/s]."""
    near_limit: bool = False
    """Whether joint 2 or 3 starts just outside the soft margin of its limit."""


def hold(rng: np.random.Generator, setting: Setting) -> Task:
    """Hold joint positions."""
    return InAir(q=_start(rng, setting), source=Hold(), law=_joint_law(setting))


def track(rng: np.random.Generator, setting: Setting) -> Task:
    """Track a sine with every joint."""
    q, period = _start(rng, setting), rng.uniform(2.5, 5.0)
    amplitude = rng.uniform(0.02, 0.15, 6) * rng.choice([-1.0, 1.0], 6)
    fastest = 2.0 * np.pi / period * np.abs(nominal_model().kinematics(q)[2][:3]) @ np.abs(amplitude)
    amplitude *= min(1.0, TOOL_SPEED / float(np.linalg.norm(fastest)))
    return InAir(q=q, source=Sine(amplitude=amplitude, period=float(period)), law=_joint_law(setting))


def teleoperate(rng: np.random.Generator, setting: Setting) -> Task:
    """Follow an operator's hand with the tool."""
    q, seed, mode = _start(rng, setting), int(rng.integers(2**31)), (BASE, MIXED, TOOL)[int(rng.integers(3))]
    return Operated(
        q=q,
        law=OperationalSpace.at_frequency(LED, friction=setting.arm.friction),
        hand=RoughHand(seed=seed, period=1.0 / setting.rate),
        modes=ModesB(mode=mode, fitted=False),
    )


def press_and_slide(rng: np.random.Generator, setting: Setting) -> Task:
    """Press on a flat or a convex mould and rub along a closed curve, or over its edge."""
    edge = setting.near_edge
    block = plate(edge) if edge or rng.uniform() < 0.5 else dome()
    stroke = _stroke(rng, block, setting)
    placement = nominal_placement(block.top)
    upright = tool_down(nominal_model())
    plant = setting.arm.plant
    # Where the arm starts is no secret of the controller's: a little above the mould as it really stands.
    R = exp(plant.mould_turn) @ placement.R
    n = R @ stroke.normals[0]
    gap = rng.uniform(0.5e-3, 1.5e-3) if setting.plunge is None else setting.plunge * rng.uniform(0.3, 0.6)
    p = R @ stroke.points[0] + placement.p + plant.mould_shift + gap * n
    nominal = placement.directions(stroke.normals[:1])[0]
    try:
        q = inverse_kinematics(nominal_model(), p, tool_rotation(nominal, upright), READY)
    except PlanError as error:
        raise AssertionError("the mould stands where the arm reaches all of it") from error
    return PressAndSlide(
        q=q,
        workpiece=Workpiece(grid=block.grid, p=placement.p, R=placement.R),
        law=law_for(setting.arm, setting.rate, tool(), WristFelt()),
        stroke=stroke,
        upright=upright,
        approach=APPROACH_SPEED if setting.plunge is None else setting.plunge,
        blind=setting.plunge is not None,
    )


TASKS = (hold, track, teleoperate, press_and_slide)
"""All of them."""
IN_AIR = (hold, track, teleoperate)
"""Those that touch nothing."""
JOINTS = (hold, track)
"""Those of the joints."""


@cache
def tool() -> PolishingTool:
    """The tool in the arm's hand."""
    return PolishingTool()


@cache
def nominal_model() -> Model:
    """The arm with its tool, without rotor inertia: for kinematics and weight."""
    return tool().on(Model.jaco2())


def _joint_law(setting: Setting) -> ComputedTorque:
    return ComputedTorque.at_frequency(10.0, friction=setting.arm.friction)


def _start(rng: np.random.Generator, setting: Setting) -> Array:
    """Joint positions in the air, away from limits and singularities."""
    model = nominal_model()
    while True:
        q = HOME + rng.uniform(-SPREAD, SPREAD, 6)
        if setting.near_limit:
            joint = int(rng.integers(1, 3))
            inside = np.deg2rad(16.0)
            low = bool(rng.uniform() < 0.5)
            q[joint] = model.lower[joint] + inside if low else model.upper[joint] - inside
            return q
        p, _, J = model.kinematics(q)
        if model.limit_distance(q).min() > ROOM and p[2] > 0.05 and np.linalg.svd(J, compute_uv=False)[-1] > 0.05:
            return q


def _stroke(rng: np.random.Generator, block: Block, setting: Setting) -> Stroke:
    """A closed curve on the top of a block, or a line over its edge."""
    feed, force = rng.uniform(0.01, 0.03), rng.uniform(3.0, 15.0)
    length = feed * (setting.duration + 1.0)
    if setting.near_edge:
        x = np.arange(-4e-3, 40e-3, 1e-3)
        plan = np.column_stack([block.half - 10e-3 + x, np.full(len(x), rng.uniform(-20e-3, 20e-3))])
    else:
        sides = rng.uniform(10e-3, 25e-3, 2)
        way = float(2.0 * np.pi * np.sqrt(0.5 * (sides @ sides)))
        angle = rng.uniform(0.0, 2.0 * np.pi) + np.linspace(0.0, 2.0 * np.pi * length / way, max(8, int(length / 1e-3)))
        plan = np.column_stack([sides[0] * np.cos(angle), sides[1] * np.sin(angle)])
    points, normals = block.surface(plan)
    count = len(points)
    return Stroke(points=points, normals=normals, feed=np.full(count, feed), force=np.full(count, force))
