"""The one place that opens an operator's device by the word that the user gave."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from burnish.errors import InputError
from burnish.teleop.device import Device
from burnish.teleop.gamepad import open_gamepad
from burnish.teleop.keyboard import Keyboard
from burnish.teleop.scripted import open_script
from burnish.teleop.spacemouse import open_space_mouse, plugged_in
from burnish.teleop.spacenav import open_space_nav, socket_path

WORDS = ("auto", "spacemouse", "spacenav", "keyboard", "gamepad")
"""What a user may say; any other word is a file to play."""


def open_device(word: str = "auto", clock: Callable[[], float] = time.monotonic) -> Device:
    """Open a device; leave it as a context manager.

    ``clock`` [s] is what readings are timed by; a simulation that is faster than real time gives its own, which makes
    sense for a file only.

    Raises:
        InputError: if the word is no device and no file.
        HardwareError: if the device is not there or may not be opened; the message says what to do.
    """
    if word == "auto":
        return open_any(clock)
    if word == "spacemouse":
        return open_space_mouse(clock)
    if word == "spacenav":
        return open_space_nav(clock)
    if word == "keyboard":
        return Keyboard(clock=clock)
    if word == "gamepad":
        return open_gamepad(clock)
    if not Path(word).is_file():
        raise InputError(f"--device {word!r} is neither one of {' '.join(WORDS)} nor a file; take one of them")
    return open_script(Path(word), clock)


def open_any(clock: Callable[[], float] = time.monotonic) -> Device:
    """What an operator most likely wants: the driver's mouse, else a mouse without a driver, else the keyboard.

    A mouse that is plugged in and may not be opened is an error and not passed over.

    Raises:
        HardwareError: if none of them can be opened.
    """
    if socket_path() is not None:
        driver = open_space_nav(clock)
        if driver.read().connected:
            return driver
        with driver:
            pass
    if plugged_in():
        return open_space_mouse(clock)
    return Keyboard(clock=clock)
