"""Several pieces in a file: what is seen from above is worked, and what is doubtful refused."""

from __future__ import annotations

import numpy as np
import pytest
from surface.shapes import box, sheet

from burnish.core import Array
from burnish.errors import MouldError
from burnish.surface import DistanceGrid, Mould, top
from burnish.surface.winding import face_vectors

X = np.linspace(-0.03, 0.03, 13)
BOX = box(0.06, 0.04, 0.01)
SHEET = sheet(X, X, np.full((13, 13), 0.01))


def together(*parts: Array) -> Mould:
    return Mould.of("parts", np.concatenate(parts))


def height(part: Mould, x: float, y: float) -> float:
    """Of the surface as seen from above, over a place in the frame of the file whose middle is the part's."""
    return float(top(DistanceGrid.of(part), np.array([[x, y]]))[0, 2])


def test_box_on_a_box_is_one_part() -> None:
    part = together(BOX, box(0.02, 0.02, 0.005) + [0.0, 0.0, 0.01])
    assert height(part, 0.0, 0.0) == pytest.approx(0.015, abs=2e-6)
    assert height(part, 0.02, 0.0) == pytest.approx(0.01, abs=2e-6)
    assert any("2 separate pieces" in sentence for sentence in part.warnings)


def test_boxes_through_each_other_are_worked_on_their_outside() -> None:
    part = together(BOX, box(0.02, 0.02, 0.016) + [0.0, 0.0, 2e-3])
    assert height(part, 0.0, 0.0) == pytest.approx(0.018, abs=2e-6)
    assert any("cuts through itself over 4" in sentence for sentence in part.warnings)


def test_box_beside_a_box_is_worked_too() -> None:
    part = together(BOX, BOX + [0.08, 0.0, 0.0])
    assert height(part, -0.04, 0.0) == pytest.approx(0.01, abs=2e-6)
    assert np.isnan(height(part, 0.0, 0.0))


def test_box_inside_out_is_turned_round() -> None:
    part = together(BOX, BOX[:, ::-1] + [0.08, 0.0, 0.0])
    corners = part.vertices[part.faces]
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert volume == pytest.approx(2 * 0.06 * 0.04 * 0.01)


def test_bubble_in_a_box_is_not_seen_and_stays() -> None:
    part = together(BOX, box(0.02, 0.02, 0.004)[:, ::-1] + [0.0, 0.0, 3e-3])
    assert height(part, 0.0, 0.0) == pytest.approx(0.01, abs=2e-6)


def test_box_that_floats_over_a_box_is_refused_with_the_gap() -> None:
    with pytest.raises(MouldError, match="over each other, 3 mm apart"):
        together(BOX, box(0.02, 0.02, 0.005) + [0.0, 0.0, 0.013])


def test_bridge_that_stands_on_its_piers_does_not_float() -> None:
    pier = box(0.01, 0.04, 0.01)
    part = together(
        box(0.06, 0.04, 0.002), pier + [0.025, 0.0, 0.002], pier + [-0.025, 0.0, 0.002],
        box(0.06, 0.04, 0.004) + [0.0, 0.0, 0.012],
    )  # fmt: skip
    assert height(part, 0.0, 0.0) == pytest.approx(0.016, abs=2e-6)


def test_two_sheets_over_each_other_are_refused() -> None:
    with pytest.raises(MouldError, match=r"over each other, 0\.4 mm apart"):
        together(SHEET, SHEET + [0.0, 0.0, 0.4e-3])


def test_sheet_that_is_there_twice_within_twenty_micrometres_is_one() -> None:
    part = together(SHEET, SHEET + [0.0, 0.0, 20e-6])
    assert height(part, 0.001, 0.002) == pytest.approx(20e-6, abs=21e-6)


def test_sheet_that_faces_down_beside_one_that_faces_up_is_turned() -> None:
    part = together(SHEET, SHEET[:100, ::-1] + [0.07, 0.0, 0.0])
    assert (face_vectors(part.vertices, part.faces)[:, 2] > 0).all()
    assert any("faced the wrong way" in sentence for sentence in part.warnings)


def test_small_opening_in_the_top_is_said_and_a_large_one_refused() -> None:
    x = np.linspace(-0.03, 0.03, 61)
    corners = np.concatenate((sheet(x, x, np.full((61, 61), 0.01)), box(0.06, 0.06, 0.01)[2:]))
    middle = corners.mean(axis=1)
    for radius, large in ((5e-3, False), (15e-3, True)):
        holed = corners[(np.linalg.norm(middle[:, :2], axis=1) > radius) | (middle[:, 2] < 9e-3)]
        if large:
            with pytest.raises(MouldError, match="shows its inside"):
                Mould.of("holed", holed)
        else:
            assert any("through openings" in sentence for sentence in Mould.of("holed", holed).warnings)


def test_surface_that_winds_through_itself_is_refused() -> None:
    across, along = np.linspace(-1.0, 1.0, 41), np.linspace(-0.05, 0.05, 40)
    width = 0.03 * np.cos(np.linspace(0.0, np.pi, 40))  # goes through zero, and the far half is seen from behind
    grid = np.stack(
        np.broadcast_arrays(along[:, None], width[:, None] * across[None, :], 0.0 * across[None, :]), axis=-1
    )
    grid = grid + [0.0, 0.0, 0.01]
    a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    bow = np.concatenate((np.stack((a, b, c), axis=-2), np.stack((a, c, d), axis=-2))).reshape(-1, 3, 3)
    with pytest.raises(MouldError, match="shows its inside"):
        Mould.of("bow tie", bow)
