"""What a run is judged by: the tilt against the axis that was commanded."""

from __future__ import annotations

import numpy as np
import pytest

from burnish.commands.evaluate import RunLog, lean_error
from burnish.core import Sample, State, ToolReference
from burnish.model.model import Model
from burnish.polish.cell import TURN
from burnish.rotation import exp
from burnish.sim.truth import Truth
from burnish.trajectory.path import tool_rotation

LEAN = np.deg2rad(10.0)


def run_of(normal: object, off: float) -> tuple[RunLog, Truth]:
    """Two cycles of a tool that was to lean by 10° to the mould's x, and leans that much further."""
    arm = Model.jaco2().at(State(t=0.0, q=np.full(6, 1.0), dq=np.zeros(6)))
    axis = exp(np.array([0.0, LEAN, 0.0])) @ [0.0, 0.0, -1.0]
    R = tool_rotation(-TURN @ axis, np.diag([1.0, -1.0, -1.0]))
    reference = ToolReference(p=arm.p, R=R, v=np.zeros(6), a=np.zeros(6), normal=normal, force=10.0)
    log, truth = RunLog(), Truth(timestep=5e-4)
    for _ in range(2):
        log.add(Sample(arm, reference, np.zeros(6), np.zeros(6)))
        truth.axis.append(tuple(exp(np.array([0.0, off, 0.0])) @ axis))
        truth.normal.append((0.0, 0.0, 1.0))
    return log, truth


@pytest.mark.parametrize("off", [0.0, 0.05, -0.05])
def test_tilt_counts_from_the_commanded_axis_in_the_part(off: float) -> None:
    log, truth = run_of(np.array([0.0, 0.0, 1.0]), off)
    np.testing.assert_allclose(lean_error(log, truth, np.array([0, 1]), TURN), abs(off), atol=1e-9)


def test_tilt_counts_from_the_normal_where_nothing_was_to_be_pressed() -> None:
    log, truth = run_of(None, 0.05)
    np.testing.assert_allclose(lean_error(log, truth, np.array([0, 1]), TURN), LEAN + 0.05, atol=1e-9)
