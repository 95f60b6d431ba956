from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from record.samples import NAMES, joint_sample, record, tool_sample

from burnish import rotation
from burnish.core import Sample
from burnish.errors import RecordingError
from burnish.record.compare import compare
from burnish.record.described import described, fingerprint
from burnish.record.mcap_file import McapFile
from burnish.record.recording import Cycles, Recording


def some_samples(count: int = 90, seed: int = 7) -> list[Sample]:
    """Tool and joint motion, with and without sensors."""
    rng = np.random.default_rng(seed)
    return [(tool_sample if i % 4 else joint_sample)(rng, 0.01 * i, F=i % 5 > 0, tau=i % 3 > 0) for i in range(count)]


def read(path: Path) -> Cycles:
    """All cycles of a recording in one piece."""
    blocks = list(Recording(path).blocks())
    return Cycles(**{f.name: np.concatenate([getattr(block, f.name) for block in blocks]) for f in fields(Cycles)})


def test_every_number_comes_back_and_what_was_absent_is_nan(tmp_path: Path) -> None:
    samples = some_samples()
    phases = [f"part {i // 30}" for i in range(90)]
    path = record(tmp_path / "run.mcap", samples, phases, seed="3")
    recording, cycles = Recording(path), read(path)
    assert (recording.metadata, recording.joint_names) == ({"seed": "3"}, NAMES)
    assert (recording.ending, recording.mended) == ({"cycles": "90", "outcome": "done"}, False)
    assert cycles.phase.tolist() == phases
    nothing = {n: np.full(n, np.nan) for n in (3, 4, 6)}
    for i, (arm, wanted, commanded, applied) in enumerate(samples):
        desired = getattr(wanted, "p", None) is not None
        expected = {
            "t": round(1e9 * arm.t) / 1e9,  # whole nanoseconds
            "q": arm.q,
            "dq": arm.dq,
            "tau": nothing[6] if arm.tau is None else arm.tau,
            "p": arm.p,
            "p_d": wanted.p if desired else nothing[3],
            "F": nothing[6] if arm.F is None else arm.F,
            "commanded": commanded,
            "applied": applied,
            "force_set": wanted.force if desired else 0.0,
        }
        for name, value in expected.items():
            assert np.array_equal(getattr(cycles, name)[i], value, equal_nan=True), (i, name)
        # Rounding of a matrix turned into a quaternion.
        assert np.allclose(cycles.Q[i], rotation.quaternion(arm.R)[[1, 2, 3, 0]], atol=1e-15)
        assert np.isnan(cycles.Q_d[i]).all() != desired
        assert np.isnan(cycles.force_measured[i]) == (not desired or arm.F is None)


def test_a_recording_that_was_cut_off_or_damaged_is_refused_with_the_remedy(tmp_path: Path) -> None:
    path = record(tmp_path / "run.mcap", some_samples())
    data = path.read_bytes()
    flipped = bytearray(data)
    # In the metadata, which no chunk's checksum covers.
    flipped[data.index(b"sensor_msgs")] ^= 1
    for content in (data[: len(data) // 2], data[:-1], bytes(flipped)):
        path.write_bytes(content)
        with pytest.raises(RecordingError, match="Mend it with 'burnish recover"):
            Recording(path)


def test_a_recording_of_something_else_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "other.mcap"
    with path.open("wb") as file:
        other = McapFile(file, 1)
        other.begin("other")
        other.describe({"sensor_msgs/msg/Joy": "float32[] axes"}, {"/joint_states": "sensor_msgs/msg/Joy"})
        other.finish()
    with pytest.raises(RecordingError, match="/joint_states is not a sensor_msgs/msg/JointState"):
        Recording(path)
    with path.open("wb") as file:
        other = McapFile(file, 1)
        other.begin("other")
        other.finish()
    with pytest.raises(RecordingError, match="not recorded by burnish"):
        Recording(path)


def test_two_recordings_of_the_same_samples_are_equal_bit_by_bit(tmp_path: Path) -> None:
    one = record(tmp_path / "one.mcap", some_samples())
    other = record(tmp_path / "other.mcap", some_samples())
    result = compare(Recording(one), Recording(other))
    assert (result.first, result.lengths) == ({}, (90, 90))


def test_one_bit_is_found_with_its_cycle_and_its_size(tmp_path: Path) -> None:
    samples = some_samples()
    one = record(tmp_path / "one.mcap", samples)
    q = samples[61].commanded.copy()
    q[2] = np.nextafter(q[2], np.inf)
    samples[61] = samples[61]._replace(commanded=q)
    result = compare(Recording(one), Recording(record(tmp_path / "other.mcap", samples)))
    assert list(result.first) == ["/control_state"]
    place = result.first["/control_state"]
    assert (place.cycle, place.t, place.name) == (61, 0.61, "tau_commanded3")
    assert result.largest == {"tau_commanded3": np.spacing(abs(q[2]))} or result.largest["tau_commanded3"] > 0.0


def test_a_shorter_recording_is_equal_as_far_as_it_goes(tmp_path: Path) -> None:
    one = record(tmp_path / "one.mcap", some_samples()[:50])
    other = record(tmp_path / "other.mcap", some_samples())
    result = compare(Recording(one), Recording(other))
    assert (result.first, result.lengths) == ({}, (50, 90))


def test_a_fingerprint_tells_the_last_bit_and_not_the_memory_of_a_law() -> None:
    from burnish.control.force import ForceMotion

    law, other = ForceMotion(), ForceMotion(force_gain=float(np.nextafter(0.1, 1.0)))
    assert fingerprint(law) == fingerprint(ForceMotion())
    assert fingerprint(law) != fingerprint(other)
    assert '"type": "ForceMotion"' in described(law)
    assert '"_integral"' not in described(law)


def test_quaternions_of_many_rotations_are_those_of_each() -> None:
    rng = np.random.default_rng(2)
    vectors = [*rng.normal(size=(200, 3)), np.zeros(3), *(np.pi * np.eye(3)), *((np.pi - 1e-9) * -np.eye(3))]
    R = np.array([rotation.exp(vector) for vector in vectors])
    # At half a turn q and −q are one rotation.
    apart = np.abs(np.einsum("ij,ij->i", rotation.quaternions(R), [rotation.quaternion(r) for r in R]))
    assert np.allclose(apart, 1.0, atol=1e-15)
    assert (rotation.quaternions(R)[:, 0] >= 0.0).all()
