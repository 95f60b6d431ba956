"""A short form of the fuzzing of everything that reads files from outside."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


def fuzz(count: int, seed: int, out: Path) -> None:
    """Run the script in a process of its own, so that its memory can be judged."""
    script = [sys.executable, str(ROOT / "scripts" / "fuzz_inputs.py")]
    words = ["--count", str(count), "--seed", str(seed), "--out", str(out)]
    done = subprocess.run([*script, *words], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    result = json.loads(out.read_text())
    assert sum(sum(kind.values()) for kind in result["inputs"].values()) == count


def test_a_thousand_damaged_files_are_read_or_refused(tmp_path: Path) -> None:
    fuzz(1000, 20, tmp_path / "result.json")


@pytest.mark.slow
def test_twenty_thousand_damaged_files_are_read_or_refused(tmp_path: Path) -> None:
    fuzz(20_000, 21, tmp_path / "result.json")


def test_the_committed_result_has_a_hundred_thousand_and_nothing_wrong() -> None:
    result = json.loads((ROOT / "benchmarks" / "results" / "fuzz_inputs.json").read_text())
    assert result["count"] >= 100_000
    assert result["wrong"] == []
    assert max(result["longest_s"].values()) <= 2.0
    assert result["memory_MiB"] <= 1024
