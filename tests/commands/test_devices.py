"""`burnish devices` opens what an operator would command with, and says what stops the rest."""

from __future__ import annotations

from pathlib import Path

import pytest
from teleop.magellan import Spacenavd

from burnish.commands import devices
from burnish.errors import HardwareError
from burnish.hardware.inventory import Plugged


@pytest.fixture(autouse=True)
def nothing_plugged(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("SPNAV_SOCKET", str(tmp_path / "none.sock"))
    mice(monkeypatch)


def mice(monkeypatch: pytest.MonkeyPatch, *ids: tuple[int, int], usable: bool = True) -> None:
    node = Path("/dev/hidraw3")
    found = [Plugged(name="a mouse", serial="", node=node, usable=usable, vendor=v, product=p) for v, p in ids]
    monkeypatch.setattr(devices, "space_mice", lambda: found)


def test_without_anything_there_is_no_line() -> None:
    assert devices.operator_lines() == []


def test_the_mouse_of_a_running_spacenavd_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    with Spacenavd() as daemon:
        monkeypatch.setenv("SPNAV_SOCKET", str(daemon.socket))
        assert devices.operator_lines() == [
            f"operator   Magellan SpaceMouse through spacenavd, at {daemon.socket}",
        ]


def test_a_mouse_that_can_be_used_is_named_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    mice(monkeypatch, (0x256F, 0xC635))
    assert devices.operator_lines() == ["operator   a mouse at /dev/hidraw3"]


@pytest.mark.parametrize("vendor", [0x256F, 0x046D])
def test_a_mouse_without_permission_gets_the_udev_line_of_its_vendor(
    monkeypatch: pytest.MonkeyPatch, vendor: int
) -> None:
    mice(monkeypatch, (vendor, 0xC635 if vendor == 0x256F else 0xC626), usable=False)
    (line,) = devices.operator_lines()
    assert "(no permission)" in line
    assert f'ATTRS{{idVendor}}=="{vendor:04x}"' in line


def test_a_mouse_with_two_axes_is_told_from_one_with_six(monkeypatch: pytest.MonkeyPatch) -> None:
    mice(monkeypatch, (0x256F, 0xC650))
    assert devices.operator_lines() == ["operator   a mouse at /dev/hidraw3; no six-axis mouse that burnish knows"]


def test_a_clash_of_python_packages_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    def clash() -> None:
        raise HardwareError("pip uninstall hid")

    mice(monkeypatch, (0x256F, 0xC635))
    monkeypatch.setattr(devices, "hidapi", clash)
    assert devices.operator_lines() == ["operator   a mouse at /dev/hidraw3; pip uninstall hid"]


def test_gamepads_are_named_with_the_word_that_opens_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(devices, "find_spec", lambda name: name)
    monkeypatch.setattr(devices, "gamepads", lambda: ["a pad"])
    assert devices.operator_lines() == ["operator   a pad, as --device gamepad"]
    monkeypatch.setattr(devices, "find_spec", lambda name: None)
    assert devices.operator_lines() == []
