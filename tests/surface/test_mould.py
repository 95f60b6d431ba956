"""What a mould is: its frame, its fingerprint, its sides, and what is none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from surface.shapes import binary_stl, box, mould, sheet

from burnish.errors import MouldError
from burnish.surface import Mould
from burnish.surface.bundled import NAMES
from burnish.surface.winding import face_vectors

PART = box(0.12, 0.08, 0.03)
FLAT = np.array([[0.02, 0.02], [0.02, 0.02]])


def volume(part: Mould) -> float:
    corners = part.vertices[part.faces]
    return float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6)


@pytest.mark.parametrize("name", NAMES)
def test_frame_stands_on_its_lowest_point_under_the_middle(name: str) -> None:
    low, high = mould(name).vertices.min(axis=0), mould(name).vertices.max(axis=0)
    np.testing.assert_allclose(low[:2], -high[:2], atol=1e-9)
    assert low[2] == 0.0


def test_part_that_lies_elsewhere_is_the_same_mould() -> None:
    moved = Mould.of("part", PART + [0.3, -0.2, 0.1])
    assert moved.sha256 == Mould.of("part", PART).sha256


def test_fingerprint_tells_shapes_apart_by_a_micrometre() -> None:
    bent = PART.copy()
    bent[bent[:, :, 2] > 0.02] += [0.0, 0.0, 1e-6]
    assert Mould.of("part", bent).sha256 != Mould.of("part", PART).sha256


def test_triangles_share_their_corners() -> None:
    assert len(Mould.of("part", PART).vertices) == 9  # eight, and the middle of the base


def test_bundled_name_wins_over_a_file_and_a_path_does_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "dome").write_bytes(binary_stl(PART * 1e3))
    monkeypatch.chdir(tmp_path)
    assert Mould.load("dome").sha256 == mould("dome").sha256
    assert Mould.load("./dome").sha256 == Mould.of("dome", PART).sha256


def test_file_gives_the_mould_its_name(tmp_path: Path) -> None:
    (tmp_path / "left wing.stl").write_bytes(binary_stl(PART * 1e3))
    assert Mould.load(str(tmp_path / "left wing.stl")).name == "left wing"


@pytest.mark.parametrize("name", ["dom", ""])
def test_unknown_name_is_answered_with_the_known_ones(name: str) -> None:
    with pytest.raises(MouldError, match="plate, dome, wave, mould"):
        Mould.load(name)


@pytest.mark.parametrize("unit", ["m", "inch"])
def test_size_out_of_range_hints_at_the_unit(tmp_path: Path, unit: str) -> None:
    (tmp_path / "part.stl").write_bytes(binary_stl(PART * 1e3))
    with pytest.raises(MouldError, match=r"measures .* mm; .* check the unit"):
        Mould.load(str(tmp_path / "part.stl"), unit)


def test_part_in_metres_read_as_millimetres_is_refused_as_too_small(tmp_path: Path) -> None:
    (tmp_path / "part.stl").write_bytes(binary_stl(PART))
    with pytest.raises(MouldError, match="check the unit"):
        Mould.load(str(tmp_path / "part.stl"), "mm")


def test_triangles_without_area_are_refused() -> None:
    line = np.array([[[0, 0, 0], [0.05, 0, 0], [0.1, 0, 0]]] * 3, dtype=float)
    with pytest.raises(MouldError, match="no area"):
        Mould.of("line", line)


def test_triangles_that_are_points_are_refused() -> None:
    points = np.repeat(np.array([[[0.0, 0, 0]], [[0.1, 0, 0]], [[0, 0.1, 0]]]), 3, axis=1)
    with pytest.raises(MouldError, match="no area"):
        Mould.of("points", points)


@pytest.mark.parametrize(
    "corners",
    [
        pytest.param(sheet(np.array([0, 0.1]), np.array([0, 0.1]), FLAT)[:, ::-1], id="faces down"),
        pytest.param(np.array([[[0, 0, 0], [0.1, 0, 0], [0.1, 0, 0.1]]]), id="stands upright"),
    ],
)
def test_surface_with_nothing_that_faces_up_is_refused(corners: np.ndarray) -> None:
    with pytest.raises(MouldError, match="nothing that faces up"):
        Mould.of("part", corners)


def test_inside_out_solid_is_turned_round() -> None:
    assert volume(Mould.of("part", PART[:, ::-1])) == pytest.approx(0.12 * 0.08 * 0.03)


def test_triangles_that_disagree_are_turned_round() -> None:
    rng = np.random.default_rng(3)
    twisted = np.where(rng.random(len(PART))[:, None, None] < 0.5, PART[:, ::-1], PART)
    assert volume(Mould.of("part", twisted)) == pytest.approx(0.12 * 0.08 * 0.03)


def test_open_sheet_that_disagrees_is_turned_up() -> None:
    x = np.linspace(0, 0.1, 6)
    corners = sheet(x, x, np.full((6, 6), 0.02))
    corners[::3] = corners[::3, ::-1]
    part = Mould.of("sheet", corners)
    assert (face_vectors(part.vertices, part.faces)[:, 2] > 0).all()


def test_open_solid_keeps_its_outside() -> None:
    without_base = PART[:-4]
    part = Mould.of("cover", without_base)
    np.testing.assert_allclose(part.vertices[part.faces], without_base, atol=1e-12)


def test_surface_with_one_side_is_refused() -> None:
    angle = np.linspace(0, 2 * np.pi, 25)
    half = np.stack((np.cos(angle / 2) * np.cos(angle), np.cos(angle / 2) * np.sin(angle), np.sin(angle / 2)), axis=1)
    middle = np.stack((np.cos(angle), np.sin(angle), 0 * angle), axis=1)
    a, b = 0.05 * middle - 0.01 * half, 0.05 * middle + 0.01 * half
    a[-1], b[-1] = b[0], a[0]
    band = np.concatenate((np.stack((a[:-1], a[1:], b[:-1]), axis=1), np.stack((b[:-1], a[1:], b[1:]), axis=1)))
    with pytest.raises(MouldError, match="only one side"):
        Mould.of("band", band)


def test_geometry_cannot_be_written_to() -> None:
    part = Mould.of("part", PART)
    with pytest.raises(ValueError, match="read-only"):
        part.vertices[0, 0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        part.faces[0, 0] = 1
