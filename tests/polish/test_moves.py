"""How fast the arm comes down on a mould."""

from __future__ import annotations

from dataclasses import replace

import pytest

from burnish.model.tool import PolishingTool
from burnish.polish.moves import APPROACH_SPEED, LIGHT, MASS, gently

TOOL = PolishingTool()


@pytest.mark.parametrize("stiffness", [1e3, 12e3, 25e3])
def test_soft_tips_touch_at_the_usual_speed(stiffness: float) -> None:
    assert gently(APPROACH_SPEED, replace(TOOL, stiffness=stiffness)) == APPROACH_SPEED


@pytest.mark.parametrize("stiffness", [30e3, 100e3, 1e6])
def test_a_stiff_tip_touches_no_harder_than_a_soft_one(stiffness: float) -> None:
    speed = gently(APPROACH_SPEED, replace(TOOL, stiffness=stiffness))
    assert speed < APPROACH_SPEED
    # ½ m v² = ½ F²/k with tip and felt of 100 kN/m behind each other.
    force = speed * (MASS / (1.0 / stiffness + 1.0 / 100e3)) ** 0.5
    assert force == pytest.approx(LIGHT)


def test_what_is_faster_by_choice_stays_so_by_the_same_share() -> None:
    tool = replace(TOOL, stiffness=100e3)
    assert gently(2.0 * APPROACH_SPEED, tool) == pytest.approx(2.0 * gently(APPROACH_SPEED, tool))
