"""``burnish campaign`` as a user meets it: results, going on, one episode alone, refusals, Ctrl-C."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from burnish.cli import main


def test_campaign_writes_its_results_and_goes_on_where_it_was(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    words = ["campaign", "--seed", "11", "--jobs", "1", "--out", str(out)]
    main([*words, "--episodes", "2"])
    first = (out / "episodes.jsonl").read_text()
    main([*words, "--episodes", "3"])
    assert (out / "episodes.jsonl").read_text().startswith(first), "what was done is not done again"
    found = json.loads((out / "campaign.json").read_text())
    assert {"episodes", "unsafe_samples", "false_trips", "virtual_hours", "by_fault"} <= set(found)
    assert found["episodes"] == 3
    page = (out / "report.html").read_text()
    assert "11" in page
    assert page.count("<svg") == 3
    assert 'src="http' not in page
    assert "3 episodes" in capsys.readouterr().out


def test_folder_of_another_seed_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    words = ["campaign", "--episodes", "1", "--jobs", "1", "--out", str(out)]
    main([*words, "--seed", "11"])
    assert main([*words, "--seed", "12"]) == 2
    assert "holds a campaign with seed 11; expected 12" in capsys.readouterr().err


@pytest.mark.parametrize("words", [["--episodes", "0"], ["--jobs", "0"], ["--seed", "-1"], ["--only", "-1"]])
def test_number_out_of_range_is_refused(words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["campaign", *words, "--out", str(tmp_path / "out")]) == 2
    assert "out of range" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_one_episode_alone_keeps_its_log(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["campaign", "--seed", "11", "--only", "1", "--out", str(tmp_path)])
    with np.load(tmp_path / "episode-1.npz", allow_pickle=False) as log:
        header = json.loads(str(log["header"]))
        assert (header["seed"], header["episode"]) == (11, 1)
        assert log["tau"].shape == log["q"].shape == (len(log["t"]), 6)
    assert "<svg" in (tmp_path / "episode-1.html").read_text()
    assert "The judge found" in capsys.readouterr().out


def test_ctrl_c_ends_with_130_and_keeps_what_is_done(tmp_path: Path) -> None:
    out = tmp_path / "out"
    process = subprocess.Popen(
        [sys.executable, "-m", "burnish", "campaign", "--episodes", "5000", "--jobs", "2", "--out", str(out)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"OMP_NUM_THREADS": "1"},
        start_new_session=True,
        # A test run in the background of a shell ignores Ctrl-C, and hands that down.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    deadline = time.monotonic() + 300.0
    while not (out / "episodes.jsonl").exists():
        assert process.poll() is None, "ended before it could be interrupted"
        assert time.monotonic() < deadline
        time.sleep(0.05)
    # As a terminal does it: every process of the group is told.
    os.killpg(process.pid, signal.SIGINT)
    printed, said = process.communicate(timeout=120)
    assert process.returncode == 130
    assert printed.startswith("Interrupted.")
    assert "Traceback" not in said
    kept = json.loads((out / "campaign.json").read_text())["episodes"]
    assert kept == len((out / "episodes.jsonl").read_text().splitlines()) > 0
    assert "Interrupted" in (out / "report.html").read_text()
