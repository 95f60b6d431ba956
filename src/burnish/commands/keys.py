"""The keys that a program listens to while somebody operates the arm: one reader of the terminal for all of them."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from burnish.teleop.device import Device
from burnish.teleop.keyboard import Keyboard

QUIT, ACKNOWLEDGE, RESET = "q", "a", "r"


@contextmanager
def typed_keys(device: Device | None) -> Iterator[Callable[[], list[str]] | None]:
    """What is typed for the program, key by key without Enter; None where nobody sits at a terminal.

    If the device is the keyboard, it hands on what does not move the arm. Else the terminal is taken for as long
    as the block lasts, and restored however it ends.
    """
    if isinstance(device, Keyboard):
        yield device.others
    elif sys.stdin is not None and sys.stdin.isatty():
        with Keyboard() as keyboard:

            def others() -> list[str]:
                keyboard.read()
                return keyboard.others()

            yield others
    else:
        yield None
