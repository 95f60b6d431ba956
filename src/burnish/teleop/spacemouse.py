"""A SpaceMouse over HID, without a driver: reports of bytes to readings.

A report begins with its number. 1 holds three 16-bit counts of translation, and those of rotation too on newer and
wireless models; 2 holds the rotation of the others; 3 holds a bit for each button; 23 the charge of a battery. Which
form of 1 it is its length says, which the Linux kernel leaves as it was sent.
"""

from __future__ import annotations

import struct
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib import import_module
from types import TracebackType
from typing import Any, Protocol

from typing_extensions import Self

from burnish.errors import HardwareError
from burnish.teleop.device import Axes, Reading, clipped, six
from burnish.teleop.spacemouse_profiles import LOGITECH, Profile, profile

TRANSLATION, ROTATION, BUTTONS, BATTERY = 1, 2, 3, 23
"""Numbers of the reports."""
LONGEST = 64
"""Bytes of the longest report that is read."""
AT_ONCE = 64
"""Reports taken in one reading: the kernel keeps no more."""
UDEV = 'KERNEL=="hidraw*", ATTRS{{idVendor}}=="{vendor:04x}"{only}, MODE="0660", TAG+="uaccess"'
ONLY_MICE = ', ATTRS{idProduct}=="c6*"'
"""Logitech's number is on keyboards too, whose keys are nobody's business."""
RULES = "/etc/udev/rules.d/70-burnish-spacemouse.rules"


@dataclass(frozen=True, kw_only=True)
class Counts:
    """What the reports so far say, in the device's own counts, order and signs."""

    translation: tuple[int, int, int] = (0, 0, 0)
    rotation: tuple[int, int, int] = (0, 0, 0)
    pressed: int = 0
    """A bit for each button."""
    battery: int | None = None
    """Charge [%]; None where none was told."""


@dataclass(frozen=True, kw_only=True)
class Found:
    """A mouse that is plugged in."""

    path: bytes
    """How hidapi names it."""
    model: Profile


class Channel(Protocol):
    """What is used of an open `hid.device`."""

    def read(self, max_length: int, /) -> list[int]:
        """The bytes of one report; none if there is none. Raises an OSError once the device is gone."""

    def close(self) -> None:
        """Give the device back."""


def decode(report: bytes, counts: Counts) -> Counts:
    """Add what a report says; a report that is cut short or not known changes nothing."""
    number, body = (report[0], report[1:]) if report else (0, b"")
    if number == TRANSLATION and len(body) >= 12:
        values = struct.unpack_from("<6h", body)
        return replace(counts, translation=values[:3], rotation=values[3:])
    if number == TRANSLATION and len(body) >= 6:
        return replace(counts, translation=struct.unpack_from("<3h", body))
    if number == ROTATION and len(body) >= 6:
        return replace(counts, rotation=struct.unpack_from("<3h", body))
    if number == BUTTONS and body:
        return replace(counts, pressed=int.from_bytes(body[:6], "little"))
    if number == BATTERY and body:
        return replace(counts, battery=min(body[0], 100))
    return counts


def axes_of(counts: Counts, model: Profile) -> Axes:
    """Counts in the operator's frame, as shares of the full scale."""
    values = counts.translation + counts.rotation
    return six(clipped(sign * value / model.full_scale) for sign, value in zip(model.signs, values, strict=True))


def buttons_of(counts: Counts, model: Profile) -> tuple[bool, ...]:
    """The model's buttons in their order."""
    return tuple(bool(counts.pressed >> bit & 1) for bit in model.button_bits)


class SpaceMouse:
    """An open SpaceMouse; `read` takes what has arrived since the last call and never waits."""

    def __init__(
        self, channel: Channel, model: Profile, *, clock: Callable[[], float] = time.monotonic, path: str = ""
    ) -> None:
        self.name = f"{model.name} at {path}" if path else model.name
        self.model = model
        self._channel, self._clock = channel, clock
        self._counts, self._connected = Counts(), True
        # Translation and rotation come in reports of their own on some models, so one can freeze without the other.
        self._translated = self._rotated = clock()

    @property
    def battery(self) -> int | None:
        """Charge of a wireless mouse [%]; None as long as it has told none."""
        return self._counts.battery

    def read(self) -> Reading:
        """What the mouse says now; an age counts from the call that took the report."""
        t = self._clock()
        for report in self._waiting():
            self._counts = decode(report, self._counts)
            if report[0] == TRANSLATION:
                self._translated = t
            if report[0] == ROTATION or (report[0] == TRANSLATION and len(report) > 12):
                self._rotated = t
        if not self._connected:
            self._counts = replace(self._counts, pressed=0)
        counts = self._counts
        moved = [since for since, values in self._reported() if any(values)]
        return Reading(
            t=t,
            axes=axes_of(counts, self.model),
            buttons=buttons_of(counts, self.model),
            age=max(0.0, t - min(moved, default=max(self._translated, self._rotated))),
            connected=self._connected,
        )

    def _waiting(self) -> list[bytes]:
        """The reports that have arrived."""
        reports: list[bytes] = []
        try:
            while self._connected and len(reports) < AT_ONCE and (report := self._channel.read(LONGEST)):
                reports.append(bytes(report))
        except (OSError, ValueError):
            # Unplugged: what had arrived still counts.
            self._connected = False
        return reports

    def _reported(self) -> tuple[tuple[float, tuple[int, int, int]], ...]:
        return (self._translated, self._counts.translation), (self._rotated, self._counts.rotation)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._channel.close()


def plugged_in() -> list[Found]:
    """The mice that hidapi sees, whether they may be opened or not.

    Raises:
        HardwareError: if hidapi is missing or another package has taken its name.
    """
    return mice(hidapi().enumerate())


def mice(listed: list[dict[str, Any]]) -> list[Found]:
    """The interfaces of a list by hidapi that are six-axis mice.

    A receiver has several: the mouse is the one that calls itself a multi-axis controller, or, where the system does
    not say what an interface is for, the first.
    """
    found: dict[tuple[int, int, str], dict[str, Any]] = {}
    for entry in listed:
        if profile(entry["vendor_id"], entry["product_id"]) is None:
            continue
        key = (entry["vendor_id"], entry["product_id"], entry.get("serial_number") or "")
        if _is_multi_axis(entry) or (not entry.get("usage_page") and key not in found):
            found[key] = entry
    return [
        Found(path=entry["path"], model=model)
        for (vendor, product, _), entry in found.items()
        if (model := profile(vendor, product)) is not None
    ]


def _is_multi_axis(entry: dict[str, Any]) -> bool:
    """Generic desktop page, multi-axis controller."""
    return (entry.get("usage_page"), entry.get("usage")) == (0x01, 0x08)


def open_space_mouse(clock: Callable[[], float] = time.monotonic) -> SpaceMouse:
    """Open the first mouse that is plugged in.

    Raises:
        HardwareError: if there is none, or it may not be opened; the message names the cause.
    """
    found = plugged_in()
    if not found:
        raise HardwareError("found no SpaceMouse; plug one in, or take another --device ('burnish devices' lists them)")
    first = found[0]
    path = first.path.decode(errors="replace")
    channel = hidapi().device()
    try:
        channel.open_path(first.path)
        channel.set_nonblocking(1)
    except OSError as error:
        raise HardwareError(
            f"{first.model.name} at {path} cannot be opened ({error}); {remedy(first.model.vendor)}"
        ) from None
    return SpaceMouse(channel, first.model, clock=clock, path=path)


def remedy(vendor: int, platform: str = sys.platform) -> str:
    """What to do about a mouse of this USB vendor that cannot be opened on this system."""
    if platform == "darwin":
        return "3DxWare's helper holds it: quit it with 'killall 3DconnexionHelper'"
    if platform == "win32":
        return "close 3DxWare and other programs that use it"
    line = UDEV.format(vendor=vendor, only=ONLY_MICE if vendor == LOGITECH else "")
    return f"as root: echo '{line}' >> {RULES} && udevadm control --reload && udevadm trigger; then plug it in anew"


def hidapi() -> Any:
    """The module of the package hidapi: ``hidraw`` on Linux, which leaves the kernel's driver in place, else ``hid``.

    Raises:
        HardwareError: if it is missing, or if the package ``hid``, which has the same module, is installed instead.
    """
    for name in ("hidraw", "hid") if sys.platform == "linux" else ("hid",):
        try:
            module = import_module(name)
        except ImportError:
            continue
        if hasattr(module, "device") and hasattr(module, "enumerate"):
            return module
        raise HardwareError(
            f"the module {name} is not hidapi's (no {name}.device): the package 'hid' has taken its place; "
            "pip uninstall hid, then pip install --force-reinstall hidapi"
        )
    raise HardwareError("found no hidapi; expected its module hidraw or hid: pip install hidapi")
