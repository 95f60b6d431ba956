"""``burnish devices``: the arms and operator devices that are connected, a line each."""

from __future__ import annotations

import argparse

from burnish.errors import HardwareError
from burnish.hardware.inventory import SPACENAVD, Plugged, arms_on_usb, space_mice, spacenavd_runs
from burnish.hardware.kinova import Device, Kinova
from burnish.hardware.kinova_library import Library, LibraryMissingError, find


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
    """A line for each device to command with."""
    lines = [f"operator   {_plugged(device)}" for device in space_mice()]
    return lines + ([f"operator   spacenavd at {SPACENAVD}"] if spacenavd_runs() else [])


def _plugged(device: Plugged) -> str:
    serial = f", serial {device.serial}" if device.serial else ""
    return f"{device.name}{serial} at {device.node}" + ("" if device.usable else " (no permission)")
