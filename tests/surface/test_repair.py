"""Faulty meshes are mended to the sound one, with a sentence, or refused."""

from __future__ import annotations

import numpy as np
import pytest
from surface.shapes import box, sheet, tray

from burnish.errors import MouldError
from burnish.surface import Mould
from burnish.surface.winding import Edges, face_vectors

X = np.linspace(-0.03, 0.03, 61)
PART = tray(X, X, 0.02 - 2.0 * (X[:, None] ** 2 + X[None, :] ** 2))


def volume(part: Mould) -> float:
    corners = part.vertices[part.faces]
    return float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6)


def is_whole(part: Mould) -> bool:
    edges = Edges(part.faces)
    return edges.closed and bool(edges.agree.all())


SOUND = volume(Mould.of("part", PART))


def test_sound_mesh_stays_as_it_is_without_a_word() -> None:
    part = Mould.of("part", PART)
    assert part.warnings == ()
    assert len(part.faces) == len(PART)


def test_corners_a_micrometre_apart_are_joined() -> None:
    loose = PART + np.random.default_rng(0).uniform(-0.5e-6, 0.5e-6, PART.shape)
    part = Mould.of("part", loose)
    assert is_whole(part)
    assert len(part.vertices) == len(Mould.of("part", PART).vertices)
    assert "were joined" in part.warnings[0]


def test_corners_are_joined_to_one_within_three_micrometres_and_not_in_chains() -> None:
    x = np.r_[-0.03, np.arange(-20, 21) * 2e-6, 0.03]  # a rim of points 2 µm apart
    part = Mould.of("sheet", sheet(x, np.array([-0.03, 0.03]), np.full((len(x), 2), 0.01)))
    moved = np.abs(np.sort(part.vertices[np.abs(part.vertices[:, 0]) < 1e-4][:, 0])[[0, -1]])
    np.testing.assert_allclose(moved, 40e-6, atol=4e-6)


def test_heap_of_triangles_that_hang_on_nothing_is_refused() -> None:
    with pytest.raises(MouldError, match="hang on nothing"):
        Mould.of("part", PART + np.random.default_rng(0).uniform(-20e-6, 20e-6, PART.shape))


def test_line_between_two_triangles_is_left_out_and_its_seam_closed() -> None:
    a, b, c = PART[100]
    middle = (a + b) / 2
    split = np.concatenate((PART[:100], PART[101:], [[a, middle, c], [middle, b, c], [a, b, middle]]))
    part = Mould.of("part", split)
    assert is_whole(part)
    assert volume(part) == pytest.approx(SOUND, rel=1e-9)
    assert "1 triangles without an area" in part.warnings[0]


def test_sliver_of_ten_micrometres_stays() -> None:
    a, b, c = PART[100]
    p = (a + b) / 2 + 10e-6 * (c - (a + b) / 2) / np.linalg.norm(c - (a + b) / 2)
    part = Mould.of("part", np.concatenate((PART[:100], PART[101:], [[a, b, p], [b, c, p], [c, a, p]])))
    assert len(part.faces) == len(PART) + 2
    assert part.warnings == ()


def test_edge_is_cut_at_the_corners_that_lie_on_it() -> None:
    fine, coarse = np.linspace(0.0, 0.03, 31), np.array([-0.03, 0.0])
    y = np.linspace(-0.03, 0.03, 5)
    left = sheet(coarse, np.array([-0.03, 0.03]), np.full((2, 2), 0.01))
    right = sheet(fine, y, np.full((31, 5), 0.01))
    part = Mould.of("two sheets", np.concatenate((left, right)))
    border = part.vertices[Edges(part.faces).border]
    assert not np.any(np.all(np.abs(border[:, :, 0]) < 1e-9, axis=1))  # none on the seam
    assert "3 corners that lay on an edge" in part.warnings[0]
    assert (face_vectors(part.vertices, part.faces)[:, 2] > 0).all()


@pytest.mark.parametrize("reverse", [False, True])
def test_triangle_that_is_there_twice_is_left_out(reverse: bool) -> None:
    if reverse:
        part = Mould.of("part", np.concatenate((PART, PART[:, ::-1])))  # all of them, as seen from both sides
    else:
        part = Mould.of("part", np.concatenate((PART, PART[:50, [1, 2, 0]])))
    assert len(part.faces) == len(PART)
    assert volume(part) == pytest.approx(SOUND)
    assert "twice" in part.warnings[0]


def test_wall_between_two_parts_that_were_put_together_goes() -> None:
    x = np.linspace(-0.03, 0.0, 4)
    flat = np.full((4, 4), 0.02)
    left = tray(x, np.linspace(-0.02, 0.02, 4), flat) + [0.0, 0.0, 0.0]
    half = np.concatenate((left, (left * [-1.0, 1.0, 1.0])[:, ::-1]))
    part = Mould.of("both", half)
    assert volume(part) == pytest.approx(0.06 * 0.04 * 0.02)
    assert "back to back" in " ".join(part.warnings)


def test_missing_triangle_is_put_back() -> None:
    part = Mould.of("part", np.delete(PART, 900, axis=0))
    assert is_whole(part)
    assert volume(part) == pytest.approx(SOUND, rel=1e-6)
    assert "1 openings of up to 1.4 mm were closed" in part.warnings[0]


def test_opening_wider_than_two_millimetres_stays_open() -> None:
    wide = tray(X[::6], X[::6], np.full((11, 11), 0.02))
    part = Mould.of("part", np.delete(wide, 60, axis=0))
    assert len(Edges(part.faces).border) == 3


def test_opening_of_many_corners_is_closed_from_its_middle() -> None:
    x = np.linspace(-0.01, 0.01, 41)
    corners = tray(x, x, np.full((41, 41), 0.01))
    middle = corners.mean(axis=1)
    gone = (np.linalg.norm(middle[:, :2] - [2e-3, 1e-3], axis=1) < 0.6e-3) & (middle[:, 2] > 9e-3)
    assert gone.sum() > 4
    part = Mould.of("part", corners[~gone])
    assert is_whole(part)
    assert volume(part) == pytest.approx(0.02 * 0.02 * 0.01, rel=1e-9)


def test_crowded_corners_are_refused_at_once() -> None:
    rng = np.random.default_rng(0)
    crowd = np.concatenate((box(0.05, 0.05, 0.02), 0.01 + rng.uniform(-1e-6, 1e-6, (20_000, 3, 3))))
    with pytest.raises(MouldError, match="crowd"):
        Mould.of("part", crowd)
