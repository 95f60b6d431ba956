"""The client of spacenavd: against the distribution's daemon with a played mouse, and against played daemons."""

from __future__ import annotations

import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from teleop.clock import Clock, read_until
from teleop.magellan import Spacenavd

from burnish.errors import HardwareError
from burnish.teleop.device import AT_REST
from burnish.teleop.shaping import Memory, Shaping, shape
from burnish.teleop.spacenav import EVENT, VARIABLE, VERSION_1, SpaceNav, axes_of, open_space_nav, socket_path

# The real daemon.


def test_the_mouse_of_a_real_daemon_reads_in_the_operators_frame(daemon: Spacenavd) -> None:
    with open_space_nav(path=daemon.socket) as device:
        assert (device.name, device.version) == ("Magellan SpaceMouse through spacenavd", 1)
        # The Magellan counts x right, y up, z towards the operator; the operator's frame is x right, y away, z up.
        daemon.mouse.move(30, -20, 50, -40, 35, -25)
        reading = read_until(device, lambda one: one.axes != AT_REST)
        assert reading.axes == pytest.approx((0.06, -0.1, -0.04, -0.08, 0.05, 0.07))
        assert reading.age == 0.0
        assert reading.connected


def test_the_buttons_of_a_real_daemon_are_pressed_and_released(daemon: Spacenavd) -> None:
    with open_space_nav(path=daemon.socket) as device:
        assert not any(device.read().buttons)
        for bits in (0b1, 0b10, 0b101, 0):
            daemon.mouse.press(bits)
            wanted = tuple(bool(bits >> i & 1) for i in range(3))
            read_until(device, lambda one, wanted=wanted: one.buttons[:3] == wanted)


def test_two_clients_of_one_daemon_hear_the_same(daemon: Spacenavd) -> None:
    with open_space_nav(path=daemon.socket) as one, open_space_nav(path=daemon.socket) as other:
        daemon.mouse.move(100, 0, 0, 0, 0, 0)
        for device in (one, other):
            read_until(device, lambda found: found.axes[0] == pytest.approx(0.2))


def test_the_daemon_is_found_by_the_environment(daemon: Spacenavd, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, str(daemon.socket))
    assert socket_path() == daemon.socket
    with open_space_nav() as device:
        assert device.read().connected


def test_a_client_of_version_0_gets_the_same_motion(daemon: Spacenavd) -> None:
    with socket.socket(socket.AF_UNIX) as plain:
        plain.connect(str(daemon.socket))
        # A client that asks nothing is served by version 0. The other one's answers show that it was let in.
        with open_space_nav(path=daemon.socket):
            daemon.mouse.move(0, 50, 0, 0, 0, 0)
        plain.settimeout(5.0)
        axes = axes_of(EVENT.unpack(plain.recv(EVENT.size, socket.MSG_WAITALL)))
        while not any(axes):  # The cap at rest, sent before it was moved.
            axes = axes_of(EVENT.unpack(plain.recv(EVENT.size, socket.MSG_WAITALL)))
        assert axes == pytest.approx((0.0, 0.0, 0.1, 0.0, 0.0, 0.0))


def test_a_daemon_that_is_killed_ends_the_motion_in_a_ramp() -> None:
    with Spacenavd() as daemon, open_space_nav(path=daemon.socket) as device:
        memory, shaping = Memory(), Shaping(dead_band=0.0)
        _, memory = shape(device.read(), memory, shaping)
        daemon.mouse.move(250, 0, 0, 0, 0, 0)
        daemon.mouse.press(1)
        read_until(device, lambda one: one.axes[0] == 0.5 and one.buttons[0])
        daemon.kill()
        found = []
        lost = time.monotonic()
        while time.monotonic() < lost + 0.3:
            meant, memory = shape(device.read(), memory, shaping)
            found.append(meant)
            time.sleep(0.005)
        assert not any(one.connected or any(one.buttons) for one in found)
        pushed = [one.axes[0] for one in found]
        assert pushed == sorted(pushed, reverse=True)
        assert found[-1].axes == AT_REST


def test_a_daemon_that_hangs_ends_the_motion_in_a_ramp() -> None:
    with Spacenavd() as daemon, open_space_nav(path=daemon.socket) as device:
        memory, shaping = Memory(), Shaping(dead_band=0.0)
        _, memory = shape(device.read(), memory, shaping)
        daemon.mouse.move(250, 0, 0, 0, 0, 0)
        read_until(device, lambda one: one.axes[0] == 0.5)
        daemon.freeze()
        daemon.mouse.move(0, 0, 0, 0, 0, 0)
        reading = read_until(device, lambda one: one.age >= 0.2)
        assert reading.axes[0] == 0.5
        assert shape(reading, memory, shaping)[0].axes == AT_REST
        daemon.process.send_signal(signal.SIGCONT)
        read_until(device, lambda one: one.axes == AT_REST)


@pytest.mark.slow  # the daemon looks for the mouse twice
def test_a_mouse_that_is_unplugged_and_plugged_in_again() -> None:
    with Spacenavd("repeat-interval = 40") as daemon, open_space_nav(path=daemon.socket) as device:
        daemon.mouse.move(250, 0, 0, 0, 0, 0)
        daemon.mouse.press(1)
        read_until(device, lambda one: one.axes[0] == 0.5 and one.buttons[0])
        daemon.take_away()
        gone = read_until(device, lambda one: not one.connected)
        assert gone.axes[0] == 0.5
        assert not any(gone.buttons)
        read_until(device, lambda one: one.age > 0.2)
        daemon.give_back()
        back = read_until(device, lambda one: one.connected)
        assert back.axes == AT_REST
        daemon.mouse.move(0, 0, 100, 0, 0, 0)
        read_until(device, lambda one: one.axes[1] == pytest.approx(-0.2))


@pytest.mark.slow  # a daemon with another setting
def test_with_repeats_a_cap_that_is_held_still_stays_fresh_and_without_it_ages() -> None:
    for lines, fresh in ((("repeat-interval = 40",), True), ((), False)):
        with Spacenavd(*lines) as daemon, open_space_nav(path=daemon.socket) as device:
            daemon.mouse.move(250, 0, 0, 0, 0, 0)
            read_until(device, lambda one: one.axes[0] == 0.5)
            ages = []
            for _ in range(60):
                time.sleep(0.01)
                ages.append(device.read().age)
            # The daemon may be late on a busy machine, so only the half of the time has to be fresh.
            assert (sorted(ages)[30] < 0.1) == fresh


# Played daemons.


@pytest.fixture
def pair() -> Iterator[tuple[socket.socket, socket.socket]]:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        yield ours, theirs


def opened(
    pair: tuple[socket.socket, socket.socket], daemon: Callable[[socket.socket], object], clock: Clock
) -> SpaceNav:
    """The client on one end, while the other plays the begin of the conversation."""
    ours, theirs = pair
    thread = threading.Thread(target=daemon, args=(theirs,))
    thread.start()
    device = SpaceNav(ours, clock=clock)
    thread.join()
    return device


def answer(theirs: socket.socket, name: bytes, buttons: int, *, whole: bool = False, before: bytes = b"") -> None:
    """A daemon of version 1: with the name in pieces as from 1.1 on, or in one as 1.0 does."""
    assert theirs.recv(4, socket.MSG_WAITALL) == VERSION_1
    theirs.sendall(before + VERSION_1)
    kind, *_ = EVENT.unpack(theirs.recv(EVENT.size, socket.MSG_WAITALL))
    theirs.sendall(before + EVENT.pack(kind, buttons, 0, 0, 0, 0, 0, 0 if buttons >= 0 else -1))
    if buttons < 0:
        return
    kind, *_ = EVENT.unpack(theirs.recv(EVENT.size, socket.MSG_WAITALL))
    if whole:
        theirs.sendall(EVENT.pack(kind, len(name), 0, 0, 0, 0, 0, 0) + name)
        return
    for begin in range(0, len(name), 24):
        piece = EVENT.pack(kind, *(int.from_bytes(name[i : i + 4].ljust(4, b"\0"), "little") for i in pieces(begin)), 0)
        left = (len(name) - begin) | (0x10000 if begin else 0)
        theirs.sendall(piece[:28] + left.to_bytes(4, "little"))


def pieces(begin: int) -> range:
    return range(begin, begin + 24, 4)


@pytest.mark.parametrize("whole", [True, False])
def test_the_name_is_read_in_both_forms(pair: tuple[socket.socket, socket.socket], whole: bool) -> None:
    name = b"3Dconnexion SpaceMouse Pro Wireless Receiver"
    device = opened(pair, lambda theirs: answer(theirs, name, 15, whole=whole), Clock())
    assert device.name == f"{name.decode()} through spacenavd"
    reading = device.read()
    assert (len(reading.buttons), reading.connected, device.version) == (15, True, 1)


def test_events_before_the_answers_do_no_harm(pair: tuple[socket.socket, socket.socket]) -> None:
    motion = EVENT.pack(0, 1, 2, 3, 4, 5, 6, 7)
    device = opened(pair, lambda theirs: answer(theirs, b"mouse", 2, before=motion), Clock())
    pair[1].sendall(EVENT.pack(0, 500, 0, 0, 0, 0, 0, 8))
    assert device.read().axes == (1.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def test_a_daemon_that_knows_version_0_only_is_read(pair: tuple[socket.socket, socket.socket]) -> None:
    device = opened(pair, lambda theirs: theirs.recv(4, socket.MSG_WAITALL), Clock())
    assert device.version == 0
    pair[1].sendall(EVENT.pack(0, 0, 250, 0, 0, 0, -250, 8) + EVENT.pack(1, 3, 0, 0, 0, 0, 0, 0))
    reading = device.read()
    assert reading.axes == (0.0, 0.0, 0.5, 0.0, -0.5, 0.0)
    assert reading.buttons == (False, False, False, True)


def test_a_daemon_of_version_0_is_told_by_its_silence_even_while_events_come(
    pair: tuple[socket.socket, socket.socket],
) -> None:
    ours, theirs = pair
    opened = threading.Event()

    def push() -> None:
        count = 0
        while not opened.wait(0.01):
            count += 1
            theirs.sendall(EVENT.pack(0, count, 0, 0, 0, 0, 0, 8))

    thread = threading.Thread(target=push)
    thread.start()
    device = SpaceNav(ours, clock=Clock())
    opened.set()
    thread.join()
    assert device.version == 0
    theirs.sendall(EVENT.pack(0, 0, 250, 0, 0, 0, 0, 8))
    assert device.read().axes == (0.0, 0.0, 0.5, 0.0, 0.0, 0.0)


def test_a_daemon_without_a_mouse_says_so_until_one_comes(pair: tuple[socket.socket, socket.socket]) -> None:
    device = opened(pair, lambda theirs: answer(theirs, b"", -1), Clock())
    assert device.name == "spacenavd without a device"
    assert not device.read().connected
    pair[1].sendall(EVENT.pack(3, 0, 1, 0, 0, 0, 0, 0))
    assert device.read().connected


def test_an_event_in_two_halves_waits_for_its_second(pair: tuple[socket.socket, socket.socket]) -> None:
    device = opened(pair, lambda theirs: answer(theirs, b"mouse", 2), Clock())
    event = EVENT.pack(0, 500, 0, 0, 0, 0, 0, 8)
    pair[1].sendall(event[:13])
    assert device.read().axes == AT_REST
    pair[1].sendall(event[13:])
    assert device.read().axes[0] == 1.0


def test_a_daemon_that_hangs_up_leaves_the_last_axes_to_age(pair: tuple[socket.socket, socket.socket]) -> None:
    clock = Clock()
    device = opened(pair, lambda theirs: answer(theirs, b"mouse", 2), clock)
    pair[1].sendall(EVENT.pack(0, 500, 0, 0, 0, 0, 0, 8) + EVENT.pack(1, 0, 0, 0, 0, 0, 0, 0))
    assert device.read().buttons == (True, False)
    pair[1].close()
    clock.now += 0.15
    reading = device.read()
    assert (reading.connected, reading.axes[0], reading.buttons) == (False, 1.0, (False, False))
    assert reading.age == pytest.approx(0.15)
    assert device.read() == reading


def test_a_button_pressed_in_the_daemons_last_word_is_not_held_for_ever(
    pair: tuple[socket.socket, socket.socket],
) -> None:
    device = opened(pair, lambda theirs: answer(theirs, b"mouse", 2), Clock())
    pair[1].sendall(EVENT.pack(0, 500, 0, 0, 0, 0, 0, 8) + EVENT.pack(1, 0, 0, 0, 0, 0, 0, 0))
    pair[1].close()
    reading = device.read()
    assert (reading.connected, reading.axes[0], reading.buttons) == (False, 1.0, (False, False))


@given(st.lists(st.tuples(*[st.integers(-(2**31), 2**31 - 1)] * 8), max_size=20))
@settings(max_examples=25)
def test_no_event_breaks_a_reading(events: list[tuple[int, ...]]) -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        device = opened((ours, theirs), lambda end: answer(end, b"mouse", 2), Clock())
        theirs.sendall(b"".join(EVENT.pack(*event) for event in events))
        reading = device.read()
        assert all(abs(x) <= 1.0 for x in reading.axes)
        assert len(reading.buttons) <= 64


def test_without_a_daemon_the_refusal_says_how_to_get_one(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "none.sock"))
    assert socket_path() is None
    with pytest.raises(HardwareError, match=r"found no socket of spacenavd at .*none\.sock; install and start it"):
        open_space_nav()


def test_a_socket_that_nobody_serves_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with socket.socket(socket.AF_UNIX) as dead:
        dead.bind("dead.sock")
    with pytest.raises(HardwareError, match=r"refuses .*restart it"):
        open_space_nav(path=Path("dead.sock"))
