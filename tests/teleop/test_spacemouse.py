"""Bytes of a SpaceMouse to readings, and the causes that are named when it cannot be opened."""

from __future__ import annotations

import errno
import struct
import sys
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from teleop.clock import Clock

from burnish.errors import HardwareError
from burnish.hardware import inventory
from burnish.teleop import spacemouse
from burnish.teleop.device import AT_REST
from burnish.teleop.spacemouse import (
    Counts,
    SpaceMouse,
    axes_of,
    buttons_of,
    decode,
    hidapi,
    mice,
    open_space_mouse,
    remedy,
)
from burnish.teleop.spacemouse_profiles import PROFILES, profile

COMPACT = profile(0x256F, 0xC635)
WIRELESS = profile(0x256F, 0xC62E)
PRO = profile(0x046D, 0xC62B)
assert COMPACT
assert WIRELESS
assert PRO


class Wire:
    """An open hid.device: reports that wait, and whether the mouse is still there."""

    def __init__(self, *reports: bytes) -> None:
        self.waiting = list(reports)
        self.unplugged = self.closed = False

    def read(self, max_length: int, /) -> list[int]:
        if self.waiting:
            return list(self.waiting.pop(0)[:max_length])
        if self.unplugged:
            raise OSError(errno.EIO, "read error")
        return []

    def close(self) -> None:
        self.closed = True


# The decoder.


def test_a_rotation_as_a_space_navigator_was_seen_to_send_it() -> None:
    # Recorded from a SpaceNavigator: −30 on the second axis of rotation.
    assert decode(bytes.fromhex("02 0000 e2ff 0000"), Counts()).rotation == (0, -30, 0)


def test_translation_and_rotation_in_two_reports() -> None:
    counts = decode(bytes.fromhex("01 5e01 a2fe 0100"), Counts())
    counts = decode(bytes.fromhex("02 0000 0a00 ffff"), counts)
    assert (counts.translation, counts.rotation) == ((350, -350, 1), (0, 10, -1))


def test_six_axes_in_one_report() -> None:
    counts = decode(bytes.fromhex("01 0100 0200 0300 fcff fbff faff"), Counts())
    assert (counts.translation, counts.rotation) == ((1, 2, 3), (-4, -5, -6))


def test_a_report_of_translation_leaves_the_rotation() -> None:
    turned = Counts(rotation=(7, 8, 9))
    assert decode(bytes.fromhex("01 0100 0200 0300"), turned).rotation == (7, 8, 9)


@pytest.mark.parametrize(
    ("report", "pressed"),
    [("03 01 00", (0,)), ("03 02 00", (1,)), ("03 03 00", (0, 1)), ("03 00 00", ()), ("03 01", (0,))],
)
def test_buttons_of_a_mouse_with_two(report: str, pressed: tuple[int, ...]) -> None:
    found = buttons_of(decode(bytes.fromhex(report), Counts()), COMPACT)
    assert tuple(i for i, down in enumerate(found) if down) == pressed
    assert len(found) == 2


def test_the_buttons_of_a_pro_are_numbered_without_gaps() -> None:
    # Menu, then 4, then the lock of rotation: bits 0, 15 and 26.
    found = buttons_of(decode(struct.pack("<BI", 3, 1 | 1 << 15 | 1 << 26), Counts()), PRO)
    assert len(found) == 15
    assert [i for i, down in enumerate(found) if down] == [0, 9, 14]


def test_a_battery_tells_its_charge() -> None:
    assert decode(bytes.fromhex("17 3f 00"), Counts()).battery == 63


@given(st.binary(max_size=64))
def test_any_bytes_give_axes_within_the_full_scale(report: bytes) -> None:
    counts = decode(report, Counts())
    assert all(abs(x) <= 1.0 for x in axes_of(counts, COMPACT))
    assert len(buttons_of(counts, PRO)) == 15


@pytest.mark.parametrize("report", ["", "01", "01 0100 0200 03", "02 ff", "03", "17", "1c 0100 0200 0300", "00 01 02"])
def test_a_report_that_is_cut_short_or_unknown_changes_nothing(report: str) -> None:
    before = Counts(translation=(1, 2, 3), rotation=(4, 5, 6), pressed=1, battery=50)
    assert decode(bytes.fromhex(report), before) == before


def test_axes_are_right_away_and_up_with_rotations_by_the_right_hand() -> None:
    # HID counts are x right, y towards the operator, z down, also right-handed: a half turn about x.
    raw = Counts(translation=(35, 70, 105), rotation=(140, 175, 210))
    assert axes_of(raw, COMPACT) == pytest.approx((0.1, -0.2, -0.3, 0.4, -0.5, -0.6))


def test_counts_beyond_the_full_scale_are_clipped() -> None:
    assert axes_of(Counts(translation=(400, -400, 0)), COMPACT)[:2] == (1.0, 1.0)


# Profiles.


def test_the_models_are_told_apart_and_named() -> None:
    assert len({(model.vendor, model.product) for model in PROFILES}) == len(PROFILES)
    assert len({model.name for model in PROFILES}) == len(PROFILES)
    assert {model.vendor for model in PROFILES} == {0x046D, 0x256F}
    assert all(list(model.button_bits) == sorted(set(model.button_bits)) for model in PROFILES)
    assert profile(0x046D, 0xC52B) is None


def test_the_inventory_knows_the_old_models_by_the_same_numbers() -> None:
    ours = {f"{model.product:04x}" for model in PROFILES if model.vendor == 0x046D}
    assert ours <= inventory.OLD_SPACE_MICE


# The device.


def test_reading_takes_all_that_waits_and_never_waits_itself() -> None:
    wire = Wire(bytes.fromhex("01 2300 0000 0000"), bytes.fromhex("02 0000 0000 2300"), bytes.fromhex("03 02 00"))
    with SpaceMouse(wire, COMPACT, clock=Clock()) as mouse:
        reading = mouse.read()
        assert reading.axes == pytest.approx((0.1, 0.0, 0.0, 0.0, 0.0, -0.1))
        assert reading.buttons == (False, True)
        assert (reading.age, reading.connected) == (0.0, True)
        assert mouse.read().axes == reading.axes
    assert wire.closed


def test_a_flood_of_reports_does_not_hold_a_reading_up() -> None:
    wire = Wire(*[bytes.fromhex("01 2300 0000 0000")] * 1000)
    SpaceMouse(wire, COMPACT, clock=Clock()).read()
    assert len(wire.waiting) == 1000 - spacemouse.AT_ONCE


def test_the_age_grows_while_no_report_of_axes_comes() -> None:
    clock, wire = Clock(), Wire(bytes.fromhex("01 2300 0000 0000 0000 0000 0000"))
    mouse = SpaceMouse(wire, WIRELESS, clock=clock)
    assert mouse.read().age == 0.0
    clock.now += 0.15
    # A button or the battery says nothing about the axes.
    wire.waiting += [bytes.fromhex("03 01 00"), bytes.fromhex("17 40 00")]
    assert mouse.read().age == pytest.approx(0.15)
    wire.waiting.append(bytes.fromhex("01 2200 0000 0000 0000 0000 0000"))
    assert mouse.read().age == 0.0


def test_a_rotation_that_freezes_ages_although_the_translation_lives() -> None:
    clock, wire = Clock(), Wire(bytes.fromhex("02 2300 0000 0000"))
    mouse = SpaceMouse(wire, COMPACT, clock=clock)
    mouse.read()
    clock.now += 0.3
    wire.waiting.append(bytes.fromhex("01 2300 0000 0000"))
    assert mouse.read().age == pytest.approx(0.3)
    wire.waiting.append(bytes.fromhex("02 0000 0000 0000"))
    assert mouse.read().age == 0.0


def test_an_unplugged_mouse_is_gone_with_its_buttons_and_its_last_axes_age() -> None:
    clock = Clock()
    wire = Wire(bytes.fromhex("01 2300 0000 0000"), bytes.fromhex("03 03 00"))
    wire.unplugged = True
    mouse = SpaceMouse(wire, COMPACT, clock=clock)
    first = mouse.read()
    clock.now += 0.2
    later = mouse.read()
    assert (first.connected, later.connected) == (False, False)
    assert first.buttons == (False, False)
    assert first.axes == later.axes != AT_REST
    assert later.age == pytest.approx(0.2)


# Opening.


def entry(vendor: int, product: int, path: bytes, usage: tuple[int, int] = (0, 0)) -> dict[str, Any]:
    return {
        "vendor_id": vendor,
        "product_id": product,
        "path": path,
        "usage_page": usage[0],
        "usage": usage[1],
        "serial_number": "",
    }


def test_of_a_receiver_the_interface_of_the_mouse_is_taken() -> None:
    listed = [
        entry(0x046D, 0xC52B, b"/dev/hidraw0", (1, 6)),
        entry(0x256F, 0xC652, b"/dev/hidraw1", (1, 6)),
        entry(0x256F, 0xC652, b"/dev/hidraw2", (1, 8)),
        entry(0x256F, 0xC652, b"/dev/hidraw3", (0xFF00, 1)),
    ]
    assert [(found.path, found.model.name) for found in mice(listed)] == [
        (b"/dev/hidraw2", "3Dconnexion Universal Receiver")
    ]


def test_where_the_system_does_not_say_what_an_interface_is_the_first_is_taken() -> None:
    listed = [entry(0x256F, 0xC635, b"0001:0004:00"), entry(0x256F, 0xC635, b"0001:0004:01")]
    assert [found.path for found in mice(listed)] == [b"0001:0004:00"]


class LockedDevice:
    def open_path(self, path: bytes) -> None:
        raise OSError("open failed")


def hidapi_with(monkeypatch: pytest.MonkeyPatch, *listed: dict[str, Any], device: Any = LockedDevice) -> None:
    fake = SimpleNamespace(enumerate=lambda: list(listed), device=device)
    monkeypatch.setattr(spacemouse, "hidapi", lambda: fake)


def test_without_a_mouse_the_refusal_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    hidapi_with(monkeypatch)
    with pytest.raises(HardwareError, match="found no SpaceMouse; plug one in"):
        open_space_mouse()


def test_a_mouse_that_may_not_be_opened_gets_its_udev_line(monkeypatch: pytest.MonkeyPatch) -> None:
    hidapi_with(monkeypatch, entry(0x046D, 0xC626, b"/dev/hidraw4", (1, 8)))
    monkeypatch.setattr(spacemouse.remedy, "__defaults__", ("linux",))
    with pytest.raises(HardwareError) as caught:
        open_space_mouse()
    text = str(caught.value)
    assert "SpaceNavigator at /dev/hidraw4 cannot be opened (open failed)" in text
    assert 'KERNEL=="hidraw*", ATTRS{idVendor}=="046d", ATTRS{idProduct}=="c6*", MODE="0660", TAG+="uaccess"' in text
    assert "plug it in anew" in text


def test_the_udev_line_gives_no_keyboard_of_logitech_away() -> None:
    assert 'ATTRS{idProduct}=="c6*"' in remedy(0x046D, "linux")
    assert all(f"{model.product:04x}".startswith("c6") for model in PROFILES if model.vendor == 0x046D)
    assert "idProduct" not in remedy(0x256F, "linux")


def test_on_a_mac_the_helper_that_holds_the_mouse_is_named() -> None:
    assert "killall 3DconnexionHelper" in remedy(COMPACT.vendor, "darwin")


def test_a_mouse_is_opened_and_read(monkeypatch: pytest.MonkeyPatch) -> None:
    class Open(Wire):
        def __init__(self) -> None:
            super().__init__(bytes.fromhex("01 5e01 0000 0000"))

        def open_path(self, path: bytes) -> None:
            assert path == b"/dev/hidraw4"

        def set_nonblocking(self, on: int) -> None:
            assert on == 1

    hidapi_with(monkeypatch, entry(0x256F, 0xC635, b"/dev/hidraw4", (1, 8)), device=Open)
    with open_space_mouse() as mouse:
        assert mouse.name == "SpaceMouse Compact at /dev/hidraw4"
        assert mouse.read().axes[0] == 1.0


def test_hidapi_is_there_with_the_backend_that_leaves_the_kernels_driver_in_place() -> None:
    assert hidapi().__name__ == ("hidraw" if sys.platform == "linux" else "hid")
    assert isinstance(hidapi().enumerate(), list)


def test_another_package_of_the_same_name_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "hidraw", None)
    monkeypatch.setitem(sys.modules, "hid", ModuleType("hid"))
    with pytest.raises(HardwareError, match="the package 'hid' has taken its place; pip uninstall hid"):
        hidapi()


def test_without_hidapi_the_refusal_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "hidraw", None)
    monkeypatch.setitem(sys.modules, "hid", None)
    with pytest.raises(HardwareError, match="pip install hidapi"):
        hidapi()
