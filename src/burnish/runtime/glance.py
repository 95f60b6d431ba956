"""`Glance`: what a running job shows at one moment, and how it lies in memory."""

from __future__ import annotations

import struct
from dataclasses import dataclass

from burnish.core import Array, read_only
from burnish.runtime.machine import Mode

PHASE, CAUSE, WAITS = 32, 256, 64
"""Longest texts of a glance, in bytes of UTF-8; longer ones are cut."""
MODES = tuple(Mode)


@dataclass(frozen=True, kw_only=True)
class Glance:
    """What a running job shows, the latest."""

    wall: float
    """`time.monotonic` of what is shown [s]."""
    t: float
    """The arm's clock [s]."""
    phase: str
    """What it does: approach, pass, retract …"""
    mode: Mode
    """The supervisor's."""
    cause: str
    """Why the supervisor holds the arm; empty if it does not."""
    stroke: int
    """The stroke under work, from 0."""
    strokes: int
    """How many there are."""
    done: float
    """Share of the work, 0 to 1."""
    q: Array
    """Joint positions [rad], (n,)."""
    dq: Array
    """Joint velocities [rad/s], (n,)."""
    tau: Array
    """Joint torques that were applied [N·m], (n,)."""
    p: Array
    """Tool position, base frame [m], (3,)."""
    R: Array
    """Tool rotation, base ← tool, (3, 3)."""
    v: Array
    """Twist of the tool, base axes [m/s, rad/s], (6,)."""
    force: float
    """Contact force along the normal [N]; nan where nothing is pressed."""
    force_set: float
    """What it shall be [N]; nan where nothing is pressed."""
    feed: float
    """Speed of the tool [m/s]."""
    feed_set: float
    """What it shall be [m/s]; nan where nothing says."""
    tilt: float
    """Angle between the tool and the surface's normal [rad]; nan where nothing is pressed."""
    late_cycles: int
    """Cycles that came late so far."""
    waits_for: tuple[str, ...] = ()
    """Names of the keys that mean something now, for `Mailbox.press`."""
    number: int = 0
    """Of the glance; the mailbox gives it, and it grows."""


def layout(joints: int) -> struct.Struct:
    """How a glance at an arm of so many joints lies in memory."""
    return struct.Struct(f"=8d4q{3 * joints + 18}d{PHASE}s{CAUSE}s{WAITS}s")


def packed(form: struct.Struct, glance: Glance) -> bytes:
    """A glance as it lies in memory."""
    return form.pack(
        glance.wall,
        glance.t,
        glance.done,
        glance.force,
        glance.force_set,
        glance.feed,
        glance.feed_set,
        glance.tilt,
        MODES.index(glance.mode),
        glance.stroke,
        glance.strokes,
        glance.late_cycles,
        *glance.q.tolist(),
        *glance.dq.tolist(),
        *glance.tau.tolist(),
        *glance.p.tolist(),
        *glance.R.ravel().tolist(),
        *glance.v.tolist(),
        glance.phase.encode()[:PHASE],
        glance.cause.encode()[:CAUSE],
        ",".join(glance.waits_for).encode()[:WAITS],
    )


def unpacked(form: struct.Struct, number: int, text: bytes) -> Glance:
    """The glance that lies in memory."""
    values = form.unpack(text)
    wall, t, done, force, force_set, feed, feed_set, tilt = values[:8]
    mode, stroke, strokes, late = values[8:12]
    reals = read_only(values[12:-3])
    n = (len(reals) - 18) // 3
    phase, cause, waits = (value.rstrip(b"\0").decode("utf-8", "ignore") for value in values[-3:])
    return Glance(
        number=number,
        wall=wall,
        t=t,
        phase=phase,
        mode=MODES[mode],
        cause=cause,
        stroke=stroke,
        strokes=strokes,
        done=done,
        q=reals[:n],
        dq=reals[n : 2 * n],
        tau=reals[2 * n : 3 * n],
        p=reals[3 * n : 3 * n + 3],
        R=reals[3 * n + 3 : 3 * n + 12].reshape(3, 3),
        v=reals[3 * n + 12 :],
        force=force,
        force_set=force_set,
        feed=feed,
        feed_set=feed_set,
        tilt=tilt,
        late_cycles=late,
        waits_for=tuple(waits.split(",")) if waits else (),
    )
