"""Sticks, triggers and shoulders to the operator's frame; pygame itself without a pad, and missing."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest
from teleop.clock import Clock

from burnish.errors import HardwareError
from burnish.teleop import gamepad
from burnish.teleop.device import AT_REST
from burnish.teleop.gamepad import Gamepad, open_gamepad


class Pad:
    """A pad with sticks and buttons where the test puts them, by SDL's numbers."""

    def __init__(self) -> None:
        self.counts = dict.fromkeys(range(6), 0)
        self.pressed: set[int] = set()
        self.there, self.given_back = True, False

    def get_axis(self, axis: int, /) -> int:
        return self.counts[axis]

    def get_button(self, button: int, /) -> bool:
        return button in self.pressed

    def attached(self) -> bool:
        return self.there

    def quit(self) -> None:
        self.given_back = True


@pytest.fixture
def pad() -> Pad:
    return Pad()


def opened(pad: Pad) -> Gamepad:
    return Gamepad(pad, "a pad", pump=lambda: None, clock=Clock())


@pytest.mark.parametrize(
    ("counts", "axis", "value"),
    [
        ({0: 32767}, 0, 1.0),  # left stick to the right: right
        ({1: -32768}, 1, 1.0),  # left stick up: away
        ({5: 32767}, 2, 1.0),  # right trigger: up
        ({4: 32767}, 2, -1.0),  # left trigger: down
        ({3: -32768}, 3, -1.0),  # right stick up: tips away, a negative turn about x
        ({2: 32767}, 5, -1.0),  # right stick to the right: clockwise seen from above
        ({4: 32767, 5: 32767}, 2, 0.0),
    ],
)
def test_each_stick_moves_its_axis(pad: Pad, counts: dict[int, int], axis: int, value: float) -> None:
    pad.counts.update(counts)
    assert opened(pad).read().axes == tuple(value if i == axis else 0.0 for i in range(6))


def test_shoulders_tip_about_y(pad: Pad) -> None:
    pad.pressed = {10}
    assert opened(pad).read().axes[4] == 1.0
    pad.pressed = {9}
    assert opened(pad).read().axes[4] == -1.0


def test_the_buttons_are_a_b_x_y_back_and_start(pad: Pad) -> None:
    for number, button in enumerate((0, 1, 2, 3, 4, 6)):
        pad.pressed = {button}
        assert opened(pad).read().buttons == tuple(i == number for i in range(6))


def test_a_stick_that_is_held_still_stays_fresh(pad: Pad) -> None:
    device = opened(pad)
    pad.counts[0] = 20_000
    assert [device.read().age for _ in range(3)] == [0.0] * 3


def test_a_pad_that_is_unplugged_is_gone_and_given_back(pad: Pad) -> None:
    pad.counts[0], pad.pressed = 32767, {0}
    with opened(pad) as device:
        pad.there = False
        reading = device.read()
        assert (reading.connected, reading.axes, reading.buttons) == (False, AT_REST, (False,) * 6)
    assert pad.given_back


def test_sdls_numbers_are_those_of_pygame() -> None:
    pygame = pytest.importorskip("pygame")
    ours = (
        gamepad.LEFT_X,
        gamepad.LEFT_Y,
        gamepad.RIGHT_X,
        gamepad.RIGHT_Y,
        gamepad.LEFT_TRIGGER,
        gamepad.RIGHT_TRIGGER,
    )
    names = ("LEFTX", "LEFTY", "RIGHTX", "RIGHTY", "TRIGGERLEFT", "TRIGGERRIGHT")
    assert ours == tuple(getattr(pygame, f"CONTROLLER_AXIS_{name}") for name in names)
    buttons = ("A", "B", "X", "Y", "BACK", "START", "LEFTSHOULDER", "RIGHTSHOULDER")
    assert (*gamepad.BUTTONS, gamepad.LEFT_SHOULDER, gamepad.RIGHT_SHOULDER) == tuple(
        getattr(pygame, f"CONTROLLER_BUTTON_{name}") for name in buttons
    )


def test_without_pygame_the_refusal_is_the_line_that_installs_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pygame", None)
    with pytest.raises(HardwareError, match=r"pip install 'burnish\[gamepad\]'"):
        open_gamepad()


def test_without_a_pad_pygame_opens_no_window_and_leaves_ctrl_c_alone() -> None:
    pytest.importorskip("pygame")
    program = """
import os, signal
from burnish.errors import HardwareError
from burnish.teleop.gamepad import open_gamepad
try:
    open_gamepad()
except HardwareError as error:
    print(error)
try:
    os.kill(os.getpid(), signal.SIGINT)
    print("ignored")
except KeyboardInterrupt:
    print("interrupted")
"""
    environment = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, env=environment, check=False, timeout=60
    )
    assert done.returncode in (0, -signal.SIGINT), done.stderr
    assert done.stdout.splitlines()[-2:] == [
        "found no gamepad; plug one in, or take another --device ('burnish devices' lists them)",
        "interrupted",
    ]
