"""A tool that leans under its spindle, where the arm is light along the normal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from burnish.model.tool import PolishingTool
from burnish.paths.tilt import Tilt
from burnish.polish.cellsim import WristFelt, plan_strokes, simulated_job
from burnish.polish.recipe import Recipe
from burnish.sim import arms
from burnish.surface import DistanceGrid, Mould


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "stiffness"), [(2, 12e3), (4, 12e3), (4, 100e3)])
def test_leaning_spindle_does_not_ring(seed: int, stiffness: float) -> None:
    mould = Mould.load("dome", "mm")
    grid, tool = DistanceGrid.of(mould), PolishingTool(spindle=300.0, stiffness=stiffness)
    (stroke,) = plan_strokes(mould, grid, Recipe(force=10.0, feed=0.02, tool=tool), tool)
    near = stroke.arc < 0.25
    tilt = Tilt(angle=np.deg2rad(15.0), heading=0.5 * np.pi)
    piece = replace(
        stroke, points=stroke.points[near], normals=stroke.normals[near], feed=stroke.feed[near],
        force=stroke.force[near], tilt=tilt,
    )  # fmt: skip
    job, robot = simulated_job(
        grid, [piece], arms.honest(seed), rate=100.0, felt=WristFelt(), tool=tool, on_phase=lambda phase: None
    )
    with robot:
        starts = [sample.arm.t for sample in job.run() if job.phase == "pass"]
    t, force = robot.truth.force()
    on = (t > starts[0] + 2.0) & (t < starts[-1])
    assert job.rig.supervisor.event is None
    assert job.failure is None
    assert np.sqrt(np.mean((force[on] - 10.0) ** 2)) < 0.5
