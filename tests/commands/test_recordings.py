"""verify, export and recover as a user meets them, on recordings of the real job."""

from __future__ import annotations

import csv
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from commands.test_cli import refusal, small_plate

from burnish.cli import main
from burnish.commands import verify
from burnish.commands.course import PLAN, Course
from burnish.commands.order import Order
from burnish.commands.progress import Progress
from burnish.commands.work import Work, drive, prepare
from burnish.errors import BurnishError, PlanError
from burnish.model.tool import PolishingTool
from burnish.paths.patterns import Raster, Spiral
from burnish.paths.stroke import Stroke
from burnish.paths.tilt import Tilt
from burnish.polish.journal import Mark
from burnish.polish.plan_file import write_plan
from burnish.polish.recipe import Pass, Recipe
from burnish.record.poses_file import read_poses
from burnish.record.recording import Recording
from burnish.surface import Mould

CYCLES = 330
"""Cycles after which the short jobs are interrupted: at 50 Hz the arm has left home and moves the tool."""


@pytest.fixture(scope="module")
def plate(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return small_plate(tmp_path_factory.mktemp("mould") / "plate_30.stl")


def short_job(plate: Path, path: Path, change: Callable[[Work], Work], course: Course | None = None) -> Path:
    """A recording of the first seconds of a job that was changed behind its metadata's back."""
    order = Order(mould=str(plate), unit="mm", arm="honest", sensor="wrist", force=10.0, feed=0.02, rate=50.0, seed=6)
    with Progress() as progress:
        work = change(prepare(order, Mould.load(order.mould), progress, course))
        drive(work, path, progress, lambda count: count == CYCLES)
    return path


@pytest.fixture(scope="module")
def recording(plate: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return short_job(plate, tmp_path_factory.mktemp("run") / "run.mcap", lambda work: work)


def test_an_interrupted_run_comes_out_bit_exact(
    recording: Path, plate: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert Recording(recording).ending["interrupted_after"] == str(CYCLES)
    assert main(["verify", str(recording), "--mould", str(plate)]) == 0
    cycles = Recording(recording).ending["cycles"]
    assert capsys.readouterr().out == f"Bit-exact: {cycles} cycles, 6 topics.\n"


COURSE = Course(
    recipe=Recipe(
        passes=(Pass(pattern=Spiral(), tilt=Tilt(angle=0.1)), Pass(pattern=Raster(angle=0.5), force=8.0)),
        tool=PolishingTool(tip_radius=0.018, spindle=200.0),
    ),
    repeats=2,
    skipped=frozenset({1}),
    since=Mark(number=1, stroke=2, s=0.01, phase="stopped", force=9.0, t=20.0, metres=0.3, joules=1.0),
)
"""All that a job may have beside its order."""


def test_a_job_with_a_recipe_that_went_on_comes_out_bit_exact(
    plate: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = short_job(plate, tmp_path / "run.mcap", lambda work: work, COURSE)
    assert Course.recorded(Recording(path).metadata, tmp_path) == COURSE
    assert main(["verify", str(path), "--mould", str(plate)]) == 0
    assert "Bit-exact" in capsys.readouterr().out


@pytest.mark.parametrize("damage", ["", "[]", "null", '{"since": null}', "[" * 100_000, "since", "tip_radius"])
def test_a_job_that_is_not_told_is_refused(damage: str, tmp_path: Path) -> None:
    text = COURSE.as_metadata()["course"]
    told = {"since": text.replace('"s": 0.01', '"s": NaN'), "tip_radius": text.replace("0.018", "-1.0")}
    assert set(told.values()) != {text}
    with pytest.raises(BurnishError):
        Course.recorded({"course": told.get(damage, damage)}, tmp_path)


def test_the_strokes_of_a_repair_stand_beside_its_recording(plate: Path, tmp_path: Path) -> None:
    stroke = Stroke(points=np.eye(3), normals=np.eye(3), feed=np.full(3, 0.01), force=np.full(3, 5.0))
    metadata = replace(COURSE, mends="runs/before", strokes=(stroke,)).as_metadata()
    with pytest.raises(PlanError, match=r"plan\.json"):
        Course.recorded(metadata, tmp_path)
    write_plan(tmp_path / PLAN, [stroke], Mould.load(str(plate)), COURSE.recipe)
    course = Course.recorded(metadata, tmp_path)
    assert course is not None
    assert np.array_equal(course.strokes[0].force, stroke.force)


def test_the_metadata_say_all_that_decides_a_run(recording: Path) -> None:
    found = Recording(recording).metadata
    asked = {"verb": "polish", "mould": "plate_30", "unit": "mm", "arm": "honest", "sensor": "wrist", "force": "10.0"}
    asked |= {"feed": "0.02", "rate": "50.0", "seed": "6"}
    assert {name: found[name] for name in asked} == asked
    assert {"burnish", "mujoco", "pin", "numpy", "scipy", "python"} <= set(found)
    hashes = [found[f"{name}_sha256"] for name in ("model", "mould", "tool", "law", "travel", "limits")]
    assert len(set(hashes)) == 6
    assert all(len(value) == 64 for value in hashes)
    assert '"position_frequency"' in found["law"]
    assert '"tool_force"' in found["limits"]


def test_a_cut_recording_is_recovered_and_exact_as_far_as_it_goes(
    recording: Path, plate: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(recording.read_bytes()[: recording.stat().st_size // 2])
    assert "burnish recover" in refusal(capsys, "verify", str(cut), "--mould", str(plate))
    assert main(["recover", str(cut)]) == 0
    said = capsys.readouterr().out
    assert "Saved: " in said
    assert "Lost: " in said
    assert main(["verify", str(tmp_path / "cut.recovered.mcap"), "--mould", str(plate)]) == 0
    assert "the recording was cut off there" in capsys.readouterr().out


def test_one_bit_of_a_gain_is_found_and_named(plate: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def change(work: Work) -> Work:
        law = work.job.law
        work.job.law = replace(law, orientation_frequency=float(np.nextafter(law.orientation_frequency, np.inf)))
        return work

    path = short_job(plate, tmp_path / "run.mcap", change)
    assert main(["verify", str(path), "--mould", str(plate)]) == 1
    said = capsys.readouterr().out
    assert said.startswith("Not exact")
    assert "law: differs" in said
    assert "travel: differs" not in said
    assert "/control_state: differs from cycle " in said
    assert "tau_commanded" in said


def test_another_seed_is_found_in_the_first_cycle(
    plate: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # One bit of the seed: 6 was run, 7 is written down.
    path = short_job(plate, tmp_path / "run.mcap", lambda work: replace(work, order=replace(work.order, seed=7)))
    assert main(["verify", str(path), "--mould", str(plate)]) == 1
    assert "/joint_states: differs from cycle 0 on (t = 0.000 s): tau1 is" in capsys.readouterr().out


def test_recordings_of_something_else_are_refused_by_their_hash(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    other = small_plate(tmp_path / "other.stl", size=31.0)
    found = Recording(recording).metadata
    line = refusal(capsys, "verify", str(recording), "--mould", str(other))
    assert found["mould_sha256"] in line
    assert Mould.load(str(other)).sha256 in line
    assert "--mould" in refusal(capsys, "verify", str(recording)), "what a recording names is no path"
    for name, message in (("model_hash", "model"), ("tool_hash", "tool")):
        with monkeypatch.context() as patch:
            patch.setattr(verify, name, lambda *of: "0" * 64)
            line = refusal(capsys, "verify", str(recording))
            assert message in line
            assert "0" * 64 in line
            assert found[f"{message}_sha256"] in line
    with monkeypatch.context() as patch:
        patch.setattr(verify, "versions", lambda: {"mujoco": "99.0"})
        line = refusal(capsys, "verify", str(recording))
        assert "'99.0'" in line
        assert found["mujoco"] in line


def test_csv_has_every_sample_with_all_its_digits(recording: Path, tmp_path: Path) -> None:
    out = tmp_path / "run.csv"
    assert main(["export", str(recording), "--to", "csv", "--out", str(out)]) == 0
    with out.open(newline="") as file:
        head, *rows = csv.reader(file)
    columns = dict(zip(head, zip(*rows, strict=True), strict=True))
    blocks = list(Recording(recording).blocks())

    def numbers(name: str) -> list[float]:
        return [float(value) if value else float("nan") for value in columns[name]]

    assert len(rows) == int(Recording(recording).ending["cycles"])
    assert numbers("t [s]") == np.concatenate([block.t for block in blocks]).tolist()
    for name, field, k in (("q3 [rad]", "q", 2), ("tau_applied6 [N·m]", "applied", 5), ("px_d [m]", "p_d", 0)):
        assert np.array_equal(numbers(name), np.concatenate([getattr(b, field)[:, k] for b in blocks]), equal_nan=True)
    assert {"force_z [N]", "moment_x [N·m]", "qw", "force_measured [N]"} <= set(head)
    assert set(columns["phase"]) >= {"move", "retract"}


def test_txt_has_the_desired_poses_of_the_tool(recording: Path, tmp_path: Path) -> None:
    out = tmp_path / "desired_poses.txt"
    assert main(["export", str(recording), "--to", "txt", "--out", str(out)]) == 0
    poses = read_poses(out)
    p = np.concatenate([block.p_d for block in Recording(recording).blocks()])
    Q = np.concatenate([block.Q_d for block in Recording(recording).blocks()])
    wanted = np.isfinite(p[:, 0])
    assert 0 < wanted.sum() < len(p)
    assert np.array_equal(poses.p, p[wanted])
    assert np.allclose(poses.Q, Q[wanted][:, [3, 0, 1, 2]], atol=1e-15)


def test_parquet_without_its_package_is_refused_with_the_way_to_get_it(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    # None in sys.modules is what the import system takes for "not there".
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    out = tmp_path / "run.parquet"
    assert "burnish[export]" in refusal(capsys, "export", str(recording), "--to", "parquet", "--out", str(out))
    assert not out.exists()


def test_parquet_has_every_sample_and_the_units(recording: Path, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    out = tmp_path / "run.parquet"
    assert main(["export", str(recording), "--to", "parquet", "--out", str(out)]) == 0
    table = parquet.read_table(out)
    assert table.schema.field("q1").metadata == {b"unit": b"rad"}
    q = np.concatenate([block.q[:, 0] for block in Recording(recording).blocks()])
    assert table.column("q1").to_pylist() == q.tolist()
    assert table.column("px_d").null_count > 0


@pytest.mark.parametrize("verb", ["recover", "verify", "export"])
def test_what_is_no_recording_is_refused_in_one_line(
    verb: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "notes.txt").write_text("not a recording at all")
    words = ["--to", "csv"] if verb == "export" else []
    assert "no recording" in refusal(capsys, verb, str(tmp_path / "notes.txt"), *words)
    assert "cannot be read" in refusal(capsys, verb, str(tmp_path / "nowhere.mcap"), *words)
    assert [p.name for p in tmp_path.iterdir()] == ["notes.txt"]


def test_a_recording_is_never_overwritten_by_its_own_table(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = recording.read_bytes()
    assert "itself" in refusal(capsys, "export", str(recording), "--to", "csv", "--out", str(recording))
    assert recording.read_bytes() == before


@pytest.mark.slow
def test_a_whole_polish_from_the_command_line_comes_out_bit_exact(plate: Path, tmp_path: Path) -> None:
    # Two processes, so that nothing is shared but the file.
    burnish = [sys.executable, "-m", "burnish"]
    words = ["polish", "--mould", str(plate), "--seed", "1", "--out", str(tmp_path / "run")]
    subprocess.run([*burnish, *words], check=True, capture_output=True)
    again = [*burnish, "verify", str(tmp_path / "run" / "run.mcap"), "--mould", str(plate)]
    done = subprocess.run(again, check=True, capture_output=True, text=True)
    assert done.stdout.startswith("Bit-exact")
