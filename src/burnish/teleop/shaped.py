"""`Shaped`: a device whose readings are what the operator means."""

from __future__ import annotations

from dataclasses import dataclass, field

from burnish.teleop.device import Device, Reading
from burnish.teleop.shaping import Memory, Shaping, shape


@dataclass(kw_only=True)
class Shaped:
    """The readings of a device through `shape`, with its memory."""

    device: Device
    """The device; whoever opened it closes it."""
    shaping: Shaping = field(default_factory=Shaping)
    """Dead-band, axes and bias."""
    memory: Memory = field(default_factory=Memory)
    """What is remembered of the readings so far."""

    def read(self) -> Reading:
        """The reading now, as it is meant."""
        reading, self.memory = shape(self.device.read(), self.memory, self.shaping)
        return reading
