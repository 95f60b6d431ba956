"""A polishing cell in simulation: the job with a simulated arm under it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from burnish.control.force import ForceMotion
from burnish.control.gears import LearntFriction
from burnish.control.joint import ComputedTorque
from burnish.control.observer import MomentumSense
from burnish.control.wrench import ContactSense, WristSense
from burnish.core import Array, Sample
from burnish.model.ik import inverse_kinematics
from burnish.model.model import Model
from burnish.model.tool import PolishingTool
from burnish.paths.hertz import recommended_step
from burnish.paths.raster import raster
from burnish.paths.stroke import Stroke
from burnish.polish.cell import HOME, READY, Placement, nominal_placement, tool_down
from burnish.polish.moves import Moves, five_touches
from burnish.polish.process import Job
from burnish.polish.recipe import MARGIN, Recipe
from burnish.runtime.limits import Limits
from burnish.runtime.loop import Rig
from burnish.runtime.supervisor import Supervisor
from burnish.sim.arms import Arm
from burnish.sim.robot import SimRobot
from burnish.sim.scene import Workpiece
from burnish.surface import DistanceGrid, Mould

SLIDE = 2e-3
"""How far a mould may stand from where it is meant to [m]."""
TURN = np.deg2rad(2.0)
"""How far it may be turned [rad]."""


@dataclass(frozen=True, kw_only=True)
class WristFelt:
    """Feel with the wrist sensor."""

    least_touch: float = WristSense.least_touch
    """Least force that counts as a touch [N], however little noise there is."""

    def sense(self, tool: PolishingTool, arm: Arm) -> ContactSense:
        """The sense for this tool on this arm."""
        return WristSense(mass=tool.mass, com=tool.com, offset=tool.length, least_touch=self.least_touch)


@dataclass(frozen=True, kw_only=True)
class JointFelt:
    """Feel with the joint torque sensors."""

    least_touch: float = MomentumSense.least_touch
    """Least force that counts as a touch [N], however little noise there is."""

    def sense(self, tool: PolishingTool, arm: Arm) -> ContactSense:
        """The sense for this tool on this arm, whose nominal rotors it knows."""
        return MomentumSense(armature=arm.armature, least_touch=self.least_touch)


def check_size(mould: Mould, tool: PolishingTool) -> None:
    """Refuse at once a mould whose corners the arm cannot reach from above: planning over it may take minutes.

    Raises:
        PlanError: says which corner, and how near the arm comes.
    """
    model = tool.on(Model.jaco2())
    low, high = mould.vertices.min(axis=0), mould.vertices.max(axis=0)
    corners = np.array([(x, y, high[2]) for x in (low[0] + MARGIN, high[0] - MARGIN)
                        for y in (low[1] + MARGIN, high[1] - MARGIN)])  # fmt: skip
    for corner in nominal_placement(float(high[2])).points(corners):
        inverse_kinematics(model, corner, tool_down(model), READY)


def plan_strokes(mould: Mould, grid: DistanceGrid, recipe: Recipe, tool: PolishingTool) -> list[Stroke]:
    """The tool path over a mould, with the step that its force and tip recommend on a flat."""
    return raster(
        mould,
        grid,
        tip_radius=tool.tip_radius,
        step=recommended_step(recipe.force, tool.tip_radius, 0.0, tool.modulus),
        feed=recipe.feed,
        force=recipe.force,
        margin=MARGIN,
    )


def simulated_job(
    grid: DistanceGrid,
    strokes: list[Stroke],
    arm: Arm,
    *,
    rate: float,
    felt: WristFelt | JointFelt,
    tool: PolishingTool,
    on_phase: Callable[[str], None],
    real_grid: DistanceGrid | None = None,
    stands: Placement | None = None,
    finder: Callable[[Moves], Iterator[Sample]] = five_touches,
) -> tuple[Job, SimRobot]:
    """A job and the simulated arm that does it.

    Args:
        grid: distance to the mould that was planned for.
        strokes: the tool path, mould frame.
        arm: the arm; the job sees its nominal figures only.
        rate: control rate [Hz].
        felt: what the arm feels with.
        tool: the tool in its hand.
        on_phase: called at the start of each phase.
        real_grid: the mould that really lies there; the planned one without it.
        stands: where it really stands, but for what the arm draws; where it is meant to without it.
        finder: how the job finds it.
    """
    points = np.concatenate([stroke.points for stroke in strokes])
    placement = nominal_placement(float(points[:, 2].max()))
    there = placement if stands is None else stands
    real = Workpiece(grid=grid if real_grid is None else real_grid, p=there.p, R=there.R)
    rig, robot = simulated_rig(arm, real, rate=rate, felt=felt, tool=tool)
    job = Job(
        rig=rig,
        tool=tool,
        grid=grid,
        strokes=strokes,
        placement=placement,
        upright=tool_down(rig.model),
        law=law_for(arm, rate, tool, felt),
        travel=travel_law(arm),
        home=HOME,
        uncertainty=SLIDE + TURN * half_size(points),
        finder=finder,
        on_phase=on_phase,
    )
    return job, robot


def simulated_rig(
    arm: Arm, workpiece: Workpiece, *, rate: float, felt: WristFelt | JointFelt, tool: PolishingTool
) -> tuple[Rig, SimRobot]:
    """A simulated arm at home over a work-piece, with the model that its controller may have of it."""
    model = tool.on(Model.jaco2()).with_armature(arm.armature)
    robot = SimRobot(HOME, rate=rate, plant=arm.plant, tool=tool, workpiece=workpiece)
    return Rig(robot, model, Supervisor(limits=Limits.jaco2(), period=1.0 / rate), felt.sense(tool, arm)), robot


def travel_law(arm: Arm) -> ComputedTorque:
    """The joint-space law of the motion from and to home."""
    return ComputedTorque.at_frequency(10.0, friction=arm.friction)


def law_for(arm: Arm, rate: float, tool: PolishingTool, felt: WristFelt | JointFelt) -> ForceMotion:
    """Gains for the dead time of the loop: what acts T late can be held no faster than about a third of 1/T.

    The brake along the normal is a loop of its own, D_n/m fast, and turns into a motor at 1.5/T.

    T is the delay, half a period of holding, half of differencing positions, and the sensor's filter. The friction of a
    joint that turns round is to be there when it does: by trial 1.5 T ahead. How much it is the law learns.
    """
    dead = (arm.delay + 1.0) / rate + 1e-3
    omega = min(40.0, 0.29 / dead)
    law = ForceMotion(
        position_frequency=omega,
        orientation_frequency=omega,
        friction=None if arm.friction is None else LearntFriction(nominal=arm.friction),
        friction_ahead=1.5 * dead,
        normal_rate=0.5 / dead,
        surface_friction=tool.friction,
        contact_force=0.6 * felt.least_touch,
        spinning=tool.spinning,
    )
    return law.against(tool.stiffness)


def half_size(points: Array) -> float:
    """Half of the larger side of the points in plan [m]."""
    return 0.5 * float((points[:, :2].max(axis=0) - points[:, :2].min(axis=0)).max())
