"""ROS 2 messages as numpy records: the layout is worked out once, then whole columns of numbers are poured in.

The encoding is CDR, little endian: four bytes say so, then every number stands at a multiple of its own size,
counted from behind those four bytes; a text is its length with the closing zero, and its bytes.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from burnish.errors import RecordingError

ENCAPSULATION = b"\x00\x01\x00\x00"
MAX_JOINTS = 64
"""Most joints of a recording that is read."""


class Layout:
    """Grows the layout of one message, from its first field to its last."""

    def __init__(self) -> None:
        self._body = bytearray()
        self._fields: dict[str, tuple[Any, int]] = {}

    def number(self, name: str, kind: str, count: int = 1) -> Layout:
        """``count`` numbers of the numpy kind (such as ``<f8``) that change from message to message."""
        size = np.dtype(kind).itemsize
        self._align(size)
        self._fields[name] = ((kind, (count,)) if count > 1 else kind, len(ENCAPSULATION) + len(self._body))
        self._body += bytes(size * count)
        return self

    def sequence(self, name: str, count: int) -> Layout:
        """A ``float64[]`` that always has ``count`` numbers."""
        self.constant(struct.pack("<I", count), 4)
        if count == 0:
            return self
        self._align(8)
        self._fields[name] = (("<f8", (count,)), len(ENCAPSULATION) + len(self._body))
        self._body += bytes(8 * count)
        return self

    def text(self, value: str) -> Layout:
        """A text that never changes."""
        return self.constant(text(value), 4)

    def constant(self, data: bytes, alignment: int) -> Layout:
        """Bytes that never change."""
        self._align(alignment)
        self._body += data
        return self

    def header(self, frame: str) -> Layout:
        """A ``std_msgs/Header``: the time as ``sec`` and ``nanosec``, and a fixed frame."""
        return self.number("sec", "<i4").number("nanosec", "<u4").text(frame)

    def align(self, size: int) -> Layout:
        """Go on at the next multiple of ``size``."""
        self._align(size)
        return self

    def done(self) -> Template:
        """The finished layout."""
        return Template(blank=ENCAPSULATION + bytes(self._body), fields=dict(self._fields))

    def _align(self, size: int) -> None:
        self._body += bytes(-len(self._body) % size)


@dataclass(frozen=True, kw_only=True)
class Template:
    """A finished layout: one message with zeros, and the places of its numbers."""

    blank: bytes
    """The message with every number zero."""
    fields: Mapping[str, tuple[Any, int]]
    """Name of a number to its numpy kind and its place [B]."""

    def columns(self, messages: Sequence[bytes]) -> NDArray[np.void]:
        """The numbers of messages of this layout, one row a message.

        Raises:
            RecordingError: if one of them has another length, or something else where nothing may change.
        """
        size = len(self.blank)
        if any(len(message) != size for message in messages):
            raise RecordingError(f"a message is not {size} bytes long; expected messages as burnish writes them")
        dtype = record_dtype(self.fields, size)
        rows = np.frombuffer(b"".join(messages), dtype=np.uint8).reshape(len(messages), size)
        fixed = np.ones(size, dtype=bool)
        for name in self.fields:
            kind, start = dtype.fields[name][:2]  # type: ignore[index]
            fixed[start : start + kind.itemsize] = False
        if np.any(rows[:, fixed] != np.frombuffer(self.blank, dtype=np.uint8)[fixed]):
            raise RecordingError("a message is not laid out as burnish writes it: a name, a frame or a length differs")
        return rows.view(dtype)[:, 0]


def record_dtype(fields: Mapping[str, tuple[Any, int]], size: int) -> np.dtype[np.void]:
    """The numpy type of ``size`` bytes with numbers at given places."""
    return np.dtype(
        {
            "names": list(fields),
            "formats": [kind for kind, _ in fields.values()],
            "offsets": [offset for _, offset in fields.values()],
            "itemsize": size,
        }
    )


def text(value: str) -> bytes:
    """A text in CDR, to be placed at a multiple of four."""
    data = value.encode() + b"\x00"
    return struct.pack("<I", len(data)) + data


def joint_state(names: tuple[str, ...], effort: bool) -> Template:
    """``sensor_msgs/msg/JointState``; without ``effort`` its sequence of efforts is empty."""
    layout = Layout().header("").constant(struct.pack("<I", len(names)), 4)
    for name in names:
        layout.text(name)
    count = len(names)
    layout.sequence("position", count).sequence("velocity", count)
    return layout.sequence("effort", count if effort else 0).done()


def joint_names(message: bytes) -> tuple[str, ...]:
    """The names in a ``sensor_msgs/msg/JointState`` that burnish wrote.

    Raises:
        RecordingError: if there are none, or more than any arm has joints.
    """
    at = len(Layout().header("").done().blank)
    at += -(at - len(ENCAPSULATION)) % 4
    names: list[str] = []
    count = _length(message, at)
    if not 0 < count <= MAX_JOINTS:
        raise RecordingError(f"a joint state has {count} joints; expected 1 to {MAX_JOINTS}")
    at += 4
    for _ in range(count):
        at += -(at - len(ENCAPSULATION)) % 4
        size = _length(message, at)
        names.append(read_text(message[at : at + 4 + size]))
        at += 4 + size
    return tuple(names)


def _length(message: bytes, at: int) -> int:
    if at + 4 > len(message):
        raise RecordingError("a message is shorter than its fields; it is damaged")
    return int(struct.unpack_from("<I", message, at)[0])


def read_text(data: bytes) -> str:
    """The text that ``text`` made these bytes of.

    Raises:
        RecordingError: if they are no such bytes.
    """
    if len(data) < 5 or struct.unpack_from("<I", data)[0] != len(data) - 4 or data[-1] != 0:
        raise RecordingError("a text in a message has a wrong length; it is damaged")
    try:
        return data[4:-1].decode()
    except UnicodeDecodeError:
        raise RecordingError("a text in a message is not UTF-8; it is damaged") from None


def pose(frame: str) -> Template:
    """``geometry_msgs/msg/PoseStamped``: ``position`` (3,), ``orientation`` (4,) as x y z w."""
    return Layout().header(frame).number("position", "<f8", 3).number("orientation", "<f8", 4).done()


def wrench(frame: str) -> Template:
    """``geometry_msgs/msg/WrenchStamped``: ``wrench`` (6,), force first."""
    return Layout().header(frame).number("wrench", "<f8", 6).done()


def transform(frame: str, child: str) -> Template:
    """``tf2_msgs/msg/TFMessage`` with one transform: ``position`` (3,), ``orientation`` (4,) as x y z w."""
    layout = Layout().constant(struct.pack("<I", 1), 4).header(frame).text(child)
    return layout.number("position", "<f8", 3).number("orientation", "<f8", 4).done()


def control_state(count: int, phase: str) -> Template:
    """``burnish_msgs/msg/ControlState`` in a phase; the phase is what stands last."""
    return _control_state(count).text(phase).done()


def control_state_head(count: int) -> Template:
    """The same up to the phase."""
    return _control_state(count).done()


def _control_state(count: int) -> Layout:
    layout = Layout().header("").sequence("torque_commanded", count).sequence("torque_applied", count)
    return layout.number("force_set", "<f8").number("force_measured", "<f8").align(4)


HEADER = "std_msgs/Header header\n"
MSG_HEADER = """builtin_interfaces/Time stamp
string frame_id
"""
MSG_TIME = """int32 sec
uint32 nanosec
"""
MSG_VECTOR = """float64 x
float64 y
float64 z
"""
MSG_QUATERNION = MSG_VECTOR + "float64 w\n"


def _schema(root: str, **parts: str) -> str:
    """A message definition with those it needs, as tools read it from a recording."""
    pieces = [root]
    for name, definition in parts.items():
        pieces.append(f"MSG: {name.replace('__', '/')}\n{definition}")
    return ("=" * 80 + "\n").join(pieces)


_STAMPED = {"std_msgs__Header": MSG_HEADER, "builtin_interfaces__Time": MSG_TIME}

SCHEMAS: dict[str, str] = {
    "sensor_msgs/msg/JointState": _schema(
        HEADER + "string[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n", **_STAMPED
    ),
    "geometry_msgs/msg/PoseStamped": _schema(
        HEADER + "geometry_msgs/Pose pose\n",
        geometry_msgs__Pose="geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
        geometry_msgs__Point=MSG_VECTOR,
        geometry_msgs__Quaternion=MSG_QUATERNION,
        **_STAMPED,
    ),
    "geometry_msgs/msg/WrenchStamped": _schema(
        HEADER + "geometry_msgs/Wrench wrench\n",
        geometry_msgs__Wrench="geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque\n",
        geometry_msgs__Vector3=MSG_VECTOR,
        **_STAMPED,
    ),
    "tf2_msgs/msg/TFMessage": _schema(
        "geometry_msgs/TransformStamped[] transforms\n",
        geometry_msgs__TransformStamped=HEADER + "string child_frame_id\ngeometry_msgs/Transform transform\n",
        geometry_msgs__Transform="geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
        geometry_msgs__Vector3=MSG_VECTOR,
        geometry_msgs__Quaternion=MSG_QUATERNION,
        **_STAMPED,
    ),
    "burnish_msgs/msg/ControlState": _schema(
        "# One control cycle: joint torques [N m], forces along the surface normal [N] (NaN: not measured).\n"
        + HEADER
        + "float64[] torque_commanded\nfloat64[] torque_applied\nfloat64 force_set\nfloat64 force_measured\n"
        "string phase\n",
        **_STAMPED,
    ),
}
"""Message type to its definition, ``ros2msg`` encoding."""
