"""The keys of a terminal as a device: no root, no window; over ssh as well.

A terminal says that a key was typed, not that it is held. A held key repeats, about 30 times a second after half a
second, so an axis counts fully for 100 ms after its last key and is back at zero after 200 ms: a tap is a small step,
and a key that is held moves without a gap once it repeats. A button is pressed for 100 ms after its key: tap it.
"""

from __future__ import annotations

import atexit
import os
import re
import select
import termios
import time
import tty
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

from typing_extensions import Self

from burnish.errors import HardwareError
from burnish.teleop.device import AT_REST, Reading, six
from burnish.teleop.shaping import FRESH, freshness

UP, DOWN, RIGHT, LEFT, PAGE_UP, PAGE_DOWN = "\x1b[A", "\x1b[B", "\x1b[C", "\x1b[D", "\x1b[5~", "\x1b[6~"
AXES = {
    RIGHT: (0, 1.0),
    LEFT: (0, -1.0),
    UP: (1, 1.0),
    DOWN: (1, -1.0),
    PAGE_UP: (2, 1.0),
    PAGE_DOWN: (2, -1.0),
    "k": (3, 1.0),
    "i": (3, -1.0),
    "o": (4, 1.0),
    "u": (4, -1.0),
    "j": (5, 1.0),
    "l": (5, -1.0),
}
"""Key: axis and sign, in the operator's frame. i tips the tool away, u to the left; j turns it left seen from above."""
BUTTONS = ("1", "2", "3", "4")
"""Keys of the buttons, in order."""
FASTER, SLOWER = "+", "-"
FIRST_DEFLECTION = 0.5
"""What a key pushes at first; the two keys above double and halve it, from 1/8 to 1."""
KEY = re.compile(r"\x1b\[[0-9;]*[@-~]|\x1bO[@-~]|\x1b(?![\[O]|$)|[^\x1b]", re.DOTALL)
"""An escape sequence, a lone escape with something after it, or any other sign."""
MOST_OTHERS = 64
TERMINAL = Path("/dev/tty")


class Keyboard:
    """The terminal, reading key by key without echo from here on; leaving it, or the program, restores the terminal."""

    def __init__(self, terminal: Path = TERMINAL, *, clock: Callable[[], float] = time.monotonic) -> None:
        """Take the terminal.

        Raises:
            HardwareError: if there is none.
        """
        self.name = "keyboard"
        self.deflection = FIRST_DEFLECTION
        self._clock, self._connected = clock, True
        self._text, self._others = "", list[str]()
        never = clock() - 1.0
        self._axes = [(never, 0.0)] * 6
        self._buttons = [never] * len(BUTTONS)
        try:
            self._file = os.open(terminal, os.O_RDWR | os.O_NOCTTY)
        except OSError as error:
            raise HardwareError(f"{terminal} cannot be opened ({error.strerror}); {NO_TERMINAL}") from None
        try:
            self._before = termios.tcgetattr(self._file)
            tty.setcbreak(self._file, termios.TCSANOW)
        except termios.error:
            os.close(self._file)
            raise HardwareError(f"{terminal} is no terminal; {NO_TERMINAL}") from None
        atexit.register(self.close)

    def read(self) -> Reading:
        """The axes and buttons of the keys that were typed last."""
        t = self._clock()
        for key in self._typed():
            self._take(key, t)
        pushed = six(value * freshness(t - since) for since, value in self._axes)
        return Reading(
            t=t,
            axes=pushed if self._connected else AT_REST,
            buttons=tuple(self._connected and t - since < FRESH for since in self._buttons),
            age=0.0,
            connected=self._connected,
        )

    def others(self) -> list[str]:
        """The keys typed since the last call that are neither axis nor button, for the program; oldest first."""
        found, self._others = self._others, []
        return found

    def _take(self, key: str, t: float) -> None:
        if key in AXES:
            axis, sign = AXES[key]
            self._axes[axis] = (t, sign * self.deflection)
        elif key in BUTTONS:
            self._buttons[BUTTONS.index(key)] = t
        elif key in (FASTER, SLOWER):
            self.deflection = min(1.0, max(0.125, self.deflection * (2.0 if key == FASTER else 0.5)))
        else:
            self._others = [*self._others, key][-MOST_OTHERS:]

    def _typed(self) -> list[str]:
        """Whole keys; the begin of an escape sequence waits for its end until the next reading."""
        arrived = self._arrived()
        if not arrived:
            # What has waited was no sequence: the escape key, and what was typed after it.
            keys, self._text = list(self._text), ""
            return keys
        self._text += arrived
        keys, end = [], 0
        while match := KEY.match(self._text, end):
            keys.append(match[0].replace("\x1bO", "\x1b["))
            end = match.end()
        self._text = self._text[end:]
        return keys

    def _arrived(self) -> str:
        try:
            if not self._connected or not select.select([self._file], [], [], 0.0)[0]:
                return ""
            data = os.read(self._file, 1024)
        except OSError:
            data = b""
        # A terminal that is ready and has nothing to say was closed.
        self._connected = bool(data)
        return data.decode("latin-1")

    def close(self) -> None:
        """Give the terminal back as it was."""
        atexit.unregister(self.close)
        if self._file < 0:
            return
        try:
            termios.tcsetattr(self._file, termios.TCSANOW, self._before)
        except termios.error:
            # The terminal was closed: there is nothing left to restore.
            self._connected = False
        os.close(self._file)
        self._file = -1

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


NO_TERMINAL = "the keyboard needs one: run burnish in a terminal, or take another --device"
