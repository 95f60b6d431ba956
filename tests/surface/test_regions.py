"""Patches of a mould, and the band along their borders."""

from __future__ import annotations

import numpy as np
import pytest
from surface.shapes import angle_deg, box, mould, tray

from burnish.errors import InputError
from burnish.surface import Mould, WorkingSurface, edge_band, regions
from burnish.surface.winding import face_vectors


def test_box_has_six_patches() -> None:
    found = regions(Mould.of("box", box(0.12, 0.08, 0.03)))
    assert [round(1e4 * region.area, 6) for region in found] == [96, 96, 36, 36, 24, 24]
    normals = {tuple(np.rint(region.normal).astype(int).tolist()) for region in found}
    assert normals == {(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)}
    assert all(region.spread == pytest.approx(0.0, abs=1e-6) for region in found)


def test_border_of_a_patch_goes_once_round_it() -> None:
    top = next(region for region in regions(Mould.of("box", box(0.12, 0.08, 0.03))) if region.normal[2] > 0.5)
    length = np.linalg.norm(top.border[:, 1] - top.border[:, 0], axis=1).sum()
    assert length == pytest.approx(2 * (0.12 + 0.08))


def test_dome_is_one_patch_whose_spread_is_its_opening_angle() -> None:
    top = next(region for region in regions(mould("dome")) if region.normal[2] > 0.5)
    assert top.area == pytest.approx(np.linalg.norm(top_vectors("dome"), axis=1).sum() / 2)
    corner = np.rad2deg(np.arcsin(np.hypot(50, 50) / 150))
    assert np.rad2deg(top.spread) == pytest.approx(corner, abs=0.5)  # facets of 1 mm on a radius of 150 mm


def top_vectors(name: str) -> np.ndarray:
    vectors = face_vectors(mould(name).vertices, mould(name).faces)
    return vectors[vectors[:, 2] > 0.5 * np.linalg.norm(vectors, axis=1)]


def test_every_face_of_the_free_form_is_in_one_patch() -> None:
    part = mould("mould")
    numbers = np.concatenate([region.faces for region in regions(part)])
    np.testing.assert_array_equal(np.sort(numbers), np.arange(len(part.faces)))


def test_half_pipe_ends_where_it_has_turned_by_45_degrees() -> None:
    angle = np.deg2rad(np.linspace(-80, 80, 81))
    pipe = tray(np.array([-0.03, 0.03]), 0.02 * np.sin(angle), np.tile(0.01 + 0.02 * np.cos(angle), (2, 1)))
    top = next(region for region in regions(Mould.of("pipe", pipe)) if region.normal[2] > 0.9)
    assert np.rad2deg(top.spread) == pytest.approx(45.0, abs=2.0)  # facets of 2°


def test_small_patch_joins_the_neighbour_of_the_same_surface() -> None:
    angle = np.deg2rad(np.linspace(-50, 50, 51))  # beyond 45° only 0.8 mm of it are left
    pipe = tray(np.array([-0.004, 0.004]), 0.01 * np.sin(angle), np.tile(0.01 + 0.01 * np.cos(angle), (2, 1)))
    counts = [len(regions(Mould.of("pipe", pipe), smallest=area)) for area in (0.0, 20e-6)]
    assert counts[0] - counts[1] == 2


def test_neighbours_in_a_patch_meet_smoothly() -> None:
    part = mould("mould")
    normals = face_vectors(part.vertices, part.faces)
    for region in regions(part):
        mean = np.broadcast_to(region.normal, (len(region.faces), 3))
        assert angle_deg(normals[region.faces], mean).max() == pytest.approx(np.rad2deg(region.spread), abs=1e-3)


def test_crease_that_is_no_angle_is_refused() -> None:
    with pytest.raises(InputError, match="crease"):
        regions(mould("plate"), crease=0.0)


@pytest.mark.parametrize("width", [3e-3, 6e-3])
def test_band_of_a_flat_patch_has_the_area_of_a_frame(width: float) -> None:
    part = Mould.of("box", box(0.12, 0.08, 0.03))
    surface = WorkingSurface.of(part, 0.5e-3)
    top = next(region for region in regions(part) if region.normal[2] > 0.5)
    band = edge_band(surface.vertices, surface.faces, top.border, width)
    frame = 0.12 * 0.08 - (0.12 - 2 * width) * (0.08 - 2 * width)
    assert surface.areas[band].sum() == pytest.approx(frame, abs=0.4 * 0.5e-3)  # half a row of vertices all round


def test_band_does_not_go_through_a_thin_wall() -> None:
    x = np.linspace(-0.02, 0.02, 41)
    sheets = [np.stack(np.meshgrid(x, x, [z], indexing="ij"), axis=-1).reshape(-1, 3) for z in (0.0, -1e-3)]
    number = np.arange(41 * 41).reshape(41, 41)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    faces = np.concatenate([np.stack(corners, axis=-1).reshape(-1, 3) for corners in ((a, b, c), (a, c, d))])
    vertices = np.concatenate(sheets)
    border = np.array([[[-0.02, -0.02, 0.0], [-0.02, 0.02, 0.0]]])  # of the upper sheet alone
    band = edge_band(vertices, np.concatenate((faces, faces + 41 * 41)), border, 4e-3)
    assert band[: 41 * 41].sum() == 5 * 41
    assert not band[41 * 41 :].any()
