"""What an experiment is: laws on arms along references, and what is said of the result."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from burnish.core import Array, Controller, Source
from burnish.model.model import Model
from burnish.sim.arms import Arm
from burnish.sim.robot import HOME
from burnish.trials.record import Record


@dataclass(frozen=True, kw_only=True)
class Trial:
    """One law on one arm along one reference."""

    name: str
    """Of the trial in its experiment, as in a legend."""
    law: Controller[Any]
    """The law, with its gains."""
    source: Source[Any]
    """The reference."""
    duration: float
    """Time [s]."""
    arm: Arm
    """The arm; the law sees its nominal figures only."""
    model: Model
    """What the law is told the arm is."""
    q: Array = field(default_factory=lambda: HOME)
    """Joint positions at the start [rad], (n,)."""
    rate: float | None = None
    """Control rate [Hz]; the arm's own without it."""
    push: Callable[[float], Array] | None = None
    """Wrench of somebody's hand on the tool over time, base axes [N, N·m], (6,)."""
    ours: bool = False
    """Whether the gains are ours, not the source's."""


@dataclass(frozen=True, kw_only=True)
class Finding:
    """A claim, what was measured, and whether it holds."""

    claim: str
    """What the source says, or what is to be reached."""
    measured: str
    """With its unit."""
    holds: bool | None
    """None where nothing is claimed."""


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """A table or figure of a source, run again."""

    title: str
    """In one line."""
    source: str
    """Where it stands: thesis, table, figure."""
    about: str
    """What was done there, what is different here, and why; a paragraph."""
    trials: Callable[[], Sequence[Trial]]
    """The runs; made when they are needed."""
    judge: Callable[[Mapping[str, Record]], Sequence[Finding]]
    """From the record of each trial, by its name, to what is found."""


def nominal(arm: Arm, model: Model | None = None) -> Model:
    """The model with the arm's nominal rotor inertia: what its controller may know."""
    return (Model.jaco2() if model is None else model).with_armature(arm.armature)


def links_only() -> Model:
    """The model as the sources have it: no rotor inertia."""
    return Model.jaco2()


def steady(values: Array, t: Array, last: float = 1.0) -> float:
    """RMS over the last seconds."""
    return float(np.sqrt(np.mean(values[t >= t[-1] - last] ** 2)))
