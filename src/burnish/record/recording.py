"""Reading a recording back, a block of cycles after the other, and believing nothing of it that was not checked."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Channel, Schema
from numpy.typing import NDArray
from typing_extensions import Self

from burnish.core import Array
from burnish.errors import RecordingError
from burnish.record import mcap_fields, messages
from burnish.record.mcap_file import HEAD, LENGTH_COUNTS_FROM
from burnish.record.mcap_scan import Content, Damage, open_recording, scan
from burnish.record.mcap_scan import messages as split
from burnish.record.recorder import (
    BASE_FRAME,
    CONTROL,
    DESIRED,
    END,
    JOINTS,
    POSE,
    START,
    TOOL_FRAME,
    TOPICS,
    TRANSFORM,
    WRENCH,
)
from burnish.record.recover import MENDED

_SEQUENCE = HEAD.fields["sequence"][1]  # type: ignore[index]


@dataclass(frozen=True, kw_only=True)
class Cycles:
    """Consecutive cycles, a row each; NaN stands for what a cycle did not have."""

    t: Array
    """Time [s], (N,)."""
    q: Array
    """Joint positions [rad], (N, n)."""
    dq: Array
    """Joint velocities [rad/s], (N, n)."""
    tau: Array
    """Measured joint torques [N·m], (N, n)."""
    p: Array
    """Tool position, base frame [m], (N, 3)."""
    Q: Array
    """Tool orientation, quaternion with the scalar last as ROS has it, (N, 4)."""
    p_d: Array
    """Desired tool position [m], (N, 3)."""
    Q_d: Array
    """Desired tool orientation, scalar last, (N, 4)."""
    F: Array
    """Measured contact wrench, base axes about the tool point [N, N·m], (N, 6)."""
    commanded: Array
    """Torque that the law asked for [N·m], (N, n)."""
    applied: Array
    """Torque that was applied [N·m], (N, n)."""
    force_set: Array
    """Force that was wanted along the surface's normal [N], (N,)."""
    force_measured: Array
    """Force that was measured along it [N], (N,)."""
    phase: NDArray[np.object_]
    """What the run was doing, (N,)."""

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, rows: slice) -> Self:
        return replace(self, **{field.name: getattr(self, field.name)[rows] for field in fields(self)})


class Quantity(NamedTuple):
    """Where a field of `Cycles` comes from, and how it is called in a table."""

    field: str
    topic: str
    unit: str
    parts: tuple[str, ...]
    """Names of its columns; ``q#`` stands for one a joint."""


WRENCH_PARTS = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z")
QUANTITIES = (
    Quantity("q", JOINTS, "rad", ("q#",)),
    Quantity("dq", JOINTS, "rad/s", ("dq#",)),
    Quantity("tau", JOINTS, "N·m", ("tau#",)),
    Quantity("p", POSE, "m", ("px", "py", "pz")),
    Quantity("Q", POSE, "", ("qx", "qy", "qz", "qw")),
    Quantity("p_d", DESIRED, "m", ("px_d", "py_d", "pz_d")),
    Quantity("Q_d", DESIRED, "", ("qx_d", "qy_d", "qz_d", "qw_d")),
    Quantity("F", WRENCH, "", WRENCH_PARTS),
    Quantity("commanded", CONTROL, "N·m", ("tau_commanded#",)),
    Quantity("applied", CONTROL, "N·m", ("tau_applied#",)),
    Quantity("force_set", CONTROL, "N", ("force_set",)),
    Quantity("force_measured", CONTROL, "N", ("force_measured",)),
)
"""All fields of `Cycles` but time and phase."""


class Recording:
    """A whole recording of burnish; its metadata at once, its cycles when they are asked for.

    Every chunk and the file as a whole have to have their checksums. What a sensor read is given back as it is,
    NaN included: refuse it where it would move an arm.
    """

    metadata: Mapping[str, str]
    """What was known before the first sample."""
    ending: Mapping[str, str]
    """How the run ended; empty where nobody could write that any more."""
    mended: bool
    """Whether it was recovered from a file that was cut off or damaged."""
    joint_names: tuple[str, ...]
    """One a joint; none in a recording without a single cycle."""

    def __init__(self, path: Path) -> None:
        """Check a recording from its first byte to its last.

        Raises:
            RecordingError: if it cannot be read, is damaged or cut off, or was not written by burnish.
        """
        self.path = path
        self._data = open_recording(path)
        self._topics: dict[int, str] = {}
        self.joint_names = ()
        notes: dict[str, Mapping[str, str]] = {}
        schemas: dict[int, Schema] = {}
        channels: list[Channel] = []
        for found in scan(self._data):
            if isinstance(found, Damage) or (isinstance(found, Content) and not found.whole):
                reason = found.reason if isinstance(found, Damage) else "its last chunk was never finished"
                raise RecordingError(
                    f"{path} is damaged at byte {found.start}: {reason}. Mend it with 'burnish recover {path}'"
                )
            if isinstance(found, Content):
                self._name_joints(found)
            elif found.opcode == Opcode.METADATA:
                note = mcap_fields.metadata(found.body)
                notes[note.name] = note.metadata
            elif found.opcode == Opcode.SCHEMA:
                schema = mcap_fields.schema(found.body)
                schemas[schema.id] = schema
            elif found.opcode == Opcode.CHANNEL:
                channels.append(mcap_fields.channel(found.body))
                if channels[-1].topic in TOPICS:
                    self._topics[channels[-1].id] = channels[-1].topic
        for channel in channels:
            self._check(channel, schemas.get(channel.schema_id))
        if START not in notes or set(self._topics.values()) != set(TOPICS):
            raise RecordingError(f"{path} was not recorded by burnish: its topics or its metadata are missing")
        self.metadata, self.ending = notes[START], notes.get(END, {})
        self.mended = MENDED in notes

    def blocks(self) -> Iterator[Cycles]:
        """All cycles in the order of the file, some dozens at a time.

        Raises:
            RecordingError: if messages are not as burnish writes them.
        """
        for found in scan(self._data):
            if isinstance(found, Content):
                block = self._block(found)
                if len(block):
                    yield block

    def _check(self, channel: Channel, schema: Schema | None) -> None:
        """Refuse a topic of ours that is something else."""
        wanted = TOPICS.get(channel.topic)
        if wanted and (schema is None or schema.name != wanted or channel.message_encoding != "cdr"):
            raise RecordingError(f"{self.path}: the topic {channel.topic} is not a {wanted} in CDR, as burnish has it")

    def _name_joints(self, content: Content) -> None:
        """Take the joints' names from the first message that has them."""
        if not self.joint_names:
            found = self._by_topic(content).get(JOINTS)
            if found:
                self.joint_names = messages.joint_names(found[0][1])

    def _by_topic(self, content: Content) -> dict[str, list[tuple[int, bytes]]]:
        """For each topic the running number and the bytes of its messages."""
        table, _, _ = split(content.raw)
        raw, found = content.raw, {topic: list[tuple[int, bytes]]() for topic in TOPICS}
        for channel, _, start in table.tolist():
            topic = self._topics.get(channel)
            if topic is not None:
                number = int.from_bytes(raw[start + _SEQUENCE : start + _SEQUENCE + 4], "little")
                length = int.from_bytes(raw[start + 1 : start + 9], "little")
                found[topic].append((number, raw[start + HEAD.itemsize : start + LENGTH_COUNTS_FROM + length]))
        return found

    def _block(self, content: Content) -> Cycles:
        found = self._by_topic(content)
        numbers = {number for rows in found.values() for number, _ in rows}
        if any(len({number for number, _ in rows}) != len(rows) for rows in found.values()):
            raise RecordingError(f"{self.path}: two messages of one topic belong to one cycle; expected one")
        row_of = {number: i for i, number in enumerate(sorted(numbers))}
        return _cycles({topic: _Rows.of(rows, row_of) for topic, rows in found.items()}, len(numbers), self.joint_names)


class _Rows(NamedTuple):
    """The messages of a topic and the rows of the block that they belong to."""

    at: NDArray[np.int64]
    messages: list[bytes]

    @classmethod
    def of(cls, found: list[tuple[int, bytes]], row_of: Mapping[int, int]) -> _Rows:
        """From running numbers to rows."""
        return cls(np.array([row_of[number] for number, _ in found], dtype=np.int64), [data for _, data in found])


def _cycles(found: Mapping[str, _Rows], count: int, names: tuple[str, ...]) -> Cycles:
    """One block from its messages."""
    joints = len(names)
    widths = {"q": joints, "dq": joints, "tau": joints, "p": 3, "Q": 4, "p_d": 3, "Q_d": 4, "F": 6}
    widths |= {"commanded": joints, "applied": joints}
    columns: dict[str, Array] = {name: np.full((count, width), np.nan) for name, width in widths.items()}
    columns |= {name: np.full(count, np.nan) for name in ("t", "force_set", "force_measured")}
    phase = np.full(count, "", dtype=object)

    def pour(rows: _Rows, template: messages.Template, **target: str) -> None:
        if rows.messages:
            values = template.columns(rows.messages)
            columns["t"][rows.at] = (values["sec"] * np.int64(1_000_000_000) + values["nanosec"]) / 1e9
            for source, name in target.items():
                columns[name][rows.at] = values[source]

    if joints:
        silent = messages.joint_state(names, effort=False)
        quiet = np.array([len(data) == len(silent.blank) for data in found[JOINTS].messages], dtype=bool)
        motion = {"position": "q", "velocity": "dq"}
        pour(_some(found[JOINTS], quiet), silent, **motion)
        pour(_some(found[JOINTS], ~quiet), messages.joint_state(names, effort=True), **motion, effort="tau")
    head = messages.control_state_head(joints)
    size = len(head.blank)
    control = found[CONTROL]
    torques = {"torque_commanded": "commanded", "torque_applied": "applied"} if joints else {}
    forces = {"force_set": "force_set", "force_measured": "force_measured"}
    pour(_Rows(control.at, [data[:size] for data in control.messages]), head, **torques, **forces)
    known: dict[bytes, str] = {}
    for row, data in zip(control.at.tolist(), control.messages, strict=True):
        tail = data[size:]
        if tail not in known:
            known[tail] = messages.read_text(tail)
        phase[row] = known[tail]
    pour(found[POSE], messages.pose(BASE_FRAME), position="p", orientation="Q")
    pour(found[TRANSFORM], messages.transform(BASE_FRAME, TOOL_FRAME))
    pour(found[DESIRED], messages.pose(BASE_FRAME), position="p_d", orientation="Q_d")
    pour(found[WRENCH], messages.wrench(BASE_FRAME), wrench="F")
    return Cycles(phase=phase, **columns)


def _some(rows: _Rows, wanted: NDArray[np.bool_]) -> _Rows:
    """Those rows that are wanted."""
    return _Rows(rows.at[wanted], [data for data, yes in zip(rows.messages, wanted.tolist(), strict=True) if yes])
