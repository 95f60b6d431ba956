"""The tests' end of the stand-in: it builds the libraries, runs the arm's process, and turns the switches."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from contextlib import suppress
from ctypes import addressof, memset, sizeof
from pathlib import Path
from typing import Any

import numpy as np
from hardware.memory import FUNCTIONS, TRACE, Memory, attach

from burnish.core import Array

HERE = Path(__file__).resolve().parent
VARIABLE = "BURNISH_STANDIN"
SERIAL = "PJ00650019161750001"


def build(compiler: str, folder: Path, actuators: int = 7, ethernet: bool = False) -> Path:
    """Compile one of the four libraries."""
    name = f"{'Eth' if ethernet else 'USB'}CommandLayerUbuntu.so"
    path = folder / str(actuators) / name
    path.parent.mkdir(parents=True, exist_ok=True)
    layer = ["-DETHERNET"] if ethernet else []
    flags = ["-Wall", "-Wextra", "-Werror", "-O1", "-shared", "-fPIC", f"-DACTUATORS={actuators}", *layer]
    subprocess.run([compiler, *flags, "-o", str(path), str(HERE / "standin.c")], check=True)
    return path


def urgent() -> None:
    """Put this process before the others of a busy machine, as one does with what drives a real arm; where it may."""
    with suppress(PermissionError):
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))


class StandIn:
    """An arm in another process. ``memory`` is what library, arm and tests share."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "memory"
        self.path.touch()
        self.memory: Memory = attach(self.path)
        os.environ[VARIABLE] = str(self.path)
        self._process = subprocess.Popen(
            [sys.executable, str(HERE / "arm.py"), str(self.path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def stop(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait(10.0)

    def reset(self, **options: Any) -> None:
        """A new arm, freshly switched on; all switches off."""
        self.off()
        memset(addressof(self.memory), 0, sizeof(Memory))
        self.memory.devices = 1
        self.memory.serial[0].value = SERIAL.encode()
        self.memory.serial[1].value = b"PJ00650019161750002"
        self._ask({"reset": {name: list(v) if isinstance(v, np.ndarray) else v for name, v in options.items()}})

    def off(self) -> None:
        """No arm."""
        self._ask({"off": True})

    def advance(self, seconds: float) -> None:
        """Let an arm on simulated time live for so long."""
        self._ask({"advance": seconds})

    def pause(self) -> None:
        """Let the arm's process not get the processor until `go_on`."""
        self._process.send_signal(signal.SIGSTOP)

    def go_on(self) -> None:
        self._process.send_signal(signal.SIGCONT)

    def fail(self, call: str, code: int, times: int = -1) -> None:
        """From now on a call returns this code, so many times; without end if negative."""
        self.memory.code[FUNCTIONS.index(call)] = code
        self.memory.times[FUNCTIONS.index(call)] = times

    def calls(self, name: str) -> int:
        """How often a call came."""
        return int(self.memory.calls[FUNCTIONS.index(name)])

    def trace(self) -> tuple[Array, Array, Array]:
        """Time [s], true joint angles [rad] and mode (1: torque) once a tick of the base since the last reset."""
        count = self.memory.traced
        assert count <= TRACE, "the trace is full: a shorter test, or a longer trace"
        rows = np.array(np.frombuffer(self.memory.trace, np.float64).reshape(TRACE, 8)[:count])
        return rows[:, 0], rows[:, 1:7], rows[:, 7]

    def _ask(self, words: dict[str, Any]) -> None:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps(words) + "\n")
        self._process.stdin.flush()
        assert self._process.stdout.readline() == "done\n", "the arm's process has died"


class SteppedClock:
    """The driver's clock where time passes only while somebody waits for it: an arm on simulated time."""

    def __init__(self, standin: StandIn) -> None:
        self._standin = standin
        self._now = 0.0

    def now(self) -> float:
        return self._now

    def wait(self, until: float) -> None:
        if until > self._now:
            self._standin.advance(until - self._now)
            self._now = until


class Unhurried:
    """A clock on which every wait is over at once: cycles follow each other as fast as they can."""

    def __init__(self) -> None:
        self._now = 0.0

    def now(self) -> float:
        return self._now

    def wait(self, until: float) -> None:
        self._now = max(self._now, until)
