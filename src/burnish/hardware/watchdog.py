"""`Watchdog`: a process with its own clock that takes the arm to position mode when the control process hangs or dies.

The control process counts its cycles in a page of shared memory. If the count stands for too long, the watchdog kills
the process, which frees its claim on the arm, connects to the arm itself, and asks for position mode until the arm
reports it. If the process dies, it does the latter at once.
"""

from __future__ import annotations

import argparse
import json
import logging
import mmap
import os
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict
from pathlib import Path
from typing import IO

from typing_extensions import Self

from burnish.errors import HardwareError
from burnish.hardware.kinova import Kinova
from burnish.hardware.kinova_library import Library, find
from burnish.hardware.network import Network
from burnish.hardware.torque_mode import to_position_mode

logger = logging.getLogger(__name__)

PATIENCE = 0.1
"""Time that the count may stand [s]: ten cycles. Two would kill a healthy process on a busy machine, where one gap of
some tens of milliseconds comes every few minutes; the arm itself waits 250 ms."""
LOOK = 2e-3
"""Time between two looks at the count [s]."""
CLAIMS = 20
"""Attempts at the connection, a tenth of a second apart: a killed process frees the arm a little after its death."""
ASLEEP = 0
"""Count while the arm is in position mode and nobody has to be watched."""


class Watchdog:
    """The control process's end: tell it in every cycle, within ``with``, and it keeps still."""

    def __init__(
        self,
        serial: str,
        *,
        library: str | Path | None = None,
        network: Network | None = None,
        patience: float = PATIENCE,
    ) -> None:
        """A watchdog for the arm with this serial number, with library and network as for `Jaco2`.

        A cycle that takes longer than ``patience`` [s] is the control process's last.
        """
        words = {"serial": serial, "library": None if library is None else str(library), "patience": patience}
        self._words = words | {"network": None if network is None else asdict(network)}
        self._count = ASLEEP

    def __enter__(self) -> Self:
        """Start the process and wait until it is ready.

        Raises:
            HardwareError: if it does not start.
        """
        with tempfile.TemporaryFile() as page:
            page.truncate(mmap.PAGESIZE)
            self._memory = mmap.mmap(page.fileno(), mmap.PAGESIZE)
            words = json.dumps(self._words | {"page": page.fileno(), "watched": os.getpid()})
            self._process = subprocess.Popen(
                [sys.executable, "-m", "burnish.hardware.watchdog", words],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                pass_fds=[page.fileno()],
                # Ctrl-C is for the control process, which then ends in its own way.
                start_new_session=True,
            )
        assert self._process.stdout is not None
        if not self._process.stdout.readline():
            raise HardwareError("the watchdog did not start; see what it said above")
        return self

    def beat(self, in_torque_mode: bool) -> None:
        """A cycle has been done; in position mode nobody has to be watched."""
        self._count = self._count + 1 if in_torque_mode else ASLEEP
        self._memory[:8] = self._count.to_bytes(8, "little")

    def __exit__(self, *exception: object) -> None:
        """The arm is in position mode: the watchdog may go."""
        self.beat(False)
        self._process.communicate(b"done\n")
        self._memory.close()


def watch(memory: mmap.mmap, watched: int, patience: float, end: IO[bytes]) -> str | None:
    """Wait until somebody has to step in, and say why; None if the process has ended as it should."""
    os.set_blocking(end.fileno(), False)
    # A handle, because a number may belong to another process by the time it is needed.
    process = os.pidfd_open(watched)
    count, since = ASLEEP, time.monotonic()
    while True:
        time.sleep(LOOK)
        if end.read():
            return None
        if os.getppid() != watched:
            return "the control process has died"
        now, found = time.monotonic(), int.from_bytes(memory[:8], "little")
        if found != count or found == ASLEEP:
            count, since = found, now
        elif now - since > patience:
            signal.pidfd_send_signal(process, signal.SIGKILL)
            return f"the control process did nothing for {1e3 * (now - since):.0f} ms and was killed"


def take_over(serial: str, library: str | None, network: Network | None) -> None:
    """Position mode, by a connection of our own.

    Raises:
        HardwareError: if the arm cannot be had, or does not confirm position mode.
    """
    # The library's own state may be none after a failed start; each attempt is a new one.
    problem: HardwareError | None = None
    for _ in range(CLAIMS):
        try:
            with Kinova(Library(find(library)), network) as kinova:
                kinova.choose(serial)
                kinova.start()
                to_position_mode(kinova, lambda: time.sleep(0.01))
            return
        except HardwareError as error:
            problem = error
            time.sleep(0.1)
    assert problem is not None
    raise problem


def main() -> int:
    """The watchdog's process; 0 if nobody had to step in, 3 if it did, 1 if it could not."""
    logging.basicConfig(format="watchdog: %(message)s", level=logging.INFO)
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("words", help="what Watchdog hands over, as JSON")
    words = json.loads(options.parse_args().words)
    memory = mmap.mmap(words["page"], mmap.PAGESIZE)
    network = None if words["network"] is None else Network(**words["network"])
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    cause = watch(memory, words["watched"], words["patience"], sys.stdin.buffer)
    if cause is None:
        return 0
    logger.error("%s; taking the arm to position mode", cause)
    try:
        take_over(words["serial"], words["library"], network)
    except HardwareError as error:
        logger.error("%s", error)
        return 1
    logger.error("the arm is in position mode")
    return 3


if __name__ == "__main__":
    sys.exit(main())
