"""Teaching and replaying in simulation: the sessions with a simulated arm under them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from typing_extensions import Self

from burnish.control.operational import OperationalSpace
from burnish.core import Array, Source, ToolReference
from burnish.model.ik import inverse_kinematics
from burnish.model.tool import PolishingTool
from burnish.polish.cell import HOME, READY, Placement, nominal_placement, tool_down
from burnish.polish.cellsim import SLIDE, TURN, JointFelt, WristFelt, half_size, law_for, simulated_rig, travel_law
from burnish.polish.moves import nearest_turn
from burnish.rotation import exp
from burnish.runtime.loop import Rig
from burnish.sim.arms import Arm
from burnish.sim.robot import SimRobot
from burnish.sim.scene import Workpiece
from burnish.surface import DistanceGrid, Mould
from burnish.teach.cleanup import Taught
from burnish.teach.execute import HoldForce, OpenLoop
from burnish.teach.replay import Track
from burnish.teach.train import READY_HEIGHT, Train


@dataclass(frozen=True, kw_only=True)
class Cell:
    """A simulated arm with a tool, and the mould in front of it."""

    arm: Arm
    """The arm; what it really is is known to the simulator alone."""
    mould: Mould
    """The mould."""
    grid: DistanceGrid
    """Distance to it."""
    rate: float
    """Control rate [Hz]."""
    felt: WristFelt | JointFelt
    """What the arm feels with."""
    tool: PolishingTool
    """The tool in its hand."""
    placement: Placement
    """Where the mould is meant to stand."""

    @classmethod
    def of(
        cls, arm: Arm, mould: Mould, grid: DistanceGrid, rate: float, felt: WristFelt | JointFelt, tool: PolishingTool
    ) -> Self:
        """With the mould at its usual place."""
        placement = nominal_placement(float(mould.vertices[:, 2].max()))
        return cls(arm=arm, mould=mould, grid=grid, rate=rate, felt=felt, tool=tool, placement=placement)

    def moved(self, shift: Array, turn: Array) -> Cell:
        """With the mould moved, as it stands and not as it is meant to, by a shift [m] and a turn [rad] that are known.

        Base axes, about the origin of the mould's frame. What nobody knows about where it stands moves along.
        """
        R, plant = exp(turn), self.arm.plant
        plant = replace(plant, mould_shift=R @ plant.mould_shift, mould_turn=R @ plant.mould_turn)
        return replace(self, arm=replace(self.arm, plant=plant), placement=moved_placement(self.placement, shift, turn))

    def rig(self) -> tuple[Rig, SimRobot]:
        """The arm at home; every session has one of its own."""
        real = Workpiece(grid=self.grid, p=self.placement.p, R=self.placement.R)
        return simulated_rig(self.arm, real, rate=self.rate, felt=self.felt, tool=self.tool)

    def stands(self) -> Placement:
        """Where the mould really stands: for a judge, never for a session."""
        plant = self.arm.plant
        return Placement(p=self.placement.p + plant.mould_shift, R=exp(plant.mould_turn) @ self.placement.R)

    def train(self, rig: Rig, operator: Source[ToolReference], mode: Callable[[], str]) -> Train:
        """A session in which this operator shows something."""
        top = float(self.placement.points(self.mould.vertices)[:, 2].max())
        middle = np.array([*self.placement.p[:2], top + READY_HEIGHT])
        shared = self._shared(rig, middle, tool_down(rig.model))
        return Train(operator=operator, mode=mode, operator_law=self.operator_law(), top=top, **shared)

    def hold_force(self, rig: Rig, taught: Taught, *, repeats: int, speed: float) -> HoldForce:
        """A session that replays what was taught with its force.

        Raises:
            PlanError: if the arm cannot get to its start.
        """
        taught_at = taught.demonstration.placement
        # The mould is where it stood, as far as the demonstration told, moved by what this cell's was moved by.
        R = self.placement.R @ taught_at.R.T
        stands = Placement(p=self.placement.p + R @ (taught.placement.p - taught_at.p), R=R @ taught.placement.R)
        strokes = taught.strokes(self.tool.tip_radius)
        first = self.placement.points(taught.demonstration.p[:1])[0]
        session = HoldForce(
            taught=taught,
            repeats=repeats,
            speed=speed,
            **self._shared(rig, first, self.placement.R @ taught.demonstration.R[0]),
        )
        session.strokes, session.placement = strokes, stands
        return session

    def open_loop(self, rig: Rig, track: Track, *, repeats: int) -> OpenLoop:
        """A session that replays poses alone.

        Raises:
            PlanError: if the arm cannot get to the first one.
        """
        return OpenLoop(
            track=track,
            follower=self.operator_law(),
            repeats=repeats,
            **self._shared(rig, track.p[0], track.R[0]),
        )

    def operator_law(self) -> OperationalSpace:
        """The law with which an operator's references are followed: no integral, so pressed it is a spring."""
        omega = law_for(self.arm, self.rate, self.tool, self.felt).position_frequency
        return OperationalSpace.at_frequency(omega, friction=self.arm.friction)

    def _shared(self, rig: Rig, p: Array, R: Array) -> dict[str, Any]:
        """What all sessions have; (p, R) is the tool in the ready pose."""
        q = inverse_kinematics(rig.model, p, R, READY)
        return {
            "rig": rig,
            "tool": self.tool,
            "grid": self.grid,
            "strokes": [],
            "placement": self.placement,
            "upright": tool_down(rig.model),
            "law": law_for(self.arm, self.rate, self.tool, self.felt),
            "travel": travel_law(self.arm),
            "home": HOME,
            "uncertainty": SLIDE + TURN * half_size(self.mould.vertices),
            "ready": nearest_turn(rig.model.lower, HOME, q),
        }


def moved_placement(placement: Placement, shift: Array, turn: Array) -> Placement:
    """A placement after a shift [m] and a turn [rad] about its own origin, base axes."""
    return Placement(p=placement.p + shift, R=exp(turn) @ placement.R)
