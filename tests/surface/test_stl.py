"""Every file becomes triangles or one sentence."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from surface.shapes import ascii_stl, binary_stl, box

from burnish.errors import MouldError
from burnish.surface import Mould, read_mesh
from burnish.surface.files import MAX_BYTES
from burnish.surface.polygons import MAX_FACES

PART = box(120.0, 80.0, 30.0)  # millimetres, as files have it


def spoilt(value: float) -> bytes:
    corners = PART.copy()
    corners[3, 1, 2] = value
    return binary_stl(corners)


def test_binary_and_ascii_files_of_the_same_part_read_alike(tmp_path: Path) -> None:
    (tmp_path / "b.stl").write_bytes(binary_stl(PART))
    (tmp_path / "a.stl").write_bytes(ascii_stl(PART))
    np.testing.assert_allclose(read_mesh(tmp_path / "a.stl")[0], PART * 1e-3, rtol=0, atol=1e-9)
    np.testing.assert_allclose(read_mesh(tmp_path / "b.stl")[0], PART * 1e-3, rtol=0, atol=1e-9)


def test_binary_file_may_begin_with_the_word_solid(tmp_path: Path) -> None:
    (tmp_path / "b.stl").write_bytes(binary_stl(PART, header=b"solid made by some program"))
    assert read_mesh(tmp_path / "b.stl")[0].shape == PART.shape


def test_ascii_file_may_be_upper_case_with_windows_line_ends(tmp_path: Path) -> None:
    (tmp_path / "a.stl").write_bytes(ascii_stl(PART).upper().replace(b"\n", b"\r\n"))
    np.testing.assert_allclose(read_mesh(tmp_path / "a.stl")[0], PART * 1e-3, rtol=0, atol=1e-9)


@pytest.mark.parametrize(("unit", "metres"), [("mm", 1e-3), ("m", 1.0), ("inch", 0.0254)])
def test_unit_scales_the_numbers_of_the_file(tmp_path: Path, unit: str, metres: float) -> None:
    (tmp_path / "b.stl").write_bytes(binary_stl(PART))
    np.testing.assert_allclose(read_mesh(tmp_path / "b.stl", unit)[0], PART * metres, rtol=1e-7)


BAD_FILES: dict[str, tuple[bytes, str]] = {
    "nothing": (b"", "is empty"),
    "a few bytes": (b"\x01\x02", "is not an STL file"),
    "prose": (b"This is the manual of the machine. " * 9, "is not an STL file"),
    "a picture": (b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 4, "is not an STL file"),
    "solid and nothing else": (b"solid ground is hard to find", "holds no triangle"),
    "header promises too many": (binary_stl(PART, count=len(PART) + 1), "cut off"),
    "header promises too few": (binary_stl(PART, count=len(PART) - 1), "follows the last triangle"),
    "header promises four billion": (binary_stl(PART, count=2**32 - 1), "cut off"),
    "binary cut in a triangle": (binary_stl(PART)[:-7], "cut off"),
    "ascii cut in a triangle": (ascii_stl(PART)[:900], "no 'endsolid'"),
    "ascii cut after a triangle": (ascii_stl(PART).split(b"endsolid")[0], "no 'endsolid'"),
    "ascii without a corner": (ascii_stl(PART).replace(b"vertex", b"vortex", 1), "damaged"),
    "ascii with a word for a number": (ascii_stl(PART).replace(b"vertex 60", b"vertex six", 1), "not three numbers"),
    "no triangles, binary": (binary_stl(np.empty((0, 3, 3))), "no triangles"),
    "no triangles, ascii": (b"solid\nendsolid\n", "no triangles"),
    "not a number": (spoilt(np.nan), "not a finite number"),
    # Its kind that complains when it is converted.
    "signalling not a number": (
        binary_stl(PART)[:96] + b"\x01\x00\x80\x7f" + binary_stl(PART)[100:],
        "not a finite number",
    ),
    "infinite": (spoilt(-np.inf), "not a finite number"),
    "ascii not a number": (ascii_stl(PART).replace(b"vertex 60", b"vertex nan", 1), "not a finite number"),
    "ascii beyond all numbers": (ascii_stl(PART).replace(b"vertex 60", b"vertex 1e999", 1), "not a finite number"),
}


@pytest.mark.parametrize("case", BAD_FILES)
def test_bad_file_is_refused_in_one_sentence(tmp_path: Path, case: str) -> None:
    content, reason = BAD_FILES[case]
    (tmp_path / "part.stl").write_bytes(content)
    with pytest.raises(MouldError, match=reason) as refusal:
        Mould.load(str(tmp_path / "part.stl"))
    assert "\n" not in str(refusal.value)
    assert str(tmp_path / "part.stl") in str(refusal.value)


def make_missing(path: Path) -> None:
    pass


def make_large(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(MAX_BYTES + 1)  # sparse: takes no room


def make_crowded(path: Path) -> None:
    path.write_bytes(bytes(80) + (MAX_FACES + 1).to_bytes(4, "little"))
    with path.open("r+b") as file:
        file.truncate(84 + 50 * (MAX_FACES + 1))


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (make_missing, "does not exist"),
        (Path.mkdir, "is a directory"),
        (os.mkfifo, "not a regular file"),
        (make_large, "MiB"),
        (make_crowded, f"at most {MAX_FACES}"),
    ],
)
def test_what_is_no_file_to_read_is_refused_unread(tmp_path: Path, make: Callable[[Path], None], reason: str) -> None:
    path = tmp_path / "part.stl"
    make(path)
    with pytest.raises(MouldError, match=reason):
        read_mesh(path)


def test_file_without_permission_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "part.stl"
    path.write_bytes(binary_stl(PART))

    def deny(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", deny)  # the tests may run as root, whom nothing is denied
    with pytest.raises(MouldError, match="may not be read"):
        read_mesh(path)


@pytest.mark.parametrize("name", ["a\0b.stl", "x" * 5000 + ".stl"])
def test_name_that_no_file_can_have_is_refused(name: str) -> None:
    with pytest.raises(MouldError, match="cannot be read"):
        Mould.load(name)


def test_unknown_unit_is_refused_with_the_known_ones(tmp_path: Path) -> None:
    with pytest.raises(MouldError, match="expected one of mm, m, inch"):
        read_mesh(tmp_path / "part.stl", "furlong")


def load(path: Path, content: bytes) -> None:
    """Read it and forget it; anything but a mould or its refusal is a failure."""
    path.write_bytes(content)
    try:
        Mould.load(str(path))
    except MouldError as error:
        assert "\n" not in str(error)  # noqa: PT017


@pytest.mark.parametrize("form", [binary_stl, ascii_stl])
def test_damaged_files_give_a_mould_or_a_refusal(tmp_path: Path, form: Callable[[object], bytes]) -> None:
    rng = np.random.default_rng(7)
    whole = form(PART)
    for _ in range(150):
        data = bytearray(whole)
        for place in rng.integers(0, len(data), rng.integers(1, 5)):
            data[place] ^= 1 << int(rng.integers(8))
        if rng.random() < 0.3:
            data = data[: rng.integers(len(data))]
        load(tmp_path / "part.stl", bytes(data))


@settings(max_examples=60, deadline=None)
@given(head=st.sampled_from([b"", b"solid ", bytes(80), bytes(80) + b"\1\0\0\0"]), tail=st.binary(max_size=300))
def test_arbitrary_bytes_give_a_mould_or_a_refusal(
    tmp_path_factory: pytest.TempPathFactory, head: bytes, tail: bytes
) -> None:
    load(tmp_path_factory.getbasetemp() / "part.stl", head + tail)
