from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.core import State
from burnish.experiments import thesis_b
from burnish.experiments.thesis_b import HybridTable, TaskTable
from burnish.model.model import Model
from burnish.rotation import quaternion_error
from burnish.sim.robot import HOME

# Thesis B's tables as printed: K and D along x, y, z and about them.
TASK = {
    "5_2": ([300, 300, 450, 350, 350, 350], [50, 50, 50, 20, 20, 20]),
    "5_3": ([100, 100, 200, 20, 20, 20], [20, 20, 20, 2, 2, 2]),
    "5_4": ([200, 200, 350, 180, 180, 180], [24, 24, 24, 3, 3, 3]),
    "5_5": ([200, 200, 400, 180, 180, 180], [24, 24, 24, 3.5, 3.5, 3.5]),
    "5_9": ([200, 200, 200, 150, 150, 150], [24, 24, 24, 6, 6, 6]),
    "5_10": ([200, 200, 200, 25, 25, 25], [10, 10, 10, 1.5, 1.5, 1.5]),
    "5_11": ([150, 150, 150, 15, 15, 15], [22, 22, 22, 0.1, 0.1, 0.1]),
    "5_12": ([150, 150, 150, 20, 20, 20], [22, 22, 22, 0.1, 0.1, 0.1]),
}
# K and D along x, y, z; K1, Kp, Kd of the joints.
HYBRID = {
    "5_6": ([600] * 3, [22] * 3, [5, 5, 5, 25, 25, 25], [10] * 6, [0.02] * 6),
    "5_7": ([200, 200, 400], [22] * 3, [5, 5, 5, 30, 30, 30], [10] * 6, [0] * 6),
    "5_13": ([500] * 3, [10] * 3, [5, 5, 5, 25, 25, 25], [10] * 6, [0.3] * 6),
    "5_14": ([150] * 3, [10] * 3, [5, 5, 5, 25, 25, 25], [7.5] * 6, [0] * 6),
}


@pytest.mark.parametrize("name", TASK)
def test_task_gains_are_the_printed_ones(name: str) -> None:
    table: TaskTable = getattr(thesis_b, f"TABLE_{name}")
    assert (list(table.k), list(table.d)) == TASK[name]


@pytest.mark.parametrize("name", HYBRID)
def test_hybrid_gains_are_the_printed_ones(name: str) -> None:
    table: HybridTable = getattr(thesis_b, f"TABLE_{name}")
    assert tuple(list(column) for column in (table.k, table.d, table.k1, table.kp, table.kd)) == HYBRID[name]


def test_joint_gains_are_the_printed_ones() -> None:
    assert_allclose(thesis_b.TABLE_5_1_FREQUENCY, [35, 10, 15, 35, 30, 40])
    assert_allclose(thesis_b.TABLE_5_1_INTEGRAL, [0.005, 0.005, 0.005, 0.015, 0.005, 0.025])
    assert_allclose(thesis_b.TABLE_5_8_KP, [200, 300, 300, 30, 30, 30])
    assert_allclose(thesis_b.TABLE_5_8_KD, [20, 20, 20, 5, 5, 5])


def test_every_law_of_the_thesis_takes_half_the_angle() -> None:
    laws = [
        thesis_b.task_computed_torque(thesis_b.TABLE_5_2),
        thesis_b.impedance(thesis_b.TABLE_5_3),
        thesis_b.force_sensing(thesis_b.TABLE_5_4),
        thesis_b.redundant(thesis_b.TABLE_5_5),
        thesis_b.hybrid(thesis_b.TABLE_5_6),
        thesis_b.hybrid_null_space(thesis_b.TABLE_5_7),
    ]
    assert all(law.orientation_error is quaternion_error for law in laws)
    assert_allclose(thesis_b.TABLE_5_3.small_angle_stiffness, [100, 100, 200, 10, 10, 10])


def test_enlarged_hand_is_harder_to_turn_and_not_heavier() -> None:
    state = State(t=0.0, q=HOME, dq=np.zeros(6))
    bare, large = Model.jaco2().at(state), thesis_b.enhanced().at(state)
    assert_allclose(large.g, bare.g, atol=1e-4)
    # About the axis of joint 6 all of it counts.
    assert_allclose(large.M[5, 5] - bare.M[5, 5], thesis_b.HAND_INERTIA, rtol=1e-3)
