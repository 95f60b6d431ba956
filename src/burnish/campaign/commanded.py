"""Faults of the law, and of what it is asked for."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from burnish.campaign.fault import INVALID, Fault, Rng
from burnish.core import Array, Dynamics, JointReference
from burnish.sim.faulty import GARBAGE


class ControllerError(RuntimeError):
    """The exception of a controller that fails; no refusal of ours."""


def not_finite(rng: Rng, start: float, period: float) -> Fault:
    """The law gives a torque that is no number."""
    joint, value = int(rng.integers(6)), float(rng.choice(GARBAGE[:3]))

    def torque(tau: Array, arm: Dynamics) -> Array:
        tau[joint] = value
        return tau

    return Fault(text=f"law gives tau[{joint}] = {value}", start=start, urgency=INVALID, torque=torque)


def wrong_length(rng: Rng, start: float, period: float) -> Fault:
    """The law gives a torque for another number of joints."""
    count = int(rng.choice([0, 1, 5, 7, 12]))
    return Fault(
        text=f"law gives {count} torques", start=start, urgency=INVALID, torque=lambda tau, arm: np.resize(tau, count)
    )


def exception(rng: Rng, start: float, period: float) -> Fault:
    """The law raises an exception."""

    def torque(tau: Array, arm: Dynamics) -> Array:
        raise ControllerError("the law broke")

    return Fault(text="law raises an exception", start=start, urgency=INVALID, torque=torque)


def too_strong(rng: Rng, start: float, period: float) -> Fault:
    """Ten times the gain: all beyond gravity is multiplied."""
    factor = float(rng.uniform(5.0, 20.0))
    return Fault(
        text=f"gains × {factor:.1f}", start=start, torque=lambda tau, arm: np.asarray(arm.g + factor * (tau - arm.g))
    )


def runaway(rng: Rng, start: float, period: float) -> Fault:
    """One joint, or all, with the wrong sign, and 2 N·m so that it does go somewhere."""
    joint = int(rng.integers(7))
    which = np.arange(6) == joint if joint < 6 else np.ones(6, dtype=bool)

    def torque(tau: Array, arm: Dynamics) -> Array:
        off = tau - arm.g
        return np.where(which, arm.g - off - 2.0 * np.sign(off), tau)

    return Fault(
        text=f"sign of {f'joint {joint + 1}' if joint < 6 else 'all joints'} flipped", start=start, torque=torque
    )


def square_wave(rng: Rng, start: float, period: float) -> Fault:
    """The law's torque jumps to and fro."""
    joint, size, rate = int(rng.integers(6)), float(rng.uniform(1.0, 30.0)), float(rng.uniform(1.0, 50.0))

    def torque(tau: Array, arm: Dynamics) -> Array:
        tau[joint] += size * np.sign(np.sin(2.0 * np.pi * rate * (arm.t - start)))
        return tau

    return Fault(text=f"tau[{joint}] ± {size:.0f} N·m at {rate:.0f} Hz", start=start, torque=torque)


def stuck_torque(rng: Rng, start: float, period: float) -> Fault:
    """The law's torque no longer changes."""
    kept: list[Array] = []

    def torque(tau: Array, arm: Dynamics) -> Array:
        if not kept:
            kept.append(tau)
        return kept[0].copy()

    return Fault(text="law gives the same torque for ever", start=start, torque=torque)


def no_weight(rng: Rng, start: float, period: float) -> Fault:
    """The law forgets gravity."""
    return Fault(text="law without gravity", start=start, torque=lambda tau, arm: np.asarray(tau - arm.g))


def target_jump(rng: Rng, start: float, period: float) -> Fault:
    """What the law is asked for jumps."""
    joint, by = int(rng.integers(6)), float(rng.choice([-1.0, 1.0]) * rng.uniform(0.1, 2.0))
    way = rng.normal(size=3)
    way *= rng.uniform(0.02, 0.3) / np.linalg.norm(way)

    def reference(wanted: Any, arm: Dynamics) -> Any:
        if isinstance(wanted, JointReference):
            return replace(wanted, q=wanted.q + by * (np.arange(6) == joint))
        return replace(wanted, p=wanted.p + way)

    return Fault(text="target jumps", start=start, reference=reference)


def target_in_degrees(rng: Rng, start: float, period: float) -> Fault:
    """Joint positions are asked for in degrees."""
    return Fault(
        text="target in degrees", start=start, reference=lambda wanted, arm: replace(wanted, q=np.degrees(wanted.q))
    )


def target_beyond_limit(rng: Rng, start: float, period: float) -> Fault:
    """Joints 2 and 3 are sent past the nearer limit, from just outside its soft margin."""
    speed = float(rng.uniform(0.1, 0.5))

    def reference(wanted: Any, arm: Dynamics) -> Any:
        # Joints 2 and 3 have their limits about half a turn to either side.
        off = wanted.q[1:3] - np.pi
        q, dq = wanted.q.copy(), wanted.dq.copy()
        q[1:3] += np.sign(off) * speed * (arm.t - start)
        dq[1:3] += np.sign(off) * speed
        return replace(wanted, q=q, dq=dq)

    return Fault(
        text=f"target past a joint limit at {speed:.1f} rad/s", start=start, reference=reference, near_limit=True
    )


def target_out_of_reach(rng: Rng, start: float, period: float) -> Fault:
    """The tool is sent away from the base for ever."""
    speed = float(rng.uniform(0.05, 0.3))

    def reference(wanted: Any, arm: Dynamics) -> Any:
        out = arm.p / max(1e-3, float(np.linalg.norm(arm.p)))
        v = wanted.v.copy()
        v[:3] += speed * out
        return replace(wanted, p=wanted.p + speed * (arm.t - start) * out, v=v)

    return Fault(text=f"target out of reach at {speed:.2f} m/s", start=start, reference=reference)
