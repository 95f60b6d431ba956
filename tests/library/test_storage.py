"""Copying from outside: bounded, whole, on regular files only."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

import pytest

from burnish.errors import InputError
from burnish.library.rows import Stored
from burnish.library.storage import CHUNK, Source, fault, place


def test_copy_is_named_by_its_content_and_placed_below_the_root(tmp_path: Path) -> None:
    content = os.urandom(3 * CHUNK + 5)
    (tmp_path / "a").write_bytes(content)
    stored = Source(called="a", content=tmp_path / "a").copied(tmp_path, "mesh", ".stl", 2**30)
    digest = hashlib.sha256(content).hexdigest()
    assert stored == Stored(role="mesh", sha256=digest, size=len(content), ending=".stl")
    place(stored, tmp_path, tmp_path / "root")
    assert (tmp_path / "root" / "files" / digest[:2] / f"{digest}.stl").read_bytes() == content
    assert fault(stored, tmp_path / "root") is None


@pytest.mark.parametrize("received", [True, False])
def test_too_much_and_nothing_at_all_are_refused(tmp_path: Path, received: bool) -> None:
    for content, said in ((bytes(101), "larger than"), (b"", "is empty")):
        (tmp_path / "a").write_bytes(content)
        with pytest.raises(InputError, match=f"part.stl .*{said}|part.stl is {said}"):
            Source(called="part.stl", content=content if received else tmp_path / "a").copied(
                tmp_path, "mesh", ".stl", 100
            )


def test_pipe_folder_and_device_are_refused_and_nobody_waits_for_them(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", tmp_path, Path("/dev/zero")):
        with pytest.raises(InputError, match="no regular file"):
            Source(called=str(path), content=path).copied(tmp_path, "mesh", ".stl", 100)


def test_missing_file_is_refused_by_the_name_that_was_given(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"reading part\.stl failed \(No such file"):
        Source(called="part.stl", content=tmp_path / "part.stl").copied(tmp_path, "mesh", ".stl", 100)


def test_placed_file_is_never_replaced_by_another_of_its_name(tmp_path: Path) -> None:
    stored = Source(called="a", content=b"abc").copied(tmp_path, "mesh", ".stl", 100)
    place(stored, tmp_path, tmp_path)
    before = (tmp_path / stored.path).stat().st_ino
    again = Source(called="a", content=b"abc").copied(tmp_path, "mesh", ".stl", 100)
    place(again, tmp_path, tmp_path)
    place(again, tmp_path, tmp_path)
    assert (tmp_path / stored.path).stat().st_ino == before
    assert list(tmp_path.glob("*.stl")) == []
