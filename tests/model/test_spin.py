from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.core import Array
from burnish.errors import InputError
from burnish.model.spin import FAR, SpinningTip, slide_and_drill
from burnish.model.tool import PolishingTool

TIP = SpinningTip(spindle=200.0, friction=0.3, radius=0.02, modulus=2e6)
UP, DOWN = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)
FORCE = 10.0
PATCH = (0.75 * FORCE * 0.02 / 2e6) ** (1.0 / 3.0)


def over_the_patch(slide: float, spin: float) -> tuple[float, float]:
    """Drag against a slide along x and moment against a spin about z, Coulomb friction summed over a Hertz contact."""
    r = (np.arange(400) + 0.5) / 400 * PATCH
    angle = (np.arange(360) + 0.5) / 360 * 2.0 * np.pi
    R, A = np.meshgrid(r, angle)
    pressure = np.sqrt(1.0 - (R / PATCH) ** 2) * R
    pressure *= FORCE / pressure.sum()
    vx, vy = slide - spin * R * np.sin(A), spin * R * np.cos(A)
    size = np.hypot(vx, vy)
    fx, fy = -0.3 * pressure * vx / size, -0.3 * pressure * vy / size
    return float(fx.sum()), float((R * (np.cos(A) * fy - np.sin(A) * fx)).sum())


@pytest.mark.parametrize("share", [0.1, 0.3, 0.999, 1.001, 3.0, 50.0])
def test_drag_of_a_sliding_spinning_tip_is_friction_summed_over_its_contact(share: float) -> None:
    slide = share * TIP.spindle * PATCH
    force, moment = TIP.drag(FORCE, UP, DOWN, (slide, 0.0, 0.0))
    # The axis points down, so that the tip spins with −200 rad/s about z.
    F, m = over_the_patch(slide, -TIP.spindle)
    # The sum has 400 rings; STANDSTILL is 1.4 % of the slowest slide, and counts squared.
    assert force[0] == pytest.approx(F, rel=2e-3)
    assert moment[2] == pytest.approx(m, rel=2e-3)


@pytest.mark.parametrize("k", [1.0, FAR])
def test_shares_do_not_jump_where_their_form_changes(k: float) -> None:
    assert_allclose(slide_and_drill(k * (1.0 - 1e-9)), slide_and_drill(k * (1.0 + 1e-9)), atol=2e-6)


def test_upright_tip_is_dragged_about_its_axis_alone() -> None:
    force, moment = TIP.drag(FORCE, UP, DOWN, (0.0, 0.0, 0.0))
    assert_allclose(force, np.zeros(3), atol=1e-12)
    # Against −200 rad/s about z. STANDSTILL of 1 mm/s beside 0.7 m/s takes 0.4 %.
    assert moment[2] == pytest.approx(3.0 * np.pi / 16.0 * 0.3 * FORCE * PATCH, rel=5e-3)


def test_tilted_tip_is_pulled_against_the_motion_of_its_rim() -> None:
    tilt = 0.2
    axis: Array = np.array([np.sin(tilt), 0.0, -np.cos(tilt)])
    force, _ = TIP.drag(FORCE, UP, axis.tolist(), (0.0, 0.0, 0.0))
    rim = np.cross(200.0 * axis, [0.0, 0.0, -0.02])
    assert_allclose(np.array(force) / np.linalg.norm(force), -rim / np.linalg.norm(rim), atol=1e-12)
    slide = np.linalg.norm(rim)
    F, _ = over_the_patch(float(slide), 200.0 * np.cos(tilt))
    assert np.linalg.norm(force) == pytest.approx(-F, rel=2e-3)


def test_tip_that_hardly_spins_drags_as_one_that_slides() -> None:
    force, moment = replace(TIP, spindle=1e-9).drag(FORCE, UP, DOWN, (0.05, 0.0, 0.02))
    speed = np.sqrt(0.05**2 + 1e-3**2)
    assert force[0] == pytest.approx(-0.3 * FORCE * 0.05 / speed, rel=1e-6)
    assert force[2] == 0.0
    assert abs(moment[2]) < 1e-9


def test_tip_in_the_air_is_not_dragged() -> None:
    force, moment = TIP.drag(0.0, UP, DOWN, (0.1, 0.0, 0.0))
    assert_allclose([*force, *moment], np.zeros(6), atol=0.0)


def test_tool_without_a_spindle_has_no_spinning_tip() -> None:
    assert PolishingTool().spinning is None
    tip = PolishingTool(spindle=-50.0).spinning
    assert tip is not None
    assert tip.spindle == -50.0


@pytest.mark.parametrize("spindle", [np.nan, np.inf])
def test_spindle_that_is_no_speed_is_refused(spindle: float) -> None:
    with pytest.raises(InputError, match="spindle ="):
        PolishingTool(spindle=spindle)
