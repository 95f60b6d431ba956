"""The command line as a user meets it: help, refusals, exit statuses, files."""

from __future__ import annotations

import json
import os
import re
import signal
import struct
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from burnish.cli import main
from burnish.commands import work
from burnish.paths.stroke import from_plan
from burnish.polish import cellsim
from burnish.polish.process import Job
from burnish.sim.robot import SimRobot
from burnish.surface import DistanceGrid

BURNISH = [sys.executable, "-m", "burnish"]


def small_plate(path: Path, size: float = 30.0, height: float = 10.0) -> Path:
    """A box of ``size`` × ``size`` mm as a binary STL."""
    x, h = 0.5 * size, height
    p = [(-x, -x, 0), (x, -x, 0), (x, x, 0), (-x, x, 0), (-x, -x, h), (x, -x, h), (x, x, h), (-x, x, h)]
    quads = [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *(v for k in t for v in p[k]), 0) for t in triangles)
    path.write_bytes(b"plate".ljust(80) + struct.pack("<I", len(triangles)) + body)
    return path


def refusal(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """The one line with which these words are refused."""
    assert main(words) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    lines = captured.err.splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("burnish: ")
    return lines[0]


def test_help_names_every_verb() -> None:
    done = subprocess.run([*BURNISH, "--help"], capture_output=True, text=True, check=True)
    assert "polish" in done.stdout
    assert "plan" in done.stdout


def test_help_loads_no_engine() -> None:
    code = "import sys, burnish.cli\ntry:\n burnish.cli.main(['polish', '--help'])\nexcept SystemExit: pass\n"
    code += "assert not {'mujoco', 'pinocchio', 'matplotlib', 'scipy', 'numpy'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)


@pytest.mark.parametrize("word", ["--force", "--feed", "--rate", "--seed", "--mould", "--arm", "--sensor", "--out"])
def test_polish_help_has_units_and_defaults(word: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["polish", "--help"])
    assert end.value.code == 0
    text = capsys.readouterr().out
    assert word in text
    assert "default" in text[text.rindex(word) :][:420]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--mould", "nowhere.stl"], "nowhere.stl"),
        (["--mould", "teapot"], "plate, dome, wave, mould"),
        (["--force", "0.5"], "expected 2 to 20 N"),
        (["--force", "nan"], "expected 2 to 20 N"),
        (["--force", "ten"], "ten"),
        (["--feed", "2"], "expected 0.005 to 0.08 m/s"),
        (["--rate", "5000"], "expected 50 to 1000 Hz"),
        (["--seed", "-1"], "seed -1"),
        (["--arm", "perfect"], "ideal"),
        (["--polish"], "--help"),
    ],
)
def test_bad_options_are_refused_in_one_line(
    words: list[str], expected: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert expected in refusal(capsys, "polish", *words, "--out", str(out))
    assert not out.exists()


@pytest.mark.parametrize("verb", ["polish", "plan"])
@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"", "empty"),
        (b"not a mesh at all", "STL"),
        (b"lies".ljust(80) + struct.pack("<I", 1000) + bytes(50), "1000"),
        (b"nan".ljust(80) + struct.pack("<I", 1) + struct.pack("<12fH", *[float("nan")] * 12, 0), "finite"),
    ],
    ids=["empty", "text", "lying", "nan"],
)
def test_bad_meshes_are_refused_and_nothing_is_written(
    verb: str, content: bytes, expected: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mesh, out = tmp_path / "bad.stl", tmp_path / "out"
    mesh.write_bytes(content)
    assert expected in refusal(capsys, verb, "--mould", str(mesh), "--out", str(out))
    assert not out.exists()


def test_mould_out_of_reach_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh = small_plate(tmp_path / "table.stl", size=900.0)
    line = refusal(capsys, "plan", "--mould", str(mesh), "--out", str(tmp_path / "plan.json"))
    assert "the arm cannot" in line or "limit" in line
    assert sorted(p.name for p in tmp_path.iterdir()) == ["table.stl"]


def test_path_too_fast_for_the_joints_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = refusal(capsys, "plan", "--mould", "dome", "--feed", "0.08", "--out", str(tmp_path / "plan.json"))
    assert "joint" in line
    assert "feed" in line


def test_output_that_cannot_be_written_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "taken").write_text("a file")
    assert "file" in refusal(capsys, "polish", "--out", str(tmp_path / "taken"))
    assert "file" in refusal(capsys, "polish", "--out", str(tmp_path / "taken" / "below"))


def test_plan_is_what_the_public_face_promises(tmp_path: Path) -> None:
    path = tmp_path / "new" / "plan.json"
    assert main(["plan", "--mould", str(small_plate(tmp_path / "p.stl")), "--out", str(path)]) == 0
    plan = json.loads(path.read_text())
    assert set(plan) == {"strokes", "mould", "recipe"}
    assert set(plan["strokes"][0]) == {"points", "normals", "feed", "force"}
    stroke = from_plan(plan)[0]
    assert np.allclose(stroke.points[:, 2], 0.01, atol=1e-5)
    assert np.allclose(stroke.force, 10.0)


def test_polish_writes_its_files_and_all_metrics(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh, out = small_plate(tmp_path / "p.stl"), tmp_path / "run"
    assert main(["polish", "--mould", str(mesh), "--seed", "1", "--out", str(out)]) == 0
    written = ["journal.jsonl", "metrics.json", "part.html", "removed.npz", "report.html", "run.mcap"]
    assert sorted(p.name for p in out.iterdir()) == written
    metrics = json.loads((out / "metrics.json").read_text())
    promised = """force_set_N force_rms_N force_mean_N force_p99_N touch_peak_N contact_lost_pct tilt_rms_deg
    tilt_max_deg feed_rms_pct coverage_pct overpolished_pct removal_cv_pct removal_mean_um path_length_m duration_s
    realtime_factor cycles late_cycles supervisor_events seed mould arm sensor rate_Hz"""
    assert set(promised.split()) <= set(metrics)
    assert metrics["force_rms_N"] < 0.5
    assert metrics["touch_peak_N"] < 3.0
    assert metrics["coverage_pct"] > 98.0
    printed = capsys.readouterr()
    assert printed.out.startswith("Done.")
    assert printed.err == "", "no progress bar in a pipe"


@pytest.mark.slow
@pytest.mark.parametrize(("mould", "seed", "tilt"), [("mould", "3", 2.5), ("plate", "4", 0.5)])
def test_whole_bundled_moulds_are_polished(tmp_path: Path, mould: str, seed: str, tilt: float) -> None:
    # One has fillets, at which the tool has to turn; the other is one pass of a quarter of an hour. Their worst seeds.
    out = tmp_path / "run"
    assert main(["polish", "--mould", mould, "--seed", seed, "--out", str(out)]) == 0
    metrics = json.loads((out / "metrics.json").read_text())
    assert metrics["force_rms_N"] < 0.5
    assert metrics["coverage_pct"] > 98.0
    assert metrics["overpolished_pct"] < 3.0
    assert metrics["tilt_rms_deg"] < tilt
    assert metrics["supervisor_events"] == 0


def with_block(grid: DistanceGrid, start: float, end: float, top: float) -> DistanceGrid:
    """The grid with a block of steel on it from x = ``start`` to ``end``, ``top`` high [m]."""
    x, y, z = (grid.origin[i] + grid.spacing * np.arange(grid.values.shape[i]) for i in range(3))
    X, _, Z = np.meshgrid(x, y, z, indexing="ij")
    beside, above = np.maximum(start - X, X - end), Z - top
    outside = np.hypot(np.maximum(beside, 0.0), np.maximum(above, 0.0))
    block = outside + np.minimum(np.maximum(beside, above), 0.0)
    return DistanceGrid(origin=grid.origin, spacing=grid.spacing, values=np.minimum(grid.values, block))


def test_clamp_left_on_the_mould_stops_the_arm_with_3_and_a_report(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    # 12 mm of steel in the way of the tip: too steep to climb, so the force along the path grows to the limit of 25 N.
    runs: list[tuple[Job, SimRobot]] = []

    def on_another_mould(grid: DistanceGrid, *given: Any, **named: Any) -> tuple[Job, SimRobot]:
        runs.append(cellsim.simulated_job(grid, *given, **named, real_grid=with_block(grid, 0.012, 0.02, 0.022)))
        return runs[-1]

    monkeypatch.setattr(work, "simulated_job", on_another_mould)
    mesh, out = small_plate(tmp_path / "p.stl", size=60.0), tmp_path / "run"
    assert main(["polish", "--mould", str(mesh), "--out", str(out)]) == 3
    said = capsys.readouterr().out
    cause = re.search(r"Stopped by the supervisor: the tool force reached (2[5-9]\.\d) N; the limit is 25 N", said)
    assert cause is not None, said
    assert cause[0] in (out / "report.html").read_text()
    assert json.loads((out / "metrics.json").read_text())["supervisor_events"] == 1
    job, robot = runs[0]
    (t, force), event = robot.truth.force(), job.rig.supervisor.event
    # From the measurement that trips on: it is mostly off 50 ms later, and has left the steel for good soon after.
    assert event is not None
    trip = event.t
    assert force.max() > 20.0
    assert force[(t > trip + 0.05) & (t < trip + 0.06)].max() < 0.5 * force.max()
    assert force[t > trip + 0.2].max() == 0.0


def test_ctrl_c_ends_with_130_and_a_report_of_what_was_done(tmp_path: Path) -> None:
    mesh, out = small_plate(tmp_path / "p.stl", size=60.0), tmp_path / "run"
    words = [*BURNISH, "polish", "--mould", str(mesh), "--out", str(out)]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=os.environ | {"OMP_NUM_THREADS": "1"})
    deadline = time.monotonic() + 60.0
    recording = out / "run.mcap"
    while not (recording.exists() and recording.stat().st_size > 500_000):
        assert process.poll() is None, "ended before it could be interrupted"
        assert time.monotonic() < deadline
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    printed, _ = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Interrupted" in printed
    assert "Interrupted" in (out / "report.html").read_text()
    assert json.loads((out / "metrics.json").read_text())["cycles"] > 100
