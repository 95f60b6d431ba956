"""What a cycle of the driver leaves behind: nothing."""

from __future__ import annotations

import gc
import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest
from hardware.standin import SERIAL, StandIn, Unhurried

from burnish.core import Torque
from burnish.hardware.jaco2 import Jaco2
from burnish.hardware.torque_mode import TorqueSetup
from burnish.model.model import Model


def growth(standin: StandIn, cycles: int) -> float:
    """Bytes that stay after so many cycles, less what the first hundred left."""
    arm = Jaco2(Model.jaco2(), serial=SERIAL, clock=Unhurried())
    with arm:
        arm._torque = TorqueSetup.thesis_a()
        standin.memory.mode = 1
        torque = Torque(np.ones(6))
        # The base refreshes its readings; only the noise, which is what the driver looks at.
        noise = np.random.default_rng(0).normal(0.0, 0.02, 997).tolist()
        tracemalloc.start()
        for cycle in range(cycles + 100):
            standin.memory.torque[cycle % 6] = noise[cycle % 997]
            arm.read()
            arm.write(torque)
            if cycle == 100:
                gc.collect()
                before = tracemalloc.get_traced_memory()[0]
        gc.collect()
        after = tracemalloc.get_traced_memory()[0]
        tracemalloc.stop()
        standin.memory.mode = 0
    assert arm.bad_readings == 0
    return float(after - before)


def test_memory_does_not_grow_over_2_000_cycles(standin: StandIn) -> None:
    # A single float kept a cycle would be 48 kB, an array 200 kB.
    assert growth(standin, 2_000) < 10_000


@pytest.mark.slow
def test_memory_does_not_grow_over_50_000_cycles(standin: StandIn) -> None:
    # A million are run by benchmarks/driver.py.
    assert growth(standin, 50_000) < 10_000


def test_what_is_returned_is_nobody_elses(standin: StandIn, jaco2: Callable[..., Jaco2]) -> None:
    with jaco2(torque=TorqueSetup.thesis_a()) as arm:
        first = arm.read()
        q, tau = first.q.copy(), first.tau
        assert tau is not None
        tau = tau.copy()
        applied = arm.write(Torque(np.full(6, 100.0)))
        # The driver's last clamp: the actuators' peak torques.
        np.testing.assert_array_equal(applied, [30.5, 30.5, 30.5, 6.8, 6.8, 6.8])
        arm.read()
        np.testing.assert_array_equal(first.q, q)
        np.testing.assert_array_equal(first.tau, tau)
