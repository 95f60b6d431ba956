"""Where a job stands on its way from a file to a report, and what each button may do there."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Stage(Enum):
    """From nothing to a report."""

    EMPTY = "empty"
    """No mould is chosen."""
    CHOSEN = "chosen"
    """A mould is there, a plan is not, or is no longer what is asked for."""
    PLANNING = "planning"
    """The plan is being made."""
    REFUSED = "refused"
    """The arm cannot do it."""
    READY = "ready"
    """Planned and checked."""
    RUNNING = "running"
    """The job runs."""
    ENDING = "ending"
    """It was asked to pause or to stop."""
    PAUSED = "paused"
    """It can be gone on with."""
    DONE = "done"
    """There is a report."""
    FAILED = "failed"
    """It ended without a result."""


LIVE = (Stage.RUNNING, Stage.ENDING)
"""Stages with an arm in motion."""
BUSY = (*LIVE, Stage.PLANNING)
"""Stages in which nothing may be chosen or edited."""

WATCHER = "another tab commands the arm; this one only watches"
"""Why a control is off in a tab that is not the commander's."""


@dataclass(frozen=True, kw_only=True)
class Offer:
    """What one control may do now."""

    may: bool
    """Whether it can be used."""
    why: str = ""
    """Why not, in plain words; empty if it can."""


@dataclass(frozen=True, kw_only=True)
class Step:
    """The one button that leads on."""

    label: str
    """On the button."""
    says: str
    """Beside it: where the job stands, and what the button does."""


STEPS = {
    Stage.EMPTY: Step(label="Plan", says="Choose a mould below, or upload a file of your own."),
    Stage.CHOSEN: Step(label="Plan the path", says="The mould is mounted. Plan the path over it; nothing moves yet."),
    Stage.PLANNING: Step(label="Cancel planning", says="The path is being planned. Nothing moves."),
    Stage.REFUSED: Step(label="Plan again", says="The arm cannot do this. Change what is said below and plan again."),
    Stage.READY: Step(label="Start polishing", says="The path is checked. Starting moves the simulated arm."),
    Stage.RUNNING: Step(label="Pause", says="The arm is at work."),
    Stage.ENDING: Step(label="Pause", says="The arm lifts off and comes to rest; the report follows."),
    Stage.PAUSED: Step(label="Resume", says="The job has not come to its end. It can go on where it was left."),
    Stage.DONE: Step(label="Do it again", says="The job is done. Its report and its run are in the library."),
    Stage.FAILED: Step(label="Plan again", says="The job ended without a result."),
}


def step(stage: Stage, commands: bool) -> tuple[Step, Offer]:
    """The button that leads on, and whether it may be used.

    Args:
        stage: where the job stands.
        commands: whether this tab is the commander's.
    """
    found = STEPS[stage]
    if not commands:
        return found, Offer(may=False, why=WATCHER)
    if stage is Stage.EMPTY:
        return found, Offer(may=False, why="no mould is chosen")
    if stage is Stage.ENDING:
        return found, Offer(may=False, why="the job is ending")
    return found, Offer(may=True)


def may_stop(stage: Stage, commands: bool) -> Offer:
    """The stop. Whoever commands may use it as long as something moves."""
    if not commands:
        return Offer(may=False, why=WATCHER)
    return Offer(may=stage in LIVE, why="" if stage in LIVE else "nothing moves")


def may_edit(stage: Stage, commands: bool) -> Offer:
    """Mould and recipe."""
    if not commands:
        return Offer(may=False, why=WATCHER)
    if stage in BUSY:
        return Offer(may=False, why="a plan is being made" if stage is Stage.PLANNING else "the arm is at work")
    return Offer(may=True)


def ended(code: int, *, paused: bool, report: bool) -> Stage:
    """Where a job stands after its process has ended.

    Args:
        code: exit status; negative if it was killed.
        paused: whether there is a journal that it can be gone on with.
        report: whether it left a report.
    """
    if code == 0 and report:
        return Stage.DONE
    return Stage.PAUSED if paused else Stage.FAILED
