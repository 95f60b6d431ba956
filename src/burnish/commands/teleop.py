"""``burnish teleop``: an operator moves the tool, sees what the arm does, and can stop at any time."""

from __future__ import annotations

import argparse
import signal
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic

import numpy as np

from burnish.analysis.metrics import write_metrics
from burnish.commands.keys import ACKNOWLEDGE, QUIT, RESET, typed_keys
from burnish.commands.options import output_folder, relative
from burnish.commands.screen import Screen, View
from burnish.commands.signals import ended_by_signals
from burnish.commands.station import Station, station
from burnish.control.wrench import NoSense
from burnish.core import Dynamics, Sample, State
from burnish.errors import HardwareError
from burnish.model.tool import PolishingTool
from burnish.record.recorder import Recorder
from burnish.rotation import euler_xyz
from burnish.runtime.loop import control
from burnish.runtime.machine import Mode
from burnish.sim.robot import SimRobot
from burnish.sim.window import Window
from burnish.teleop.keyboard import Keyboard
from burnish.teleop.modes import Frame
from burnish.teleop.scripted import Scripted
from burnish.trajectory import HoldPose

FINISHED, STOPPED, INTERRUPTED = 0, 3, 130
SHOWN = 0.1
"""Time between two pictures on the screen [s]."""
TARE, TARE_FROM = 0.6, 0.2
"""The sensor is tared for so long, and from when on [s]: the arm has come to rest by then."""
AT_REST = np.deg2rad(1.0)
"""Joint speed below which the arm is at rest [rad/s]."""
STANDING, PATIENCE = 0.1, 2.0
"""How long it has to be at rest before the program ends, and when it ends anyway [s]."""
HELD = 1.0
"""How long a stopped arm is held where nobody can acknowledge it, or it has a position mode [s]."""
FINGER_LEASH = np.deg2rad(5.0)
"""How far ahead of the fingers their reference may get [rad]: enough for the drives to grip with all that they have."""
SIGNALS = {
    signal.SIGINT: "interrupted",
    signal.SIGTERM: "interrupted: the program was told to end",
    signal.SIGHUP: "interrupted: the terminal was closed",
}


def run(options: argparse.Namespace) -> int:
    """Operate the arm; write ``run.mcap`` and ``metrics.json``, nothing when it is refused."""
    folder = output_folder(options.out, "teleop")
    place = station(options)
    with ExitStack() as stack:
        # Left in the opposite order: the arm first, the device last.
        stack.enter_context(place.device)
        tool = None if options.mould is None else PolishingTool()
        window = Window(place.simulated, tool) if options.view and place.simulated else None
        folder.mkdir(parents=True, exist_ok=True)
        typed = stack.enter_context(typed_keys(place.device))
        session = Session(place=place, typed=typed, seconds=options.seconds)
        stack.enter_context(ended_by_signals(lambda number: session.end(SIGNALS[number])))
        session.screen = stack.enter_context(Screen())
        session.window = stack.enter_context(window) if window else None
        names = place.rig.model.joint_names
        recorder = Recorder(folder / "run.mcap", joint_names=names, metadata=place.metadata)
        session.recorder = stack.enter_context(recorder)
        stack.enter_context(place.robot)
        session.run()
    write_metrics(folder / "metrics.json", session.metrics())
    if session.ending != SIGNALS[signal.SIGHUP]:
        _say(session, folder)
    if session.ending in INTERRUPTIONS:
        return INTERRUPTED
    return STOPPED if place.rig.supervisor.tripped or session.failure else FINISHED


MOVING = {"arrows, page up and down": "move", "i k u o j l": "turn", "+ -": "faster, slower", "1 2 3 4": "buttons"}
"""What the keys do where the keyboard is the device."""
DONE, GONE = "done", "interrupted: the device went away"
INTERRUPTIONS = (*SIGNALS.values(), GONE)


@dataclass(kw_only=True)
class Session:
    """From the first cycle to the arm at rest."""

    place: Station
    """Arm, law, operator and device."""
    typed: Callable[[], list[str]] | None
    """The keys for the program; None where nobody sits at a terminal."""
    seconds: float | None
    """When to end [s]; None for when somebody says so."""
    screen: Screen = field(init=False)
    """What the operator sees."""
    recorder: Recorder = field(init=False)
    """Where it is recorded."""
    window: Window | None = field(default=None, init=False)
    """The engine's viewer."""
    ending: str = field(default="", init=False)
    """Why it ends; empty while it goes on."""
    failure: str = field(default="", init=False)
    """What the arm failed with; empty while it does not."""
    cycles: int = field(default=0, init=False)
    """So far."""
    duration: float = field(default=0.0, init=False)
    """Time of the arm so far [s]."""
    trips: int = field(default=0, init=False)
    """How often the supervisor stopped the arm."""
    _note: str = field(default="", init=False)
    _was_tripped: bool = field(default=False, init=False)
    _stop_at: float | None = field(default=None, init=False)
    _still_at: float | None = field(default=None, init=False)
    _shown: tuple[float, int] = field(default=(-1.0, 0), init=False)

    def end(self, why: str) -> None:
        """Come to rest and end; the first reason counts. Safe in a signal handler."""
        self.ending = self.ending or why

    def run(self) -> None:
        """All cycles."""
        rig, operator = self.place.rig, self.place.operator
        if not isinstance(rig.sense, NoSense):
            self._tare()
        try:
            for sample in control(rig, operator, self.place.law, until=self._over):
                self._after(sample, operator.panel.modes.mode.name)
        except HardwareError as error:
            # Of a real arm, which the driver has sent to its position mode by now.
            self.failure = str(error)
        self.recorder.end_with(outcome=self.outcome())

    def outcome(self) -> str:
        """How it ended, in words."""
        if self.failure:
            return f"stopped: {self.failure}"
        event = self.place.rig.supervisor.event
        return self.ending if event is None else f"{self.ending}; stopped by the supervisor: {event.cause}"

    def metrics(self) -> dict[str, float | int | str]:
        """What ``metrics.json`` holds."""
        return {
            "duration_s": self.duration,
            "cycles": self.cycles,
            "late_cycles": self.place.robot.late_cycles,
            "supervisor_events": self.trips,
            "rate_Hz": 1.0 / self.place.robot.period,
            "outcome": self.outcome(),
        }

    def _tare(self) -> None:
        """Stand still and take what is felt for nothing."""
        rig, readings = self.place.rig, list[tuple[Dynamics, State]]()
        for sample in control(rig, HoldPose(), self.place.law, lambda arm: arm.t > TARE or bool(self.ending)):
            if sample.arm.t > TARE_FROM and rig.state is not None:
                readings.append((sample.arm, rig.state))
            self._after(sample, "tare")
        if readings:
            rig.sense.tare(readings)
            rig.feel()

    def _over(self, arm: Dynamics) -> bool:
        """Whether the arm has come to rest after it was asked to."""
        if not self.ending:
            return False
        if self._stop_at is None:
            self.place.operator.stop()
            self._stop_at = arm.t
        moving = float(np.abs(arm.dq).max()) > AT_REST
        self._still_at = None if moving else arm.t if self._still_at is None else self._still_at
        stands = self._still_at is not None and arm.t - self._still_at >= STANDING
        return stands or arm.t - self._stop_at > PATIENCE

    def _after(self, sample: Sample, phase: str) -> None:
        """What belongs to every cycle besides the arm: recording, keys, endings, screen."""
        arm = sample.arm
        self.cycles, self.duration = self.cycles + 1, arm.t
        self.recorder.record(sample, phase)
        if self.place.fingers and self.place.simulated is not None:
            self._move_fingers(self.place.simulated)
        for key in self.typed() if self.typed else ():
            self._take(key)
        self._look_for_an_end(arm)
        if self.window is not None:
            self.window.update()
        now = monotonic()
        since, cycles = self._shown
        if now - since >= SHOWN:
            self.screen.show(self._view(arm, phase, (self.cycles - cycles) / (now - since) if since > 0.0 else 0.0))
            self._shown = (now, self.cycles)

    def _move_fingers(self, robot: SimRobot) -> None:
        """Send them where the operator wants them, which is no further than they can follow: they open at once."""
        operator, measured = self.place.operator, robot.fingers()
        low, high = float(measured.min()) - FINGER_LEASH, float(measured.max()) + FINGER_LEASH
        operator.fingers = min(max(operator.fingers, low), high)
        robot.move_fingers(np.full(3, operator.fingers))

    @property
    def _can_go_on(self) -> bool:
        """Whether a stopped arm can be acknowledged; a real one is left to its position mode, and armed anew."""
        return self.typed is not None and self.place.simulated is not None

    def _take(self, key: str) -> None:
        """A key for the program."""
        supervisor = self.place.rig.supervisor
        if key == QUIT:
            self.end(DONE)
        elif not self._can_go_on:
            return
        elif key == ACKNOWLEDGE and supervisor.tripped:
            self._note = supervisor.acknowledge() or "acknowledged: let go of the device, then go on"
        elif key == RESET and supervisor.mode is Mode.FAULT and supervisor.event is not None:
            supervisor.reset(supervisor.event)
            self._note = "reset: let go of the device, then go on"

    def _look_for_an_end(self, arm: Dynamics) -> None:
        """Whatever else may end the session."""
        event, device = self.place.rig.supervisor.event, self.place.device
        self.trips += event is not None and not self._was_tripped
        self._was_tripped = event is not None
        if self.seconds is not None and arm.t >= self.seconds:
            self.end(DONE)
        if not self.place.operator.reading.connected:
            self.end(DONE if isinstance(device, Scripted) else GONE)
        if event is not None and not self._can_go_on and arm.t - event.t > HELD:
            self.end(DONE)

    def _view(self, arm: Dynamics, phase: str, rate: float) -> View:
        """What the operator sees of this cycle."""
        place, operator = self.place, self.place.operator
        supervisor, limits = place.rig.supervisor, place.rig.supervisor.limits
        panel, mode, reading, slowed = operator.panel, operator.panel.modes.mode, operator.reading, operator.slowed
        deadman = "" if panel.deadman is None else f"button {panel.deadman} {'' if panel.live else 'not '}held"
        keys = {QUIT: "quit"} | (MOVING if isinstance(place.device, Keyboard) else {})
        if supervisor.tripped and self._can_go_on:
            keys |= {RESET: "reset"} if supervisor.mode is Mode.FAULT else {ACKNOWLEDGE: "acknowledge"}
        held = {str(panel.deadman): "hold to move"} if panel.deadman is not None else {}
        return View(
            title=place.title,
            t=arm.t,
            mode=phase,
            moves=f"move in {_axes(mode.translation)}, turn in {_axes(mode.rotation)}",
            deadman=deadman,
            p=arm.p.tolist(),
            angles=np.rad2deg(euler_xyz(arm.R)).tolist(),
            force=None if arm.F is None else arm.F[:3].tolist(),
            q=np.rad2deg(arm.q).tolist(),
            lower=[_finite(value) for value in np.rad2deg(limits.lower)],
            upper=[_finite(value) for value in np.rad2deg(limits.upper)],
            slowed=f"{slowed.cause}, to {100 * slowed.share:.0f} %" if slowed.cause else "",
            device=place.device.name,
            age=reading.age if reading.connected else None,
            rate=rate,
            late=place.robot.late_cycles,
            cycles=self.cycles,
            supervisor=supervisor.mode.value,
            cause=supervisor.event.cause if supervisor.event else "",
            buttons={str(button): what for button, what in panel.modes.keys.items()} | held,
            keys=keys,
            note=self.ending or self._note,
            fingers=float(np.rad2deg(operator.fingers)) if place.fingers else None,
            speed=float(np.linalg.norm(arm.v[:3])),
        )


def _axes(frame: Frame | None) -> str:
    return "no axes" if frame is None else f"{frame.value} axes"


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _say(session: Session, folder: Path) -> None:
    """How it ended, for a terminal."""
    ending, robot = session.outcome(), session.place.robot
    print(f"{ending[:1].upper()}{ending[1:]}.")
    print(f"{session.duration:.1f} s, {session.cycles} cycles at {1.0 / robot.period:g} Hz, {robot.late_cycles} late")
    print(f"recording: {relative(folder / 'run.mcap')}")
