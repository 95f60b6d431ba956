"""The operator's seat at a session of teaching or replaying: keys in, a screen out, a recording beside it."""

from __future__ import annotations

import signal
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from time import monotonic

import numpy as np

from burnish.commands.live import GONE, Alone, Done
from burnish.commands.screen import Screen, View
from burnish.core import Sample
from burnish.errors import InputError
from burnish.record.recorder import Recorder
from burnish.rotation import euler_xyz
from burnish.runtime.loop import Rig
from burnish.sim.paced import Paced
from burnish.sim.robot import SimRobot
from burnish.teach.execute import Execute, HoldForce
from burnish.teach.session import Key, Session

TYPED = {"r": Key.RECORD, "e": Key.STORE, "\n": Key.GO_ON, "\r": Key.GO_ON, " ": Key.CANCEL, "p": Key.PAUSE}
"""What is typed, in small letters, to what it means."""
NAMED = {Key.RECORD: "R", Key.STORE: "E", Key.GO_ON: "Enter", Key.CANCEL: "Space", Key.PAUSE: "P"}
"""What a key is called."""
MEANS = {
    Key.RECORD: "record",
    Key.STORE: "store and go home",
    Key.GO_ON: "go on",
    Key.CANCEL: "cancel",
    Key.PAUSE: "pause, go on",
}
"""What it does."""
OUTSIDE = {key.value: key for key in Key}
"""What a key is called in a mailbox."""
SHOWN = 1.0 / 15.0
"""Time between two looks at the screen [s]."""
PACES = 0.1, 100.0
"""Range of the pace."""
Script = Mapping[int, Key]
"""Keys by the number of the cycle after which they were pressed, from 1."""


@dataclass(kw_only=True)
class Seat:
    """Drives a session to its end."""

    session: Session
    """What is driven; it can be run once."""
    robot: SimRobot
    """The simulated arm under it."""
    recorder: Recorder
    """Where it is recorded."""
    after: Callable[[Sample], None] = lambda sample: None
    """Called after every cycle."""
    typed: Callable[[], list[str]] | None = None
    """What was typed; None where nobody sits at a terminal."""
    by_itself: Callable[[Session], Key | None] = lambda session: None
    """The key that is pressed where nobody is there."""
    screen: Screen | None = None
    """What the operator sees."""
    title: str = ""
    """Of the screen."""
    device: str = "no device"
    """What moves the tool."""
    mode: Callable[[], str] = lambda: ""
    """What the device moves now."""
    live: Alone = field(default_factory=Alone)
    """Whoever watches and commands from outside."""
    why: str = field(default="", init=False)
    """The signal that interrupted; empty without one."""
    pressed: list[str] = field(default_factory=list, init=False)
    """``cycle:key`` of every key that was pressed, so that the run can be repeated."""
    _share: float = field(default=0.0, init=False)
    _shown: tuple[float, int] = field(default=(-1.0, 0), init=False)

    def interrupt(self, number: signal.Signals) -> None:
        """A signal asks for an early end; safe in a signal handler."""
        self.why = number.name

    def drive(
        self, script: Script | None = None, interrupted_after: int | None = None, abandoned_after: int | None = None
    ) -> float:
        """Run the session to the arm at rest; with a script as it was run before. Returns the wall time [s]."""
        start = time.perf_counter()
        abandoned = False
        with self.session.rig.robot:
            for count, sample in enumerate(self.session.run(), 1):
                self.recorder.record(sample, self.session.phase)
                self.after(sample)
                for key in self._keys(count, script):
                    self.pressed.append(f"{count}:{key.value}")
                    self.session.press(key)
                if (self.live.gone() or count == abandoned_after) and not abandoned:
                    abandoned = True
                    self.recorder.end_with(abandoned_after=str(count))
                    self.session.rig.supervisor.stop(GONE)
                if (self.why or self.live.told_to_end() or count == interrupted_after) and not self.session.interrupted:
                    self.recorder.end_with(interrupted_after=str(count))
                    self.session.interrupt()
                self._show(sample, count)
                self.live.show(sample, self.session, self._done())
        self.recorder.end_with(outcome=self.outcome(), keys=" ".join(self.pressed))
        return time.perf_counter() - start

    def outcome(self) -> str:
        """How it ended, in words."""
        session = self.session
        event = session.rig.supervisor.event
        if event is not None:
            return f"stopped by the supervisor: {event.cause}"
        if session.failure is not None:
            return f"stopped: {session.failure}"
        if session.interrupted:
            return "interrupted"
        return "done" if session.completed else "cancelled"

    def _keys(self, count: int, script: Script | None) -> list[Key]:
        if script is not None:
            return [script[count]] if count in script else []
        keys = [TYPED[key.lower()] for key in (self.typed() if self.typed else ()) if key.lower() in TYPED]
        keys += [OUTSIDE[name] for name in self.live.pressed() if name in OUTSIDE]
        own = self.by_itself(self.session)
        return keys if own is None else [*keys, own]

    def _done(self) -> Done:
        """How far it is, for whoever watches from outside."""
        session = self.session
        pieces = len(session.taught.pieces) if isinstance(session, HoldForce) else 1
        if isinstance(session, Execute) and session.along is not None:
            piece = session.piece + session.along.s / session.along.track.length
            self._share = (session.repeat - 1 + piece / pieces) / session.repeats
        return Done(
            share=1.0 if session.completed else self._share,
            stroke=session.piece if isinstance(session, Execute) else 0,
            strokes=pieces,
            late_cycles=self.robot.late_cycles,
            waits_for=tuple(key.value for key in session.waits_for),
        )

    def _show(self, sample: Sample, count: int) -> None:
        """What the operator sees of this cycle, 15 times a second."""
        now = monotonic()
        since, before = self._shown
        if self.screen is None or now - since < SHOWN:
            return
        self._shown = (now, count)
        arm, session = sample.arm, self.session
        supervisor, limits = session.rig.supervisor, session.rig.supervisor.limits
        self.screen.show(
            View(
                title=self.title,
                t=arm.t,
                mode=session.phase,
                moves=session.progress(),
                deadman="",
                p=arm.p.tolist(),
                angles=np.rad2deg(euler_xyz(arm.R)).tolist(),
                force=None if arm.F is None else arm.F[:3].tolist(),
                q=np.rad2deg(arm.q).tolist(),
                lower=[_finite(value) for value in np.rad2deg(limits.lower)],
                upper=[_finite(value) for value in np.rad2deg(limits.upper)],
                slowed="",
                device=self.device,
                age=0.0,
                rate=(count - before) / (now - since) if since > 0.0 else 0.0,
                late=self.robot.late_cycles,
                cycles=count,
                supervisor=supervisor.mode.value,
                cause=supervisor.event.cause if supervisor.event else "",
                buttons={"mode": self.mode()} if self.mode() else {},
                keys={NAMED[key]: MEANS[key] for key in session.waits_for},
                note=self.why,
                speed=float(np.linalg.norm(arm.v[:3])),
            )
        )


def paced(rig: Rig, robot: SimRobot, pace: float) -> None:
    """From now on the rig's arm keeps to ``pace`` times real time; 0 leaves it as fast as it can.

    Raises:
        InputError: if the pace is out of range.
    """
    if pace == 0.0:
        return
    if not PACES[0] <= pace <= PACES[1]:
        raise InputError(f"--pace {pace:g} is out of range; expected 0, or {PACES[0]:g} to {PACES[1]:g}")
    rig.robot = Paced(robot, lambda: pace * monotonic(), lambda s: time.sleep(s / pace))


def needs_somebody(yes: bool) -> None:
    """Refuse to wait for keys that nobody can press; ``yes`` if somebody outside can, or nobody has to.

    Raises:
        InputError: if there is no terminal and nobody said --yes.
    """
    if not yes and not (sys.stdin is not None and sys.stdin.isatty()):
        raise InputError("there is no terminal to press keys in; run it in one, or give --yes to go on by itself")


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
