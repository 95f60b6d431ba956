"""A demonstration through a recording and back, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from teach.cells import shown

from burnish.core import Dynamics, Sample, ToolReference
from burnish.errors import RecordingError
from burnish.record.poses_file import read_poses
from burnish.record.recorder import Recorder
from burnish.record.recording import Recording
from burnish.teach.demonstration import STORED, Demonstration, check_same, phase_of, placement_text, write_poses


def recorded(path: Path, wanted: Demonstration, ending: dict[str, str], **metadata: str) -> Recording:
    """A recording of a demonstration between ten cycles before and after it, in base axes as the arm has them."""
    placement, n = wanted.placement, 6
    about = {"verb": "teach", "placement": placement_text(placement), "law": wanted.gains} | metadata
    with Recorder(path, joint_names=[f"joint_{i}" for i in range(n)], metadata=about) as recorder:
        for k in range(-10, len(wanted.t) + 10):
            i = min(max(k, 0), len(wanted.t) - 1)
            inside = 0 <= k < len(wanted.t)
            p, R = placement.points(wanted.p[i : i + 1])[0], placement.R @ wanted.R[i]
            F = np.concatenate([placement.R @ wanted.F[i, :3], placement.R @ wanted.F[i, 3:]])
            zero = np.zeros(n)
            arm = Dynamics.of(t=1.0 + 0.01 * k, q=zero, dq=zero, p=p, R=R, F=F, tau=None)
            p_d, R_d = placement.points(wanted.p_d[i : i + 1])[0], placement.R @ wanted.R_d[i]
            reference = ToolReference(p=p_d, R=R_d, v=np.zeros(6), a=np.zeros(6))
            phase = phase_of(bool(wanted.contact[i]), str(wanted.mode[i])) if inside else "home"
            recorder.record(Sample(arm, reference, zero, zero), phase)
        recorder.end_with(**ending)
    return Recording(path)


def stored(wanted: Demonstration) -> dict[str, str]:
    return {STORED: f"10 {10 + len(wanted.t) - 1}"}


def test_a_demonstration_comes_back_from_its_recording_in_the_mould_s_frame(tmp_path: Path) -> None:
    wanted = shown(noise=0.3)
    found = Demonstration.of(recorded(tmp_path / "run.mcap", wanted, stored(wanted)))
    assert found.t == pytest.approx(wanted.t)
    for name in ("p", "p_d", "R", "R_d"):
        assert getattr(found, name) == pytest.approx(getattr(wanted, name), abs=1e-12)
    assert pytest.approx(wanted.F, abs=1e-12) == found.F
    assert (found.contact == wanted.contact).all()
    assert (found.mode == wanted.mode).all()


def test_the_poses_file_has_a_line_a_cycle_in_base_axes_and_is_read_back(tmp_path: Path) -> None:
    wanted = shown()
    write_poses(tmp_path / "desired_poses.txt", wanted)
    poses = read_poses(tmp_path / "desired_poses.txt")
    assert (poses.p == wanted.placement.points(wanted.p_d)).all()


def test_a_recording_of_another_verb_or_without_anything_stored_is_refused(tmp_path: Path) -> None:
    wanted = shown()
    with pytest.raises(RecordingError, match="of 'polish'"):
        Demonstration.of(recorded(tmp_path / "a.mcap", wanted, stored(wanted), verb="polish"))
    with pytest.raises(RecordingError, match="no stored demonstration"):
        Demonstration.of(recorded(tmp_path / "b.mcap", wanted, {}))


@pytest.mark.parametrize("words", ["0 400", "10 99999", "10", "-1 5", "a b", "15 20"])
def test_stored_cycles_that_cannot_be_are_refused(tmp_path: Path, words: str) -> None:
    with pytest.raises(RecordingError):
        Demonstration.of(recorded(tmp_path / "run.mcap", shown(), {STORED: words}))


@pytest.mark.parametrize("words", ["", "0 0 0", "0 0 0 2 0 0 0", "nan 0 0 1 0 0 0", "a b c d e f g"])
def test_a_placement_that_is_none_is_refused(tmp_path: Path, words: str) -> None:
    wanted = shown()
    with pytest.raises(RecordingError, match="where the mould stood"):
        Demonstration.of(recorded(tmp_path / "run.mcap", wanted, stored(wanted), placement=words))


@pytest.mark.parametrize("other", ["model", "tool", "mould"])
def test_another_arm_tool_or_mould_is_refused_by_its_hash(tmp_path: Path, other: str) -> None:
    here = {name: f"{name[0]}" * 64 for name in ("model", "tool", "mould")}
    hashes = {f"{name}_sha256": value for name, value in here.items()}
    recording = recorded(tmp_path / "run.mcap", shown(), {}, **hashes)
    check_same(recording, **here)
    with pytest.raises(RecordingError, match=r"hash is '.{16}', here it is '0{16}'"):
        check_same(recording, **(here | {other: "0" * 64}))
