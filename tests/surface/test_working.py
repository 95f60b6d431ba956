"""The finely divided working surface is the same surface."""

from __future__ import annotations

import numpy as np
import pytest
from surface.shapes import angle_deg, dome_centre, mould

from burnish.errors import MouldError
from burnish.surface import Mould, WorkingSurface, bundled, refine
from burnish.surface.winding import Edges, face_vectors


@pytest.mark.parametrize("name", bundled.NAMES)
@pytest.mark.parametrize("edge", [1.3e-3, 0.8e-3])
def test_refining_keeps_the_area_and_shortens_every_side(name: str, edge: float) -> None:
    vertices, faces = refine(mould(name), edge)
    sides = np.linalg.norm(vertices[faces] - vertices[np.roll(faces, 1, axis=1)], axis=2)
    part = mould(name)
    before = face_vectors(part.vertices, part.faces)
    size = np.linalg.norm(before, axis=1)
    up = before[:, 2] > np.cos(np.deg2rad(80)) * size
    assert sides.max() <= edge
    assert np.linalg.norm(face_vectors(vertices, faces), axis=1).sum() == pytest.approx(size[up].sum(), rel=1e-9)


@pytest.mark.parametrize("name", bundled.NAMES)
def test_refining_opens_no_gaps(name: str) -> None:
    coarse, fine = refine(mould(name), 1.0)[1], refine(mould(name), 0.9e-3)[1]
    assert Edges(fine).agree.all()
    holes = {"mould": 1}.get(name, 0)
    vertices = len(np.unique(fine))
    edges = len(Edges(fine).inner) + len(Edges(fine).border)
    assert vertices - edges + len(fine) == 1 - holes  # Euler: a disc, or a disc with a hole
    assert len(fine) > len(coarse)


def test_vertex_areas_add_up_to_the_plate() -> None:
    surface = WorkingSurface.of(mould("plate"), 5e-3)
    assert surface.areas.sum() == pytest.approx(0.04)
    assert surface.areas.min() > 0


def test_vertex_normals_of_the_dome_point_away_from_its_centre() -> None:
    surface = WorkingSurface.of(mould("dome"), 1.3e-3)
    inner = np.abs(surface.vertices[:, :2]).max(axis=1) < 0.049
    assert angle_deg(surface.normals, surface.vertices - dome_centre())[inner].max() < 0.3


@pytest.mark.parametrize("edge", [1e-5, 0.0, float("nan")])
def test_sides_too_short_for_the_mould_are_refused(edge: float) -> None:
    with pytest.raises(MouldError, match="use longer sides"):
        refine(mould("plate"), edge)


def test_part_of_steep_walls_has_nothing_to_work() -> None:
    wedge = np.array([[[0.0, 0, 0], [0.1, 0, 0], [0.1, 0.005, 0.1]]])
    with pytest.raises(MouldError, match="flatter than 80°"):
        refine(Mould.of("wedge", wedge), 1e-3)
