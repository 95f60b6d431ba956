"""``burnish replay`` and the proof that a replay comes out the same: on a terminal, by itself, and refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from commands.test_cli import refusal, small_plate
from commands.test_teach import Seat, last_rows, phases, time_of
from teach.cells import cell_of, shown
from teach.test_demonstration import recorded, stored

from burnish.cli import main
from burnish.commands.replay import STILL, Replay, prepare, script_of, seated
from burnish.commands.seat import Script
from burnish.commands.taught import Place
from burnish.record.recorder import Recorder
from burnish.record.recording import Recording
from burnish.teach.session import Key

PLACE = Place(mould="dome", unit="mm", arm="honest", sensor="wrist", rate=100.0, seed=1)


@pytest.fixture(scope="module")
def taught(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of a demonstration on the dome that no arm had to show."""
    path = tmp_path_factory.mktemp("taught") / "run.mcap"
    cell = cell_of()
    rig, _ = cell.rig()
    wanted = shown()
    about = PLACE.metadata(cell, cell.train(rig, None, lambda: ""))  # type: ignore[arg-type]
    recorded(path, wanted, stored(wanted), **about)
    return path


def short_replay(taught: Path, path: Path, script: Script, interrupted_after: int | None = None) -> Path:
    """A replay with these keys after these cycles, recorded."""
    replay = Replay(path=taught, place=PLACE, repeats=1, speed=1.0, open_loop=False, mould_at=STILL)
    stage = prepare(replay)
    with Recorder(path, joint_names=stage.rig.model.joint_names, metadata=stage.metadata()) as recorder:
        seated(stage, recorder).drive(script, interrupted_after)
    return path


KEYS: Script = {10: Key.GO_ON, 1100: Key.GO_ON, 1250: Key.CANCEL}


def test_words_that_cannot_be_used_are_refused_before_anything_moves(
    taught: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = ("--yes", "--out", str(tmp_path / "out"))
    words = str(taught)
    assert "--yes" in refusal(capsys, "replay", words, "--out", str(tmp_path / "out"))
    assert "speed" in refusal(capsys, "replay", words, "--speed", "3", *out)
    assert "repeats" in refusal(capsys, "replay", words, "--repeats", "0", *out)
    assert "mould-at" in refusal(capsys, "replay", words, "--mould-at", "0", "0", "2", "0", "0", "0", *out)
    assert "mould-at" in refusal(capsys, "replay", words, "--mould-at", "nan", "0", "0", "0", "0", "0", *out)
    assert "cannot be read" in refusal(capsys, "replay", str(tmp_path / "none.mcap"), *out)
    assert not (tmp_path / "out").exists()


def test_another_mould_is_refused_by_its_hash(taught: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    other = small_plate(tmp_path / "plate.stl", size=60.0)
    line = refusal(capsys, "replay", str(taught), "--mould", str(other), "--yes", "--out", str(tmp_path / "out"))
    assert "another mould" in line
    assert Recording(taught).metadata["mould_sha256"][:16] in line


def test_poses_alone_are_replayed_open_loop_only(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    poses = tmp_path / "desired_poses.txt"
    poses.write_text(shown().poses(), encoding="ascii")
    assert "--open-loop" in refusal(capsys, "replay", str(poses), "--yes", "--out", str(tmp_path / "out"))


def test_a_replay_with_keys_comes_out_bit_exact(
    taught: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = short_replay(taught, tmp_path / "run.mcap", KEYS)
    seen = phases(path)
    assert seen[:4] == ["home", "to ready", "ready", "move"]
    assert seen[-1] == "stop"
    assert "to home" in seen
    assert main(["verify", str(path), "--taught", str(taught)]) == 0
    assert capsys.readouterr().out == f"Bit-exact: {Recording(path).ending['cycles']} cycles, 6 topics.\n"


def test_an_interrupted_replay_is_at_rest_within_300_ms_and_comes_out_bit_exact(
    taught: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = short_replay(taught, tmp_path / "run.mcap", {10: Key.GO_ON}, interrupted_after=150)
    t, dq = last_rows(path)
    assert t - time_of(path, 150) <= 0.3
    assert np.abs(dq).max() < np.deg2rad(1.0)
    assert phases(path) == ["home", "to ready", "stop"]
    assert main(["verify", str(path), "--taught", str(taught)]) == 0
    assert capsys.readouterr().out.startswith("Bit-exact")


def test_one_key_a_cycle_later_is_found(taught: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    one = short_replay(taught, tmp_path / "one.mcap", {10: Key.GO_ON}, interrupted_after=60)
    script, after, _ = script_of(Recording(one))
    assert script == {10: Key.GO_ON}
    assert after == 60
    replay = Replay(path=taught, place=PLACE, repeats=1, speed=1.0, open_loop=False, mould_at=STILL)
    stage = prepare(replay)
    other = tmp_path / "other.mcap"
    with Recorder(other, joint_names=stage.rig.model.joint_names, metadata=stage.metadata()) as recorder:
        seat = seated(stage, recorder)
        seat.drive({11: Key.GO_ON}, 60)
        # The keys that the recording names are not those that were pressed.
        recorder.end_with(keys="10:enter")
    assert main(["verify", str(other), "--taught", str(taught)]) == 1
    assert capsys.readouterr().out.startswith("Not exact")


def test_verify_asks_for_what_was_replayed_and_knows_it_by_its_hash(
    taught: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = short_replay(taught, tmp_path / "run.mcap", {10: Key.CANCEL})
    assert "--taught" in refusal(capsys, "verify", str(path))
    other = tmp_path / "other.mcap"
    other.write_bytes(taught.read_bytes() + b"\0")
    assert "is not what was replayed" in refusal(capsys, "verify", str(path), "--taught", str(other))
    assert "of 'teach'" in refusal(capsys, "verify", str(taught))


@pytest.mark.parametrize("keys", ["x:enter", "10:none", "10", "10:enter:p", "99999999999999:enter"])
def test_keys_that_are_none_are_refused(taught: Path, tmp_path: Path, keys: str) -> None:
    from burnish.errors import RecordingError

    wanted = shown()
    recording = recorded(tmp_path / "run.mcap", wanted, {"keys": keys})
    with pytest.raises(RecordingError, match="no cycle and key"):
        script_of(recording)


@pytest.mark.slow
def test_a_person_plays_pauses_goes_on_and_stops(taught: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    with Seat("replay", str(taught), "--pace", "10", "--repeats", "2", "--out", str(out)) as terminal:
        terminal.until("mode        home")
        terminal.type("\r")
        terminal.until("mode        ready")
        terminal.type("\r")
        # The line of keys may be drawn a moment after that of the mode.
        terminal.until(lambda text: "mode        pass" in text and "P pause" in text)
        terminal.type("p")
        terminal.until("paused")
        terminal.type("p")
        terminal.until(lambda text: "mode        pass" in text and "paused" not in text)
        terminal.type(" ")
        assert terminal.ends() == 0
        assert "Cancelled." in terminal.text
    seen = phases(out / "run.mcap")
    assert seen[:3] == ["home", "to ready", "ready"]
    assert "pass" in seen
    assert seen[-2:] == ["to home", "stop"]
    told = json.loads((out / "metrics.json").read_text())
    assert told["outcome"] == "cancelled"
    assert main(["verify", str(out / "run.mcap"), "--taught", str(taught)]) == 0


@pytest.mark.slow
def test_a_replay_by_itself_reports_the_force_it_held(taught: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert main(["replay", str(taught), "--yes", "--mould-at", "0.01", "0", "0.005", "0", "0", "0.1",
                 "--out", str(out)]) == 0  # fmt: skip
    told = json.loads((out / "metrics.json").read_text())
    assert told["force_rms_N"] < 1.0
    assert told["position_rms_mm"] < 2.0
    page = (out / "report.html").read_text()
    assert "What was held" in page
    assert "before and after" in page
    assert main(["verify", str(out / "run.mcap"), "--taught", str(taught)]) == 0


@pytest.mark.slow
def test_poses_of_a_file_are_passed_open_loop(tmp_path: Path) -> None:
    poses = tmp_path / "desired_poses.txt"
    lines = shown().poses().splitlines()
    # 30 mm higher: it is about the way, not about pressing.
    raised = [" ".join([*w[:2], repr(float(w[2]) + 0.03), *w[3:]]) for w in (line.split() for line in lines)]
    poses.write_text("\n".join(raised) + "\n", encoding="ascii")
    out = tmp_path / "out"
    assert main(["replay", str(poses), "--open-loop", "--yes", "--out", str(out)]) == 0
    assert "poses" in phases(out / "run.mcap")
    assert json.loads((out / "metrics.json").read_text())["touched_N"] == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("mould", ["wave", "plate"])
def test_what_a_hand_shows_on_other_moulds_is_replayed_with_its_force(
    mould: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("burnish.teach.hand.SWINGS", 1)
    taught, out = tmp_path / "taught", tmp_path / "replayed"
    assert main(["teach", "--yes", "--device", "hand", "--mould", mould, "--out", str(taught)]) == 0
    assert main(["replay", str(taught / "run.mcap"), "--yes", "--out", str(out)]) == 0
    found = json.loads((out / "metrics.json").read_text())
    assert found["outcome"] == "done"
    assert found["force_rms_N"] < 1.0
    assert found["position_rms_mm"] < 2.0
    assert found["contact_lost_pct"] == 0.0


@pytest.mark.slow
def test_what_was_shown_in_the_air_alone_is_replayed_open_loop_and_not_with_force(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    script, taught, out = tmp_path / "script.csv", tmp_path / "taught", tmp_path / "out"
    rows = ["0,0,0,0,0,0,0,00", "0.3,0.5,0,0,0,0,0,00", "0.9,0,0,0,0,0,0,00",
            "1.2,-0.5,0,0,0,0,0,00", "1.8,0,0,0,0,0,0,00"]  # fmt: skip
    script.write_text("\n".join(["t,x,y,z,turn_x,turn_y,turn_z,buttons", *rows]) + "\n")
    assert main(["teach", "--yes", "--device", str(script), "--out", str(taught)]) == 0
    assert "--open-loop only" in capsys.readouterr().out
    recording = str(taught / "run.mcap")
    assert "never touches the mould" in refusal(capsys, "replay", recording, "--yes", "--out", str(out))
    assert main(["replay", recording, "--open-loop", "--yes", "--out", str(out)]) == 0
    found = json.loads((out / "metrics.json").read_text())
    assert found["outcome"] == "done"
    assert found["supervisor_events"] == 0
