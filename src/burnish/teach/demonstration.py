"""What an operator showed: pose, wrench, contact, mode and gains of every cycle, in the mould's frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from typing_extensions import Self

from burnish.core import Array, read_only
from burnish.errors import RecordingError
from burnish.polish.cell import Placement
from burnish.record.poses_file import pose_lines
from burnish.record.recording import Cycles, Recording
from burnish.rotation import from_quaternion, quaternions

RECORDING = "record"
"""First word of the phase of a cycle that was demonstrated; the other two are contact or free, and the mode."""
STORED = "demonstrated_cycles"
"""Entry of a recording's ending that says which cycles were stored, ``first last``."""
LEAST = 20
"""Cycles of the shortest demonstration."""


def phase_of(contact: bool, mode: str) -> str:
    """What the recorder notes of a demonstrated cycle."""
    return f"{RECORDING} {'contact' if contact else 'free'} {mode}"


@dataclass(frozen=True, kw_only=True)
class Demonstration:
    """One demonstration, a row a cycle; positions and directions in the frame of the mould as it was meant to stand."""

    t: Array
    """Time from the start [s], (N,)."""
    p: Array
    """Tool position [m], (N, 3)."""
    R: Array
    """Tool rotation, mould ← tool, (N, 3, 3)."""
    p_d: Array
    """Position that the operator asked for [m], (N, 3)."""
    R_d: Array
    """Rotation that the operator asked for, (N, 3, 3)."""
    F: Array
    """Wrench that the environment exerted on the tool, about the tool point [N, N·m], (N, 6)."""
    contact: NDArray[np.bool_]
    """Whether the tool touched, (N,)."""
    mode: NDArray[np.object_]
    """The operator's mode, (N,)."""
    gains: str
    """The law with which the operator's commands were followed, as JSON."""
    placement: Placement
    """Where the mould was meant to stand."""

    def __post_init__(self) -> None:
        count = len(self.t)
        if count < LEAST:
            raise RecordingError(f"the demonstration has {count} cycles; expected at least {LEAST}: teach again")
        for field in fields(self):
            values = getattr(self, field.name)
            if isinstance(values, np.ndarray):
                if len(values) != count:
                    raise RecordingError(f"the demonstration has {len(values)} rows of {field.name}; expected {count}")
                if values.dtype == np.float64:
                    object.__setattr__(self, field.name, read_only(values))
                    if not np.isfinite(values).all():
                        raise RecordingError(f"the demonstration's {field.name} is not finite; nothing can follow it")
        if not (np.diff(self.t) > 0.0).all():
            raise RecordingError("the demonstration's times do not rise; nothing can follow it")

    @classmethod
    def of(cls, recording: Recording) -> Self:
        """The stored demonstration of a recording of ``burnish teach``.

        Raises:
            RecordingError: if it is of another verb, nothing was stored, or a value cannot be used.
        """
        found = recording.metadata
        if found.get("verb") != "teach":
            raise RecordingError(
                f"{recording.path} is of '{found.get('verb', 'unknown')[:40]}'; expected a recording of 'burnish teach'"
            )
        first, last = _stored(recording)
        placement = _placement(found)
        cycles = _rows(recording, first, last)
        words = [str(phase).split(" ", 2) for phase in cycles.phase]
        if not all(len(word) == 3 and word[0] == RECORDING for word in words):
            raise RecordingError(f"{recording.path}: a stored cycle was not demonstrated; it cannot be replayed")
        R, R_d = _rotations(cycles.Q), _rotations(cycles.Q_d)
        into = placement.R.T
        return cls(
            t=cycles.t - cycles.t[0],
            p=(cycles.p - placement.p) @ placement.R,
            R=into @ R,
            p_d=(cycles.p_d - placement.p) @ placement.R,
            R_d=into @ R_d,
            F=np.column_stack([cycles.F[:, :3] @ placement.R, cycles.F[:, 3:] @ placement.R]),
            contact=np.array([word[1] == "contact" for word in words]),
            mode=np.array([word[2] for word in words], dtype=object),
            gains=found.get("law", ""),
            placement=placement,
        )

    def poses(self) -> str:
        """The poses that were asked for, base frame, in the form of thesis B's ``desired_poses.txt``."""
        p = self.placement.points(self.p_d)
        return "".join(pose_lines(p, quaternions(self.placement.R @ self.R_d)))


def check_same(recording: Recording, *, model: str, tool: str, mould: str) -> None:
    """Refuse a recording of another arm, tool or mould, by their hashes.

    Raises:
        RecordingError: says which, and both hashes.
    """
    for what, name, now in (("arm", "model", model), ("tool", "tool", tool), ("mould", "mould", mould)):
        was = recording.metadata.get(f"{name}_sha256", "nothing")
        if was != now:
            raise RecordingError(
                f"{recording.path} was taught with another {what}: its hash is {was[:16]!r}, here it is {now[:16]!r}; "
                f"expected the same {what}: replay it there, or teach anew"
            )


def _stored(recording: Recording) -> tuple[int, int]:
    """First and last cycle of what was stored."""
    words = recording.ending.get(STORED, "").split()
    if len(words) != 2 or not all(word.isdecimal() and len(word) < 12 for word in words):
        raise RecordingError(f"{recording.path} holds no stored demonstration; teach again, and store it with E")
    return int(words[0]), int(words[1])


def _placement(metadata: Mapping[str, str]) -> Placement:
    """Where the mould was meant to stand: position and quaternion [η, ε]."""
    try:
        values = np.array([float(word) for word in metadata.get("placement", "").split()])
    except ValueError:
        values = np.zeros(0)
    if values.shape != (7,) or not np.isfinite(values).all() or abs(float(np.linalg.norm(values[3:])) - 1.0) > 1e-6:
        raise RecordingError("the recording does not say where the mould stood; expected px py pz η εx εy εz")
    return Placement(p=read_only(values[:3]), R=read_only(from_quaternion(values[3:])))


def placement_text(placement: Placement) -> str:
    """A placement as a recording keeps it, with all digits."""
    return " ".join(map(repr, [*placement.p.tolist(), *quaternions(placement.R[None])[0].tolist()]))


def _rows(recording: Recording, first: int, last: int) -> Cycles:
    """Cycles ``first`` to ``last`` of a recording, both included."""
    parts, count = [], 0
    for block in recording.blocks():
        low, high = max(first - count, 0), min(last + 1 - count, len(block))
        if low < high:
            parts.append(block[low:high])
        count += len(block)
    if not parts or count <= last:
        raise RecordingError(f"{recording.path} has {count} cycles; expected the stored ones, {first} to {last}")
    return Cycles(**{f.name: np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(Cycles)})


def _rotations(Q: Array) -> Array:
    """Matrices of quaternions with the scalar last, (N, 3, 3)."""
    return np.array([from_quaternion(q) for q in Q[:, [3, 0, 1, 2]]])


def write_poses(path: Path, demonstration: Demonstration) -> None:
    """Write ``desired_poses.txt``."""
    path.write_text(demonstration.poses(), encoding="ascii")
