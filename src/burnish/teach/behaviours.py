"""Train and execute in the order of thesis B, ch. 6: hold home, show or play, come to rest, go home.

Keys come between cycles by `press`, so a run with the same keys after the same cycles is the same run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from burnish.control.joint import GravityCompensation
from burnish.core import Array, Controller, Dynamics, Sample, Source, ToolReference
from burnish.errors import PlanError
from burnish.polish.feasible import follow as feasible
from burnish.polish.moves import CLEARANCE, Moves
from burnish.teach.cleanup import Piece, Taught, clear_of
from burnish.teach.demonstration import phase_of
from burnish.teach.replay import Along, Track
from burnish.teach.stop import Brake
from burnish.trajectory import Hold

READY_HEIGHT = 0.05
"""Height of the ready pose above the mould [m]: room to adjust the work-piece."""
LEFT = 0.5
"""Share of the touch force below which a contact counts as left."""
HELD_AFTER_TRIP = 1.0
"""Time for which the supervisor's hold is watched [s]."""
REST_AT_MOST = 1.0
"""Time after which an arm that still trembles counts as at rest [s]."""


class Key(Enum):
    """What an operator can ask for, by the key's name."""

    RECORD = "r"
    STORE = "e"
    GO_ON = "enter"
    CANCEL = "space"
    PAUSE = "p"


@dataclass(kw_only=True)
class Session(Moves):
    """What teaching and replaying share: keys, holding for one, stopping, going home."""

    ready: Array
    """Joint positions of the ready pose [rad], (n,)."""
    cancelled: bool = field(default=False, init=False)
    """Whether the operator cancelled what is under way."""
    waits_for: tuple[Key, ...] = field(default=(), init=False)
    """The keys that mean something now, for whoever shows them."""
    pressed: Key | None = field(default=None, init=False)
    """The key that ended the last hold."""
    _key: Key | None = field(default=None, init=False)

    def press(self, key: Key) -> None:
        """An operator's key; between two cycles, or in a signal handler. Space cancels whatever is under way."""
        self._key = key
        if key is Key.CANCEL:
            self.cancelled = True

    @property
    def stopping(self) -> bool:
        """Whether what is under way is to end now."""
        return self.cancelled or super().stopping

    def run(self) -> Iterator[Sample]:
        """All samples of the session, to the arm at rest."""
        raise NotImplementedError

    @property
    def completed(self) -> bool:
        """Whether all that was asked for was done."""
        raise NotImplementedError

    def progress(self) -> str:
        """How far it has come, in words for a screen."""
        raise NotImplementedError

    def take(self, *keys: Key) -> Key | None:
        """The key that was pressed, if it is one of these; every key is taken once, and others are forgotten."""
        key, self._key = self._key, None
        return key if key in keys else None

    def hold(self, phase: str, *keys: Key) -> Iterator[Sample]:
        """Hold the joints where they are by torque until one of the keys is pressed; `pressed` says which."""
        self.waits_for, self._key, self.pressed = (*keys, Key.CANCEL), None, None

        def asked(arm: Dynamics) -> bool:
            self.pressed = self.take(*keys)
            return self.pressed is not None

        yield from self.drive(phase, Hold(), self.travel, asked)
        self.waits_for = (Key.CANCEL,)

    def go_ready(self) -> Iterator[Sample]:
        """A cubic to the ready pose."""
        yield from self.joints(self.ready, "to ready")

    def come_to_rest(self) -> Iterator[Sample]:
        """Brake, wherever the arm is and whatever it does; ends with the arm at rest."""
        supervisor = self.rig.supervisor
        start = self.arm().t
        if supervisor.tripped:
            held = GravityCompensation()
            yield from self.always("stopped", Hold(), held, lambda arm: arm.t - start > HELD_AFTER_TRIP)
            return
        brake = Brake()
        yield from self.always(
            "stop", brake, self.travel, lambda arm: brake.stopped(arm) or arm.t - start > REST_AT_MOST
        )

    def go_home(self) -> Iterator[Sample]:
        """Off the surface if the tool is low, and home in joint space under position control."""
        arm = self.arm()
        if arm.p[2] < self.ceiling():
            yield from self.pose(np.array([arm.p[0], arm.p[1], self.ceiling()]), arm.R, "lift")
        yield from self.joints(self.home, "to home")

    def end(self) -> Iterator[Sample]:
        """Leave the arm at rest: where it is after an interruption or a trip, else at home."""
        self.waits_for = ()
        yield from self.come_to_rest()
        if self.rig.supervisor.tripped or self.interrupted:
            return
        # What was cancelled, or failed, is over: only an interruption keeps the arm from going home now.
        self.cancelled = False
        failure, self.failure = self.failure, None
        try:
            yield from self.go_home()
        finally:
            self.failure = failure or self.failure
        yield from self.come_to_rest()


@dataclass(kw_only=True)
class Train(Session):
    """Hold home; R records what the operator shows; E stores it and goes home; Space cancels at any time.

    Enter goes to the ready pose first; R works there and at home. What was cancelled is not stored, and the next R
    starts anew; Space at home ends the session.
    """

    operator: Source[ToolReference]
    """Where the operator moves the tool to."""
    mode: Callable[[], str]
    """The name of the mode that the operator is in."""
    operator_law: Controller[ToolReference]
    """Follows the operator."""
    top: float
    """Height of the mould's highest point where it is meant to stand, base frame [m]."""
    stored: tuple[int, int] | None = field(default=None, init=False)
    """First and last cycle of what was stored, counted from 0."""
    count: int = field(default=0, init=False)
    """Cycles so far."""
    _touching: bool = field(default=False, init=False)

    @property
    def completed(self) -> bool:
        """Whether something was stored."""
        return self.stored is not None

    def progress(self) -> str:
        """What the operator moves now."""
        if self.stored is not None:
            return "stored"
        return f"{self.mode()}, {'touching' if self._touching else 'free'}" if Key.STORE in self.waits_for else ""

    def ceiling(self) -> float:
        """Height above which nothing of the mould can be [m], base frame."""
        return self.top + self.uncertainty + 0.5 * READY_HEIGHT

    def run(self) -> Iterator[Sample]:
        """All samples of the session, to the arm at rest."""
        for sample in self._run():
            self.count += 1
            yield sample

    def _run(self) -> Iterator[Sample]:
        try:
            while True:
                yield from self.hold("home", Key.RECORD, Key.GO_ON)
                if self.stopping:
                    break
                if self.pressed is Key.GO_ON:
                    yield from self.go_ready()
                    yield from self.hold("ready", Key.RECORD)
                yield from self._record()
                if self.stored is not None or not self._again():
                    break
                yield from self.come_to_rest()
                yield from self.go_home()
        except PlanError as error:
            self.failure = str(error)
        yield from self.end()

    def _again(self) -> bool:
        """Whether what was cancelled is forgotten and the session goes on."""
        if self.interrupted or self.failure is not None or self.rig.supervisor.tripped:
            return False
        self.cancelled = False
        return True

    def _record(self) -> Iterator[Sample]:
        """Tare in free air, then follow the operator until E."""
        yield from self.tare()
        if self.stopping:
            return
        first = self.count
        self.waits_for, self._key = (Key.STORE, Key.CANCEL), None
        self._touching = False
        ended = False

        def store(arm: Dynamics) -> bool:
            nonlocal ended
            self._note_contact(arm)
            ended = self.take(Key.STORE) is not None
            return ended

        yield from self.drive("record", self.operator, self.operator_law, store)
        self.waits_for = (Key.CANCEL,)
        if ended and not self.stopping and self.count > first:
            self.stored = (first, self.count - 1)

    def _note_contact(self, arm: Dynamics) -> None:
        """Name the phase by contact, with two thresholds, and by mode."""
        if arm.F is not None:
            pressing = -float(arm.R[:, 2] @ arm.F[:3])
            self._touching = pressing > (LEFT if self._touching else 1.0) * self.touch_force
        self.phase = phase_of(self._touching, self.mode())


@dataclass(kw_only=True)
class Execute(Session):
    """Hold home until Enter; go to the ready pose, where the work-piece may be adjusted; Enter plays, Space cancels."""

    repeats: int = 1
    """How often it is played."""
    repeat: int = field(default=0, init=False)
    """Number of the repeat under way, from 1."""
    piece: int = field(default=0, init=False)
    """Number of the piece under way."""
    along: Along | None = field(default=None, init=False)
    """The reference of that piece; None between two pieces."""
    _completed: bool = field(default=False, init=False)

    @property
    def completed(self) -> bool:
        """Whether all repeats were played."""
        return self._completed

    def progress(self) -> str:
        """Which repeat, and how much of the piece."""
        if self.along is None:
            return f"repeat {self.repeat} of {self.repeats}" if self.repeat else ""
        paused = ", paused" if self.along.paused else ""
        share = self.along.s / self.along.track.length
        return f"repeat {self.repeat} of {self.repeats}, piece {self.piece + 1}, {100.0 * share:.0f} %{paused}"

    def press(self, key: Key) -> None:
        """As for every session; P pauses what is played and resumes it."""
        super().press(key)
        if key is Key.PAUSE and self.along is not None:
            self.along.paused = not self.along.paused

    def run(self) -> Iterator[Sample]:
        """All samples of the session, to the arm at rest."""
        try:
            yield from self.hold("home", Key.GO_ON)
            yield from self.go_ready()
            yield from self.hold("ready", Key.GO_ON)
            if not self.stopping:
                yield from self.play()
                self._completed = not self.stopping
        except PlanError as error:
            self.failure = str(error)
        yield from self.end()

    def play(self) -> Iterator[Sample]:
        """What is played, as often as asked."""
        raise NotImplementedError

    def follow(self, phase: str, track: Track, law: Controller[ToolReference]) -> Iterator[Sample]:
        """Along a track to its end."""
        self.along = Along(track=track)
        self.waits_for = (Key.PAUSE, Key.CANCEL)
        yield from self.drive(phase, self.along, law, self.along.arrived)
        self.along, self.waits_for = None, (Key.CANCEL,)


@dataclass(kw_only=True)
class HoldForce(Execute):
    """Find the mould by touch, then each piece in turn: the shown force where it was shown, however fast."""

    taught: Taught
    """What to replay."""
    speed: float = 1.0
    """How many times as fast as it was shown."""

    def play(self) -> Iterator[Sample]:
        """All of it is checked where the mould was found before the first piece begins."""
        yield from self.find()
        if self.stopping:
            return
        tracks = [Track.of(piece, self.placement, self.speed) for piece in self._open_pieces()]
        for track in tracks:
            feasible(self.rig.model, track.timed())
        for repeat in range(1, self.repeats + 1):
            for piece, track in enumerate(tracks):
                self.repeat, self.piece = repeat, piece
                if not self.stopping:
                    yield from self._contact(track) if track.normal is not None else self._free(track)

    def _contact(self, track: Track) -> Iterator[Sample]:
        """Guarded approach, the shown force along the shown path, and off along the normal."""
        assert track.normal is not None, "asked only of a contact"
        yield from self.approach("approach", track.p[0], track.normal[0], track.R[0])
        yield from self.follow("pass", track, self.law)
        yield from self.lift(track.normal[-1])

    def _free(self, track: Track) -> Iterator[Sample]:
        """Ease in from wherever the arm stands, then the shown way through the air."""
        yield from self.across(track.p[0], track.R[0])
        yield from self.follow("free", track, self.law)

    def _open_pieces(self) -> list[Piece]:
        """The pieces, the free ones cut to where the tool is clear of the mould."""
        clear, r = self.uncertainty + CLEARANCE, self.tool.tip_radius
        pieces = []
        for piece in self.taught.pieces:
            gap = self.grid.distance(piece.p - r * piece.R[:, :, 2]) - r
            cut = piece if piece.contact else clear_of(piece, gap, clear)
            if cut is not None:
                pieces.append(cut)
        return pieces


@dataclass(kw_only=True)
class OpenLoop(Execute):
    """The poses that were asked for, by an impedance, and no force: thesis B's way, for comparison."""

    track: Track
    """The poses."""
    follower: Controller[ToolReference]
    """The law that follows them."""

    def ceiling(self) -> float:
        """Height to which the tool is lifted before it crosses the mould [m]: that of the ends of the poses."""
        return float(max(self.track.p[0, 2], self.track.p[-1, 2]))

    def play(self) -> Iterator[Sample]:
        """Checked as a whole before it begins."""
        feasible(self.rig.model, self.track.timed())
        for repeat in range(1, self.repeats + 1):
            self.repeat = repeat
            if not self.stopping:
                yield from self.across(self.track.p[0], self.track.R[0])
                yield from self.follow("poses", self.track, self.follower)
