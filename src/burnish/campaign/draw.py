"""What is drawn of an episode: its task, its faults, its arm. Everything comes from a seed and its number."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from burnish.campaign import faults, tasks
from burnish.campaign.commanded import runaway
from burnish.campaign.fault import Fault, Kind
from burnish.campaign.tasks import Setting, Task

FAULTLESS = 0.15
"""Share of the episodes in which nothing goes wrong."""
PAIRS = 0.15
"""Share of those with a fault that have a second one."""
FAST, FAST_RUNAWAY = 0.08, 0.4
"""Share of the episodes at 1 kHz, and of those with a runaway joint; the others run at 100 Hz."""
STIFF = 0.2
"""Share of arms with twice the friction."""
FIRST, LAST = 0.15, 1.0
"""Between these times a fault begins [s]."""
TOUCHED = 0.6
"""Time in which a tool that comes down has usually touched [s]."""
AFTER = 0.95
"""Time that is looked at after a fault and after a stop [s]."""
DRIFT = 2.0
"""The same after a stop where an unknown payload may pull [s]."""
NOMINAL = 30.0
"""Length of an episode of a campaign without faults [s]."""


@dataclass(frozen=True, kw_only=True)
class Episode:
    """What is drawn of an episode before it runs."""

    seed: int
    """Of the campaign."""
    number: int
    """Within it."""
    task: Callable[[np.random.Generator, Setting], Task]
    """Draws the task."""
    stiff: bool
    """Whether the arm has stiff gears."""
    rate: float
    """Control rate [Hz]."""
    duration: float
    """Time that it lasts unless it is stopped late [s]."""
    kinds: tuple[str, ...] = ()
    """Names of its faults."""
    faults: tuple[Fault, ...] = ()
    """What goes wrong."""
    after: float = AFTER
    """Time that it goes on after a stop [s]."""

    @property
    def name(self) -> str:
        """Its faults in a word."""
        return " + ".join(sorted(self.kinds)) or "none"

    @property
    def fault_at(self) -> float | None:
        """When the first fault may reach the controller [s]."""
        return min((fault.start for fault in self.faults), default=None)

    @property
    def urgent(self) -> tuple[Fault, ...]:
        """The faults that must stop the arm once they reach the controller."""
        return tuple(fault for fault in self.faults if fault.urgency is not None)


def draw(seed: int, number: int, *, nominal: bool) -> Episode:
    """The episode of this number; the same whatever else is run.

    Args:
        seed: of the campaign.
        number: of the episode, from 0.
        nominal: whether it is a long one of operating or polishing, without a fault.
    """
    rng = np.random.default_rng([seed, number, int(nominal)])
    stiff = bool(rng.uniform() < STIFF)
    if nominal:
        return Episode(
            seed=seed,
            number=number,
            task=(tasks.teleoperate, tasks.press_and_slide)[number % 2],
            stiff=stiff,
            rate=100.0,
            duration=NOMINAL,
        )
    kinds = _kinds(rng)
    possible = _tasks(kinds[0]) if kinds else tasks.TASKS
    task = possible[int(rng.integers(len(possible)))]
    # A kilogram that pulls is held with the longest delay, and for longer.
    loaded = any(kind in faults.LOADED for kind in kinds)
    fast = not loaded and rng.uniform() < (FAST_RUNAWAY if runaway in kinds else FAST)
    # Most of the faults are to meet a tool that presses already.
    first = FIRST + (TOUCHED if task is tasks.press_and_slide and rng.uniform() < 0.7 else 0.0)
    starts = np.sort(rng.uniform(first, first + LAST - FIRST, len(kinds)))
    period = 1e-3 if fast else 1e-2
    return Episode(
        seed=seed,
        number=number,
        task=task,
        kinds=tuple(kind.__name__ for kind in kinds),
        faults=tuple(kind(rng, float(start), period) for kind, start in zip(kinds, starts, strict=True)),
        stiff=stiff,
        rate=1.0 / period,
        duration=float(starts[-1]) + AFTER if kinds else float(rng.uniform(1.5, 2.5)),
        after=DRIFT if loaded else AFTER,
    )


def _kinds(rng: np.random.Generator) -> list[Kind]:
    """No fault, one, or two different ones."""
    if rng.uniform() < FAULTLESS:
        return []
    kind = faults.KINDS[int(rng.integers(len(faults.KINDS)))]
    if rng.uniform() >= PAIRS:
        return [kind]
    others = [other for other in faults.ANYWHERE if other is not kind]
    return [kind, others[int(rng.integers(len(others)))]]


def _tasks(kind: Kind) -> tuple[Callable[[np.random.Generator, Setting], Task], ...]:
    """The tasks that a kind of fault may meet."""
    if kind in faults.OF_JOINTS:
        return tasks.JOINTS
    if kind in faults.OF_TOOL:
        return (tasks.teleoperate,)
    if kind in faults.PRESSING:
        return (tasks.press_and_slide,)
    return tasks.IN_AIR if kind in faults.LOADED else tasks.TASKS
