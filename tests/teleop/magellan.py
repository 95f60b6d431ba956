"""A real spacenavd fed by a serial SpaceMouse (a Magellan) that is played on a pseudo-terminal.

    with Spacenavd() as daemon:                       # about 2 s until it has found the mouse
        daemon.mouse.move(30, -20, 50, -40, 30, -25)  # the mouse's own counts: x right, y up, z towards the operator
        daemon.mouse.press(0b01)                      # a bit for each button
        open_space_nav(path=daemon.socket)

A program under test finds it through the environment variable SPNAV_SOCKET, see `Spacenavd.environment`. The daemon
runs in a folder of its own, because the distribution's binds the relative path run/spnav.sock.
"""

from __future__ import annotations

import os
import select
import shutil
import signal
import subprocess
import tempfile
import threading
import time
import tty
from pathlib import Path
from types import TracebackType

import pytest

READY = 20.0
"""Time that the daemon gets until its socket answers [s]; it waits 2 s for a mouse of another make first."""


class Magellan:
    """A serial SpaceMouse on a pseudo-terminal: it says its version when asked, and sends what the test lets it."""

    def __init__(self) -> None:
        self._master, slave = os.openpty()
        tty.setraw(slave)
        self.path = os.ttyname(slave)
        self._slave = slave
        self.heard = b""
        self.known = threading.Event()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def move(self, *counts: int) -> None:
        """Send six counts: translation x y z, rotation x y z."""
        assert len(counts) == 6
        self._send("d" + "".join(_nibbles(count + 0x8000, 4) for count in counts))

    def press(self, bits: int) -> None:
        """Send which buttons are pressed."""
        self._send("k" + _nibbles(bits, 4)[::-1])

    def unplug(self) -> None:
        """Pull the plug: the line hangs up."""
        if not self._stop.is_set():
            self._stop.set()
            self._thread.join()
            os.close(self._slave)
            os.close(self._master)

    def _listen(self) -> None:
        while not self._stop.is_set():
            if select.select([self._master], [], [], 0.01)[0]:
                self.heard += os.read(self._master, 256)
                if b"vQ\r" in self.heard:
                    self.heard = b""
                    self._send("vMAGELLAN  Version 6.60  3D Space Mouse")
                    self.known.set()

    def _send(self, packet: str) -> None:
        os.write(self._master, packet.encode("ascii") + b"\r")


def _nibbles(value: int, count: int) -> str:
    """A number in nibbles, highest first, each a letter whose lower four bits are the nibble."""
    return "".join("0AB3D56GH9:K<MN?"[value >> 4 * place & 0xF] for place in reversed(range(count)))


class Spacenavd:
    """The distribution's daemon with the played mouse, in a folder of its own."""

    def __init__(self, *settings: str) -> None:
        """Further ``settings`` are lines of its file."""
        program = executable()
        self.mouse = Magellan()
        # The path of a socket may be 107 bytes long, so this is no folder of pytest's.
        self.folder = Path(tempfile.mkdtemp(prefix="spn"))
        (self.folder / "run").mkdir()
        self.socket = self.folder / "run" / "spnav.sock"
        self._lines = ("dead-zone = 0", *settings)
        self._configure(f"serial = {self.mouse.path}")
        self.process = subprocess.Popen(
            [program, "-d", "-v", "-c", str(self.folder / "spnavrc"), "-l", str(self.folder / "log")],
            cwd=self.folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self._wait()

    @property
    def environment(self) -> dict[str, str]:
        """What a program under test needs in its environment."""
        return {"SPNAV_SOCKET": str(self.socket)}

    def take_away(self) -> None:
        """Let the daemon lose its mouse, as when a USB plug is pulled: it tells its clients."""
        self._configure()
        self.process.send_signal(signal.SIGHUP)

    def give_back(self) -> None:
        """Let it find the mouse again; it takes as long as at the start."""
        self.mouse.known.clear()
        self._configure(f"serial = {self.mouse.path}")
        self.process.send_signal(signal.SIGHUP)

    def freeze(self) -> None:
        """Stop the daemon as if it hung."""
        self.process.send_signal(signal.SIGSTOP)

    def kill(self) -> None:
        """End it without notice."""
        self.process.kill()
        self.process.wait(10.0)

    def _configure(self, *lines: str) -> None:
        (self.folder / "spnavrc").write_text("\n".join((*lines, *self._lines)) + "\n")

    def _wait(self) -> None:
        deadline = time.monotonic() + READY
        while not (self.mouse.known.is_set() and self.socket.is_socket()):
            if self.process.poll() is not None or time.monotonic() > deadline:
                self.close()
                raise RuntimeError("spacenavd did not find the played mouse")
            time.sleep(0.02)

    def close(self) -> None:
        """End all of it."""
        self.kill()
        self.mouse.unplug()
        shutil.rmtree(self.folder)

    def __enter__(self) -> Spacenavd:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def executable() -> str:
    """The distribution's daemon; a test is skipped without it, and fails where CI is set."""
    found = shutil.which("spacenavd") or shutil.which("spacenavd", path="/usr/sbin:/usr/bin")
    if found is None:
        why = "spacenavd is not installed (apt install spacenavd)"
        pytest.fail(why) if os.environ.get("CI") else pytest.skip(why)
    return found
