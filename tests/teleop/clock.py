"""A clock that a test sets, and waiting for what another process does."""

from __future__ import annotations

import time
from collections.abc import Callable

from burnish.teleop.device import Device, Reading


class Clock:
    """Seconds that pass only when the test says so."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def read_until(device: Device, seen: Callable[[Reading], bool], patience: float = 10.0) -> Reading:
    """Read until the reading is as expected; fails with the last one after ``patience`` [s]."""
    deadline = time.monotonic() + patience
    while True:
        reading = device.read()
        if seen(reading):
            return reading
        assert time.monotonic() < deadline, reading
        time.sleep(0.002)
