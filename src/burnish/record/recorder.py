"""A recording of a run: one MCAP file with ROS 2 messages, written by a thread of its own.

The control loop only appends to a queue. Every 10 ms at 1 kHz, 25 ms at 100 Hz, the thread packs what has come,
compresses it and hands it to the operating system as a chunk that stands for itself, so that a run that is killed loses
what its last few hundredths of a second brought. A disk that is full stops the recording, never the arm.
"""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Mapping, Sequence
from itertools import groupby
from pathlib import Path
from time import monotonic, sleep
from types import TracebackType
from typing import IO, Any, NamedTuple

import numpy as np
from typing_extensions import Self

from burnish import rotation
from burnish.core import Array, Sample, ToolReference
from burnish.errors import InputError
from burnish.record import messages
from burnish.record.cycle import Cycle
from burnish.record.mcap_file import McapFile

logger = logging.getLogger(__name__)

CHUNK_SIZE = 64 * 1024
"""Uncompressed size at which a chunk is closed before its time [B]; a cycle takes about 1.3 kB."""
PERIOD = 0.01
"""Time between two looks at the queue [s]. On a busy machine the thread gets a processor and the interpreter late, some
times over: with 20 ms what a killed run lost was above 50 ms there now and then."""
FEW, LATEST = 8, 0.025
"""Fewer samples than this wait for more until so long after the last chunk [s]: small chunks cost time and space."""
BATCH = 32
"""Most samples that are packed at once: about 40 kB of messages, so that chunks come out near their size."""
BASE_FRAME, TOOL_FRAME = "base", "tool"
START, END = "burnish", "burnish_end"
"""Names of the metadata that are known before the first sample, and after the last one."""
MOST_BEHIND = 30_000
"""Samples that wait to be written, about 150 MB, beyond which the recording is given up: half a minute at 1 kHz."""
MOST_SHAPES = 64
"""Layouts of a cycle that are kept; a run has about a dozen phases."""

JOINTS, POSE, TRANSFORM = "/joint_states", "/tool_pose", "/tf"
DESIRED, WRENCH, CONTROL = "/tool_pose_desired", "/wrench", "/control_state"
TOPICS = {
    JOINTS: "sensor_msgs/msg/JointState",
    POSE: "geometry_msgs/msg/PoseStamped",
    DESIRED: "geometry_msgs/msg/PoseStamped",
    WRENCH: "geometry_msgs/msg/WrenchStamped",
    TRANSFORM: "tf2_msgs/msg/TFMessage",
    CONTROL: "burnish_msgs/msg/ControlState",
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
        self._ending: dict[str, str] = {}
        try:
            # Before the first sample: a run that is killed at once has a file that can be read.
            self._file.begin()
        except OSError as error:
            self._give_up(error)
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
            if len(self._queue) > MOST_BEHIND:
                self._give_up(BufferError(f"the disk or the processor is too slow: {MOST_BEHIND} samples behind"))

    def catch_up(self) -> None:
        """Wait while the writing is far behind: for a loop in simulated time, which nothing else holds back."""
        while len(self._queue) > MOST_BEHIND // 3 and self.error is None:
            sleep(PERIOD)

    def end_with(self, **values: str) -> None:
        """Names and values to write behind the last sample: how the run ended."""
        self._ending |= values

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
            if self.error is not None:
                return
            stopping, written = False, monotonic()
            while not stopping:
                # Asked before the queue is emptied: whatever came before close() is written.
                stopping = self._stopping.wait(PERIOD)
                if len(self._queue) < FEW and not stopping and monotonic() - written < LATEST:
                    continue
                written = monotonic()
                while self._queue:
                    self._file.write(self._take())
                self._file.flush()
            self._file.finish(self._ending)
        except Exception as error:  # noqa: BLE001  The edge of the thread: nothing may reach the control loop.
            self._queue.clear()
            self._give_up(error)
        finally:
            self._file.abandon()

    def _give_up(self, error: Exception) -> None:
        """End the recording with what came so far; the run goes on."""
        self.error = error
        logger.error("the recording %s ended early: %s", self.path, error)

    def _take(self) -> list[Entry]:
        return [self._queue.popleft() for _ in range(min(BATCH, len(self._queue)))]


class _Shape(NamedTuple):
    """What a sample has to say; samples of one shape are packed together."""

    effort: bool
    wrench: bool
    desired: bool
    normal: bool
    phase: str


def _shape(entry: Entry) -> _Shape:
    sample, phase = entry
    arm, wanted = sample.arm, sample.reference
    desired = isinstance(wanted, ToolReference)
    return _Shape(arm.tau is not None, arm.F is not None, desired, desired and wanted.normal is not None, phase)


class _File:
    """The MCAP file; touched by the thread alone once that has started."""

    def __init__(self, file: IO[bytes], joint_names: tuple[str, ...], metadata: Mapping[str, str]) -> None:
        self._file = file
        self._metadata = {str(name): str(value) for name, value in metadata.items()}
        self._names = joint_names
        self._mcap = McapFile(file, CHUNK_SIZE)
        self._channels: dict[str, int] = {}
        self._cycles: dict[_Shape, Cycle] = {}
        self._count = 0

    def begin(self) -> None:
        """Header, metadata, schemas and channels, handed to the operating system."""
        self._mcap.begin("burnish")
        self._mcap.note(START, self._metadata)
        self._channels = self._mcap.describe(messages.SCHEMAS, TOPICS)

    def write(self, entries: list[Entry]) -> None:
        """All messages of a batch, sample by sample."""
        for shape, run in groupby(entries, key=_shape):
            samples = [sample for sample, _ in run]
            stamps = np.array([round(sample.arm.t * 1e9) for sample in samples], dtype=np.int64)
            columns = _columns(samples, shape, len(self._names))
            self._mcap.write(*self._cycle(shape).encode(self._count, stamps, columns))
            self._count += len(samples)

    def flush(self) -> None:
        """Hand all messages so far to the operating system."""
        self._mcap.close_chunk()

    def finish(self, ending: Mapping[str, str]) -> None:
        """Last chunk, how it ended, index and end."""
        if ending:
            self._mcap.note(END, {"cycles": str(self._count), **ending})
        self._mcap.finish()
        self._file.close()

    def abandon(self) -> None:
        """Let go of the file, whatever state it is in."""
        try:
            self._file.close()
        except OSError as error:
            logger.debug("closing the recording: %s", error)

    def _cycle(self, shape: _Shape) -> Cycle:
        """The layout of a cycle of this shape."""
        if shape not in self._cycles:
            if len(self._cycles) >= MOST_SHAPES:
                self._cycles.clear()
            self._cycles[shape] = self._laid_out(shape)
        return self._cycles[shape]

    def _laid_out(self, shape: _Shape) -> Cycle:
        parts = {
            JOINTS: messages.joint_state(self._names, shape.effort),
            POSE: messages.pose(BASE_FRAME),
            TRANSFORM: messages.transform(BASE_FRAME, TOOL_FRAME),
        }
        if shape.desired:
            parts[DESIRED] = messages.pose(BASE_FRAME)
        if shape.wrench:
            parts[WRENCH] = messages.wrench(BASE_FRAME)
        parts[CONTROL] = messages.control_state(len(self._names), shape.phase)
        return Cycle([(topic, self._channels[topic], template) for topic, template in parts.items()])


def _columns(samples: Sequence[Sample], shape: _Shape, joints: int) -> dict[str, dict[str, Any]]:
    """For each topic its numbers, a row a sample."""
    count = len(samples)
    arms = [sample.arm for sample in samples]
    wanted = [sample.reference for sample in samples]

    def rows(values: Sequence[Any], width: int) -> Array:
        # One copy of all: three times as fast as an array of arrays. A wrong size does not fit the shape.
        return np.concatenate(values).reshape(count, width)

    turned = [arm.R for arm in arms] + ([w.R for w in wanted] if shape.desired else [])
    orientation = rotation.quaternions(np.concatenate(turned).reshape(-1, 3, 3))[:, [1, 2, 3, 0]]
    place = {"position": rows([arm.p for arm in arms], 3), "orientation": orientation[:count]}
    joint = {"position": rows([arm.q for arm in arms], joints), "velocity": rows([arm.dq for arm in arms], joints)}
    if shape.effort:
        joint["effort"] = rows([arm.tau for arm in arms], joints)
    columns: dict[str, dict[str, Any]] = {JOINTS: joint, POSE: place, TRANSFORM: place}
    control: dict[str, Any] = {
        "torque_commanded": rows([sample.commanded for sample in samples], joints),
        "torque_applied": rows([sample.applied for sample in samples], joints),
        "force_set": 0.0,
        # Nothing is measured without a sensor, nor along no normal.
        "force_measured": np.nan,
    }
    if shape.desired:
        columns[DESIRED] = {"position": rows([w.p for w in wanted], 3), "orientation": orientation[count:]}
        control["force_set"] = [w.force for w in wanted]
    if shape.wrench:
        wrench = rows([arm.F for arm in arms], 6)
        columns[WRENCH] = {"wrench": wrench}
        if shape.normal:
            # The wrench is what the environment does to the tool: one that presses is pushed along the outward normal.
            control["force_measured"] = np.einsum("ij,ij->i", wrench[:, :3], rows([w.normal for w in wanted], 3))
    columns[CONTROL] = control
    return columns
