"""What a number of a recipe may be."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from burnish.errors import InputError


@dataclass(frozen=True, kw_only=True)
class Range:
    """What a number of a recipe may be, both ends included."""

    unit: str
    """In SI; empty for a pure number."""
    low: float
    """Least value."""
    high: float
    """Largest value."""

    def __str__(self) -> str:
        return f"{self.low:g} to {self.high:g} {self.unit}".rstrip()

    def check(self, name: str, value: Any) -> None:
        """Refuse what is outside.

        Raises:
            InputError: names the value, its unit and the range.
        """
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not (number and self.low <= value <= self.high):
            shown = f"{float(value):g} {self.unit}".rstrip() if number and abs(value) < 1e300 else repr(value)[:40]
            raise InputError(f"{name} {shown} is out of range; expected {self}")
