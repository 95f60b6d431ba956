"""Mutants of the supervisor: how many small changes of its code the tests of tests/runtime notice.

`python benchmarks/mutants.py` installs mutmut below .venv-mutants/, an environment of its own beside ours, copies the
package and the quick tests to a folder for it, runs it there, and writes results/mutants.md: the share that was killed
and, by name and change, the mutants that live.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import venv
from collections import Counter
from pathlib import Path

from common import machine, markdown_table, write_text

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
FOLDER = ROOT / ".venv-mutants"
PACKAGE = "mutmut==3.8.1"
FILES = ("supervisor", "guards", "limits", "machine")
TESTS = ("test_supervisor", "test_guards", "test_limits", "test_machine", "test_clearance")
GOAL = 0.95
KILLED = ("killed", "timeout", "segfault", "caught by type check")
SLOW = "test_bound_is_never_more or test_distance_is_that or axes_of_the_packaged or capsules_hold"
"""Tests that take a while and find what others find as well, as a pytest expression."""
EXPLAINED = HERE / "results" / "mutants_explained.md"
"""Why those live that do, by hand."""


def install() -> Path:
    """The environment with mutmut, and all that ours has; its interpreter."""
    python = FOLDER / "bin" / "python"
    if not python.exists():
        venv.create(FOLDER, clear=True, with_pip=True)
        (FOLDER / ".gitignore").write_text("*\n")
        subprocess.run([str(python), "-m", "pip", "install", "--quiet", PACKAGE], check=True)
    ask = [str(python), "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"]
    theirs = subprocess.run(ask, check=True, capture_output=True, text=True).stdout.strip()
    # Its own packages first, then ours; of burnish it finds the mutated copy before the installed one.
    ours = sysconfig.get_path("purelib")
    Path(theirs, "burnish_dependencies.pth").write_text(f"import site; site.addsitedir({ours!r})\n")
    return python


def lay_out(folder: Path) -> None:
    """The copy that is mutated."""
    shutil.copytree(ROOT / "src", folder / "src", ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))
    (folder / "tests" / "runtime").mkdir(parents=True)
    for name in TESTS:
        shutil.copy(ROOT / "tests" / "runtime" / f"{name}.py", folder / "tests" / "runtime")
    lines = ["[mutmut]", "source_paths=src", "only_mutate="]
    lines += [f"    src/burnish/runtime/{name}.py" for name in FILES]
    lines += ["pytest_add_cli_args_test_selection=", "    tests/runtime"]
    lines += ["pytest_add_cli_args=", "    -k", f"    not ({SLOW})", "    -p", "    no:cacheprovider"]
    (folder / "setup.cfg").write_text("\n".join(lines) + "\n")
    (folder / "pytest.ini").write_text("[pytest]\naddopts = -q --import-mode=importlib -m 'not slow'\nmarkers = slow\n")


def run(python: Path, folder: Path, jobs: int) -> dict[str, str]:
    """The outcome of each mutant by name."""
    quiet = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    mutmut = [str(python), "-m", "mutmut"]
    subprocess.run([*mutmut, "run", "--max-children", str(jobs)], cwd=folder, env=quiet, check=True, stdout=sys.stderr)
    text = subprocess.run([*mutmut, "results", "--all", "true"], cwd=folder, env=quiet, capture_output=True, text=True)
    rows = (line.strip().rpartition(": ") for line in text.stdout.splitlines() if "__mutmut_" in line)
    return {name: outcome for name, _, outcome in rows}


def change(python: Path, folder: Path, name: str) -> str:
    """What a mutant changes, as the lines of a diff."""
    shown = subprocess.run([str(python), "-m", "mutmut", "show", name], cwd=folder, capture_output=True, text=True)
    return "\n".join(
        line for line in shown.stdout.splitlines() if line[:1] in "+-" and not line.startswith(("+++", "---"))
    )


def report(outcomes: dict[str, str], changes: dict[str, str]) -> str:
    """The page."""
    rows = []
    for name in FILES:
        counts = Counter(o for mutant, o in outcomes.items() if mutant.startswith(f"burnish.runtime.{name}."))
        killed = sum(counts[word] for word in KILLED)
        rows.append([f"{name}.py", str(counts.total()), str(killed), f"{100 * killed / max(1, counts.total()):.1f}"])
    killed = sum(outcome in KILLED for outcome in outcomes.values())
    rows.append(["all", str(len(outcomes)), str(killed), f"{100 * killed / len(outcomes):.1f}"])
    about = machine()
    parts = [
        "# Mutants of the supervisor",
        (
            f"`python benchmarks/mutants.py`, {PACKAGE}, {about['date']}, Python {about['python']}. "
            f"Goal: {100 * GOAL:.0f} % killed: {'met' if killed >= GOAL * len(outcomes) else 'missed'}."
        ),
        markdown_table(["file", "mutants", "killed", "%"], rows),
    ]
    if EXPLAINED.exists():
        parts.append(EXPLAINED.read_text().strip())
    parts += ["## Those that live"]
    parts += [f"`{name}` ({outcomes[name]})\n```diff\n{changes[name]}\n```" for name in sorted(changes)]
    return "\n\n".join(parts) + "\n"


def main() -> int:
    """Run and report; 0 if enough are killed, 1 if not."""
    cli = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    cli.add_argument("--jobs", type=int, default=2, metavar="J", help="mutants at once (default: 2)")
    options = cli.parse_args()
    python = install()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        lay_out(folder)
        outcomes = run(python, folder, options.jobs)
        lives = [mutant for mutant, outcome in outcomes.items() if outcome not in KILLED]
        changes = {mutant: change(python, folder, mutant) for mutant in lives}
    page = report(outcomes, changes)
    write_text(HERE / "results" / "mutants.md", page)
    print(page.split("## Those that live")[0])
    return 0 if len(lives) <= (1.0 - GOAL) * len(outcomes) else 1


if __name__ == "__main__":
    sys.exit(main())
