"""Keys typed into a pseudo-terminal to axes and buttons; the terminal is given back whatever happens."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import termios
import textwrap
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from teleop.clock import Clock

from burnish.errors import HardwareError
from burnish.teleop.device import AT_REST
from burnish.teleop.keyboard import AXES, DOWN, FIRST_DEFLECTION, PAGE_UP, UP, Keyboard

HALF = FIRST_DEFLECTION


@dataclass
class Terminal:
    """A pseudo-terminal: the person's end, and the path of the program's."""

    master: int
    slave: int
    path: Path

    def type(self, keys: str) -> None:
        os.write(self.master, keys.encode("latin-1"))

    def settings(self) -> list[Any]:
        return termios.tcgetattr(self.slave)


@pytest.fixture
def terminal() -> Iterator[Terminal]:
    master, slave = os.openpty()
    yield Terminal(master, slave, Path(os.ttyname(slave)))
    for end in (master, slave):
        with suppress(OSError):
            os.close(end)


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def keyboard(terminal: Terminal, clock: Clock) -> Iterator[Keyboard]:
    with Keyboard(terminal.path, clock=clock) as found:
        yield found


@pytest.mark.parametrize(("key", "pushed"), AXES.items())
def test_each_key_pushes_its_axis(terminal: Terminal, keyboard: Keyboard, key: str, pushed: tuple[int, float]) -> None:
    terminal.type(key)
    axis, sign = pushed
    assert keyboard.read().axes == tuple(sign * HALF if i == axis else 0.0 for i in range(6))


def test_a_tap_counts_for_100_ms_and_is_gone_after_200_ms(terminal: Terminal, keyboard: Keyboard, clock: Clock) -> None:
    terminal.type(UP)
    start, pushed = clock.now, {}
    for ms in (0, 50, 99, 150, 201, 400):
        clock.now = start + ms / 1000.0
        pushed[ms] = keyboard.read().axes[1]
    assert pushed == pytest.approx({0: HALF, 50: HALF, 99: HALF, 150: 0.5 * HALF, 201: 0.0, 400: 0.0})


def test_a_held_key_moves_without_a_gap_once_it_repeats(terminal: Terminal, keyboard: Keyboard, clock: Clock) -> None:
    for _ in range(30):
        terminal.type(DOWN)
        for _ in range(4):
            assert keyboard.read().axes[1] == -HALF
            clock.now += 0.01


def test_the_key_typed_last_decides_between_two_of_one_axis(terminal: Terminal, keyboard: Keyboard) -> None:
    terminal.type(UP + "j" + DOWN)
    reading = keyboard.read()
    assert (reading.axes[1], reading.axes[5]) == (-HALF, HALF)


def test_plus_and_minus_change_how_much_a_key_pushes(terminal: Terminal, keyboard: Keyboard) -> None:
    terminal.type("+" * 5 + UP)
    assert keyboard.read().axes[1] == 1.0
    terminal.type("-" * 9 + UP)
    assert keyboard.read().axes[1] == 0.125


def test_a_button_key_is_a_press_of_100_ms(terminal: Terminal, keyboard: Keyboard, clock: Clock) -> None:
    assert keyboard.read().buttons == (False,) * 4
    terminal.type("2")
    assert keyboard.read().buttons == (False, True, False, False)
    clock.now += 0.11
    assert keyboard.read().buttons == (False,) * 4


def test_other_keys_are_left_to_the_program_in_order(terminal: Terminal, keyboard: Keyboard) -> None:
    terminal.type("q" + UP + "R \n")
    keyboard.read()
    assert keyboard.others() == ["q", "R", " ", "\n"]
    assert keyboard.others() == []


def test_a_sequence_in_two_halves_is_one_key(terminal: Terminal, keyboard: Keyboard) -> None:
    terminal.type(PAGE_UP[:2])
    assert keyboard.read().axes == AT_REST
    terminal.type(PAGE_UP[2:])
    assert keyboard.read().axes[2] == HALF
    assert keyboard.others() == []


def test_the_escape_key_alone_is_a_key(terminal: Terminal, keyboard: Keyboard) -> None:
    terminal.type("\x1b")
    keyboard.read()
    keyboard.read()
    assert keyboard.others() == ["\x1b"]


def test_arrows_of_a_terminal_in_application_mode_count_too(terminal: Terminal, keyboard: Keyboard) -> None:
    terminal.type("\x1bOA")
    assert keyboard.read().axes[1] == HALF


@given(st.text(st.characters(max_codepoint=255, exclude_characters="\x03\x1a\x1c\x11\x13"), max_size=200))
def test_nothing_that_is_typed_breaks_a_reading(typed: str) -> None:
    master, slave = os.openpty()
    try:
        with Keyboard(Path(os.ttyname(slave)), clock=Clock()) as keyboard:
            os.write(master, typed.encode("latin-1"))
            for _ in range(3):
                assert all(abs(x) <= 1.0 for x in keyboard.read().axes)
            assert all(len(key) == 1 or key.startswith("\x1b") for key in keyboard.others())
    finally:
        os.close(master)
        os.close(slave)


def test_a_terminal_that_is_closed_is_a_device_that_is_gone(terminal: Terminal, clock: Clock) -> None:
    with Keyboard(terminal.path, clock=clock) as keyboard:
        terminal.type(UP + "1")
        assert keyboard.read().buttons[0]
        os.close(terminal.master)
        reading = keyboard.read()
        assert not reading.connected
        assert not any(reading.buttons)
        assert keyboard.read().axes == AT_REST


def test_the_terminal_is_as_before_after_leaving(terminal: Terminal) -> None:
    before = terminal.settings()
    with Keyboard(terminal.path):
        assert not terminal.settings()[3] & (termios.ECHO | termios.ICANON)
        # Ctrl-C still interrupts.
        assert terminal.settings()[3] & termios.ISIG
    assert terminal.settings() == before


def test_the_terminal_is_as_before_after_an_error(terminal: Terminal) -> None:
    before = terminal.settings()
    with pytest.raises(ZeroDivisionError), Keyboard(terminal.path):
        raise ZeroDivisionError
    assert terminal.settings() == before


@pytest.mark.parametrize("end", ["sys.exit(3)", "1 / 0", "os.kill(os.getpid(), signal.SIGINT)"])
def test_the_terminal_is_as_before_after_a_program_that_never_left_it(terminal: Terminal, end: str) -> None:
    before = terminal.settings()
    program = f"""
        import os, signal, sys
        from pathlib import Path
        from burnish.teleop.keyboard import Keyboard
        keyboard = Keyboard(Path({str(terminal.path)!r}))
        {end}
    """
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(program)], capture_output=True, check=False)
    assert done.returncode in (3, 1, -signal.SIGINT, 130)
    assert terminal.settings() == before


def test_without_a_terminal_the_refusal_says_so(tmp_path: Path) -> None:
    with pytest.raises(HardwareError, match=r"cannot be opened .*run burnish in a terminal"):
        Keyboard(tmp_path / "none")
    (tmp_path / "file").touch()
    with pytest.raises(HardwareError, match=r"is no terminal; .* take another --device"):
        Keyboard(tmp_path / "file")
