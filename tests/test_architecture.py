"""The import rules of pyproject.toml hold, and a breach of each is noticed."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


def lint_imports(folder: Path) -> subprocess.CompletedProcess[str]:
    """Import-linter with the contracts of ``folder``, on the package under its ``src``."""
    # A process of its own: the linter imports the package by name, and here burnish is already imported.
    script = "import sys; sys.path.insert(0, 'src'); from importlinter import cli; sys.exit(cli.lint_imports())"
    return subprocess.run([sys.executable, "-c", script], cwd=folder, capture_output=True, text=True)


@pytest.fixture
def bare_package(tmp_path: Path) -> Path:
    """The layers of burnish without any content, under the same contracts."""
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    package = tmp_path / "src" / "burnish"
    for name in ("control", "trajectory", "model", "surface", "sim", "runtime", "polish", "analysis"):
        (package / name).mkdir(parents=True)
        (package / name / "__init__.py").touch()
    for name in ("__init__", "cli", "core", "errors", "inverse", "rotation"):
        (package / f"{name}.py").touch()
    (package / "teleop").mkdir()
    for name in ("__init__", "modes", "modes_a", "modes_b", "limits", "smooth", "reference"):
        (package / "teleop" / f"{name}.py").touch()
    return tmp_path


def write(package: Path, lines: dict[str, str]) -> None:
    for file, line in lines.items():
        (package / "src" / "burnish" / file).write_text(line + "\n")


def test_import_contracts_hold() -> None:
    result = lint_imports(ROOT)
    assert result.returncode == 0, result.stdout + result.stderr


def test_each_engine_may_be_imported_at_its_home(bare_package: Path) -> None:
    write(
        bare_package,
        {
            "model/model.py": "import pinocchio, burnish.core",
            "sim/robot.py": "import mujoco, burnish.model.model",
            "runtime/loop.py": "import threading, burnish.sim.robot",
            "cli.py": "import burnish.polish, burnish.analysis, burnish.runtime.loop",
        },
    )
    result = lint_imports(bare_package)
    assert result.returncode == 0, result.stdout + result.stderr


def test_every_breach_of_the_import_rules_is_reported(bare_package: Path) -> None:
    write(
        bare_package,
        {
            "surface/mould.py": "import burnish.control",
            "polish/teach.py": "import burnish.analysis",
            "newcomer.py": "",
            "sim/robot.py": "import pinocchio",
            "analysis/plot.py": "import mujoco.viewer",
            "control/joint.py": "from time import monotonic",
            # Not even through another module.
            "trajectory/hold.py": "import burnish.model.worker",
            "model/worker.py": "import threading",
        },
    )
    result = lint_imports(bare_package)
    assert result.returncode == 1
    # Lines are wrapped to the width of the terminal, so spaces are no part of what is looked for.
    said = "".join(result.stdout.split())
    for breach in (
        "burnish.surface.mould->burnish.control",
        "burnish.polish.teach->burnish.analysis",
        "newcomer",
        "burnish.sim.robot->pinocchio",
        "burnish.analysis.plot->mujoco",
        "burnish.control.joint->time",
        "burnish.model.worker->threading",
    ):
        assert breach in said, result.stdout
