"""``burnish doctor``: what the real arm and the operator devices need, what of it is there, and what to do next."""

from __future__ import annotations

import argparse
import platform
from collections.abc import Iterator
from importlib.metadata import version
from typing import NamedTuple

from burnish.errors import HardwareError
from burnish.hardware.inventory import (
    KINOVA_RULE,
    RULE_FILE,
    SPACENAVD,
    arms_on_usb,
    space_mice,
    spacenavd_runs,
)
from burnish.hardware.kinova import Kinova
from burnish.hardware.kinova_codes import VendorError
from burnish.hardware.kinova_library import HOW_TO_GET_IT, Library, LibraryMissingError, find
from burnish.hardware.ros1_installed import RosMissingError, installed
from burnish.teleop.spacemouse import remedy

GOOD, BAD, NOTE = "ok", "missing", "note"


class Finding(NamedTuple):
    """One thing that was looked at."""

    verdict: str
    """`GOOD`, `BAD` or `NOTE`: a note is something that not everybody needs."""
    what: str
    """What was found."""
    remedy: str = ""
    """What to do about it."""


def run(options: argparse.Namespace) -> int:
    """Print the findings and the next step; nothing is moved, and 0 says that it was looked, not that all is well."""
    findings = [*software(), *arm(options.lib), *ros(), *operator()]
    for finding in findings:
        print(f"{finding.verdict:<8} {finding.what}")
        if finding.remedy:
            print(f"{'':<8} → {finding.remedy}")
    missing = [finding for finding in findings if finding.verdict == BAD]
    print(f"\nnext: {missing[0].remedy if missing else 'burnish devices, then docs/jaco2-arm.md'}")
    return 0


def software() -> Iterator[Finding]:
    """Versions."""
    packages = ", ".join(f"{name} {version(name)}" for name in ("burnish", "numpy", "mujoco", "pin"))
    yield Finding(GOOD, f"Python {platform.python_version()}, {packages}")
    if platform.machine() != "x86_64":
        yield Finding(NOTE, f"this is {platform.machine()}; Kinova's library is for x86_64", "take a PC for the arm")


def arm(given: str | None) -> Iterator[Finding]:
    """Library, cable, permission and firmware of the arm."""
    plugged = arms_on_usb()
    for device in plugged:
        where = f"{device.name} at {device.node}"
        if device.usable:
            yield Finding(GOOD, where)
        else:
            yield Finding(BAD, f"{where}: no permission", rule(KINOVA_RULE))
    try:
        library = Library(find(given))
    except LibraryMissingError as error:
        yield Finding(BAD, str(error).split(";")[0], HOW_TO_GET_IT)
        if not plugged:
            yield Finding(NOTE, "no Kinova arm on the USB", "plug it in and switch it on, or use the Ethernet layer")
        return
    layer = "Ethernet" if library.ethernet else "USB"
    yield Finding(GOOD, f"{library.path}: {layer} layer, layout for {library.layout.actuators} actuators")
    yield from _answers(library)


def _answers(library: Library) -> Iterator[Finding]:
    """What the library says when it is asked."""
    try:
        with Kinova(library) as kinova:
            devices = kinova.devices()
            interface, _ = kinova.versions()
    except VendorError as error:
        what, _, remedy = str(error).partition("; ")
        yield Finding(BAD, what, remedy)
        return
    except HardwareError as error:
        yield Finding(BAD, str(error), HOW_TO_GET_IT)
        return
    yield Finding(GOOD, f"interface {'.'.join(map(str, interface))} (both layouts call themselves 5.2.0)")
    if not devices:
        yield Finding(BAD, "the library sees no arm", "check the cable and the arm's power switch")
    for device in devices:
        firmware = ".".join(map(str, device.firmware))
        yield Finding(GOOD, f"arm {device.model}, serial {device.serial}, firmware {firmware}")


def ros() -> Iterator[Finding]:
    """Whether an arm could be reached through kinova-ros as well."""
    try:
        yield Finding(GOOD, f"rospy in {installed()}, for an arm behind kinova-ros")
    except RosMissingError as error:
        what, _, remedy = str(error).partition("; ")
        yield Finding(NOTE, f"{what}, and only kinova-ros needs it", remedy)


def operator() -> Iterator[Finding]:
    """Devices to command with."""
    mice = space_mice()
    for device in mice:
        if device.usable:
            yield Finding(GOOD, f"{device.name} at {device.node}")
        else:
            yield Finding(BAD, f"{device.name} at {device.node}: no permission", remedy(device.vendor))
    if spacenavd_runs():
        yield Finding(GOOD, f"spacenavd at {SPACENAVD}")
    elif not mice:
        yield Finding(NOTE, "no SpaceMouse and no spacenavd", "plug one in if you want to steer the tool by hand")


def rule(line: str) -> str:
    """How to let every user have a device."""
    return f"as root: echo '{line}' >> {RULE_FILE} && udevadm control --reload && udevadm trigger; plug it in anew"
