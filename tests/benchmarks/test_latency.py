"""The benchmark of an operator's latency runs, loses no event, and judges by its goals. Nothing is timed here."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from teleop.magellan import executable

SCRIPT = Path(__file__).resolve().parents[2] / "benchmarks" / "latency.py"


def test_help_names_the_options_and_the_defaults() -> None:
    run = subprocess.run([sys.executable, str(SCRIPT), "--help"], capture_output=True, text=True, check=True)
    assert "--events" in run.stdout
    assert "default 1000" in run.stdout


@pytest.mark.slow
def test_a_short_run_sees_every_event_and_writes_figures_and_page(tmp_path: Path) -> None:
    executable()
    out = tmp_path / "operator.json"
    subprocess.run([sys.executable, str(SCRIPT), "--events", "5", "--out", str(out)], check=True, capture_output=True)
    result = json.loads(out.read_text())
    assert result["lost_events"] == 0
    assert {row["events"] for row in result["latency"].values()} == {5}
    assert all(row["p50_ms"] <= row["p99_ms"] <= row["max_ms"] for row in result["latency"].values())
    page = out.with_suffix(".md").read_text()
    assert all(name in page for name in result["latency"])
    verdicts = [
        line for line in page.splitlines() if line.startswith("| event to") and line.endswith(("met |", "missed |"))
    ]
    assert len(verdicts) == 3
