"""What teaching and replaying share: an operator's keys, a hold that waits for one, coming to rest, going home.

Keys come between cycles by `press`, so a run with the same keys after the same cycles is the same run.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from burnish.control.joint import GravityCompensation
from burnish.core import Array, Dynamics, Sample
from burnish.polish.moves import Moves
from burnish.teach.stop import Brake
from burnish.trajectory import Hold

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
class Session(Moves, ABC):
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

    @abstractmethod
    def run(self) -> Iterator[Sample]:
        """All samples of the session, to the arm at rest."""

    @property
    @abstractmethod
    def completed(self) -> bool:
        """Whether all that was asked for was done."""

    @abstractmethod
    def progress(self) -> str:
        """How far it has come, in words for a screen."""

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
