"""Faults that really fire: each changes what is read or written, when it should and not before."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.control import ComputedTorque
from burnish.core import Array, Robot, State
from burnish.model.model import Model
from burnish.runtime.limits import Limits
from burnish.runtime.loop import Rig, control
from burnish.runtime.supervisor import Supervisor
from burnish.sim import arms
from burnish.sim.faulty import (
    GARBAGE,
    Clock,
    Delayed,
    Fault,
    FaultyRobot,
    Garbage,
    Hang,
    Intermittent,
    Off,
    Offset,
    Scaled,
    Slow,
    Stuck,
)
from burnish.sim.robot import SimRobot
from burnish.trajectory import Sine

T = 0.01


class Counting:
    """A robot whose k-th reading says k in every place."""

    def __init__(self) -> None:
        self.k = -1
        self.sent: list[Array] = []

    def __enter__(self) -> Counting:
        return self

    def __exit__(self, *exception: object) -> None:
        """Nothing to leave."""

    def read(self) -> State:
        self.k += 1
        here = np.full(6, float(self.k))
        return State(t=self.k * T, q=here, dq=here, tau=here, F=here)

    def write(self, command: Any) -> Array:
        self.sent.append(command.tau)
        return np.asarray(command.tau)


def readings(fault: Fault, count: int) -> list[State]:
    robot = FaultyRobot(robot=Counting(), faults=[fault])
    return [robot.read() for _ in range(count)]


def test_off_repeats_the_last_reading_before_it() -> None:
    assert [s.q[0] for s in readings(Off(start=0.03, end=0.06), 8)] == [0, 1, 2, 2, 2, 2, 6, 7]


def test_stuck_holds_one_number_and_the_clock_runs_on() -> None:
    states = readings(Stuck(start=0.02, signal="dq", index=4), 5)
    assert [s.dq[4] for s in states] == [0, 1, 2, 2, 2]
    assert [s.dq[3] for s in states] == [0, 1, 2, 3, 4]
    assert_allclose([s.t for s in states], np.arange(5) * T)


@pytest.mark.parametrize("value", GARBAGE)
def test_garbage_is_in_one_place(value: float) -> None:
    states = readings(Garbage(start=0.02, end=0.03, signal="tau", index=1, value=value), 4)
    assert_allclose([s.tau[1] for s in states], [0.0, 1.0, value, 3.0])
    assert_allclose([s.tau[0] for s in states], [0.0, 1.0, 2.0, 3.0])


def test_offset_adds() -> None:
    assert readings(Offset(start=0.0, signal="F", index=2, by=-3.0), 1)[0].F[2] == -3.0


def test_slow_loses_readings() -> None:
    assert [s.q[0] for s in readings(Slow(start=0.02, lost=2), 4)] == [0, 1, 4, 7]


def test_scaled_multiplies_all_numbers_of_one_signal() -> None:
    states = readings(Scaled(start=0.02, signal="q", factor=57.3), 4)
    assert_allclose([s.q for s in states], np.outer([0.0, 1.0, 114.6, 171.9], np.ones(6)))
    assert states[3].dq[0] == 3.0


@pytest.mark.parametrize("by", [1.0, -0.05, np.nan])
def test_clock_is_off_while_it_is_on(by: float) -> None:
    states = readings(Clock(start=0.02, end=0.03, by=by), 4)
    assert_allclose([s.t for s in states], [0.0, T, 2 * T + by, 3 * T])


def test_hang_loses_its_readings_once() -> None:
    assert [s.q[0] for s in readings(Hang(start=0.02, lost=3), 5)] == [0, 1, 5, 6, 7]


def test_intermittent_loses_about_its_share() -> None:
    assert 150 < readings(Intermittent(start=0.0, share=0.4), 100)[-1].q[0] < 185


def test_delayed_shows_the_past_as_if_it_were_now() -> None:
    states = readings(Delayed(start=0.03, cycles=2), 6)
    assert [s.q[0] for s in states] == [0, 1, 2, 1, 2, 3]
    assert_allclose([s.t for s in states], np.arange(6) * T)


# On the honest arm, judged by its motion.

MODEL = Model.jaco2().with_armature(arms.honest(0).armature)
STATE_FAULTS: dict[str, Callable[[int], Fault]] = {
    **{f"position {v}": lambda j, v=v: Garbage(start=1.0, signal="q", index=j, value=v) for v in GARBAGE},
    **{f"speed {v}": lambda j, v=v: Garbage(start=1.0, signal="dq", index=j, value=v) for v in GARBAGE},
    **{f"torque {v}": lambda j, v=v: Garbage(start=1.0, signal="tau", index=j, value=v) for v in GARBAGE},
    "encoder jump": lambda j: Offset(start=1.0, signal="q", index=j, by=0.06),
    "nothing new": lambda j: Off(start=1.0),
    "three of four lost": lambda j: Slow(start=1.0, lost=3),
    "six of ten lost": lambda j: Intermittent(start=1.0, share=0.6, seed=j),
}
AFTER = {"nothing new": 2, "three of four lost": 3, "six of ten lost": 12}
"""Cycles until the arm is held, where it is not the first."""


def faulty_run(fault: Fault, seed: int, duration: float = 2.5) -> tuple[Array, Array, Array, Array]:
    """Time, whether the arm is held, true joint speeds and sent torques, a row a cycle."""
    arm = arms.honest(seed)
    plant = SimRobot(rate=100.0, plant=arm.plant)
    supervisor = Supervisor(limits=Limits.jaco2(), period=T)
    robot: Robot = FaultyRobot(robot=plant, faults=[fault])
    law = ComputedTorque.at_frequency(10.0, friction=arm.friction)
    rows: list[tuple[float, bool, Array, Array]] = []
    for sample in control(Rig(robot, MODEL, supervisor), Sine(amplitude=0.15, period=6.0), law):
        rows.append((plant.time, supervisor.tripped, plant.truth_dq(), sample.applied))
        if plant.time > duration:
            break
    t, held, speeds, sent = zip(*rows, strict=True)
    return np.array(t), np.array(held), np.array(speeds), np.array(sent)


@pytest.mark.parametrize("name", STATE_FAULTS)
def test_fault_holds_the_arm_at_once_and_the_arm_stops(name: str) -> None:
    joint = sorted(STATE_FAULTS).index(name) % 6
    with np.errstate(all="ignore"):
        t, held, speeds, sent = faulty_run(STATE_FAULTS[name](joint), seed=joint)
    limits = Limits.jaco2()
    assert held.any()
    first_bad, first_held = int(np.argmax(t >= 1.0)), int(np.argmax(held))
    assert 0 <= first_held - first_bad <= AFTER.get(name, 0)
    assert held[first_held:].all()
    assert np.isfinite(sent).all()
    assert (np.abs(sent) <= limits.torque).all()
    # Without any measurement nobody can hold an arm by torque for long: that is for its position mode.
    upto = first_held + 20 if name == "nothing new" else len(t)
    assert np.abs(speeds[:upto] / limits.speed).max() <= 1.0
    if name != "nothing new":
        assert np.degrees(np.abs(speeds[-1]).max()) < 1.0
