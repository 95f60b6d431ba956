"""Train, in the order of thesis B, ch. 6: hold home, show, come to rest, go home."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from burnish.core import Controller, Dynamics, Sample, Source, ToolReference
from burnish.errors import PlanError
from burnish.teach.demonstration import phase_of
from burnish.teach.session import Key, Session

READY_HEIGHT = 0.05
"""Height of the ready pose above the mould [m]: room to adjust the work-piece."""
LEFT = 0.5
"""Share of the touch force below which a contact counts as left."""


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
            outward = -arm.R[:, 2]
            touch = self.rig.sense.touch_threshold(outward)
            self._touching = float(outward @ arm.F[:3]) > (LEFT if self._touching else 1.0) * touch
        self.phase = phase_of(self._touching, self.mode())
