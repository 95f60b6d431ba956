"""Faults of what is measured, and of when."""

from __future__ import annotations

import numpy as np

from burnish.campaign.fault import FROZEN, INVALID, STALE, Fault, Rng
from burnish.sim.faulty import (
    GARBAGE,
    Clock,
    Delayed,
    Garbage,
    Hang,
    Intermittent,
    Off,
    Offset,
    Scaled,
    Slow,
    Stuck,
)


def garbage_reading(rng: Rng, start: float, period: float) -> Fault:
    """A number of a measurement is none, or absurd, for some samples or for good."""
    signal, joint, value = _signal(rng), int(rng.integers(6)), float(rng.choice(GARBAGE))
    end = start + float(rng.choice([1.0, 2.0, 3.0, 10.0, np.inf])) * period
    spell = Garbage(start=start, end=end, signal=signal, index=joint, value=value)
    return Fault(text=f"{signal}[{joint}] = {value:g} {_until(end)}", start=start, urgency=INVALID, reading=(spell,))


def garbage_sample(rng: Rng, start: float, period: float) -> Fault:
    """All numbers of a measurement are none."""
    end = start + float(rng.choice([1.0, 2.0, 3.0, 10.0])) * period
    spells = tuple(
        Garbage(start=start, end=end, signal=signal, index=joint) for signal in ("q", "dq", "tau") for joint in range(6)
    )
    return Fault(text=f"all of q, dq, tau = nan {_until(end)}", start=start, urgency=INVALID, reading=spells)


def stuck_reading(rng: Rng, start: float, period: float) -> Fault:
    """A number of a measurement no longer changes."""
    signal, joint = _signal(rng), int(rng.integers(6))
    return Fault(
        text=f"{signal}[{joint}] stuck", start=start, reading=(Stuck(start=start, signal=signal, index=joint),)
    )


def stuck_joint(rng: Rng, start: float, period: float) -> Fault:
    """Position and speed of a joint no longer change: one actuator's messages are missing."""
    joint = int(rng.integers(6))
    spells = tuple(Stuck(start=start, signal=signal, index=joint) for signal in ("q", "dq", "tau"))
    return Fault(text=f"joint {joint + 1} reports nothing new", start=start, urgency=FROZEN, reading=spells)


def encoder_jump(rng: Rng, start: float, period: float) -> Fault:
    """A joint's position jumps by 3° to 60°, or by a whole turn."""
    joint, whole = int(rng.integers(6)), rng.uniform() < 0.2
    by = float(rng.choice([-1.0, 1.0]) * (2.0 * np.pi if whole else np.deg2rad(rng.uniform(3.0, 60.0))))
    spell = Offset(start=start, signal="q", index=joint, by=by)
    return Fault(text=f"q[{joint}] jumps by {np.degrees(by):.0f}°", start=start, urgency=INVALID, reading=(spell,))


def encoder_offset(rng: Rng, start: float, period: float) -> Fault:
    """A joint's position is off by less than anybody could notice."""
    joint, by = int(rng.integers(6)), float(rng.uniform(-1.8, 1.8))
    spell = Offset(start=start, signal="q", index=joint, by=float(np.deg2rad(by)))
    return Fault(text=f"q[{joint}] jumps by {by:.1f}°", start=start, reading=(spell,))


def speed_offset(rng: Rng, start: float, period: float) -> Fault:
    """A joint's speed is read wrong."""
    joint, by = int(rng.integers(6)), float(rng.uniform(-1.0, 1.0))
    spell = Offset(start=start, signal="dq", index=joint, by=by)
    return Fault(text=f"dq[{joint}] off by {by:.2f} rad/s", start=start, reading=(spell,))


def torque_offset(rng: Rng, start: float, period: float) -> Fault:
    """A torque sensor is off, from a little to far."""
    joint, by = int(rng.integers(6)), float(rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-0.5, 1.0))
    spell = Offset(start=start, signal="tau", index=joint, by=by)
    return Fault(text=f"tau[{joint}] off by {by:.1f} N·m", start=start, reading=(spell,))


def wrench_offset(rng: Rng, start: float, period: float) -> Fault:
    """The wrist sensor is off, from a little to more than the arm may press."""
    axis, by = int(rng.integers(3)), float(rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(0.0, 1.8))
    spell = Offset(start=start, signal="F", index=axis, by=by)
    return Fault(text=f"F[{axis}] off by {by:.1f} N", start=start, reading=(spell,))


def degrees_reading(rng: Rng, start: float, period: float) -> Fault:
    """The measurement comes in degrees."""
    spells = tuple(Scaled(start=start, signal=signal, factor=float(np.degrees(1.0))) for signal in ("q", "dq"))
    return Fault(text="q and dq in degrees", start=start, urgency=INVALID, reading=spells)


def nothing_new(rng: Rng, start: float, period: float) -> Fault:
    """The same measurement again and again, for a time or for good."""
    end = start + float(rng.choice([rng.uniform(0.03, 0.2), np.inf]))
    # Two samples may be the same, and cycles may be longer than they should be.
    return Fault(
        text=f"no new measurement {_until(end)}",
        start=start,
        urgency=STALE if end - start >= 5.0 * period else None,
        reading=(Off(start=start, end=end),),
    )


def lost_samples(rng: Rng, start: float, period: float) -> Fault:
    """Measurements are lost, regularly or by chance."""
    if rng.uniform() < 0.5:
        lost = int(rng.integers(1, 5))
        return Fault(
            text=f"{lost} of {lost + 1} measurements lost", start=start, reading=(Slow(start=start, lost=lost),)
        )
    share = float(rng.uniform(0.05, 0.7))
    spell = Intermittent(start=start, share=share, seed=int(rng.integers(2**31)))
    return Fault(text=f"{100 * share:.0f} % of the measurements lost", start=start, reading=(spell,))


def delayed_reading(rng: Rng, start: float, period: float) -> Fault:
    """Measurements are some cycles old, and nobody says so."""
    cycles = int(rng.integers(1, 4))
    return Fault(text=f"measurements {cycles} cycles old", start=start, reading=(Delayed(start=start, cycles=cycles),))


def wrong_clock(rng: Rng, start: float, period: float) -> Fault:
    """The time of the measurements jumps, or is none."""
    by = float(rng.choice([np.nan, 3600.0, -3600.0, 1.0, -1.0, 0.05, -0.05]))
    end = start + float(rng.choice([1.0, 3.0, np.inf])) * period
    urgency = INVALID if by != by else STALE if by < 0.0 and end == np.inf else None
    return Fault(
        text=f"clock off by {by:g} s {_until(end)}",
        start=start,
        urgency=urgency,
        reading=(Clock(start=start, end=end, by=by),),
    )


def hang(rng: Rng, start: float, period: float) -> Fault:
    """The controller does nothing for 20 to 250 ms, then goes on."""
    lost = max(1, round(float(rng.uniform(0.02, 0.25)) / period))
    return Fault(text=f"controller hangs for {lost} cycles", start=start, reading=(Hang(start=start, lost=lost),))


def _signal(rng: Rng) -> str:
    return str(rng.choice(["q", "dq", "tau", "F"]))


def _until(end: float) -> str:
    return "for good" if end == np.inf else f"until {end:.3f} s"
