"""Distances to single triangles, and the samples that find the right one."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree
from trimesh.triangles import closest_point

from burnish.surface.nearest import Nearest, ragged
from burnish.surface.triangles import Triangles

RNG = np.random.default_rng(11)
ANY = RNG.normal(size=(3000, 3, 3))
SLENDER = np.stack((ANY[:, 0], ANY[:, 1], ANY[:, 0] + 0.7 * (ANY[:, 1] - ANY[:, 0]) + 1e-4 * ANY[:, 2]), axis=1)
BLUNT = np.stack((ANY[:, 0], ANY[:, 1], (ANY[:, 0] + ANY[:, 1]) / 2 + 0.05 * ANY[:, 2]), axis=1)


@pytest.mark.parametrize("corners", [ANY, SLENDER, BLUNT], ids=["any", "slender", "blunt"])
def test_distance_to_a_triangle_is_that_of_another_library(corners: np.ndarray) -> None:
    points = RNG.normal(size=(len(corners), 3))
    expected = np.linalg.norm(closest_point(corners, points) - points, axis=1)
    found = Triangles(corners).distance(points, np.arange(len(corners)))
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_distance_of_points_on_a_triangle_is_zero() -> None:
    share = RNG.dirichlet((1, 1, 1), len(ANY))
    points = np.einsum("nc,nci->ni", share, ANY)
    assert Triangles(ANY).distance(points, np.arange(len(ANY))).max() < 1e-12


@pytest.mark.parametrize("corners", [ANY, SLENDER, BLUNT], ids=["any", "slender", "blunt"])
def test_every_place_of_a_triangle_has_a_sample_of_its_own_within_a_spacing(corners: np.ndarray) -> None:
    spacing = 0.05
    for triangle in corners[:40]:
        nearest = Nearest(triangle, np.array([[0, 1, 2]]), spacing)
        places = RNG.dirichlet((1, 1, 1), 500) @ triangle
        assert cKDTree(nearest.samples).query(places)[0].max() < 0.9 * spacing
        assert (
            nearest.triangles.distance(nearest.samples, nearest.owner).max() < 1e-10
        )  # rounding, where the height is 1e-4


def test_ragged_numbers_each_occurrence() -> None:
    item, number = ragged(np.array([2, 0, 3]))
    assert item.tolist() == [0, 0, 2, 2, 2]
    assert number.tolist() == [0, 1, 0, 1, 2]


def test_surface_of_a_large_area_is_sampled_more_coarsely(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("burnish.surface.nearest.MOST_SAMPLES", 10_000)
    nearest = Nearest(ANY.reshape(-1, 3), np.arange(len(ANY) * 3).reshape(-1, 3), 0.01)
    assert nearest.spacing > 0.1
    assert len(ANY) <= len(nearest.samples) < 30_000
