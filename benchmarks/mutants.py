"""Mutants of the supervisor: how many small changes of its code the tests of tests/runtime notice.

`python benchmarks/mutants.py` installs mutmut below .venv-mutants/, an environment of its own beside ours, copies the
package and the quick tests to a folder for it, runs it there, and writes results/mutants.md: the share that was killed
and, by name and change, the mutants that live. With --folder what was done there is not done again, but for those that
live: the tests are copied anew, and they may kill them now.
"""

from __future__ import annotations

import argparse
import difflib
import json
import os
import re
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
FILES = ("supervisor", "guards", "limits", "machine", "swing")
TESTS = (
    "test_supervisor",
    "test_guards",
    "test_edges",
    "test_corners",
    "test_look_ahead",
    "test_limits",
    "test_machine",
    "test_clearance",
    "test_swing",
)
GOAL = 0.95
LIVES, NO_TESTS = "lives", 33
EQUAL = re.compile(r",? ?\b(strict|lower)=(True|False|None|1)|,(?= ?\))")
"""What changes nothing: the check of lengths that were compared before, and which half of a symmetric matrix."""
SLOW = " or ".join(
    (
        "test_bound_is_never_more",
        "test_distance_is_that",
        "axes_of_the_packaged",
        "capsules_hold",
        "held_joint_comes",
        "stays_as_it_is",
    )
)
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
    """The copy that is mutated; of one that is there already the tests alone."""
    if not (folder / "src").exists():
        shutil.copytree(ROOT / "src", folder / "src", ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))
    (folder / "tests" / "runtime").mkdir(parents=True, exist_ok=True)
    for name in TESTS:
        shutil.copy(ROOT / "tests" / "runtime" / f"{name}.py", folder / "tests" / "runtime")
    lines = ["[mutmut]", "source_paths=src", "only_mutate="]
    lines += [f"    src/burnish/runtime/{name}.py" for name in FILES]
    lines += ["pytest_add_cli_args_test_selection=", "    tests/runtime"]
    lines += ["pytest_add_cli_args=", "    -k", f"    not ({SLOW})", "    -p", "    no:cacheprovider"]
    (folder / "setup.cfg").write_text("\n".join(lines) + "\n")
    (folder / "pytest.ini").write_text("[pytest]\naddopts = -q --import-mode=importlib -m 'not slow'\nmarkers = slow\n")


def forget_the_living(folder: Path) -> None:
    """Let those that live be run again."""
    for path in folder.glob("mutants/src/burnish/runtime/*.py.meta"):
        about = json.loads(path.read_text())
        codes = about["exit_code_by_key"]
        about["exit_code_by_key"] = {n: None if code in (0, NO_TESTS) else code for n, code in codes.items()}
        path.write_text(json.dumps(about, indent=4))


def run(python: Path, folder: Path, jobs: int) -> None:
    """All mutants, in the folder."""
    quiet = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    mutmut = [str(python), "-m", "mutmut", "run", "--max-children", str(jobs)]
    subprocess.run(mutmut, cwd=folder, env=quiet, check=True, stdout=sys.stderr)


def found(folder: Path) -> tuple[dict[str, str], dict[str, str]]:
    """The outcome of each mutant that was run, and of those that live the line that they have instead."""
    outcomes, changes = {}, {}
    for name in FILES:
        path = folder / "mutants" / "src" / "burnish" / "runtime" / f"{name}.py"
        codes = json.loads(path.with_name(f"{name}.py.meta").read_text())["exit_code_by_key"]
        bodies = bodies_of(path.read_text().splitlines())
        for mutant, code in codes.items():
            # Of pytest: 0 all tests passed, 1 one failed, 33 there was none; anything else is an end by force.
            outcomes[mutant] = {0: LIVES, NO_TESTS: "no tests", None: "not run"}.get(code, "killed")
            if code == 0:
                function = mutant.rpartition(".")[2]
                before = bodies[re.sub(r"__mutmut_\d+$", "__mutmut_orig", function)]
                diff = difflib.unified_diff(before, bodies[function], lineterm="", n=0)
                lines = [line for line in diff if line[:1] in "+-" and line[:3] not in ("+++", "---")]
                changes[mutant] = "\n".join(lines)
                if len({EQUAL.sub("", line[1:]).replace(" ", "") for line in lines}) == 1:
                    outcomes[mutant] = "equal"
    return outcomes, changes


def bodies_of(lines: list[str]) -> dict[str, list[str]]:
    """The lines of each variant of a function in a mutated file, by its name."""
    bodies: dict[str, list[str]] = {}
    now: list[str] = []
    for line in lines:
        head = re.match(r"\s*def (\w+__mutmut_\w+)\(", line)
        if head:
            now = bodies[head.group(1)] = []
        else:
            now.append(line.strip())
            if re.match(r" {0,4}(def |class |@|mutants_)", line):
                now = []
    return bodies


def counted(counts: Counter[str]) -> list[str]:
    """Cells of the table: all, equal, not run, killed, share."""
    differ = counts.total() - counts["equal"]
    share = f"{100 * counts['killed'] / max(1, differ):.1f}"
    return [*map(str, (counts.total(), counts["equal"], counts["not run"], counts["killed"])), share]


def enough(outcomes: dict[str, str]) -> bool:
    """Whether the goal is met."""
    counts = Counter(outcomes.values())
    return counts["killed"] >= GOAL * (counts.total() - counts["equal"])


def report(outcomes: dict[str, str], changes: dict[str, str]) -> str:
    """The page."""
    rows = []
    for name in FILES:
        counts = Counter(o for mutant, o in outcomes.items() if mutant.startswith(f"burnish.runtime.{name}."))
        rows.append([f"{name}.py", *counted(counts)])
    rows.append(["all", *counted(Counter(outcomes.values()))])
    about = machine()
    parts = [
        "# Mutants of the supervisor",
        (
            f"`python benchmarks/mutants.py`, {PACKAGE}, {about['date']}, Python {about['python']}. "
            f"Goal: {100 * GOAL:.0f} % killed of those that change anything: {'met' if enough(outcomes) else 'missed'}."
        ),
        markdown_table(
            ["file", "mutants", "equal to the code", "not run", "killed", "% of those that are not equal"], rows
        ),
    ]
    if EXPLAINED.exists():
        parts.append(EXPLAINED.read_text().strip())
    parts += ["## Those that live"]
    parts += [f"`{name}`\n```diff\n{changes[name]}\n```" for name in sorted(changes)]
    return "\n\n".join(parts) + "\n"


def main() -> int:
    """Run and report; 0 if enough are killed, 1 if not."""
    cli = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    cli.add_argument("--jobs", type=int, default=2, metavar="J", help="mutants at once (default: 2)")
    cli.add_argument("--folder", type=Path, metavar="DIR", help="work here (default: a new one, gone afterwards)")
    options = cli.parse_args()
    python = install()
    with tempfile.TemporaryDirectory() as name:
        folder = options.folder or Path(name)
        lay_out(folder)
        forget_the_living(folder)
        run(python, folder, options.jobs)
        outcomes, changes = found(folder)
    page = report(outcomes, changes)
    write_text(HERE / "results" / "mutants.md", page)
    print(page.split("## Those that live")[0])
    return 0 if enough(outcomes) else 1


if __name__ == "__main__":
    sys.exit(main())
