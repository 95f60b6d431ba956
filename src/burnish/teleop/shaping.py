"""A raw reading to what the operator means: bias, dead-band, chosen axes, freshness, and buttons without bounces.

All are pure functions of a reading and of what is remembered of those before, so they need no clock. The axes are::

    x → (x − b) / (1 − b sgn(x − b))                bias b, the ends stay ±1
      → sgn(x) max(0, |x| − w) / (1 − w)            dead-band w, continuous, the ends stay ±1
      → x freshness(age)                            zero 200 ms after the last report

Source: burnish's own; the dead-band lies between 0.05 and 0.1 as in other teleoperation programs.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import zip_longest
from math import copysign

from burnish.errors import InputError
from burnish.teleop.device import AT_REST, Axes, Reading, six

FRESH = 0.1
"""Age up to which a report counts fully [s]; devices report every 8 to 16 ms while they are pushed."""
STALE = 0.2
"""Age at which nothing is left of it [s]."""
BOUNCE = 0.03
"""A button has changed when it has stayed changed for this long [s]."""
LARGEST_BIAS = 0.2
"""More than this is a hand on the cap and no drift."""


@dataclass(frozen=True, kw_only=True)
class Shaping:
    """What the operator has set."""

    dead_band: float = 0.07
    """Share of the full scale in which nothing happens, in [0, 0.5]; drift of up to 5 % is expected."""
    enabled: tuple[bool, bool, bool, bool, bool, bool] = (True, True, True, True, True, True)
    """Which of the six axes count."""
    bias: Axes = AT_REST
    """What the device shows at rest; see `rezeroed`."""
    dominant_only: bool = False
    """Whether only the axis that is pushed most counts; see `dominant`."""

    def __post_init__(self) -> None:
        """Refuse what leaves no range.

        Raises:
            InputError: if the dead-band or the bias is too large or no number.
        """
        if not 0.0 <= self.dead_band <= 0.5:
            raise InputError(f"the dead-band is {self.dead_band}; expected a share in [0, 0.5], such as 0.07")
        if len(self.enabled) != 6:
            raise InputError(f"{len(self.enabled)} axes are enabled or not; expected six")
        if len(self.bias) != 6 or not all(abs(b) <= LARGEST_BIAS for b in self.bias):
            raise InputError(
                f"a bias of {self.bias} is too large; expected six within ±{LARGEST_BIAS}: let go of the cap"
            )


@dataclass(frozen=True, kw_only=True)
class Button:
    """What is remembered of a button."""

    pressed: bool = False
    """What it counts as."""
    raw: bool = True
    """What the device said last; assumed pressed until it is seen released."""
    since: float = 0.0
    """Since when it has said so [s]."""
    armed: bool = False
    """Whether it was seen released since the start, or since the device came back."""


@dataclass(frozen=True, kw_only=True)
class Memory:
    """What is remembered between two readings; the default is that of a program that starts."""

    connected: bool = False
    """Whether the device was there."""
    rested: bool = False
    """Whether the axes were seen at rest since the start, or since the device came back."""
    buttons: tuple[Button, ...] = ()
    """One for each button seen so far."""


def shape(reading: Reading, memory: Memory, shaping: Shaping) -> tuple[Reading, Memory]:
    """Return the reading as the operator means it, and what to remember for the next one.

    A cap that is pushed, or a button that is held, when the program starts or the device comes back does nothing until
    it was seen released. The last axes of a device that is gone age until nothing is left; its buttons are released.
    """
    came_back = reading.connected and not memory.connected
    axes = deflection(reading.axes, shaping)
    rested = (memory.rested and not came_back) or axes == AT_REST
    known = zip_longest(memory.buttons, reading.buttons)
    buttons = tuple(
        debounced(button or Button(since=reading.t), bool(raw), reading.t)
        if reading.connected
        else Button(since=reading.t)
        for button, raw in known
    )
    meant = replace(
        reading,
        axes=scaled(axes, freshness(reading.age) if rested else 0.0),
        buttons=tuple(button.pressed for button in buttons),
    )
    return meant, Memory(connected=reading.connected, rested=rested, buttons=buttons)


def deflection(axes: Axes, shaping: Shaping) -> Axes:
    """How far the cap is pushed on purpose: without bias, dead-band and axes that do not count."""
    centred = (unbiased(x, b) for x, b in zip(axes, shaping.bias, strict=True))
    counted = (
        dead_banded(x, shaping.dead_band) if enabled else 0.0
        for x, enabled in zip(centred, shaping.enabled, strict=True)
    )
    found = six(counted)
    return dominant(found) if shaping.dominant_only else found


def unbiased(x: float, bias: float) -> float:
    """``(x − b) / (1 − b sgn(x − b))``: 0 at the bias, ±1 at the ends."""
    return (x - bias) / (1.0 - bias if x > bias else 1.0 + bias)


def dead_banded(x: float, width: float) -> float:
    """``sgn(x) max(0, |x| − w) / (1 − w)``: nothing in the band, no step at its edge, 1 at 1."""
    return copysign(max(0.0, abs(x) - width) / (1.0 - width), x)


def dominant(axes: Axes) -> Axes:
    """Leave the largest axis alone, less the second largest: it is continuous where the two change places."""
    sizes = [abs(x) for x in axes]
    largest = max(range(6), key=sizes.__getitem__)
    second = max(size for axis, size in enumerate(sizes) if axis != largest)
    return six(copysign(sizes[i] - second, x) if i == largest else 0.0 for i, x in enumerate(axes))


def freshness(age: float) -> float:
    """Share of a report that still counts: 1 up to `FRESH`, from there straight to 0 at `STALE`."""
    return min(1.0, max(0.0, (STALE - age) / (STALE - FRESH)))


def debounced(button: Button, raw: bool, t: float) -> Button:
    """Take a change over once it has lasted for `BOUNCE`; a button counts once it was seen released that long."""
    since = button.since if raw == button.raw else t
    settled = t - since >= BOUNCE
    armed = button.armed or (settled and not raw)
    return Button(pressed=(raw if settled else button.pressed) and armed, raw=raw, since=since, armed=armed)


def rezeroed(shaping: Shaping, reading: Reading) -> Shaping:
    """Take what the device shows now for rest.

    Raises:
        InputError: if that is more than drift.
    """
    return replace(shaping, bias=reading.axes)


def scaled(axes: Axes, share: float) -> Axes:
    """Each axis times ``share``."""
    return six(x * share for x in axes)
