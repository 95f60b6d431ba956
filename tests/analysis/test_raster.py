from __future__ import annotations

import numpy as np
import pytest

from burnish.analysis.raster import NOTHING, barycentric, rasterise


def square(x0, y0, x1, y1, near):
    corners = np.array([[[x0, y0], [x1, y0], [x1, y1]], [[x0, y0], [x1, y1], [x0, y1]]], dtype=float)
    return corners, np.full((2, 3), float(near))


def test_a_square_covers_exactly_the_pixels_whose_centres_it_holds():
    raster = rasterise(*square(2, 1, 7, 4, 1), 10, 6)
    expected = np.zeros((6, 10), dtype=bool)
    expected[1:4, 2:7] = True
    assert np.array_equal(raster.face != NOTHING, expected)


def test_every_pixel_agrees_with_the_half_planes_of_a_random_triangle(rng):
    width, height = 40, 30
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    for _ in range(200):
        corners = rng.uniform(-10.0, 50.0, (1, 3, 2))
        raster = rasterise(corners, np.ones((1, 3)), width, height)
        weights = barycentric(np.repeat(corners, x.size, 0), np.stack([x.ravel(), y.ravel()], 1))
        inside = (weights > 0.0).all(axis=1).reshape(height, width)
        # Only a centre within rounding of an edge may go either way; random corners have none.
        assert np.array_equal(raster.face[..., :] == 0, inside)


def test_both_senses_of_rotation_are_drawn():
    corners, near = square(2, 1, 7, 4, 1)
    forwards, backwards = (rasterise(c, near, 10, 6).face != NOTHING for c in (corners, corners[:, ::-1]))
    assert np.array_equal(forwards, backwards)


def test_triangles_that_share_an_edge_leave_no_crack(rng):
    # A fan around an inner point covers its square completely, wherever the point is.
    for _ in range(50):
        middle = rng.uniform(5.0, 25.0, 2)
        ring = np.array([[0, 0], [30, 0], [30, 30], [0, 30]], dtype=float)
        corners = np.stack([np.stack([middle, ring[i], ring[(i + 1) % 4]]) for i in range(4)])
        assert (rasterise(corners, np.ones((4, 3)), 30, 30).face != NOTHING).all()


@pytest.mark.parametrize("order", [[0, 1], [1, 0]])
def test_the_nearer_of_two_faces_wins_whatever_their_order(order):
    far, near = square(0, 0, 10, 10, 1.0), square(3, 3, 6, 6, 2.0)
    parts = [(far, near)[i] for i in order]
    corners, nearness = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
    raster = rasterise(corners, nearness, 10, 10)
    assert np.array_equal(raster.nearness == 2.0, np.pad(np.ones((3, 3), bool), ((3, 4), (3, 4))))
    assert (raster.nearness >= 1.0).all()


def test_two_crossing_planes_hide_each_other_along_their_line_of_intersection():
    corners, _ = square(0, 0, 20, 20, 0)
    # One plane rises to the right, the other falls: they meet in the column x = 10.
    rising = corners[..., 0] / 20.0
    raster = rasterise(np.concatenate([corners, corners]), np.concatenate([rising, 1.0 - rising]), 20, 20)
    assert (raster.face[:, 10:] < 2).all()
    assert (raster.face[:, :10] >= 2).all()


def test_nearness_is_interpolated_at_the_pixel_centre():
    corners, _ = square(0, 0, 8, 8, 0)
    raster = rasterise(corners, corners @ np.array([0.5, 0.25]), 8, 8)
    x, y = np.meshgrid(np.arange(8) + 0.5, np.arange(8) + 0.5)
    # Affine in the screen; 1e-12 is rounding.
    assert np.allclose(raster.nearness, 0.5 * x + 0.25 * y, atol=1e-12)


def test_faces_outside_flat_or_not_finite_draw_nothing():
    corners, _ = square(2, 1, 7, 4, 1)
    flat = np.array([[[0.0, 0.0], [5.0, 5.0], [9.0, 9.0]]])
    behind = np.array([[[0.0, 0.0], [np.nan, 5.0], [9.0, 0.0]]])
    heap = np.concatenate([corners + 100.0, flat, behind])
    assert (rasterise(heap, np.ones((4, 3)), 10, 6).face == NOTHING).all()
    assert (rasterise(np.zeros((0, 3, 2)), np.zeros((0, 3)), 10, 6).face == NOTHING).all()


def test_a_picture_larger_than_one_group_of_work_is_complete(monkeypatch, rng):
    corners, near = rng.uniform(0.0, 60.0, (300, 3, 2)), rng.uniform(0.0, 1.0, (300, 3))
    whole = rasterise(corners, near, 60, 60)
    monkeypatch.setattr("burnish.analysis.raster.FRAGMENTS_AT_ONCE", 500)
    assert np.array_equal(rasterise(corners, near, 60, 60).face, whole.face)
