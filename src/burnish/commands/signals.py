"""How a program that moves an arm is ended from outside: the arm comes to rest first."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Ctrl-C, a request to end, and a closed terminal."""


@contextmanager
def ended_by_signals(end: Callable[[signal.Signals], None]) -> Iterator[None]:
    """Each of `ENDING` asks ``end`` to bring the arm to rest; a second Ctrl-C ends the program at once.

    Ctrl-Z does nothing: nobody leaves an arm alone that way.
    """
    before = {number: signal.getsignal(number) for number in (*ENDING, signal.SIGTSTP)}

    def ask(number: int, frame: FrameType | None) -> None:
        found = signal.Signals(number)
        signal.signal(found, before[found] if found == signal.SIGINT else signal.SIG_IGN)
        end(found)

    try:
        for number in ENDING:
            signal.signal(number, ask)
        signal.signal(signal.SIGTSTP, signal.SIG_IGN)
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
