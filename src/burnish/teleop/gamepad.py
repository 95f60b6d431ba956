"""A gamepad with two sticks, through pygame (the extra ``gamepad``), without a window.

Left stick: x and y. Triggers: the right one lifts, the left one lowers. Right stick: to the side turns about z, up and
down tips about x. Shoulder buttons tip about y. SDL knows where each of these is on the pads in its list.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, Protocol

from typing_extensions import Self

from burnish.errors import HardwareError
from burnish.teleop.device import AT_REST, Axes, Reading, clipped

FULL_SCALE = 32767.0
LEFT_X, LEFT_Y, RIGHT_X, RIGHT_Y, LEFT_TRIGGER, RIGHT_TRIGGER = range(6)
"""SDL's numbers of the axes; y grows downwards, triggers go from 0 to full scale."""
LEFT_SHOULDER, RIGHT_SHOULDER = 9, 10
BUTTONS = (0, 1, 2, 3, 4, 6)
"""SDL's numbers of our buttons: A, B, X, Y, back, start."""
INSTALL = "found no pygame, which gamepads need: pip install 'burnish[gamepad]'"


class Pad(Protocol):
    """What is used of pygame's controller."""

    def get_axis(self, axis: int, /) -> int:
        """Counts of an axis."""

    def get_button(self, button: int, /) -> bool:
        """Whether a button is pressed."""

    def attached(self) -> bool:
        """Whether the pad is still there."""

    def quit(self) -> None:
        """Give it back."""


class Gamepad:
    """An open gamepad. It is asked and does not report, so its readings have no age."""

    def __init__(
        self, pad: Pad, name: str, *, pump: Callable[[], object], clock: Callable[[], float] = time.monotonic
    ) -> None:
        """``pump`` lets SDL take in what has happened."""
        self.name = name
        self._pad, self._pump, self._clock = pad, pump, clock

    def read(self) -> Reading:
        """Where sticks and buttons are now."""
        self._pump()
        there = bool(self._pad.attached())
        return Reading(
            t=self._clock(),
            axes=axes_of(self._pad) if there else AT_REST,
            buttons=tuple(there and bool(self._pad.get_button(button)) for button in BUTTONS),
            age=0.0,
            connected=there,
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._pad.quit()


def axes_of(pad: Pad) -> Axes:
    """Sticks, triggers and shoulders in the operator's frame."""

    def stick(axis: int) -> float:
        return clipped(pad.get_axis(axis) / FULL_SCALE)

    tip = float(pad.get_button(RIGHT_SHOULDER)) - float(pad.get_button(LEFT_SHOULDER))
    lift = clipped(stick(RIGHT_TRIGGER) - stick(LEFT_TRIGGER))
    # Stick up tips away, which is a negative turn about x; stick to the right turns clockwise seen from above.
    return stick(LEFT_X), -stick(LEFT_Y), lift, stick(RIGHT_Y), tip, -stick(RIGHT_X)


def open_gamepad(clock: Callable[[], float] = time.monotonic) -> Gamepad:
    """Open the first gamepad that SDL knows.

    Raises:
        HardwareError: if pygame is missing, or there is no gamepad.
    """
    pygame, controller = _pygame()
    for index in filter(controller.is_controller, range(controller.get_count())):
        pad = controller.Controller(index)
        return Gamepad(pad, str(pad.name), pump=pygame.event.pump, clock=clock)
    raise HardwareError("found no gamepad; plug one in, or take another --device ('burnish devices' lists them)")


def gamepads() -> list[str]:
    """Names of the gamepads that are connected.

    Raises:
        HardwareError: if pygame is missing.
    """
    _, controller = _pygame()
    names = []
    for index in filter(controller.is_controller, range(controller.get_count())):
        pad = controller.Controller(index)
        names.append(str(pad.name))
        pad.quit()
    return names


def _pygame() -> tuple[Any, Any]:
    """pygame and its controllers, with a screen that is none, and sticks that count without a window."""
    for variable, value in (
        ("SDL_VIDEODRIVER", "dummy"),
        ("SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS", "1"),
        ("PYGAME_HIDE_SUPPORT_PROMPT", "1"),
    ):
        os.environ.setdefault(variable, value)
    try:
        import pygame
        from pygame._sdl2 import controller
    except ImportError:
        raise HardwareError(INSTALL) from None
    pygame.display.init()
    controller.init()
    return pygame, controller
