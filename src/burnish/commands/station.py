"""The operator's place at an arm: a simulated one in real time or a real one, a law, a device, its modes."""

from __future__ import annotations

import argparse
import platform
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from typing import Any

from burnish.commands.order import ARMS, named
from burnish.commands.real_arm import RealArm, confirmed, found
from burnish.commands.work import model_hash, versions
from burnish.control import OperationalSpace
from burnish.core import Controller
from burnish.errors import InputError
from burnish.experiments import ours
from burnish.experiments.contenders import CONTENDERS
from burnish.model.model import Model
from burnish.model.tool import PolishingTool
from burnish.polish.cell import HOME, nominal_placement
from burnish.polish.cellsim import WristFelt, check_size, simulated_rig
from burnish.record.described import described, fingerprint
from burnish.runtime.limits import Limits
from burnish.runtime.loop import Rig
from burnish.runtime.machine import Mode
from burnish.runtime.operating import operator
from burnish.runtime.supervisor import Supervisor
from burnish.sim.arms import Arm
from burnish.sim.hand import Hand
from burnish.sim.paced import Paced
from burnish.sim.robot import SimRobot
from burnish.sim.scene import Workpiece
from burnish.surface import DistanceGrid, Mould
from burnish.teleop.device import Device
from burnish.teleop.find import WORDS, open_device
from burnish.teleop.modes import Panel
from burnish.teleop.modes_a import ModesA
from burnish.teleop.modes_b import ModesB
from burnish.teleop.reference import Operator, Pace
from burnish.teleop.shaped import Shaped

JACO2 = "jaco2"
"""The word for the real arm."""


def hand_led(arm: Arm) -> OperationalSpace:
    """`OperationalSpace` without its integral, which would press harder and harder where the tool meets something."""
    return replace(ours.operational_space(arm), ki=0.0)


LAWS: dict[str, Callable[[Arm], Controller[Any]]] = {
    each.name: each.ours for each in CONTENDERS if each.ours is not None and not each.joints
} | {"OperationalSpace": hand_led}
"""Every law that follows tool poses, with our gains for an arm."""
MODES: dict[str, ModesA | ModesB] = {"a": ModesA(fitted=False), "b": ModesB(fitted=False)}
"""The machines of modes for an arm without fingers."""
MODE_BUTTONS = {"a": 2, "b": 1}
"""The highest button that a machine of modes uses."""


@dataclass(frozen=True, kw_only=True)
class Station:
    """All that a session needs; nothing of it moves yet."""

    title: str
    """Arm, rate and law, for people."""
    rig: Rig
    """The arm, its model and its supervisor."""
    robot: Paced | RealArm
    """That arm: a simulated one that keeps to the wall's clock, or a real one."""
    law: Controller[Any]
    """What follows the operator."""
    operator: Operator
    """Where the operator moves the tool to."""
    device: Device
    """What the operator commands with."""
    fingers: bool
    """Whether the arm has fingers that move."""
    metadata: dict[str, str]
    """For the recording."""

    @property
    def simulated(self) -> SimRobot | None:
        """The simulated arm; None for a real one, which has no viewer, and no way back after a stop but a new start."""
        return self.robot.robot if isinstance(self.robot, Paced) else None


def station(options: argparse.Namespace) -> Station:
    """What the options of ``burnish teleop`` ask for; the device is opened and has to be left.

    Raises:
        InputError: if an option cannot be used, or a real arm was not confirmed.
        HardwareError: if the device, or a real arm, is not there.
    """
    rate = _checked(options)
    rig, robot, arm, about = _real(options) if options.robot == JACO2 else _simulated(options, rate)
    law, supervisor = LAWS[options.law](arm), rig.supervisor
    limits, shared = supervisor.limits, options.near_people or options.robot == JACO2
    fingers = isinstance(robot, Paced) and options.mould is None
    device = open_device(options.device, time.monotonic if options.device in WORDS else _clock_of(robot))
    hand = operator(
        read=Shaped(device=device).read,
        panel=Panel(modes=replace(MODES[options.modes], fitted=fingers), deadman=options.deadman),
        supervisor=supervisor,
        pace=Pace.near_people() if shared else Pace(),
    )
    recorded = ("robot", "arm", "modes", "law", "seed", "mould", "device", "near_people", "deadman")
    return Station(
        title=f"{about} at {rate:g} Hz, {options.law}",
        rig=rig,
        robot=robot,
        law=law,
        operator=hand,
        device=device,
        fingers=fingers,
        metadata={"verb": "teleop", "rate": str(rate)}
        | {name: str(getattr(options, name)) for name in recorded}
        | {"operated": about, "operated_with": device.name}
        | {"python": platform.python_version(), "model_sha256": model_hash()}
        | versions()
        | {"law_gains": described(law), "pace": described(hand.pace), "leash": described(hand.leash)}
        | {"limits": described(limits), "limits_sha256": fingerprint(limits)},
    )


def _simulated(options: argparse.Namespace, rate: float) -> tuple[Rig, Paced | RealArm, Arm, str]:
    """A simulated arm that keeps to the wall's clock, its nominal figures, and its name for people."""
    arm = ARMS[options.arm](options.seed)
    limits = Limits.jaco2() if options.near_people else unshared(Limits.jaco2())
    if options.mould is None:
        robot = SimRobot(HOME, rate=rate, plant=arm.plant, hand=Hand())
        rig = Rig(robot, _model(arm), Supervisor(limits=limits, period=1.0 / rate))
    else:
        mould, tool = Mould.load(options.mould, named(options.unit)), PolishingTool()
        check_size(mould, tool)
        placement = nominal_placement(float(mould.vertices[:, 2].max()))
        workpiece = Workpiece(grid=DistanceGrid.of(mould), p=placement.p, R=placement.R)
        rig, robot = simulated_rig(arm, workpiece, rate=rate, felt=WristFelt(), tool=tool)
        rig.supervisor = Supervisor(limits=limits, period=1.0 / rate)
    rig.robot = paced = Paced(robot)
    return rig, paced, arm, f"simulated {options.arm} arm"


def _real(options: argparse.Namespace) -> tuple[Rig, Paced | RealArm, Arm, str]:
    """The real arm, once somebody has confirmed it, and the nominal figures of the honest one.

    Somebody stands beside it, so the limits are those with people near by.
    """
    arm, device = ARMS["honest"](0), found(options.serial, options.lib)
    confirmed(device)
    model, supervisor = _model(arm), Supervisor(limits=Limits.jaco2(), period=RealArm.period, start=Mode.IDLE)
    robot = RealArm(device, model, supervisor, options.lib)
    return Rig(robot, model, supervisor), robot, arm, f"real arm {device.serial}"


def _clock_of(robot: Paced | RealArm) -> Callable[[], float]:
    """What a file is played by: the clock of the simulation, so that it comes out the same on a busy machine."""
    if isinstance(robot, RealArm):
        return time.monotonic
    simulated = robot.robot
    return lambda: simulated.time


def _model(arm: Arm) -> Model:
    return Model.jaco2().with_armature(arm.armature)


def unshared(limits: Limits) -> Limits:
    """The limits where nobody can get to the arm: its tool speed is bounded by what it can do, and by no impact."""
    return replace(limits, free_speed=inf, impact_force=inf)


def _checked(options: argparse.Namespace) -> float:
    """The control rate; refuses what is out of range before anything is built."""
    if options.law not in LAWS:
        raise InputError(f"--law {options.law} is none that follows tool poses; expected one of {', '.join(LAWS)}")
    if options.seed < 0:
        raise InputError(f"--seed {options.seed} is negative; expected 0 or more")
    if options.seconds is not None and not 0.0 < options.seconds < 1e6:
        raise InputError(f"--seconds {options.seconds:g} is out of range; expected more than 0")
    least = MODE_BUTTONS[options.modes] + 1
    if options.deadman is not None and not least <= options.deadman <= 32:
        raise InputError(f"--deadman {options.deadman} is a button of the modes or none; expected {least} to 32")
    if options.device not in WORDS and not Path(options.device).is_file():
        raise InputError(f"--device {options.device}: no such device or file; expected {', '.join(WORDS)}, or a file")
    _check_robot(options)
    if options.robot == JACO2:
        return 1.0 / RealArm.period
    rate = ARMS[options.arm](options.seed).rate if options.rate is None else options.rate
    if not 50.0 <= rate <= 1000.0:
        raise InputError(f"--rate {rate:g} Hz is out of range; expected 50 to 1000 Hz")
    return float(rate)


def _check_robot(options: argparse.Namespace) -> None:
    """Refuse the options that mean nothing to the robot that was chosen."""
    of_simulation = {"arm": "honest", "mould": None, "rate": None, "seed": 0, "view": False}
    idle = of_simulation if options.robot == JACO2 else {"serial": None, "lib": None}
    for name, default in idle.items():
        if getattr(options, name) != default:
            raise InputError(f"--{name} means nothing to --robot {options.robot}; leave it out")
