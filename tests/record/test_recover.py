from __future__ import annotations

import random
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import NonSeekingReader, make_reader
from mcap_ros2.decoder import DecoderFactory
from record.samples import record, tool_sample

from burnish.errors import InputError, RecordingError
from burnish.record.mcap_file import McapFile
from burnish.record.recorder import Recorder
from burnish.record.recover import MENDED, recover


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    rng = np.random.default_rng(3)
    return record(tmp_path / "run.mcap", [tool_sample(rng, 0.01 * i) for i in range(70)], mould="dome")


def messages(path: Path) -> list[tuple[str, int, bytes]]:
    """Topic, time and bytes of all messages, by the index."""
    with path.open("rb") as file:
        found = make_reader(file, validate_crcs=True).iter_messages(log_time_order=False)
        return [(channel.topic, message.log_time, message.data) for _, channel, message in found]


def messages_in_order(path: Path) -> int:
    """Number of messages from front to back, the checksum of the whole file included."""
    with path.open("rb") as file:
        return sum(1 for _ in NonSeekingReader(file, validate_crcs=True).iter_messages(log_time_order=False))


def cut_lengths(data: bytes) -> list[int]:
    """Every length near the ends of the file and the starts of its chunks, and a share of all others."""
    edges = {0, len(data)} | {i for i in range(len(data)) if data.startswith(b"\x04\0\0\0zstd", i)}
    near = {cut for edge in edges for cut in range(edge - 20, edge + 20) if 0 <= cut <= len(data)}
    return sorted(near | set(range(0, len(data) + 1, 997)))


def check_cuts(recording: Path, cuts: list[int]) -> None:
    data, whole = recording.read_bytes(), messages(recording)
    cut_file, out = recording.with_name("cut.mcap"), recording.with_name("out.mcap")
    before = 0
    for cut in cuts:
        cut_file.write_bytes(data[:cut])
        out.unlink(missing_ok=True)
        if cut < 8:
            with pytest.raises(RecordingError):
                recover(cut_file, out)
            assert not out.exists()
            continue
        saved = recover(cut_file, out)
        found = messages(out)
        assert found == whole[: len(found)], cut
        assert len(found) == saved.messages == messages_in_order(out)
        assert len(found) >= before, "a longer file gives no less"
        before = len(found)
        assert bool(saved.damages) == (cut < len(data))
        assert cut_file.read_bytes() == data[:cut], "the original is only read"
    assert before == len(whole)


def test_a_recording_cut_anywhere_gives_back_its_first_messages(recording: Path) -> None:
    check_cuts(recording, cut_lengths(recording.read_bytes()))


@pytest.mark.slow
def test_a_recording_cut_at_every_length_gives_back_its_first_messages(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    recording = record(tmp_path / "run.mcap", [tool_sample(rng, 0.01 * i) for i in range(6)])
    check_cuts(recording, list(range(len(recording.read_bytes()) + 1)))


def test_what_is_mended_is_decoded_as_what_was_recorded(recording: Path, tmp_path: Path) -> None:
    data = recording.read_bytes()
    recording.write_bytes(data[: int(0.9 * len(data))])
    recover(recording, tmp_path / "out.mcap")
    with (tmp_path / "out.mcap").open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        decoded = [m.decoded_message for m in reader.iter_decoded_messages(topics=["/control_state"])]
        notes = {note.name: note.metadata for note in reader.iter_metadata()}
    assert len(decoded) > 5
    assert all(message.phase == "pass" for message in decoded)
    assert notes["burnish"] == {"mould": "dome"}
    assert "byte" in notes[MENDED]["damages"]


def test_a_whole_recording_is_copied_and_nothing_is_lost(recording: Path, tmp_path: Path) -> None:
    saved = recover(recording, tmp_path / "out.mcap")
    assert (saved.damages, saved.unread, saved.messages) == ([], 0, 420)
    assert messages(tmp_path / "out.mcap") == messages(recording)


def test_a_damaged_chunk_costs_only_itself(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    path, out = record(tmp_path / "run.mcap", [tool_sample(rng, 0.01 * i) for i in range(300)]), tmp_path / "out.mcap"
    data, whole = bytearray(path.read_bytes()), messages(path)
    second = data.index(b"\x04\0\0\0zstd", data.index(b"\x04\0\0\0zstd") + 1)
    data[second + 5000] ^= 4
    path.write_bytes(data)
    saved = recover(path, out)
    found = messages(out)
    assert 0 < len(found) < len(whole)
    # What is left stands in its order, its beginning and its end included.
    rest = iter(whole)
    assert all(message in rest for message in found)
    assert (found[0], found[-1]) == (whole[0], whole[-1])
    assert any("checksum" in damage.reason for damage in saved.damages)


def test_flipped_bits_are_refused_or_mended_and_never_invent_a_message(recording: Path, tmp_path: Path) -> None:
    data, whole, out = recording.read_bytes(), set(messages(recording)), tmp_path / "out.mcap"
    rng = random.Random(11)
    chunks = data.index(b"\x04\0\0\0zstd")
    for _ in range(60):
        damaged = bytearray(data)
        # Behind the topics: their names and types have no checksum before the end of the file.
        damaged[rng.randrange(chunks - 40, len(data))] ^= 1 << rng.randrange(8)
        recording.write_bytes(damaged)
        out.unlink(missing_ok=True)
        saved = recover(recording, out)
        assert saved.damages
        assert set(messages(out)) <= whole


def test_messages_of_an_unpacked_unfinished_chunk_are_saved(tmp_path: Path) -> None:
    # As other recorders write it: no compression, and the length of the chunk known before its end.
    from mcap.writer import CompressionType, Writer

    path, out = tmp_path / "other.mcap", tmp_path / "out.mcap"
    with path.open("wb") as file:
        writer = Writer(file, compression=CompressionType.NONE)
        writer.start()
        schema = writer.register_schema("text", "jsonschema", b"{}")
        channel = writer.register_channel("/text", "json", schema)
        for i in range(100):
            writer.add_message(channel, i, b'{"text": "hello"}', i)
        writer.finish()
    data = path.read_bytes()
    path.write_bytes(data[: data.index(b"hello", 3000)])
    saved = recover(path, out)
    assert 20 < saved.messages < 100
    assert [stamp for _, stamp, _ in messages(out)] == list(range(saved.messages))


@pytest.mark.parametrize("content", [b"", b"\x89MCAP", b"solid mould", bytes(1000), b"\x89PNG\r\n\x1a\n" + bytes(100)])
def test_what_is_no_recording_is_refused(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(content)
    with pytest.raises(RecordingError, match="recording"):
        recover(path, tmp_path / "out.mcap")
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_a_file_that_exists_is_not_replaced(recording: Path, tmp_path: Path) -> None:
    (tmp_path / "mine").write_text("mine")
    with pytest.raises(InputError, match="exists"):
        recover(recording, tmp_path / "mine")
    with pytest.raises(InputError, match="cannot write"):
        recover(recording, tmp_path / "nowhere" / "out.mcap")
    assert (tmp_path / "mine").read_text() == "mine"


def test_a_chunk_that_promises_more_than_is_read_is_left_out(tmp_path: Path) -> None:
    # A few kB that would unpack to a gigabyte.
    import struct

    import zstandard

    bomb = zstandard.compress(bytes(2**27))
    size = 2**20
    head = struct.pack("<QQQII4sQ", 0, 1, size, 0, 4, b"zstd", len(bomb))
    with (tmp_path / "bomb.mcap").open("wb") as file:
        McapFile(file, 1).begin("bomb")
        file.write(struct.pack("<BQ", 6, len(head) + len(bomb)) + head + bomb)
    saved = recover(tmp_path / "bomb.mcap", tmp_path / "out.mcap")
    assert saved.messages == 0
    assert "checksum" in saved.damages[0].reason


def test_a_short_run_that_was_killed_before_its_first_chunk_is_an_empty_recording(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "run.mcap", joint_names=("one",), metadata={})
    recorder.close()
    data = (tmp_path / "run.mcap").read_bytes()
    (tmp_path / "run.mcap").write_bytes(data[: len(data) // 2])
    assert recover(tmp_path / "run.mcap", tmp_path / "out.mcap").messages == 0
    assert messages(tmp_path / "out.mcap") == []
