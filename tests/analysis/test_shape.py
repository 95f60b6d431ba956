from __future__ import annotations

import numpy as np
import pytest
import trimesh

from burnish.analysis import Shape, thin, tube
from burnish.errors import InputError


def shape(mesh):
    return Shape(name="m", vertices=mesh.vertices, faces=mesh.faces, colour=np.array([0.5, 0.5, 0.5]))


def test_normals_of_a_ball_point_away_from_its_centre(ball):
    sphere = ball(1.0, fineness=4)
    # The mean normal of a polyhedron is off by about the square of its edge, here 0.07.
    assert np.abs(sphere.corner_normals - sphere.corners).max() < 0.07**2 * 1.2


def test_a_box_keeps_its_edges():
    box = shape(trimesh.creation.box((1, 2, 3)))
    u, v = box.corners[:, 1] - box.corners[:, 0], box.corners[:, 2] - box.corners[:, 0]
    flat = np.cross(u, v) / np.linalg.norm(np.cross(u, v), axis=1, keepdims=True)
    assert np.allclose(box.corner_normals, flat[:, None], atol=1e-12)


def test_a_mesh_whose_faces_share_no_vertex_is_as_smooth_as_one_whose_do(ball):
    whole = ball(0.3)
    torn = Shape(
        name="torn",
        vertices=whole.corners.reshape(-1, 3),
        faces=np.arange(3 * len(whole.faces)).reshape(-1, 3),
        colour=whole.colour,
    )
    assert np.allclose(torn.corner_normals, whole.corner_normals, atol=1e-12)


def test_a_face_without_area_has_a_unit_normal_all_the_same():
    line = Shape(name="line", vertices=np.eye(3) * 0.0, faces=np.array([[0, 1, 2]]), colour=np.zeros(3))
    assert np.allclose(np.linalg.norm(line.corner_normals, axis=-1), 1.0)


def test_every_point_of_a_tube_is_a_radius_from_its_line():
    s = np.linspace(0.0, 6.0, 400)
    helix = np.stack([np.cos(s), np.sin(s), 0.2 * s], axis=1)
    ring = tube(helix, 0.01, (0, 0, 0), "t").vertices.reshape(400, -1, 3)
    assert np.allclose(np.linalg.norm(ring - helix[:, None], axis=2), 0.01, atol=1e-12)
    inner = np.einsum("nkd,nd->nk", ring - helix[:, None], np.gradient(helix, axis=0))
    assert np.abs(inner).max() < 1e-12


def test_the_section_of_a_tube_does_not_spin():
    s = np.linspace(0.0, 6.0, 400)
    line = np.stack([np.cos(s), np.sin(s), np.sin(3 * s)], axis=1)
    ring = tube(line, 0.01, (0, 0, 0), "t").vertices.reshape(400, -1, 3) - line[:, None]
    tangent = np.gradient(line, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    turn = np.linalg.norm(np.diff(tangent, axis=0), axis=1)
    # Carried along without spin, a vector across the line turns at most as far as the line.
    assert (np.linalg.norm(np.diff(ring, axis=0), axis=2) <= 0.01 * turn[:, None] * (1.0 + 1e-3)).all()


def test_a_tube_goes_round_a_full_reversal():
    there = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 0.001, 0], [1, 0.001, 0], [0, 0.001, 0]], dtype=float)
    assert np.isfinite(tube(there, 0.01, (0, 0, 0), "t").vertices).all()
    back = np.array([[0, 0, 0], [1, 0, 0], [0, 0, 0]], dtype=float)
    assert np.isfinite(tube(back, 0.01, (0, 0, 0), "t").vertices).all()


@pytest.mark.parametrize("points", [np.zeros((0, 3)), np.zeros((1, 3)), np.zeros((5, 3))])
def test_a_line_that_goes_nowhere_has_no_tube(points):
    assert len(tube(points, 0.01, (0, 0, 0), "t").faces) == 0


def test_thin_keeps_the_ends_and_stays_on_the_line():
    line = np.stack([np.linspace(0.0, 1.0, 1001), np.zeros(1001), np.zeros(1001)], axis=1)
    few = thin(line, 0.1)
    assert len(few) == 11
    assert np.array_equal(few[[0, -1]], line[[0, -1]])
    assert np.diff(few[:, 0]).max() < 0.2


@pytest.mark.parametrize(
    "wrong",
    [
        {"faces": np.array([[0, 1, 3]])},
        {"vertices": np.full((3, 3), np.nan)},
        {"colour": np.zeros((2, 3))},
    ],
)
def test_a_shape_that_cannot_be_drawn_is_refused(wrong):
    good = {"name": "m", "vertices": np.eye(3), "faces": np.array([[0, 1, 2]]), "colour": np.zeros(3)}
    with pytest.raises(InputError, match="'m'"):
        Shape(**{**good, **wrong})
