from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from burnish import rotation
from burnish.errors import RecordingError
from burnish.record import poses_file
from burnish.record.poses_file import pose_lines, read_poses


def test_poses_come_back_to_the_last_bit_of_their_positions(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    p = rng.uniform(-1.0, 1.0, (50, 3))
    Q = rotation.quaternions(np.array([rotation.exp(v) for v in rng.normal(size=(50, 3))]))
    (tmp_path / "desired_poses.txt").write_text("".join(pose_lines(p, Q)))
    poses = read_poses(tmp_path / "desired_poses.txt")
    assert np.array_equal(poses.p, p)
    # They are made of length 1 once more.
    assert np.allclose(poses.Q, Q, atol=3e-16)


def test_the_scalar_part_stands_last_in_a_line(tmp_path: Path) -> None:
    (tmp_path / "p.txt").write_text("0.1 0.2 0.3 0 0 0 1\n\n 1e-1\t0.2 0.3  1 0 0 0 \r\n")
    poses = read_poses(tmp_path / "p.txt")
    assert poses.Q.tolist() == [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]]


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"", "no pose"),
        (b"0 0 0 0 0 1\n", "line 1: found 6 words; expected seven numbers"),
        (b"0 0 0 0 0 0 1\n0 0 x 0 0 0 1\n", "line 2: found 7 words"),
        (b"nan 0 0 0 0 0 1", "not finite"),
        (b"0 0 1e999 0 0 0 1", "not finite"),
        (b"300 0 0 0 0 0 1", "beyond 10 m"),
        (b"0 0 0 0 0 0 1.01", "norm 1.01"),
        (b"0 0 0 0 0 0 0", "norm 0"),
        ("0 0 0 0 0 0 ١".encode(), "no text of numbers"),
    ],
)
def test_what_is_no_pose_is_refused_with_its_line(content: bytes, expected: str, tmp_path: Path) -> None:
    (tmp_path / "p.txt").write_bytes(content)
    with pytest.raises(RecordingError, match=expected):
        read_poses(tmp_path / "p.txt")


def test_a_file_that_is_too_large_is_refused_unread(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(poses_file, "MAX_BYTES", 100)
    (tmp_path / "p.txt").write_text("0 0 0 0 0 0 1\n" * 10)
    with pytest.raises(RecordingError, match="larger than"):
        read_poses(tmp_path / "p.txt")


@pytest.mark.parametrize("name", ["nowhere.txt", ".", "a\0b"])
def test_a_file_that_cannot_be_read_is_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="cannot be read"):
        read_poses(tmp_path / name)
