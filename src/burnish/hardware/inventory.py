"""What is plugged in, as the system sees it: arms and operator devices, and whether this user may open them.

Nothing is opened and nothing is sent; the folders of the kernel's device lists are arguments, so that a test can give
others.
"""

from __future__ import annotations

import os
import stat
from dataclasses import dataclass
from pathlib import Path

KINOVA = "22cd"
"""USB vendor of the arm."""
CONNEXION = "256f"
LOGITECH = "046d"
"""3Dconnexion's devices were sold under this vendor first."""
OLD_SPACE_MICE = frozenset("c603 c605 c606 c621 c623 c625 c626 c627 c628 c629 c62b".split())
"""Products of theirs; other things of that vendor are keyboards and mice."""
KINOVA_RULE = 'SUBSYSTEM=="usb", ATTR{idVendor}=="22cd", MODE="0666"'
RULE_FILE = "/etc/udev/rules.d/99-burnish.rules"
SPACENAVD = Path("/var/run/spnav.sock")


@dataclass(frozen=True, kw_only=True)
class Plugged:
    """A device that the kernel knows."""

    name: str
    """What it calls itself."""
    serial: str
    """Its serial number; empty if it shows none."""
    node: Path
    """The file through which it is used."""
    usable: bool
    """Whether this user may read and write it."""
    vendor: int = 0
    product: int = 0
    """Its USB numbers, of a mouse."""


def arms_on_usb(devices: Path = Path("/sys/bus/usb/devices"), nodes: Path = Path("/dev/bus/usb")) -> list[Plugged]:
    """Kinova arms on the USB, whether their library is there or not."""
    found = []
    for folder in sorted(devices.glob("*")):
        if _line(folder / "idVendor").lower() != KINOVA:
            continue
        bus, number = _line(folder / "busnum") or "0", _line(folder / "devnum") or "0"
        node = nodes / f"{int(bus):03d}" / f"{int(number):03d}"
        name = " ".join(filter(None, (_line(folder / "manufacturer"), _line(folder / "product")))) or "Kinova arm"
        found.append(Plugged(name=name, serial=_line(folder / "serial"), node=node, usable=_usable(node)))
    return found


def space_mice(devices: Path = Path("/sys/class/hidraw"), nodes: Path = Path("/dev")) -> list[Plugged]:
    """3Dconnexion's devices that can be read without a driver."""
    found = []
    for folder in sorted(devices.glob("hidraw*")):
        try:
            text = (folder / "device" / "uevent").read_text(errors="replace")
        except OSError:
            continue
        facts = dict(line.split("=", 1) for line in text.splitlines() if "=" in line)
        # As 0003:0000256F:0000C635: bus, vendor, product.
        _, _, ids = facts.get("HID_ID", "").partition(":")
        vendor, _, product = (part[-4:].lower() for part in ids.partition(":"))
        if vendor == CONNEXION or (vendor == LOGITECH and product in OLD_SPACE_MICE):
            node = nodes / folder.name
            name = facts.get("HID_NAME", "SpaceMouse")
            found.append(
                Plugged(
                    name=name,
                    serial=facts.get("HID_UNIQ", ""),
                    node=node,
                    usable=_usable(node),
                    vendor=int(vendor, 16),
                    product=int(product or "0", 16),
                )
            )
    return found


def spacenavd_runs(socket: Path = SPACENAVD) -> bool:
    """Whether the free driver for such devices offers its socket."""
    try:
        return stat.S_ISSOCK(socket.stat().st_mode)
    except OSError:
        return False


def _line(file: Path) -> str:
    """The content of a one-line file; empty if there is none."""
    try:
        return file.read_text(errors="replace").strip()
    except OSError:
        return ""


def _usable(node: Path) -> bool:
    """Whether this user may read and write the file."""
    return os.access(node, os.R_OK | os.W_OK)
