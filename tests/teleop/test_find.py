"""The user's word to a device."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from teleop.magellan import Spacenavd

from burnish.errors import HardwareError, InputError
from burnish.teleop import find, spacemouse
from burnish.teleop.device import AT_REST, Reading
from burnish.teleop.find import open_device
from burnish.teleop.keyboard import Keyboard
from burnish.teleop.scripted import HEAD, Scripted
from burnish.teleop.spacenav import VARIABLE, SpaceNav

MOUSE = {"vendor_id": 0x256F, "product_id": 0xC635, "path": b"/dev/hidraw9", "usage_page": 1, "usage": 8}


@pytest.fixture
def bare(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    """A machine with a terminal and nothing else."""
    monkeypatch.setenv(VARIABLE, str(tmp_path / "none.sock"))
    mice(monkeypatch)
    master, slave = os.openpty()
    monkeypatch.setattr(Keyboard.__init__, "__defaults__", (Path(os.ttyname(slave)),))
    yield
    os.close(master)
    os.close(slave)


def mice(monkeypatch: pytest.MonkeyPatch, *listed: dict[str, Any]) -> None:
    class Locked:
        def open_path(self, path: bytes) -> None:
            raise OSError("open failed")

    monkeypatch.setattr(spacemouse, "hidapi", lambda: SimpleNamespace(enumerate=lambda: list(listed), device=Locked))


@pytest.mark.usefixtures("bare")
def test_auto_is_the_keyboard_where_there_is_nothing_else() -> None:
    with open_device() as device:
        assert isinstance(device, Keyboard)


@pytest.mark.usefixtures("bare")
def test_auto_does_not_pass_over_a_mouse_that_may_not_be_opened(monkeypatch: pytest.MonkeyPatch) -> None:
    mice(monkeypatch, MOUSE)
    with pytest.raises(HardwareError, match="SpaceMouse Compact at /dev/hidraw9 cannot be opened"):
        open_device("auto")


@pytest.mark.usefixtures("bare")
def test_auto_is_the_drivers_mouse_first(daemon: Spacenavd, monkeypatch: pytest.MonkeyPatch) -> None:
    mice(monkeypatch, MOUSE)
    monkeypatch.setenv(VARIABLE, str(daemon.socket))
    with open_device("auto") as device:
        assert isinstance(device, SpaceNav)


@pytest.mark.usefixtures("bare")
def test_auto_passes_over_a_driver_that_has_no_mouse(monkeypatch: pytest.MonkeyPatch) -> None:
    left = []

    class Empty:
        def read(self) -> Reading:
            return Reading(t=0.0, axes=AT_REST, buttons=(), age=0.0, connected=False)

        def __enter__(self) -> None:
            pass

        def __exit__(self, *_: object) -> None:
            left.append(True)

    monkeypatch.setattr(find, "socket_path", lambda: Path("spnav.sock"))
    monkeypatch.setattr(find, "open_space_nav", lambda clock: Empty())
    with open_device("auto") as device:
        assert isinstance(device, Keyboard)
    assert left == [True]


@pytest.mark.usefixtures("bare")
def test_a_file_is_played(tmp_path: Path) -> None:
    path = tmp_path / "session.csv"
    path.write_text(f"{HEAD}\n0,0,0,0,0,0,0,0\n1,0,0,0,0,0,0,0\n")
    with open_device(str(path), clock=lambda: 3.0) as device:
        assert isinstance(device, Scripted)
        assert device.read().t == 3.0


@pytest.mark.usefixtures("bare")
@pytest.mark.parametrize(
    ("word", "error", "said"),
    [
        ("spacemouse", HardwareError, "found no SpaceMouse"),
        ("spacenav", HardwareError, "found no socket of spacenavd"),
        ("joystick", InputError, "neither one of auto spacemouse spacenav keyboard gamepad nor a file"),
        (".", InputError, "nor a file"),
        ("", InputError, "nor a file"),
    ],
)
def test_what_is_not_there_is_refused_in_one_line(word: str, error: type[Exception], said: str) -> None:
    with pytest.raises(error) as caught:
        open_device(word)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_every_word_is_understood(monkeypatch: pytest.MonkeyPatch) -> None:
    opened = []
    for name in ("open_any", "open_space_mouse", "open_space_nav", "Keyboard", "open_gamepad"):
        monkeypatch.setattr(find, name, lambda *_, name=name, **__: opened.append(name))
    for word in find.WORDS:
        open_device(word)
    assert len(set(opened)) == len(find.WORDS)
