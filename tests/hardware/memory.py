"""The memory that the stand-in's library and its arm share, and the tests turn their switches in.

Field for field the struct ``Memory`` of standin.h; a test compares the sizes.
"""

from __future__ import annotations

import mmap
import re
from ctypes import Structure, c_char, c_double, c_float, c_int32, c_uint32, sizeof
from pathlib import Path

JOINTS, SLOTS, VALUES, TRACE, MOST_FUNCTIONS = 6, 4096, 44, 32768, 64
FUNCTIONS = tuple(re.findall(r"FUNCTION\((\w+)\)", (Path(__file__).parent / "functions.def").read_text()))
"""Names of the calls; the place of a name is its number in the memory."""


class Entry(Structure):
    _fields_ = [("function", c_int32), ("value", c_float * VALUES)]


class Memory(Structure):
    _fields_ = [
        ("state_sequence", c_uint32),
        ("mode", c_int32),
        ("time", c_double),
        ("lived", c_double),
        *((name, c_float * JOINTS) for name in ("position", "velocity", "torque", "gravity", "command")),
        ("fingers", c_float * 3),
        ("queued", c_uint32),
        ("torque_sequence", c_uint32),
        ("torque_command", c_float * JOINTS),
        ("head", c_uint32),
        ("tail", c_uint32),
        ("calls", c_uint32 * MOST_FUNCTIONS),
        ("active", c_char * 20),
        ("code", c_int32 * MOST_FUNCTIONS),
        ("times", c_int32 * MOST_FUNCTIONS),
        ("unplugged", c_int32),
        ("garbage", c_int32),
        ("garbage_value", c_float),
        ("devices", c_int32),
        ("serial", (c_char * 20) * 2),
        ("frozen", c_int32),
        ("refuse_torque_mode", c_int32),
        ("drop_to_position", c_int32),
        ("slowest", c_float),
        ("fastest", c_float),
        ("joystick", c_float),
        ("torque_taken_at", c_double),
        ("traced", c_uint32),
        ("trace", (c_double * 8) * TRACE),
        ("ring", Entry * SLOTS),
    ]


def attach(path: Path | str) -> Memory:
    """The memory in the file at ``path``, made as long as it has to be."""
    with open(path, "r+b") as file:
        file.truncate(sizeof(Memory))
        return Memory.from_buffer(mmap.mmap(file.fileno(), sizeof(Memory)))
