"""The bundled moulds have the shapes that they claim."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest
import trimesh
from surface.shapes import dome_centre, grid, mould

from burnish.surface import Border, Mould, bundled, top
from burnish.surface.winding import face_vectors

ROOT = Path(__file__).parents[2]
SIZES = {"plate": (200, 200, 20), "dome": (100, 100, 27.712), "wave": (120, 80, 17), "mould": (120, 80, 24.481)}


def points_on_top(part: Mould, count: int) -> np.ndarray:
    """Random points on the faces that face up."""
    rng = np.random.default_rng(5)
    up = np.flatnonzero(face_vectors(part.vertices, part.faces)[:, 2] > 0)
    share = rng.dirichlet((1, 1, 1), count)
    return np.einsum("nc,nci->ni", share, part.vertices[part.faces[rng.choice(up, count)]])


@pytest.mark.parametrize("name", bundled.NAMES)
def test_bundled_mould_is_watertight_and_of_its_size(name: str) -> None:
    part = mould(name)
    mesh = trimesh.Trimesh(part.vertices, part.faces, process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume > 0
    np.testing.assert_allclose(1e3 * np.ptp(part.vertices, axis=0), SIZES[name], atol=1e-3)


def test_facets_of_the_dome_keep_within_5_um_of_the_sphere() -> None:
    radius = np.linalg.norm(points_on_top(mould("dome"), 50_000) - dome_centre(), axis=1)
    assert np.abs(radius - bundled.DOME_RADIUS).max() < 5e-6


def test_facets_of_the_wave_keep_within_5_um_of_the_wave() -> None:
    points = points_on_top(mould("wave"), 50_000)
    assert np.abs(points[:, 2] - bundled.wave_height(points[:, 0], points[:, 1])).max() < 5e-6


def test_wave_swings_2_mm_over_60_mm() -> None:
    x = np.linspace(-0.06, 0.06, 5)
    height = bundled.wave_height(x, x)
    np.testing.assert_allclose(height - bundled.WAVE_SKIRT, 2e-3 * np.array([1, -1, 1, -1, 1]), atol=1e-12)


def test_script_writes_the_committed_mould_again(tmp_path: Path) -> None:
    script = runpy.run_path(str(ROOT / "scripts" / "make_mould.py"))
    script["write_stl"](tmp_path / "mould.stl", script["mould"]())
    assert (tmp_path / "mould.stl").read_bytes() == script["ASSET"].read_bytes()


def test_mould_has_a_hole_right_through() -> None:
    x, y = bundled_features()["HOLE_CENTRE"]
    assert np.isnan(top(grid("mould"), 1e-3 * np.array([[x, y], [x + 6, y], [x, y - 6]]))).all()
    assert trimesh.Trimesh(mould("mould").vertices, mould("mould").faces).euler_number == 0  # a ring, not a ball


def test_mould_has_a_pocket_of_its_depth() -> None:
    features = bundled_features()
    centre = np.array([features["POCKET_CENTRE"]])
    free = features["free_form"](centre[:, 0], centre[:, 1])
    np.testing.assert_allclose(
        1e3 * top(grid("mould"), 1e-3 * centre)[:, 2], free - features["POCKET_DEPTH"], atol=0.02
    )


def test_rims_and_edges_of_the_mould_are_borders_and_the_fillet_is_none() -> None:
    features = bundled_features()
    border = Border.of(mould("mould"), np.deg2rad(40))
    (x, y), radius = features["HOLE_CENTRE"], features["HOLE_RADIUS"]
    pocket = np.array(features["POCKET_CENTRE"]) + [features["POCKET_HALF"][0], 0]
    at_edges = 1e-3 * np.array([[x + radius, y], pocket, [60, 0], [-60, 10], [0, 40]])
    np.testing.assert_allclose(border.distance(at_edges), 0, atol=5e-5)
    along_the_fillet = 1e-3 * np.array([[0, -40], [20, -36], [-20, -30]])
    assert (border.distance(along_the_fillet) > 15e-3).all()


def bundled_features() -> dict[str, object]:
    return runpy.run_path(str(ROOT / "scripts" / "make_mould.py"))
