"""A recording of a run: one MCAP file with ROS 2 messages, written by a thread of its own.

The control loop only appends to a queue. The thread packs whole batches, compresses them in chunks of 64 KiB
and hands each to the operating system, so that a run that is killed loses a fraction of a second. A disk that
is full stops the recording, never the arm.
"""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import IO

import numpy as np
from typing_extensions import Self

from burnish import rotation
from burnish.core import Array, Sample, ToolReference
from burnish.errors import InputError
from burnish.runtime import messages
from burnish.runtime.mcap_file import McapFile

logger = logging.getLogger(__name__)

CHUNK_SIZE = 64 * 1024
"""Uncompressed size of a chunk [B]: what a killed run loses at most."""
PERIOD = 0.05
"""Time between two batches [s]."""
BATCH = 32
"""Most samples of a batch: about 50 kB of messages, so that chunks come out near their size."""
BASE_FRAME, TOOL_FRAME = "base", "tool"

TOPICS = {
    "/joint_states": "sensor_msgs/msg/JointState",
    "/tool_pose": "geometry_msgs/msg/PoseStamped",
    "/tool_pose_desired": "geometry_msgs/msg/PoseStamped",
    "/wrench": "geometry_msgs/msg/WrenchStamped",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/control_state": "burnish_msgs/msg/ControlState",
}
"""Topic to message type."""

Entry = tuple[Sample, str]


class Recorder:
    """Writes samples to an MCAP file; use it as a context manager.

    ``/wrench`` is the contact wrench that was measured, base axes; it and ``/tool_pose_desired`` are absent
    from samples that have none. Message times are those of the samples.
    """

    error: Exception | None
    """What ended the recording early; None while all is well. Later samples are dropped."""

    def __init__(self, path: Path | str, *, joint_names: Sequence[str], metadata: Mapping[str, str]) -> None:
        """Open the file and write what is known before the first sample.

        Args:
            path: of the file; one that exists is replaced.
            joint_names: one a joint, in the order of q.
            metadata: what a reader needs to know of the run: hashes, recipe, limits, versions, seed.

        Raises:
            InputError: if the file cannot be opened.
        """
        self.error = None
        self.path = Path(path)
        try:
            file = self.path.open("wb")
        except OSError as error:
            raise InputError(f"cannot record to {path}: {error.strerror}; give a folder that is writable") from error
        self._queue: deque[Entry] = deque()
        self._stopping = threading.Event()
        self._file = _File(file, tuple(joint_names), metadata)
        self._thread = threading.Thread(target=self._run, name="burnish-recorder", daemon=True)
        self._thread.start()

    def record(self, sample: Sample, phase: str) -> None:
        """Queue one sample; costs about a microsecond, never blocks and never fails.

        Args:
            sample: of the control loop; its arrays must not change afterwards.
            phase: what the run is doing.
        """
        if self.error is None:
            self._queue.append((sample, phase))

    def close(self) -> None:
        """Write what is queued, the index and the end of the file; returns when all of it is on its way."""
        self._stopping.set()
        self._thread.join()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _run(self) -> None:
        try:
            self._file.begin()
            stopping = False
            while not stopping:
                # Asked before the queue is emptied: whatever came before close() is written.
                stopping = self._stopping.wait(PERIOD)
                while self._queue:
                    self._file.write(self._take())
            self._file.finish()
        except Exception as error:  # noqa: BLE001  The edge of the thread: nothing may reach the control loop.
            self.error = error
            self._queue.clear()
            logger.error("the recording %s ended early: %s", self.path, error)
        finally:
            self._file.abandon()

    def _take(self) -> list[Entry]:
        return [self._queue.popleft() for _ in range(min(BATCH, len(self._queue)))]


class _File:
    """The MCAP file; touched by the thread alone once that has started."""

    def __init__(self, file: IO[bytes], joint_names: tuple[str, ...], metadata: Mapping[str, str]) -> None:
        self._file = file
        self._metadata = {str(name): str(value) for name, value in metadata.items()}
        self._joints = len(joint_names)
        self._joint_state = {effort: messages.joint_state(joint_names, effort) for effort in (False, True)}
        self._pose = messages.pose(BASE_FRAME)
        self._wrench = messages.wrench(BASE_FRAME)
        self._transform = messages.transform(BASE_FRAME, TOOL_FRAME)
        self._control = messages.control_state(self._joints)
        self._mcap = McapFile(file, CHUNK_SIZE)
        self._channels: dict[str, int] = {}
        self._count = 0

    def begin(self) -> None:
        """Header, metadata, schemas and channels."""
        self._channels = self._mcap.begin("burnish", self._metadata, messages.SCHEMAS, TOPICS)

    def write(self, entries: list[Entry]) -> None:
        """All messages of a batch, sample by sample."""
        stamps = np.array([round(sample.arm.t * 1e9) for sample, _ in entries], dtype=np.int64)
        topics, columns = zip(*self._pack(entries, stamps), strict=True)
        numbers = [self._channels[topic] for topic in topics]
        rows = [
            (channel, stamp, self._count + i, data)
            for i, (stamp, row) in enumerate(zip(stamps.tolist(), zip(*columns, strict=True), strict=True))
            for channel, data in zip(numbers, row, strict=True)
            if data
        ]
        channels, times, sequences, payloads = zip(*rows, strict=True)
        self._mcap.write(channels, times, sequences, payloads)
        self._count += len(entries)

    def finish(self) -> None:
        """Last chunk, index and end."""
        self._mcap.finish()
        self._file.close()

    def abandon(self) -> None:
        """Let go of the file, whatever state it is in."""
        try:
            self._file.close()
        except OSError as error:
            logger.debug("closing the recording: %s", error)

    def _pack(self, entries: list[Entry], stamps: messages.Stamps) -> Iterable[tuple[str, list[bytes]]]:
        """Topic and one message a sample; empty bytes where the sample has nothing to say."""
        arms = [sample.arm for sample, _ in entries]
        efforts = [arm.tau for arm in arms]
        motion = {"position": np.array([arm.q for arm in arms]), "velocity": np.array([arm.dq for arm in arms])}
        yield (
            "/joint_states",
            _merge(
                self._joint_state[False].fill(stamps, **motion),
                self._joint_state[True].fill(stamps, **motion, effort=_rows(efforts, self._joints)),
                efforts,
            ),
        )
        place = {"position": np.array([arm.p for arm in arms]), "orientation": _orientations([arm.R for arm in arms])}
        yield "/tool_pose", self._pose.fill(stamps, **place)
        yield "/tf", self._transform.fill(stamps, **place)

        wanted = [s.reference if isinstance(s.reference, ToolReference) else None for s, _ in entries]
        desired = self._pose.fill(
            stamps,
            position=_rows([None if w is None else w.p for w in wanted], 3),
            orientation=_orientations([np.eye(3) if w is None else w.R for w in wanted]),
        )
        yield "/tool_pose_desired", _merge([b""] * len(entries), desired, wanted)
        wrenches = [arm.F for arm in arms]
        yield "/wrench", _merge([b""] * len(entries), self._wrench.fill(stamps, wrench=_rows(wrenches, 6)), wrenches)

        control = self._control.fill(
            stamps,
            torque_commanded=np.array([sample.commanded for sample, _ in entries]),
            torque_applied=np.array([sample.applied for sample, _ in entries]),
            force_set=[0.0 if w is None else w.force for w in wanted],
            force_measured=[_pressing(F, w) for F, w in zip(wrenches, wanted, strict=True)],
        )
        phases = [messages.text(phase) for _, phase in entries]
        yield "/control_state", [head + phase for head, phase in zip(control, phases, strict=True)]


def _merge(absent: list[bytes], present: list[bytes], values: Sequence[object]) -> list[bytes]:
    """Per sample, ``present`` where there is a value."""
    return [a if value is None else p for a, p, value in zip(absent, present, values, strict=True)]


def _rows(values: Sequence[Array | None], count: int) -> Array:
    blank = np.zeros(count)
    return np.array([blank if value is None else value for value in values])


def _orientations(rotations: Sequence[Array]) -> Array:
    """Quaternions in the order of ROS, x y z w, (N, 4)."""
    return np.array([rotation.quaternion(R) for R in rotations])[:, [1, 2, 3, 0]]


def _pressing(F: Array | None, wanted: ToolReference | None) -> float:
    """Measured force along the outward normal [N]; NaN without a sensor or without a surface.

    ``F`` is what the environment does to the tool, so a tool that presses is pushed along the outward normal.
    """
    if F is None or wanted is None or wanted.normal is None:
        return float("nan")
    return float(F[:3] @ wanted.normal)
