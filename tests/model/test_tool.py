from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.core import State
from burnish.errors import InputError
from burnish.model.model import Model
from burnish.model.tool import TIP_FRAME, PolishingTool

TOOL = PolishingTool()


def random_states(seed: int, count: int) -> list[State]:
    rng = np.random.default_rng(seed)
    return [State(t=0.0, q=rng.uniform(-np.pi, np.pi, 6), dq=rng.uniform(-1.0, 1.0, 6)) for _ in range(count)]


def test_model_with_the_tool_ends_at_the_apex_of_the_tip() -> None:
    bare, tooled = Model.jaco2(), TOOL.on(Model.jaco2())
    assert tooled.tool == TIP_FRAME
    for state in random_states(1, 5):
        arm, tip = bare.at(state), tooled.at(state)
        assert_allclose(tip.p, arm.p + TOOL.length * arm.R[:, 2], atol=1e-14)
        assert_allclose(tip.R, arm.R, atol=1e-14)


def test_tool_weighs_as_one_mass_in_its_centre() -> None:
    bare, tooled = Model.jaco2(), TOOL.on(Model.jaco2())
    for state in random_states(2, 5):
        arm = bare.at(state)
        J_com = arm.J[:3] + np.cross(arm.J[3:].T, TOOL.com * arm.R[:, 2]).T
        assert_allclose(tooled.at(state).g, arm.g + J_com.T @ [0.0, 0.0, 9.81 * TOOL.mass], atol=1e-12)


def test_tool_adds_the_kinetic_energy_of_its_two_bodies() -> None:
    bare, tooled = Model.jaco2(), TOOL.on(Model.jaco2())
    bodies = [
        (TOOL.body_mass, TOOL.body_com, TOOL.body_inertia),
        (TOOL.tip_mass, TOOL.tip_centre, TOOL.tip_inertia),
    ]
    for state in random_states(3, 5):
        arm = bare.at(state)
        velocity, spin = arm.v[:3], arm.v[3:]
        energy = 0.5 * state.dq @ arm.M @ state.dq
        for mass, height, inertia in bodies:
            v = velocity + np.cross(spin, height * arm.R[:, 2])
            energy += 0.5 * mass * v @ v + 0.5 * inertia @ (arm.R.T @ spin) ** 2
        assert 0.5 * state.dq @ tooled.at(state).M @ state.dq == pytest.approx(energy, rel=1e-12)


def test_tool_leaves_the_model_it_is_fitted_to_alone() -> None:
    model = Model.jaco2()
    state = random_states(4, 1)[0]
    before = model.at(state).g
    TOOL.on(model)
    assert_allclose(model.at(state).g, before, atol=0.0)


def test_tip_reaches_its_apex_from_its_centre() -> None:
    assert TOOL.tip_centre + TOOL.tip_radius == pytest.approx(TOOL.length)


def test_damping_ratio_is_that_of_the_free_decay() -> None:
    # The roots of m s² + d s + k: their real part over their size is −ζ.
    roots = np.roots([TOOL.tip_mass, TOOL.damping, TOOL.stiffness])
    assert -roots.real / np.abs(roots) == pytest.approx([TOOL.damping_ratio] * 2)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        (field.name, value)
        for field in fields(PolishingTool)
        for value in (0.0, -1.0, np.nan, np.inf)
        # A spindle may stand still, or turn the other way round.
        if field.name != "spindle" or not np.isfinite(value)
    ],
)
def test_impossible_figure_is_refused_by_name(name: str, value: float) -> None:
    with pytest.raises(InputError, match=rf"\b{name} ="):
        PolishingTool(**{name: value})
