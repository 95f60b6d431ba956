"""A client of spacenavd, the free driver for six-axis mice: its socket's events to readings.

An event is eight 32-bit integers: motion ``(0, x, y, z, rx, ry, rz, period)``, press ``(1, button, …)``, release
``(2, button, …)``, and in version 1 of the protocol a device that comes or goes ``(3, 0 | 1, …)``. A client that says
nothing is served by version 0. Its frame is x to the right, y up, z away from the operator; those are left-handed
axes, and ours are the same three in the order x z y.

Source: spacenavd 1.1, src/proto.h and src/proto_unix.c; the order of the axes also thesis A, section 6.2.
"""

from __future__ import annotations

import os
import socket
import struct
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

from typing_extensions import Self

from burnish.errors import HardwareError
from burnish.teleop.device import AT_REST, Axes, Reading, clipped, six

EVENT = struct.Struct("=8i")
MOTION, PRESS, RELEASE, DEVICE = range(4)
"""First integer of an event."""
ADDED, REMOVED = range(2)
"""Second integer of a device's event."""
VERSION_1 = struct.pack("=I", 0x7FAA5501)
"""The request to speak version 1; a driver that knows it sends the same back."""
REQUEST = 0x7FAA0000
NAME, BUTTONS = 0x2000, 0x2003
"""Questions about the device, of version 1."""
ANSWER = 0.5
"""Time that the driver gets to answer [s]; it takes less than a millisecond."""
FULL_SCALE = 500.0
"""Counts at the end of an axis, at the driver's usual sensitivity; as other programs take it."""
ORDER = (0, 2, 1, 3, 5, 4)
"""The driver's axes in our order."""
MOST_BUTTONS = 64
LONGEST_NAME = 256
LENGTH = 0xFFFF
"""Bits of a name's answer that are its length; a bit above them marks a further piece."""
AT_ONCE = 256
"""Events taken in one reading; a mouse sends about two in a cycle of 100 Hz."""
VARIABLE = "SPNAV_SOCKET"
"""Environment variable that names another socket, as libspnav has it."""
SOCKETS = (Path("/var/run/spnav.sock"), Path("/run/spnav.sock"))


class SpaceNav:
    """A connection to spacenavd; `read` takes what has arrived since the last call and never waits."""

    def __init__(self, connection: socket.socket, *, clock: Callable[[], float] = time.monotonic) -> None:
        """Ask for version 1 of the protocol, and for the device; takes the socket over.

        Raises:
            HardwareError: if the driver hangs up or answers half.
        """
        self._socket, self._clock = connection, clock
        self._bytes = b""
        self._axes, self._reported = AT_REST, clock()
        self._buttons = [False, False]
        self._daemon, self._device = True, True
        connection.settimeout(ANSWER)
        try:
            self.version = self._handshake()
            self.name = self._introduce() if self.version else "spacenavd (protocol 0)"
        except OSError as error:
            raise HardwareError(f"spacenavd hung up ({error}); restart it: systemctl restart spacenavd") from None
        connection.setblocking(False)

    def read(self) -> Reading:
        """What the mouse says now; an age counts from the call that took the event."""
        t = self._clock()
        self._receive()
        whole = len(self._bytes) // EVENT.size * EVENT.size
        for event in EVENT.iter_unpack(self._bytes[:whole]):
            self._take(event, t)
        self._bytes = self._bytes[whole:]
        connected = self._daemon and self._device
        return Reading(
            t=t,
            axes=self._axes,
            buttons=tuple(pressed and connected for pressed in self._buttons),
            age=max(0.0, t - self._reported),
            connected=connected,
        )

    def _take(self, event: tuple[int, ...], t: float) -> None:
        kind, first = event[:2]
        if kind == MOTION:
            self._axes, self._reported, self._device = axes_of(event), t, True
        elif kind in (PRESS, RELEASE) and 0 <= first < MOST_BUTTONS:
            self._buttons += [False] * (first + 1 - len(self._buttons))
            self._buttons[first] = kind == PRESS
        elif kind == DEVICE:
            self._device = first == ADDED
            if self._device:
                self._axes = AT_REST
            self._buttons = [False] * len(self._buttons)

    def _receive(self) -> None:
        """Add what has arrived; a driver that is gone leaves its last axes to age."""
        try:
            while self._daemon and len(self._bytes) < AT_ONCE * EVENT.size:
                piece = self._socket.recv(4096)
                self._bytes += piece
                self._daemon = bool(piece)
        except (BlockingIOError, InterruptedError):
            return
        except OSError:
            self._daemon = False

    def _handshake(self) -> int:
        """Version of the protocol; a driver of version 0 takes the request for a number and does not answer."""
        self._socket.sendall(VERSION_1)
        deadline = time.monotonic() + ANSWER
        try:
            while time.monotonic() < deadline:
                if self._exactly(len(VERSION_1)) == VERSION_1:
                    return 1
                # The begin of an event: a hand is on the cap already. Nothing is known of the time before it either.
                self._exactly(EVENT.size - len(VERSION_1))
        except TimeoutError:
            # Silence is the answer of version 0.
            return 0
        return 0

    def _introduce(self) -> str:
        """Name of the device, and room for its buttons; a driver without a device says that it has none."""
        count, *_, status = self._ask(BUTTONS)
        self._device = status == 0
        if not self._device:
            return "spacenavd without a device"
        self._buttons = [False] * min(max(count, 0), MOST_BUTTONS)
        return f"{self._ask_name()} through spacenavd"

    def _ask_name(self) -> str:
        """Name of the device.

        Version 1.0 of the driver says how long it is and sends that many bytes. From 1.1 on it comes in pieces of 24
        bytes, each with the length that is left.
        """
        answer = self._ask(NAME)
        if answer[-1] == 0:
            return self._exactly(min(max(answer[0], 0), LONGEST_NAME)).decode(errors="replace")
        name, left = b"", min(max(answer[-1] & LENGTH, 0), LONGEST_NAME)
        while True:
            name += struct.pack("=6i", *answer[:6])
            if len(name) >= left:
                return name[:left].decode(errors="replace")
            answer = self._answer(NAME)

    def _ask(self, question: int) -> tuple[int, ...]:
        """The seven numbers of the answer: the last is the status."""
        self._socket.sendall(EVENT.pack(REQUEST | question, *(0,) * 7))
        return self._answer(question)

    def _answer(self, question: int) -> tuple[int, ...]:
        """The next answer to a question; events before it say what a later one says again."""
        while True:
            kind, *numbers = EVENT.unpack(self._exactly(EVENT.size))
            if kind == REQUEST | question:
                return tuple(numbers)

    def _exactly(self, count: int) -> bytes:
        """The next bytes.

        Raises:
            TimeoutError: if they do not come.
            OSError: if the driver hung up.
        """
        found = b""
        while len(found) < count:
            piece = self._socket.recv(count - len(found))
            if not piece:
                raise ConnectionResetError("end of file")
            found += piece
        return found

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._socket.close()


def axes_of(event: tuple[int, ...]) -> Axes:
    """The axes of a motion event in the operator's frame, as shares of the full scale."""
    return six(clipped(event[1 + axis] / FULL_SCALE) for axis in ORDER)


def socket_path() -> Path | None:
    """Where the driver's socket is; None if there is none."""
    named = os.environ.get(VARIABLE)
    return next((path for path in ([Path(named)] if named else SOCKETS) if path.is_socket()), None)


def open_space_nav(clock: Callable[[], float] = time.monotonic, path: Path | None = None) -> SpaceNav:
    """Connect to the driver, at its usual socket if none is given.

    Raises:
        HardwareError: if it does not run or refuses.
    """
    path = path or socket_path()
    if path is None:
        where = os.environ.get(VARIABLE) or SOCKETS[0]
        raise HardwareError(
            f"found no socket of spacenavd at {where}; install and start it (apt install spacenavd), "
            f"or name its socket in {VARIABLE}"
        )
    connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        connection.settimeout(ANSWER)
        connection.connect(str(path))
        return SpaceNav(connection, clock=clock)
    except OSError as error:
        connection.close()
        raise HardwareError(f"spacenavd at {path} refuses ({error}); restart it: systemctl restart spacenavd") from None
    except HardwareError:
        connection.close()
        raise
