"""What a run is judged by: the tilt against the axis that was commanded, and how the abrasive rubbed."""

from __future__ import annotations

import numpy as np
import pytest

from burnish.commands.evaluate import RunLog, lean_error, rubbed
from burnish.core import Sample, State, ToolReference
from burnish.finish.rubbing import Rubbing
from burnish.model.model import Model
from burnish.model.tool import PolishingTool
from burnish.polish.cell import TURN
from burnish.polish.depth import law_of
from burnish.polish.recipe import Recipe
from burnish.rotation import exp
from burnish.sim.truth import Truth
from burnish.surface import Mould, WorkingSurface
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


def rubbing_on(name: str, tool: PolishingTool) -> Rubbing:
    """A tip that goes along x over the middle of a bundled mould at 20 mm/s, leaning by 10° to y."""
    surface = WorkingSurface.of(Mould.load(name), law_of(Recipe()).edge(10.0))
    z = float(surface.vertices[np.argmin(np.hypot(*surface.vertices[:, :2].T)), 2])
    truth = Truth(timestep=0.01)
    for k in range(100):
        truth.point.append((0.2e-3 * k - 0.01, 0.0, z))
        truth.normal.append((0.0, 0.0, 1.0))
        truth.axis.append((0.0, -float(np.sin(LEAN)), -float(np.cos(LEAN))))
        truth.slip.append(0.02)
        truth.time.append(0.01 * (k + 1))
        truth.cycle_step.append(k + 1)
        truth.normal_force.append(10.0)
    return rubbed(truth, surface, Recipe(tool=tool), tool)


def test_spindle_slides_at_its_rate_times_the_lever_of_the_true_tilt() -> None:
    found = rubbing_on("plate", PolishingTool(spindle=300.0))
    # ω a × (−r n) with a = (0, −sin θ, −cos θ) out of the arm and n = z, and the feed along x.
    np.testing.assert_allclose(found.velocity, [[300.0 * 0.02 * np.sin(LEAN) + 0.02, 0.0, 0.0]] * 100, atol=1e-9)
    np.testing.assert_allclose(found.spin, -300.0 * np.cos(LEAN))


def test_tip_that_does_not_spin_slides_with_its_feed_alone() -> None:
    found = rubbing_on("plate", PolishingTool())
    np.testing.assert_allclose(np.linalg.norm(found.velocity, axis=1), 0.02)
    assert not found.spin.any()


def test_contact_is_as_large_as_the_surface_is_round() -> None:
    assert not np.abs(rubbing_on("plate", PolishingTool()).curvature).max() > 1e-6
    # At the ends of the line the points are 0.3 mm above the dome.
    np.testing.assert_allclose(rubbing_on("dome", PolishingTool()).curvature[10:-10], 1.0 / 0.15, rtol=0.1)
