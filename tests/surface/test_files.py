"""OBJ, PLY and 3MF files become the triangles of an STL file, or one sentence that says why not."""

from __future__ import annotations

import struct
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from surface.mesh_files import CORE, model, obj, ply, ply_head, shared, threemf, zipped
from surface.shapes import binary_stl, box

from burnish.errors import MouldError
from burnish.surface import Mould, read_mesh
from burnish.surface.polygons import MAX_FACES

PART = box(120.0, 80.0, 30.0)  # millimetres, as files have it

FORMS: dict[str, Callable[[np.ndarray], bytes]] = {
    "a.obj": obj,
    "a.ply": ply,
    "b.ply": lambda corners: ply(corners, "binary_little_endian"),
    "c.PLY": lambda corners: ply(corners, "binary_big_endian"),
    "a.3mf": threemf,
}


def read(folder: Path, name: str, content: bytes, unit: str | None = None) -> np.ndarray:
    (folder / name).write_bytes(content)
    return read_mesh(folder / name, unit)[0]


def refused(folder: Path, name: str, content: bytes) -> str:
    with pytest.raises(MouldError) as refusal:
        read(folder, name, content)
    assert "\n" not in str(refusal.value)
    return str(refusal.value)


@pytest.mark.parametrize("name", FORMS)
def test_every_form_of_a_part_is_the_same_mould(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(FORMS[name](PART))
    np.testing.assert_allclose(read_mesh(tmp_path / name)[0], PART * 1e-3, rtol=0, atol=1e-9)
    assert Mould.load(str(tmp_path / name)).sha256 == Mould.of("part", PART * 1e-3).sha256


def test_numbers_of_an_obj_may_count_back(tmp_path: Path) -> None:
    vertices, faces = shared(PART)
    lines = ["v {} {} {}".format(*v) for v in vertices]
    lines += ["f " + " ".join(str(i - len(vertices)) for i in face) for face in faces]
    np.testing.assert_allclose(read(tmp_path, "a.obj", "\n".join(lines).encode()), PART * 1e-3, atol=1e-12)


QUAD = "v 0 0 0\nv 90 0 0\nv 90 60 0\nv 0 60 0\n"


def test_convex_polygon_becomes_triangles_that_cover_it(tmp_path: Path) -> None:
    corners = read(tmp_path, "a.obj", (QUAD + "f 1 2 3 4\n").encode())
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2
    assert area == pytest.approx(0.09 * 0.06)


def test_polygon_that_is_not_convex_is_refused_because_its_fan_would_overlap(tmp_path: Path) -> None:
    arrow = "v 0 0 0\nv 90 0 0\nv 90 60 0\nv 80 10 0\n"
    assert "not convex" in refused(tmp_path, "a.obj", f"{arrow}f 1 2 3 4\n".encode())
    assert len(read(tmp_path, "a.obj", f"{arrow}f 2 3 4 1\n".encode())) == 2  # from a corner that sees all of it


def test_binary_ply_may_mix_triangles_and_quads(tmp_path: Path) -> None:
    vertices = [[0, 0, 0], [90, 0, 0], [90, 60, 0], [0, 60, 0], [120, 0, 0]]
    body = b"".join(struct.pack("<3dB", *v, 0) for v in vertices)
    body += struct.pack("<B4i", 4, 0, 1, 2, 3) + struct.pack("<B3i", 3, 1, 4, 2)
    assert read(tmp_path, "a.ply", ply_head("binary_little_endian", 5, 2) + body).shape == (3, 3, 3)


def test_3mf_names_its_unit_and_a_different_one_that_is_asked_for_is_answered(tmp_path: Path) -> None:
    (tmp_path / "a.3mf").write_bytes(zipped(model(PART / 25.4, "inch")))
    corners, said = read_mesh(tmp_path / "a.3mf", "m")
    np.testing.assert_allclose(corners, PART * 1e-3, atol=1e-9)
    assert "names its own unit" in said[0]
    assert read_mesh(tmp_path / "a.3mf")[1] == ()


def test_3mf_places_its_components(tmp_path: Path) -> None:
    pair = (
        '<object id="7"><components><component objectid="1"/>'
        '<component objectid="1" transform="-1 0 0 0 1 0 0 0 1 300 0 0"/></components></object>'
    )
    text = model(PART, build='<item objectid="7" transform="1 0 0 0 1 0 0 0 1 0 0 50"/>', more=pair)
    corners = read(tmp_path, "a.3mf", zipped(text))
    mirrored = (PART * [-1, 1, 1] + [300, 0, 0])[:, ::-1]  # and still with its outside out
    np.testing.assert_allclose(corners, (np.concatenate((PART, mirrored)) + [0, 0, 50]) * 1e-3, atol=1e-9)


def test_3mf_may_keep_its_objects_in_parts_of_their_own(tmp_path: Path) -> None:
    text = (
        f'<model xmlns="{CORE}" xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06"><resources>'
        '<object id="2"><components><component p:path="/3D/Objects/one.model" objectid="1"/></components></object>'
        '</resources><build><item objectid="2"/></build></model>'
    )
    packed = zipped(text, one=model(PART, build=""))
    np.testing.assert_allclose(read(tmp_path, "a.3mf", packed), PART * 1e-3, atol=1e-9)


def nested(levels: int) -> str:
    """Every object ten times the one before."""
    more = "".join(
        f'<object id="{n}"><components>{f"<component objectid={chr(34)}{n - 1}{chr(34)}/>" * 10}</components></object>'
        for n in range(2, levels + 2)
    )
    return model(PART, build=f'<item objectid="{levels + 1}"/>', more=more)


LOOP = '<object id="2"><components><component objectid="2"/></components></object>'
BOMB = (
    '<?xml version="1.0"?><!DOCTYPE m [<!ENTITY a "aaaa">'
    + "".join(f'<!ENTITY {chr(98 + i)} "{f"&{chr(97 + i)};" * 10}">' for i in range(9))
    + "]><model>&j;</model>"
)
BAD: dict[str, tuple[str, bytes, str]] = {
    "zip bomb": ("a.3mf", zipped(b" " * 30_000_000), "trap"),
    "entity bomb": ("a.3mf", zipped(BOMB), "DOCTYPE"),
    "component bomb": ("a.3mf", zipped(nested(9)), f"at most {MAX_FACES}"),
    "component of itself": ("a.3mf", zipped(model(PART, build='<item objectid="2"/>', more=LOOP)), "in themselves"),
    "deep components": ("a.3mf", zipped(nested(30).replace('<component objectid="1"/>' * 10, "")), "in themselves"),
    "missing object": ("a.3mf", zipped(model(PART, build='<item objectid="9"/>')), "not in it"),
    "nothing built": ("a.3mf", zipped(model(PART, build="")), "no triangles"),
    "unknown unit": ("a.3mf", zipped(model(PART, "cubit")), "unit 'cubit'"),
    "no model": ("a.3mf", zipped("hello", name="readme.txt"), "holds no model"),
    "no zip": ("a.3mf", b"PK\x03\x04" + bytes(50), "not a 3MF file"),
    "no XML": ("a.3mf", zipped("<model><build>"), "no XML"),
    "vertex without x": ("a.3mf", zipped(model(PART).replace(" x=", " w=", 1)), "no 'x'"),
    "infinite vertex": ("a.3mf", zipped(model(PART).replace('x="60.0"', 'x="inf"')), "not a finite number"),
    "corner beyond": ("a.3mf", zipped(model(PART).replace('v1="0"', 'v1="99"')), "beyond its 9 vertices"),
    "obj of prose": ("a.obj", b"This is the manual of the machine.", "no lines 'v' and 'f'"),
    "obj with a word": ("a.obj", obj(PART).replace(b"v -60.0", b"v minus", 1), "word for a number"),
    "obj with corner 0": ("a.obj", QUAD.encode() + b"f 0 1 2\n", "corner 0"),
    "obj with corner beyond": ("a.obj", QUAD.encode() + b"f 1 2 9\n", "beyond its 4 vertices"),
    "obj not a number": ("a.obj", obj(PART).replace(b"v -60.0", b"v nan", 1), "not a finite number"),
    "obj with a line for a face": ("a.obj", QUAD.encode() + b"f 1 2\n", "polygon with 2 corners"),
    "ply of prose": ("a.ply", b"This is the manual of the machine.", "no header"),
    "ply with a billion vertices": ("a.ply", ply_head("ascii", 10**9, 1), "rows of 'vertex'"),
    "ply cut off": ("a.ply", ply(PART, "binary_big_endian")[:-5], "cut off"),
    "ply text cut off": ("a.ply", ply(PART)[:-9], "cut off"),
    "ply with a word": ("a.ply", ply(PART).replace(b"\n3 ", b"\nthree ", 1), "word for a number"),
    "ply with half a corner": ("a.ply", ply(PART).replace(b"\n3 0", b"\n3 0.5", 1), "no whole number"),
    "ply with a negative list": ("a.ply", ply(PART).replace(b"\n3 ", b"\n-3 ", 1), "list has -3"),
    "ply without faces": ("a.ply", ply_head("ascii", 0, 0), "no triangles"),
    "exact surfaces": ("a.step", b"ISO-10303-21;", "export the part as 3MF"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_file_is_refused_in_one_sentence(tmp_path: Path, case: str) -> None:
    name, content, reason = BAD[case]
    assert reason in refused(tmp_path, name, content)


def test_zip_bomb_is_refused_before_it_unpacks(tmp_path: Path) -> None:
    content = zipped(b" " * 30_000_000)
    tracemalloc.start()
    try:
        refused(tmp_path, "a.3mf", content)
        assert tracemalloc.get_traced_memory()[1] < 10e6
    finally:
        tracemalloc.stop()


def test_archive_that_lies_about_its_size_is_refused(tmp_path: Path) -> None:
    whole = zipped(model(PART))
    size = struct.pack("<I", len(model(PART)))
    assert whole.count(size) >= 2  # beside the file, and in the directory
    assert "3MF" in refused(tmp_path, "a.3mf", whole.replace(size, struct.pack("<I", 100)))


@pytest.mark.parametrize("unit", [None, "mm", "m"])
def test_stl_without_a_unit_is_taken_for_what_fits(tmp_path: Path, unit: str | None) -> None:
    (tmp_path / "a.stl").write_bytes(binary_stl(PART * 1e-3 if unit != "mm" else PART))
    part = Mould.load(str(tmp_path / "a.stl"), unit)
    np.testing.assert_allclose(np.ptp(part.vertices, axis=0), [0.12, 0.08, 0.03], rtol=1e-6)
    assert bool(part.warnings) == (unit is None)
