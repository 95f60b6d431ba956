"""References one after the other, each for its time."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Generic

import numpy as np

from burnish.core import Dynamics, JointReference, Ref, Source
from burnish.errors import InputError


@dataclass(kw_only=True)
class Schedule(Generic[Ref]):
    """Sources in turn; each starts where the reference, not the arm, has come to, and the last goes on for ever.

    So a law's error in one part does not move the target of the next. All of them are sources of the joints, or all of
    the tool.
    """

    parts: Sequence[tuple[float, Source[Ref]]]
    """Duration [s] and source of each part."""
    _starts: list[float] = field(default_factory=list, init=False, repr=False)
    _t0: float = field(default=0.0, init=False, repr=False)

    def __post_init__(self) -> None:
        if not self.parts or not all(np.isfinite(duration) and duration > 0.0 for duration, _ in self.parts):
            raise InputError(
                f"Schedule: durations {[duration for duration, _ in self.parts]} s; "
                "expected at least one part, each of a finite time above 0"
            )
        self._starts = np.cumsum([0.0] + [duration for duration, _ in self.parts[:-1]]).tolist()

    @property
    def duration(self) -> float:
        """Time of all parts [s]."""
        return float(sum(duration for duration, _ in self.parts))

    def reset(self, arm: Dynamics) -> None:
        """Start from this instant and this pose."""
        self._t0 = arm.t
        for (duration, source), start in zip(self.parts, self._starts, strict=True):
            source.reset(arm)
            end = replace(arm, t=self._t0 + start + duration)
            arm = _standing_at(end, source.at(end))

    def at(self, arm: Dynamics) -> Ref:
        """The reference at the instant of ``arm``."""
        now = max(bisect_right(self._starts, arm.t - self._t0) - 1, 0)
        return self.parts[now][1].at(arm)


def _standing_at(arm: Dynamics, reference: Any) -> Dynamics:
    """The arm as if it were where the reference is, in what sources look at."""
    if isinstance(reference, JointReference):
        return replace(arm, q=reference.q)
    return replace(arm, p=reference.p, R=reference.R)
