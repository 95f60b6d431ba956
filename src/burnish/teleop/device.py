"""What every operator device hands over: six axes, buttons, and how old they are.

The frame is the operator's, right-handed: x to the right, y away from the operator, z up. Axes 0–2 say where the cap is
pushed, axes 3–5 about which of these axes it is turned, by the right-hand rule. 1 is the device's full scale.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import isfinite
from types import TracebackType
from typing import Protocol, TypeAlias

from burnish.errors import InputError

Axes: TypeAlias = tuple[float, float, float, float, float, float]
"""Translation x y z, rotation x y z."""
AT_REST: Axes = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class Reading:
    """A device's state at one moment."""

    t: float
    """Time of this reading [s], monotonic."""
    axes: Axes
    """Deflection in [−1, 1]: translation x y z, then rotation x y z, in the operator's frame (see the module)."""
    buttons: tuple[bool, ...]
    """Whether each button is pressed; none is once the device is gone."""
    age: float
    """Time since the report that these axes come from [s]; 0 for devices that are asked and do not report."""
    connected: bool = True
    """Whether the device is there. Of one that is gone the last axes stay, and age: `shape` ramps them to zero."""

    def __post_init__(self) -> None:
        """Refuse what is no reading.

        Raises:
            InputError: if the axes are not six numbers in [−1, 1], or a time is not finite or the age negative.
        """
        if len(self.axes) != 6 or not all(-1.0 <= value <= 1.0 for value in self.axes):
            raise InputError(f"axes of a reading are {self.axes}; expected six numbers in [-1, 1]: mend the device")
        if not isfinite(self.t) or not self.age >= 0.0:
            raise InputError(f"a reading at {self.t} s is {self.age} s old; expected a finite time and an age >= 0")


class Device(Protocol):
    """Something an operator commands with; a context manager that gives the device back when it is left."""

    @property
    def name(self) -> str:
        """What the device calls itself."""

    def read(self) -> Reading:
        """Return the state now; never blocks and never raises because a device went away."""

    def __enter__(self) -> Device: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...


def six(values: Iterable[float]) -> Axes:
    """Six values as axes; more or fewer raise a ValueError."""
    x, y, z, turn_x, turn_y, turn_z = values
    return x, y, z, turn_x, turn_y, turn_z


def clipped(value: float) -> float:
    """The value within [−1, 1]."""
    return min(1.0, max(-1.0, value))
