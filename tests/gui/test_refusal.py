import numpy as np
import pytest

from burnish.check.on_mould import refusal
from burnish.gui.refusal import explained
from burnish.polish.cell import nominal_placement


def test_the_place_of_a_refusal_is_found_on_the_mould() -> None:
    error = refusal(
        "stroke 3", np.array([0.0104, -0.02, 0.0301]), 0.045, "the arm is too slow; expected 60 %", "Lower the feed"
    )
    found = explained(str(error))
    assert found.at == pytest.approx([0.0104, -0.02, 0.0301])
    assert found.where == "Stroke 3, 45 mm along"
    assert found.why == "The arm is too slow; expected 60 %."
    assert found.remedy == "Lower the feed."


def test_a_pose_that_is_out_of_reach_is_told_in_the_base_frame_and_found_on_the_mould() -> None:
    placement = nominal_placement(0.02)
    there = np.array([0.05, -0.03, 0.02])
    x, y, z = placement.points(there[None])[0]
    text = f"the arm cannot bring its tool to ({x:.3f}, {y:.3f}, {z:.3f}) m in the wanted direction; it is 4 mm off"
    assert explained(f"{text}. Move it", placement).at == pytest.approx(there, abs=1e-3)


def test_a_refusal_without_a_place_keeps_all_its_words() -> None:
    found = explained("part.stl is no mesh; expected an STL file")
    assert found.at is None
    assert found.sentence == "Part.stl is no mesh; expected an STL file."


def test_what_helps_is_told_apart_from_what_is_wrong() -> None:
    found = explained("the raster leaves nothing of the mould; use a smaller tip")
    assert (found.why, found.remedy) == ("The raster leaves nothing of the mould.", "Use a smaller tip.")
