"""``--live FILE``: a job that is watched and commanded through a mailbox, and the one that nobody watches."""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from math import acos, inf, nan

import numpy as np
from typing_extensions import Self

from burnish.core import Array, Sample, ToolReference
from burnish.errors import InputError
from burnish.polish.moves import Moves
from burnish.runtime.mailbox import Glance, Mailbox, Order
from burnish.teleop.device import Device, Reading, six

GONE = "whoever commanded the arm is gone"
STALL = 0.05
"""Time between two looks that tells of a process that was held up [s]: several cycles of any rate."""
SHOWN = 0.02
"""Time between two glances [s]."""
MARKED = 1e-3
"""Way between two rows of the contact track [m]."""


class Alone:
    """A job that nobody watches: it was typed, and Ctrl-C ends it."""

    def tell(self, stage: str) -> None:
        """What is being done now."""

    def gone(self) -> bool:
        """Whether somebody commanded it and is gone; to be asked once a cycle."""
        return False

    def told_to_end(self) -> bool:
        """Whether it is to come to rest; to be asked once a cycle."""
        return False

    def pressed(self) -> list[str]:
        """Names of the keys that were pressed from outside since it was asked last."""
        return []

    def show(self, sample: Sample, job: Moves, progress: Done) -> None:
        """Show a cycle."""

    def jog(self) -> Device:
        """Whoever moves the tool from outside.

        Raises:
            InputError: there is no outside.
        """
        raise InputError("--device jog is the workshop's, and this job has none; expected --live FILE beside it")


@dataclass(frozen=True, kw_only=True)
class Done:
    """How far a job is."""

    share: float
    """Of the work, 0 to 1."""
    stroke: int = 0
    """The stroke under work, from 0."""
    strokes: int = 0
    """How many there are."""
    late_cycles: int = 0
    """Cycles that came late so far."""
    waits_for: tuple[str, ...] = ()
    """Keys that mean something now."""


@dataclass(kw_only=True)
class Live(Alone):
    """A job on one end of a mailbox."""

    box: Mailbox
    """The mailbox."""
    _next: float = field(default=0.0, init=False, repr=False)
    _looked: float = field(default=inf, init=False, repr=False)
    _excused: float = field(default=0.0, init=False, repr=False)
    _phase: tuple[str, bool] = field(default=("", False), init=False, repr=False)
    _last: tuple[Sample, Moves, Done] | None = field(default=None, init=False, repr=False)
    _marked: tuple[Array, float] | None = field(default=None, init=False, repr=False)

    def tell(self, stage: str) -> None:
        """What is being done now."""
        self.box.tell(stage)

    def gone(self) -> bool:
        """Whether the commander's beats have ended, or never began.

        Where this process itself was held up, whoever beats was most likely held up with it, and gets `STALL` to come.
        """
        now = time.monotonic()
        if now - self._looked > STALL:
            self._excused = now + STALL
        self._looked = now
        return now >= self._excused and not self.box.commanded

    def told_to_end(self) -> bool:
        """Whether the commander wants a pause or a stop: the job ends as by Ctrl-C."""
        return self.box.wanted is not Order.GO

    def pressed(self) -> list[str]:
        """Names of the keys that were pressed from outside since it was asked last."""
        return self.box.pressed()

    def jog(self) -> Device:
        """Whoever moves the tool from outside."""
        return Jog(box=self.box)

    def show(self, sample: Sample, job: Moves, progress: Done) -> None:
        """A glance where it is time for one, or something new has begun; the contact point every `MARKED`."""
        arm, supervisor = sample.arm, job.rig.supervisor
        reference = sample.reference if isinstance(sample.reference, ToolReference) else None
        normal = None if reference is None or arm.F is None else reference.normal
        force = nan if normal is None or arm.F is None else float(normal @ arm.F[:3])
        if normal is not None:
            self._mark(arm.t, job, normal, force)
        else:
            self._marked = None
        now = time.monotonic()
        phase = (job.phase, supervisor.tripped)
        self._last = (sample, job, progress)
        if now < self._next and phase == self._phase:
            return
        self._next, self._phase, self._last = now + SHOWN, phase, None
        self.box.post(
            Glance(
                wall=now,
                t=arm.t,
                phase=job.phase,
                mode=supervisor.mode,
                cause="" if supervisor.event is None else supervisor.event.cause,
                stroke=progress.stroke,
                strokes=progress.strokes,
                done=progress.share,
                q=arm.q,
                dq=arm.dq,
                tau=sample.applied,
                p=arm.p,
                R=arm.R,
                v=arm.v,
                force=force,
                force_set=nan if reference is None or normal is None else reference.force,
                feed=float(np.linalg.norm(arm.v[:3])),
                feed_set=nan if reference is None else float(np.linalg.norm(reference.v[:3])),
                tilt=nan if reference is None or normal is None else _angle(arm.R[:, 2], reference.R[:, 2]),
                late_cycles=progress.late_cycles,
                waits_for=progress.waits_for,
            )
        )

    def end(self) -> None:
        """Show the last cycle, whether or not it was time for it."""
        if self._last is not None:
            self._next = 0.0
            self.show(*self._last)

    def _mark(self, t: float, job: Moves, normal: Array, force: float) -> None:
        """A row of the contact track where the tool has gone on by `MARKED`."""
        placement = job.placement
        contact = placement.R.T @ (job.tip_centre() - job.tool.tip_radius * normal - placement.p)
        if self._marked is None:
            self._marked = (contact, t)
            return
        before, since = self._marked
        way = float(np.linalg.norm(contact - before))
        if way >= MARKED and t > since:
            self.box.mark(contact, force, way / (t - since), t - since)
            self._marked = (contact, t)


@dataclass(frozen=True, kw_only=True)
class Jog:
    """The six buttons of a page as an operator's device; at rest where nothing new comes."""

    box: Mailbox
    """Where the page leaves what it wants."""
    name: str = "the workshop's jog buttons"
    """What it is called."""

    def read(self) -> Reading:
        """What the page wants now."""
        return Reading(t=time.monotonic(), axes=six(self.box.jogged.tolist()), buttons=(), age=0.0)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        """The mailbox is left by whoever opened it."""


@contextmanager
def watched(options: argparse.Namespace) -> Iterator[Alone]:
    """Whoever watches and commands, by ``--live``.

    Raises:
        RecordingError: the file is no mailbox.
    """
    if options.live is None:
        yield Alone()
        return
    with Mailbox.open(options.live) as box:
        live = Live(box=box)
        try:
            yield live
        finally:
            live.end()


def _angle(a: Array, b: Array) -> float:
    """Between two unit vectors [rad]."""
    return acos(min(1.0, max(-1.0, float(a @ b))))
