"""`Lease`: which of the browsers commands; one at most, and only as long as it proves that it is there."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from burnish.runtime.mailbox import PATIENCE


@dataclass(frozen=True, kw_only=True)
class Grant:
    """The command, given to somebody once; whoever lost it and takes it again gets another."""

    number: int
    """Of the grant; grows."""
    who: int
    """Who holds it."""


@dataclass(kw_only=True)
class Lease:
    """One grant at a time; it ends where its holder does not renew it, and nothing revives it. Safe in threads."""

    term: float = PATIENCE
    """Age of the last renewal from which on the grant has ended [s]; a job gives its commander as long."""
    clock: Callable[[], float] = time.monotonic
    """Tells the time [s]."""
    _grant: Grant | None = field(default=None, init=False, repr=False)
    _renewed: float = field(default=0.0, init=False, repr=False)
    _count: int = field(default=0, init=False, repr=False)
    _lock: threading.Lock = field(default_factory=threading.Lock, init=False, repr=False)

    def take(self, who: int) -> Grant | None:
        """The command, if nobody else has it."""
        with self._lock:
            held = self._held()
            if held is None:
                self._count += 1
                self._renewed = self.clock()
                held = self._grant = Grant(number=self._count, who=who)
            return held if held.who == who else None

    def renew(self, who: int, at: float) -> Grant | None:
        """They were there at this time of the clock [s]; their grant, or None if they have none any more."""
        with self._lock:
            held = self._held()
            if held is None or held.who != who:
                return None
            self._renewed = max(self._renewed, min(at, self.clock()))
            return held

    def leave(self, who: int) -> Grant | None:
        """They are gone, or want it no more; the grant that ended, if it was theirs."""
        with self._lock:
            held = self._grant
            if held is None or held.who != who:
                return None
            self._grant = None
            return held

    @property
    def grant(self) -> Grant | None:
        """The grant that holds now."""
        with self._lock:
            return self._held()

    def holds(self, who: int | None) -> bool:
        """Whether they command now."""
        grant = self.grant
        return grant is not None and grant.who == who

    def _held(self) -> Grant | None:
        if self._grant is not None and not self.clock() - self._renewed <= self.term:
            self._grant = None
        return self._grant
