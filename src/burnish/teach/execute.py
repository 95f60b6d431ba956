"""Execute, in the order of thesis B, ch. 6: hold home, get ready, play, go home; with the force held, or open loop."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, field

from burnish.core import Controller, Sample, ToolReference
from burnish.errors import PlanError
from burnish.polish.feasible import follow as feasible
from burnish.polish.moves import CLEARANCE
from burnish.teach.cleanup import Piece, Taught, clear_of
from burnish.teach.replay import Along, Track
from burnish.teach.session import Key, Session


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

    @abstractmethod
    def play(self) -> Iterator[Sample]:
        """What is played, as often as asked."""

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
