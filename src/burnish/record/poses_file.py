"""Desired tool poses as text, a line each: ``px py pz εx εy εz η``, metres and a unit quaternion.

Source: the form in which thesis B hands desired poses to its controller.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import sqrt
from pathlib import Path

import numpy as np

from burnish.core import Array, read_only
from burnish.errors import RecordingError

MAX_BYTES = 16 * 2**20
"""Largest file that is read [B]: about 100,000 poses with all their digits, a quarter of an hour at 100 Hz."""
FURTHEST = 10.0
"""Largest coordinate that is believed [m]; the arms that this is for reach 1 m."""
UNIT = 1e-3
"""Deviation of a quaternion's norm from 1 that is accepted."""


@dataclass(frozen=True, kw_only=True)
class Poses:
    """Tool poses in order, base frame."""

    p: Array
    """Positions [m], (N, 3)."""
    Q: Array
    """Unit quaternions [η, ε], scalar first, (N, 4)."""


def read_poses(path: Path) -> Poses:
    """The poses of a file.

    Raises:
        RecordingError: if it cannot be read, is too large, or a line is not seven numbers that make a pose.
    """
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        raise RecordingError(f"{str(path)!r} cannot be read ({error}); expected a file of poses") from None
    if len(data) > MAX_BYTES:
        raise RecordingError(f"{path} is larger than {MAX_BYTES // 2**20} MiB; expected fewer poses: split the file")
    try:
        lines = data.decode("ascii").split("\n")
    except UnicodeDecodeError:
        raise RecordingError(f"{path} is no text of numbers; expected lines of px py pz εx εy εz η") from None
    rows = [_pose(path, number, words) for number, line in enumerate(lines, 1) if (words := line.split())]
    if not rows:
        raise RecordingError(f"{path} holds no pose; expected lines of px py pz εx εy εz η")
    values = np.array(rows)
    Q = values[:, [6, 3, 4, 5]]
    return Poses(p=read_only(values[:, :3]), Q=read_only(Q / np.linalg.norm(Q, axis=1)[:, None]))


def pose_lines(p: Array, Q: Array) -> Iterable[str]:
    """Positions (N, 3) and quaternions [η, ε] (N, 4) as lines with all their digits."""
    for position, (eta, *epsilon) in zip(p.tolist(), Q.tolist(), strict=True):
        yield " ".join(map(repr, [*position, *epsilon, eta])) + "\n"


def _pose(path: Path, number: int, words: list[str]) -> list[float]:
    """The seven numbers of a line, checked one by one."""
    try:
        if len(words) != 7:
            raise ValueError
        values = [float(word) for word in words]
    except ValueError:
        raise RecordingError(f"{path}, line {number}: found {len(words)} words; expected seven numbers") from None
    # Written so that NaN fails too.
    if not all(abs(value) <= FURTHEST for value in values):
        raise RecordingError(f"{path}, line {number}: a number is not finite or beyond {FURTHEST:g} m; check the unit")
    norm = sqrt(sum(value * value for value in values[3:]))
    if not abs(norm - 1.0) <= UNIT:
        raise RecordingError(
            f"{path}, line {number}: the quaternion has norm {norm:.4g}; expected 1, and the order εx εy εz η"
        )
    return values
