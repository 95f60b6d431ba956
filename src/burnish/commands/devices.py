"""``burnish devices``: the arms and operator devices that are connected, a line each."""

from __future__ import annotations

import argparse
from importlib.util import find_spec

from burnish.errors import HardwareError
from burnish.hardware.inventory import Plugged, arms_on_usb, space_mice
from burnish.hardware.kinova import Device, Kinova
from burnish.hardware.kinova_library import Library, LibraryMissingError, find
from burnish.teleop.gamepad import gamepads
from burnish.teleop.spacemouse import hidapi, remedy
from burnish.teleop.spacemouse_profiles import profile
from burnish.teleop.spacenav import open_space_nav, socket_path


def run(options: argparse.Namespace) -> int:
    """Print what is there; nothing is moved."""
    lines = [*arm_lines(options.lib), *operator_lines()]
    print("\n".join(lines) if lines else "nothing is connected; 'burnish doctor' says what to look at")
    return 0


def arm_lines(library: str | None) -> list[str]:
    """A line for each arm: through Kinova's library where there is one, else as the USB shows it."""
    try:
        arms = connected(library)
    except LibraryMissingError:
        return [f"arm        {_plugged(arm)}; Kinova's library is missing" for arm in arms_on_usb()]
    except HardwareError as error:
        return [f"arm        none through the library: {error}"]
    return [f"arm        {arm.model}, serial {arm.serial}, firmware {'.'.join(map(str, arm.firmware))}" for arm in arms]


def connected(library: str | None) -> list[Device]:
    """The arms that Kinova's library sees.

    Raises:
        LibraryMissingError: if there is no library.
        VendorError: if it cannot be started or finds nothing.
    """
    with Kinova(Library(find(library))) as kinova:
        return kinova.devices()


def operator_lines() -> list[str]:
    """A line for each device to command with, and what stops those that cannot be used."""
    return [*space_mouse_lines(), *space_nav_lines(), *gamepad_lines()]


def space_mouse_lines() -> list[str]:
    """Mice that are read without a driver."""
    return [f"operator   {_plugged(mouse)}{_obstacle(mouse)}" for mouse in space_mice()]


def _obstacle(mouse: Plugged) -> str:
    """What stops a mouse, and what to do about it; empty if nothing does."""
    if profile(mouse.vendor, mouse.product) is None:
        return "; no six-axis mouse that burnish knows"
    if not mouse.usable:
        return f"; {remedy(mouse.vendor)}"
    try:
        hidapi()
    except HardwareError as error:
        return f"; {error}"
    return ""


def space_nav_lines() -> list[str]:
    """The free driver, asked for the mouse that it has."""
    path = socket_path()
    if path is None:
        return []
    try:
        with open_space_nav(path=path) as device:
            return [f"operator   {device.name}, at {path}"]
    except HardwareError as error:
        return [f"operator   {error}"]


def gamepad_lines() -> list[str]:
    """Gamepads, where pygame is installed; who has none does not need it."""
    return [f"operator   {name}, as --device gamepad" for name in gamepads()] if find_spec("pygame") else []


def _plugged(device: Plugged) -> str:
    serial = f", serial {device.serial}" if device.serial else ""
    return f"{device.name}{serial} at {device.node}" + ("" if device.usable else " (no permission)")
