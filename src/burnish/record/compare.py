"""Two recordings of one run, bit by bit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from burnish.core import Array
from burnish.record.recording import QUANTITIES, Cycles, Quantity, Recording


@dataclass(frozen=True, kw_only=True)
class Difference:
    """The first place of a topic where two recordings differ, and how far they part later."""

    cycle: int
    """Number of the cycle, from 0."""
    t: float
    """Its time in the first recording [s]."""
    name: str
    """The column that differs."""
    values: tuple[object, object]
    """What the two recordings have there."""
    unit: str
    """Of the column."""


@dataclass(kw_only=True)
class Comparison:
    """What came out."""

    lengths: tuple[int, int] = (0, 0)
    """Cycles of the two recordings; of the longer one, where it was left early, so far."""
    first: dict[str, Difference] = field(default_factory=dict)
    """For each topic that differs, where it does first."""
    largest: dict[str, float] = field(default_factory=dict)
    """For each column that differs, the largest difference, in its unit."""


def compare(one: Recording, other: Recording) -> Comparison:
    """Compare all cycles that both have; -0 and 0 differ, and a NaN equals itself."""
    result = Comparison()
    count = 0
    left, right = one.blocks(), other.blocks()
    a, b = next(left, None), next(right, None)
    while a is not None and b is not None:
        size = min(len(a), len(b))
        _compare_block(result, count, a[:size], b[:size])
        count += size
        a = a[size:] if len(a) > size else next(left, None)
        b = b[size:] if len(b) > size else next(right, None)
    result.lengths = (count + _count(a, left), count + _count(b, right))
    return result


def _count(block: Cycles | None, rest: Iterator[Cycles]) -> int:
    """Cycles that are left."""
    return 0 if block is None else len(block) + sum(map(len, rest))


def _compare_block(result: Comparison, count: int, a: Cycles, b: Cycles) -> None:
    """Note what differs in cycles of the same number."""
    found = [(quantity, getattr(a, quantity.field), getattr(b, quantity.field)) for quantity in ALL]
    for quantity, left, right in found:
        differs = _bits(left) != _bits(right)
        if not differs.any():
            continue
        row, column = (int(i) for i in np.argwhere(differs)[0])
        names = columns_of(quantity, left.shape[-1] if left.ndim > 1 else 1)
        place = Difference(
            cycle=count + row,
            t=float(a.t[row]),
            name=names[column],
            values=(_rows(left)[row, column].item(), _rows(right)[row, column].item()),
            unit=quantity.unit,
        )
        before = result.first.get(quantity.topic)
        if before is None or place.cycle < before.cycle:
            result.first[quantity.topic] = place
        for i in np.flatnonzero(differs.any(axis=0)).tolist():
            apart = np.abs(_rows(left)[:, i] - _rows(right)[:, i])[differs[:, i]]
            # Where only one of the two has a number they are as far apart as can be.
            most = float(np.max(np.where(np.isnan(apart), np.inf, apart)))
            result.largest[names[i]] = max(most, result.largest.get(names[i], 0.0))
    changed = np.flatnonzero(a.phase != b.phase)
    if len(changed):
        row = int(changed[0])
        place = Difference(
            cycle=count + row, t=float(a.t[row]), name="phase", values=(a.phase[row], b.phase[row]), unit=""
        )
        before = result.first.get(CONTROL_TOPIC)
        if before is None or place.cycle < before.cycle:
            result.first[CONTROL_TOPIC] = place


def columns_of(quantity: Quantity, width: int) -> list[str]:
    """The names of a quantity's columns; joints are numbered from 1."""
    (first, *_) = quantity.parts
    if first.endswith("#"):
        return [f"{first[:-1]}{i + 1}" for i in range(width)]
    return list(quantity.parts)


def _rows(values: Array) -> Array:
    return values.reshape(len(values), -1)


def _bits(values: Array) -> np.ndarray[tuple[int, ...], np.dtype[np.uint64]]:
    return np.ascontiguousarray(_rows(values)).view(np.uint64)


ALL = (Quantity("t", "/control_state", "s", ("t",)), *QUANTITIES)
CONTROL_TOPIC = "/control_state"
