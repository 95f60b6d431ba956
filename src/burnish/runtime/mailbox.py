"""`Mailbox`: the memory that a job and whoever watches and commands it share; neither ever waits for the other.

One file, mapped by both. Each value has one writer. What is shown has two seats, written in turn with a checksum, so
that a reader finds a whole glance whatever happens to the writer. Both sides read the one monotonic clock of their
machine, so an age means the same to both.
"""

from __future__ import annotations

import mmap
import os
import struct
import time
import zlib
from enum import Enum
from pathlib import Path

import numpy as np
from typing_extensions import Self

from burnish.core import Array
from burnish.errors import RecordingError
from burnish.runtime.glance import Glance as Glance
from burnish.runtime.glance import layout, packed, unpacked

MAGIC, VERSION = b"BURNMAIL", 1
HEADER = struct.Struct("=8sIIQ")
"""Magic, version, joints, size of the file."""
ORDERS, SEATS = 64, 1024
"""Where the orders and the glances begin."""
SEAT = struct.Struct("=QII")
"""Number of the glance, its length, its checksum; the glance follows."""
COLUMNS = 6
"""Of the contact track: x, y, z of the contact, force, speed, time."""
ROWS = 1 << 16
"""Rows of the track that are kept: 65 m at one a millimetre."""
KEYS, KEY = 32, 8
"""Keys that may wait, and the longest name of one."""
STAGE = 128
"""Longest name of what is being done where no arm moves, in bytes."""
MOST_JOINTS = 32
PATIENCE = 0.25
"""Age of a beat from which on its sender counts as gone [s]: five beats of 50 ms, and a cycle less than 0.3 s."""
JOG_LASTS = 0.2
"""Age from which on a jog means rest [s]."""
TRIES = 8
"""Looks at a glance that is being written, before the one before it has to do."""
_BEAT, _ORDER, _COUNT, _PRESSED, _JOG = 0, 1, 2, 3, 4
"""Places of the beat, the order, the rows of the track, the keys and the jog, in 8 bytes."""


class Order(Enum):
    """What a commander wants of a job."""

    GO = 0
    """Go on."""
    PAUSE = 1
    """End as soon as the arm is at rest, to be resumed."""
    STOP = 2
    """The same, and nobody means to resume it."""


class Mailbox:
    """One end of the shared memory; `create` it once, `open` it on the other side."""

    def __init__(self, path: Path, memory: mmap.mmap, joints: int) -> None:
        """Use `create` or `open`."""
        self.path, self.joints = path, joints
        self._memory = memory
        self._layout = layout(joints)
        self._seat = _seat(joints)
        # One store each: nobody reads half of one.
        self._numbers = np.frombuffer(memory, np.int64, 4 + 8, ORDERS)
        self._reals = self._numbers.view(np.float64)
        self._names = np.frombuffer(memory, f"S{KEY}", KEYS, ORDERS + 128)
        rows = SEATS + 2 * self._seat
        self._stage = np.frombuffer(memory, f"S{STAGE}", 1, ORDERS + 128 + KEYS * KEY)
        self._track = np.frombuffer(memory, np.float64, ROWS * COLUMNS, rows).reshape(ROWS, COLUMNS)
        self._number = 0
        self._taken = int(self._numbers[_PRESSED])
        self._last: Glance | None = None

    @classmethod
    def create(cls, path: str | Path, joints: int = 6) -> Self:
        """A new and empty one, for this user alone; where it lies on a disk, keep it on one in memory.

        Raises:
            RecordingError: there is a file already, or it cannot be made.
        """
        path = Path(path)
        if not 1 <= joints <= MOST_JOINTS:
            raise RecordingError(f"a mailbox for {joints} joints cannot be made; expected 1 to {MOST_JOINTS}")
        size = _size(joints)
        try:
            handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
            try:
                # Really there: a store into a hole of a full disk would end the process.
                os.posix_fallocate(handle, 0, size)
                memory = mmap.mmap(handle, size)
            finally:
                os.close(handle)
        except OSError as error:
            raise RecordingError(
                f"the mailbox {path} cannot be made ({error.strerror}); every job has a new one"
            ) from None
        box = cls(path, memory, joints)
        box._reals[_BEAT] = -np.inf
        memory[: HEADER.size] = HEADER.pack(MAGIC, VERSION, joints, size)
        return box

    @classmethod
    def open(cls, path: str | Path) -> Self:
        """The one that the other side has created.

        Raises:
            RecordingError: the file is no mailbox, or of another version.
        """
        path = Path(path)
        try:
            handle = os.open(path, os.O_RDWR | os.O_CLOEXEC)
        except OSError as error:
            raise RecordingError(
                f"the mailbox {path} cannot be opened ({error.strerror}); expected one that 'burnish gui' has made"
            ) from None
        try:
            found = os.fstat(handle).st_size
            head = os.pread(handle, HEADER.size, 0)
            magic, version, joints, size = HEADER.unpack(head) if len(head) == HEADER.size else (b"", 0, 0, 0)
            if magic != MAGIC:
                raise RecordingError(f"{path} is no mailbox; expected one that 'burnish gui' has made")
            if version != VERSION:
                raise RecordingError(
                    f"the mailbox {path} is of version {version}, expected {VERSION}; start both sides anew"
                )
            if not 1 <= joints <= MOST_JOINTS or not size == found == _size(joints):
                raise RecordingError(
                    f"the mailbox {path} is damaged: {found} bytes for {joints} joints; make a new one"
                )
            memory = mmap.mmap(handle, size)
        except (OSError, ValueError) as error:
            raise RecordingError(f"{path} is no mailbox ({error}); expected one that 'burnish gui' has made") from None
        finally:
            os.close(handle)
        return cls(path, memory, joints)

    def close(self) -> None:
        """Leave the memory; the file stays for the other side."""
        del self._numbers, self._reals, self._names, self._stage, self._track
        self._memory.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    # The job's side.

    def post(self, glance: Glance) -> None:
        """Show this from now on; its number is the mailbox's own. Some microseconds; nobody is waited for."""
        self._number += 1
        text = packed(self._layout, glance)
        at = SEATS + (self._number & 1) * self._seat
        head = SEAT.pack(self._number, len(text), zlib.crc32(text, self._number & 0xFFFFFFFF))
        self._memory[at : at + SEAT.size + len(text)] = head + text

    def tell(self, stage: str) -> None:
        """What is being done where nothing moves yet, or any more: planning, checking, reporting."""
        self._stage[0] = stage.encode()[:STAGE]

    def mark(self, p_mould: Array, force: float, speed: float, dt: float) -> None:
        """A row of the contact track: the contact point in the mould's frame [m], N, m/s, and its time [s]."""
        count = int(self._numbers[_COUNT])
        row = self._track[count & (ROWS - 1)]
        row[:3] = p_mould
        row[3], row[4], row[5] = force, speed, dt
        self._numbers[_COUNT] = count + 1

    @property
    def age(self) -> float:
        """Time since the commander's last beat [s]; infinite if there was none."""
        return time.monotonic() - float(self._reals[_BEAT])

    @property
    def commanded(self) -> bool:
        """Whether a commander is there."""
        return abs(self.age) <= PATIENCE

    @property
    def wanted(self) -> Order:
        """The commander's latest order."""
        number = int(self._numbers[_ORDER])
        return Order(number) if number in (0, 1) else Order.STOP

    @property
    def jogged(self) -> Array:
        """The latest jog, (6,) in [-1, 1]; zeros where it is older than `JOG_LASTS` or no numbers."""
        reals = self._reals[_JOG : _JOG + 8].copy()
        fresh = reals[0] == reals[7] and abs(time.monotonic() - reals[0]) <= JOG_LASTS
        twist = reals[1:7]
        return np.clip(twist, -1.0, 1.0) if fresh and np.isfinite(twist).all() else np.zeros(6)

    def pressed(self) -> list[str]:
        """The keys that were pressed since it was asked last; of more than `KEYS` the latest."""
        count = int(self._numbers[_PRESSED])
        new = range(max(self._taken, count - KEYS), count)
        self._taken = count
        return [bytes(self._names[k % KEYS]).decode("ascii", "replace") for k in new]

    # The server's side.

    @property
    def stage(self) -> str:
        """What the job told last."""
        return bytes(self._stage[0]).decode("utf-8", "ignore")

    def latest(self) -> Glance | None:
        """What the job shows now; the one before if it cannot be read whole, None if there is none yet."""
        for _ in range(TRIES):
            seats = [self._read(SEATS + k * self._seat) for k in (0, 1)]
            whole = [seat for seat in seats if seat is not None]
            if whole:
                number, text = max(whole)
                if self._last is None or number > self._last.number:
                    self._last = unpacked(self._layout, number, text)
                break
        return self._last

    def track(self, since: int) -> tuple[int, Array]:
        """The rows of the contact track after the first ``since``: the next count, and rows (k, 6).

        x, y, z in the mould's frame [m], force [N], speed [m/s], time [s]. ``next − since − k`` were overwritten
        before anybody read them.
        """
        count = int(self._numbers[_COUNT])
        first = max(since, count - ROWS, 0)
        rows = self._track[np.arange(first, count) & (ROWS - 1)]
        # What was written over while it was copied is lost as well; the row being written is not counted yet.
        over = int(self._numbers[_COUNT]) + 1 - ROWS - first
        return count, rows[max(0, over) :]

    def beat(self, at: float | None = None) -> None:
        """The commander is alive, now or at a time of `time.monotonic` [s]."""
        self._reals[_BEAT] = time.monotonic() if at is None else at

    def order(self, order: Order) -> None:
        """What the commander wants from now on."""
        self._numbers[_ORDER] = order.value

    def jog(self, twist: Array) -> None:
        """Move the tool like this for at most `JOG_LASTS`: linear and angular, (6,) in [-1, 1]."""
        now = time.monotonic()
        reals = self._reals[_JOG : _JOG + 8]
        reals[0] = np.nan
        reals[1:7] = twist
        reals[7] = now
        reals[0] = now

    def press(self, key: str) -> None:
        """An operator's key, by the name that `Glance.waits_for` has."""
        count = int(self._numbers[_PRESSED])
        self._names[count % KEYS] = key.encode("ascii", "replace")[:KEY]
        self._numbers[_PRESSED] = count + 1

    def _read(self, at: int) -> tuple[int, bytes] | None:
        """Number and bytes of a glance if it is whole."""
        number, length, checksum = SEAT.unpack_from(self._memory, at)
        if number == 0 or length != self._layout.size:
            return None
        text = self._memory[at + SEAT.size : at + SEAT.size + length]
        return (number, text) if zlib.crc32(text, number & 0xFFFFFFFF) == checksum else None


def _seat(joints: int) -> int:
    """Bytes between the two seats."""
    size = SEAT.size + layout(joints).size
    return size + -size % 64


def _size(joints: int) -> int:
    """Bytes of a mailbox."""
    return SEATS + 2 * _seat(joints) + 8 * ROWS * COLUMNS
