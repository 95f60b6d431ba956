"""A recording process that is killed, for real."""

from __future__ import annotations

import json
import random
import sys
from pathlib import Path
from types import ModuleType

import pytest

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"


@pytest.fixture
def benchmark(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The benchmark of the recorder, as its own command line would import it."""
    monkeypatch.syspath_prepend(BENCHMARKS)
    for name in ("recording", "common"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    return __import__("recording")


def test_a_process_that_is_killed_leaves_a_recording_up_to_its_last_moments(benchmark: ModuleType) -> None:
    rng = random.Random(4)
    # Each has been read by the readers of the mcap package, as it was left and mended. How little is lost is for the
    # benchmark to say, on a machine that has nothing else to do; a recorder that writes at its end alone saves nothing.
    saved = [benchmark.kill_once(rng.uniform(0.2, 0.5))["messages"] for _ in range(5)]
    assert sorted(saved)[2] > 0


@pytest.mark.slow
def test_of_thirty_killed_processes_every_recording_can_be_read(benchmark: ModuleType) -> None:
    rng = random.Random(5)
    for _ in range(30):
        benchmark.kill_once(rng.uniform(0.2, 0.5))


def test_the_committed_result_reaches_the_goals() -> None:
    result = json.loads((BENCHMARKS / "results" / "recording.json").read_text())
    assert result["kill"]["kills"] >= 100
    assert result["kill"]["readable"] == result["kill"]["kills"]
    assert result["kill"]["lost_ms_max"] <= 50.0
    assert result["cost"]["cost_median_us"] <= 10.0
