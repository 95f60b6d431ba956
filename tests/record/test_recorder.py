from __future__ import annotations

import struct
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, make_reader
from mcap_ros2.decoder import DecoderFactory
from record.samples import NAMES, joint_sample, tool_sample
from rosbags.highlevel import AnyReader
from scipy.spatial.transform import Rotation

from burnish.errors import InputError
from burnish.record.recorder import CHUNK_SIZE, TOPICS, Recorder
from burnish.record.recover import recover

METADATA = {"mould": "sha256:12ab", "seed": "3", "recipe": '{"force_N": 10.0}'}


@pytest.fixture
def rng():
    return np.random.default_rng(5)


def record(path, samples, phase="polish"):
    with Recorder(path, joint_names=NAMES, metadata=METADATA) as recorder:
        for i, sample in enumerate(samples):
            recorder.record(sample, phase if isinstance(phase, str) else phase[i])
    return recorder


def read(path):
    """Topic to the list of (log time [ns], decoded message)."""
    messages = {topic: [] for topic in TOPICS}
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages():
            messages[channel.topic].append((message.log_time, decoded))
    return messages


def salvage(path):
    """Topic and message of all that a file without its end still holds."""
    found = []
    with path.open("rb") as file:
        reader = NonSeekingReader(file, decoder_factories=[DecoderFactory()])
        try:
            for _, channel, _, decoded in reader.iter_decoded_messages(log_time_order=False):
                found.append((channel.topic, decoded))
        except (McapError, struct.error):  # The package says the one inside a chunk, the other inside an index.
            pass
    return found


def xyz(v):
    return [v.x, v.y, v.z]


def matrix(q):
    return Rotation.from_quat([q.x, q.y, q.z, q.w]).as_matrix()


def check(samples, messages):
    """Compare decoded messages, from whichever reader, with what went in."""
    for i, sample in enumerate(samples):
        state, wanted = sample.arm, sample.reference
        joints = messages["/joint_states"][i][1]
        assert tuple(joints.name) == NAMES
        assert np.array_equal(joints.position, state.q)
        assert np.array_equal(joints.velocity, state.dq)
        assert np.array_equal(joints.effort, [] if state.tau is None else state.tau)
        tool, desired = messages["/tool_pose"][i][1], messages["/tool_pose_desired"][i][1]
        (transform,) = messages["/tf"][i][1].transforms
        assert xyz(tool.pose.position) == list(state.p) == xyz(transform.transform.translation)
        assert xyz(desired.pose.position) == list(wanted.p)
        # Rounding of a matrix turned into a quaternion and back.
        assert np.allclose(matrix(tool.pose.orientation), state.R, atol=1e-14)
        assert np.allclose(matrix(transform.transform.rotation), state.R, atol=1e-14)
        assert np.allclose(matrix(desired.pose.orientation), wanted.R, atol=1e-14)
        assert (transform.header.frame_id, transform.child_frame_id) == ("base", "tool")
        wrench = messages["/wrench"][i][1].wrench
        assert xyz(wrench.force) + xyz(wrench.torque) == list(state.F)
        control = messages["/control_state"][i][1]
        assert np.array_equal(control.torque_commanded, sample.commanded)
        assert np.array_equal(control.torque_applied, sample.applied)
        assert control.force_set == wanted.force
        assert control.force_measured == pytest.approx(state.F[:3] @ wanted.normal, abs=1e-15)


def test_mcap_ros2_reads_back_every_number(tmp_path, rng):
    samples = [tool_sample(rng, 0.01 * i, tau=i % 3 > 0) for i in range(150)]
    assert record(tmp_path / "run.mcap", samples).error is None
    messages = read(tmp_path / "run.mcap")
    assert {topic: len(rows) for topic, rows in messages.items()} == dict.fromkeys(TOPICS, 150)
    check(samples, messages)


def test_rosbags_reads_back_every_number(tmp_path, rng):
    samples = [tool_sample(rng, 0.01 * i) for i in range(40)]
    record(tmp_path / "run.mcap", samples)
    messages = {topic: [] for topic in TOPICS}
    with AnyReader([tmp_path / "run.mcap"]) as reader:
        assert {c.topic: c.msgtype for c in reader.connections} == TOPICS
        for connection, stamp, raw in reader.messages():
            messages[connection.topic].append((stamp, reader.deserialize(raw, connection.msgtype)))
    check(samples, messages)


def test_times_are_those_of_the_samples(tmp_path, rng):
    times = [0.0, 0.001, 1.25, 3599.999999999, 4000.5]
    record(tmp_path / "run.mcap", [tool_sample(rng, t) for t in times])
    for rows in read(tmp_path / "run.mcap").values():
        assert [stamp for stamp, _ in rows] == [round(t * 1e9) for t in times]
        headers = [getattr(m, "header", None) or m.transforms[0].header for _, m in rows]
        assert [h.stamp.sec * 10**9 + h.stamp.nanosec for h in headers] == [round(t * 1e9) for t in times]


def test_phases_of_any_length_and_script_are_kept(tmp_path, rng):
    phases = ["", "touch", "polish: stroke 12", "Rückzug – 退く"]
    record(tmp_path / "run.mcap", [tool_sample(rng, 0.1 * i) for i in range(4)], phases)
    assert [m.phase for _, m in read(tmp_path / "run.mcap")["/control_state"]] == phases


def test_what_a_sample_does_not_have_is_not_recorded(tmp_path, rng):
    samples = [joint_sample(rng, 0.0, F=False, tau=False), tool_sample(rng, 0.1), joint_sample(rng, 0.2)]
    record(tmp_path / "run.mcap", samples)
    messages = read(tmp_path / "run.mcap")
    assert [stamp for stamp, _ in messages["/tool_pose_desired"]] == [100_000_000]
    assert [stamp for stamp, _ in messages["/wrench"]] == [100_000_000, 200_000_000]
    control = [m for _, m in messages["/control_state"]]
    assert [m.force_set for m in control] == [0.0, samples[1].reference.force, 0.0]
    # Without a surface there is no direction to measure a force along.
    assert [np.isnan(m.force_measured) for m in control] == [True, False, True]


def test_the_metadata_is_that_of_the_caller(tmp_path):
    record(tmp_path / "run.mcap", [])
    with (tmp_path / "run.mcap").open("rb") as file:
        (metadata,) = make_reader(file).iter_metadata()
    assert (metadata.name, metadata.metadata) == ("burnish", METADATA)


def test_the_summary_counts_what_is_there(tmp_path, rng):
    record(tmp_path / "run.mcap", [tool_sample(rng, 0.01 * i) for i in range(300)])
    with (tmp_path / "run.mcap").open("rb") as file:
        reader = make_reader(file)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
    assert summary.statistics.message_count == 6 * 300
    assert (summary.statistics.message_start_time, summary.statistics.message_end_time) == (0, 2_990_000_000)
    assert len(summary.chunk_indexes) == summary.statistics.chunk_count > 3
    assert max(index.uncompressed_size for index in summary.chunk_indexes) < 2 * CHUNK_SIZE


def test_a_reader_can_seek_by_time_and_topic(tmp_path, rng):
    samples = [tool_sample(rng, 0.01 * i) for i in range(300)]
    record(tmp_path / "run.mcap", samples)
    with (tmp_path / "run.mcap").open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        found = list(reader.iter_decoded_messages(topics=["/wrench"], starting_at=10**9, ending_before=2 * 10**9))
    assert [m.log_time for _, _, m, _ in found] == [round(s.arm.t * 1e9) for s in samples[100:200]]


@pytest.mark.parametrize("share", [0.3, 0.6, 0.95])
def test_a_truncated_file_gives_back_all_its_whole_chunks(tmp_path, rng, share):
    samples = [tool_sample(rng, 0.01 * i) for i in range(600)]
    path = tmp_path / "run.mcap"
    record(path, samples)
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    found = salvage(path)
    # One chunk of about 40 samples may be lost.
    assert len(found) > 6 * (share * 600 - 90)
    positions = [m.position for topic, m in found if topic == "/joint_states"]
    assert np.array_equal(positions, [s.arm.q for s in samples[: len(positions)]])


def test_a_run_that_is_killed_has_written_its_chunks(tmp_path, rng):
    recorder = Recorder(tmp_path / "run.mcap", joint_names=NAMES, metadata=METADATA)
    for i in range(200):
        recorder.record(tool_sample(rng, 0.01 * i), "polish")
    deadline = time.monotonic() + 10.0
    copy = tmp_path / "copy.mcap"
    count = 0
    # What is in the file before close() is what a killed process leaves.
    while count < 6 * 150 and time.monotonic() < deadline:
        copy.write_bytes((tmp_path / "run.mcap").read_bytes())
        count = len(salvage(copy))
        time.sleep(0.02)
    recorder.close()
    assert count >= 6 * 150


def test_ten_thousand_samples_cost_the_caller_an_append_each(tmp_path, rng):
    sample = tool_sample(rng, 0.0)
    recorder = Recorder(tmp_path / "run.mcap", joint_names=NAMES, metadata=METADATA)
    start = time.perf_counter()
    for _ in range(10_000):
        recorder.record(sample, "polish")
    cost = (time.perf_counter() - start) / 10_000
    recorder.close()
    print(f"record: {1e6 * cost:.2f} µs a sample; {recorder.path.stat().st_size / 10_000:.0f} B a sample")
    assert recorder.error is None
    with recorder.path.open("rb") as file:
        assert make_reader(file).get_summary().statistics.message_count == 60_000


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_full_disk_ends_the_recording_and_not_the_run(rng, caplog):
    recorder = Recorder("/dev/full", joint_names=NAMES, metadata=METADATA)
    for i in range(300):
        recorder.record(tool_sample(rng, 0.01 * i), "polish")
    recorder.close()
    assert isinstance(recorder.error, OSError)
    assert "No space left" in str(recorder.error)
    assert "ended early" in caplog.text
    assert not [thread for thread in threading.enumerate() if thread.name == "burnish-recorder"]


def test_a_disk_that_fills_up_later_keeps_what_was_written(tmp_path, rng, monkeypatch):
    recorder = Recorder(tmp_path / "run.mcap", joint_names=NAMES, metadata=METADATA)
    put, written = recorder._file._mcap._put, []

    def full(data):
        written.append(len(data))
        if sum(written) > 100_000:
            raise OSError(28, "No space left on device")
        put(data)

    monkeypatch.setattr(recorder._file._mcap, "_put", full)
    samples = [tool_sample(rng, 0.01 * i) for i in range(400)]
    for sample in samples:
        recorder.record(sample, "polish")
    recorder.close()
    assert isinstance(recorder.error, OSError)
    found = [m.position for topic, m in salvage(tmp_path / "run.mcap") if topic == "/joint_states"]
    assert len(found) > 40
    assert np.array_equal(found, [s.arm.q for s in samples[: len(found)]])


def test_a_sample_of_the_wrong_size_is_an_error_of_the_recording_alone(tmp_path, rng):
    recorder = Recorder(tmp_path / "run.mcap", joint_names=NAMES[:3], metadata=METADATA)
    recorder.record(tool_sample(rng, 0.0), "polish")
    recorder.close()
    assert isinstance(recorder.error, ValueError)


def test_samples_after_an_error_are_dropped(tmp_path, rng):
    recorder = Recorder(tmp_path / "run.mcap", joint_names=NAMES[:3], metadata=METADATA)
    recorder.record(tool_sample(rng, 0.0), "polish")
    recorder.close()
    for i in range(10):
        recorder.record(tool_sample(rng, 0.1 * i), "polish")
    assert len(recorder._queue) == 0


def test_a_file_can_be_read_before_its_first_sample(tmp_path):
    with Recorder(tmp_path / "run.mcap", joint_names=NAMES, metadata=METADATA) as recorder:
        begun = recorder.path.read_bytes()
    (tmp_path / "cut.mcap").write_bytes(begun)
    recover(tmp_path / "cut.mcap", tmp_path / "mended.mcap")
    with (tmp_path / "mended.mcap").open("rb") as file:
        assert make_reader(file).get_summary().statistics.channel_count == 6


def test_a_recording_far_behind_is_given_up_and_keeps_what_came_before(tmp_path, rng, monkeypatch):
    monkeypatch.setattr("burnish.record.recorder.MOST_BEHIND", 50)
    gate = threading.Event()
    recorder = Recorder(tmp_path / "run.mcap", joint_names=NAMES, metadata=METADATA)
    write = recorder._file.write
    monkeypatch.setattr(recorder._file, "write", lambda entries: gate.wait() and write(entries))
    for i in range(300):
        recorder.record(tool_sample(rng, 0.01 * i), "polish")
    assert isinstance(recorder.error, BufferError)
    gate.set()
    recorder.close()
    with recorder.path.open("rb") as file:
        count = make_reader(file).get_summary().statistics.channel_message_counts[1]
    # What the writer holds in its hands, and what was queued.
    assert 51 <= count <= 51 + 32


def test_catching_up_waits_until_the_writer_has_written(tmp_path, rng, monkeypatch):
    monkeypatch.setattr("burnish.record.recorder.MOST_BEHIND", 90)
    with Recorder(tmp_path / "run.mcap", joint_names=NAMES, metadata=METADATA) as recorder:
        for i in range(300):
            recorder.record(tool_sample(rng, 0.01 * i), "polish")
            recorder.catch_up()
            assert len(recorder._queue) <= 30
    assert recorder.error is None


def test_a_folder_that_is_not_there_is_refused_before_the_run(tmp_path):
    with pytest.raises(InputError, match="cannot record"):
        Recorder(tmp_path / "nowhere" / "run.mcap", joint_names=NAMES, metadata=METADATA)


def test_an_interrupted_run_has_a_complete_file(tmp_path, rng):
    samples = [tool_sample(rng, 0.01 * i) for i in range(20)]

    def run():
        with Recorder(tmp_path / "run.mcap", joint_names=NAMES, metadata=METADATA) as recorder:
            for sample in samples:
                recorder.record(sample, "polish")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run()
    check(samples, read(tmp_path / "run.mcap"))


def test_closing_twice_is_harmless(tmp_path):
    recorder = Recorder(tmp_path / "run.mcap", joint_names=NAMES, metadata=METADATA)
    recorder.close()
    recorder.close()
    assert recorder.error is None
