"""``burnish reproduce`` as a user meets it: one short experiment, names, refusals, Ctrl-C."""

from __future__ import annotations

import json
import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pytest

from burnish.cli import main
from burnish.commands.reproduce import Reproduction
from burnish.experiments.catalogue import experiment, experiments
from burnish.trials.experiment import Finding
from burnish.trials.record import Record
from burnish.trials.run import run as run_trial

SHORT = "c_adaptive_push"
METRICS = """position_rmse_mm orientation_rmse_deg joint_rmse_mrad position_steady_mm orientation_steady_deg settling_s
coupling_position_peak_mm coupling_position_rms_mm coupling_orientation_peak_deg coupling_orientation_rms_deg effort_Nm
roughness_Nm_s step_median_us step_p5_us""".split()


def test_one_experiment_by_name_leaves_its_results_and_a_report(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "new"
    assert main(["reproduce", SHORT, "--out", str(out)]) == 0
    assert sorted(path.name for path in out.iterdir()) == ["report.html", "results.json", "results.md"]
    (result,) = json.loads((out / "results.json").read_text())
    assert set(result) == {"name", "title", "source", "about", "trials", "findings"}
    assert result["name"] == SHORT
    assert [trial["name"] for trial in result["trials"]] == [trial.name for trial in experiments()[SHORT].trials()]
    for trial in result["trials"]:
        assert set(trial) == {"name", "ours", "arm", "rate_Hz", "duration_s", "law", "gains", "metrics", "stopped"}
        assert list(trial["metrics"]) == METRICS
        assert trial["stopped"] is None
    assert all(set(finding) == {"claim", "measured", "holds"} for finding in result["findings"])
    assert result["findings"][0]["holds"] is True
    page = (out / "report.html").read_text()
    assert "simulated" in page
    assert "<svg" in page
    assert result["findings"][0]["measured"] in page
    assert result["title"] in (out / "results.md").read_text()
    printed = capsys.readouterr()
    assert printed.out.startswith("Done.")
    assert printed.err == "", "no progress bar in a pipe"


def test_a_name_that_nobody_has_is_refused_with_those_that_there_are(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["reproduce", "c_nothing", "--out", str(tmp_path / "out")]) == 2
    captured = capsys.readouterr()
    (line,) = captured.err.splitlines()
    assert "c_nothing" in line
    assert all(name in line for name in experiments())
    assert not (tmp_path / "out").exists()


def test_a_number_of_processes_that_cannot_be_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["reproduce", SHORT, "--jobs", "0", "--out", str(tmp_path / "out")]) == 2
    assert "expected 1 to 64" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_the_list_has_a_line_for_each_experiment(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["reproduce", "--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(experiments())
    assert all(each.title in line for line, each in zip(lines, experiments().values(), strict=True))


def test_ctrl_c_ends_with_130_and_keeps_what_is_done(tmp_path: Path) -> None:
    out = tmp_path / "out"
    words = [sys.executable, "-m", "burnish", "reproduce", SHORT, "a_figures_5_2_5_3", "--out", str(out)]
    process = subprocess.Popen(
        words,
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | {"OMP_NUM_THREADS": "1"},
        # A test run in the background of a shell ignores Ctrl-C, and hands that down.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    deadline = time.monotonic() + 300.0
    while not (out / "results.json").exists():
        assert process.poll() is None, "ended before it could be interrupted"
        assert time.monotonic() < deadline
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    printed, _ = process.communicate(timeout=60)
    assert process.returncode == 130
    assert printed.startswith("Interrupted.")
    first, *_ = json.loads((out / "results.json").read_text())
    assert first["name"] == SHORT
    assert first["findings"]
    assert "Interrupted" in (out / "report.html").read_text()


def test_record_from_another_process_is_judged_with_its_model(tmp_path: Path) -> None:
    judged: list[int] = []

    def judge(records: Mapping[str, Record]) -> list[Finding]:
        judged.extend(record.model.n for record in records.values())
        return []

    made = experiment("c_masks")
    trial = replace(made.trials()[0], duration=0.05)
    short = replace(made, trials=lambda: [trial], judge=judge)
    work = Reproduction(experiments={"short": short}, folder=tmp_path)
    work._trials, work._records = {"short": [trial]}, {"short": {}}
    work._take("short", 0, pickle.loads(pickle.dumps(run_trial(trial))))
    assert judged == [6]
