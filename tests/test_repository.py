"""The repository around the package: its lock, its bootstrap, and what its files may not give away."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).resolve().parent.parent
RUN = ROOT / "run.py"


# The lock.


def locked() -> dict[str, list[str]]:
    """Each entry of the lock (``name==version ; marker``) with its hashes."""
    entries: dict[str, list[str]] = {}
    text = (ROOT / "requirements.lock.txt").read_text()
    for line in text.replace("\\\n", " ").splitlines():
        if line.strip() and not line.lstrip().startswith("#"):
            requirement, *hashes = line.split("--hash=")
            entries[requirement.strip()] = [value.strip() for value in hashes]
    return entries


def package_name(requirement: str) -> str:
    """The name that a requirement begins with, spelt as package indexes compare it."""
    name = re.split(r"[^A-Za-z0-9._-]", requirement, maxsplit=1)[0]
    return re.sub(r"[-_.]+", "-", name).lower()


def test_lock_pins_every_requirement_with_sha256_hashes() -> None:
    for requirement, hashes in locked().items():
        assert re.match(r"[A-Za-z0-9._-]+(\[\w+\])?==[^ ;]+( ; .*)?$", requirement), requirement
        assert hashes, requirement
        assert all(re.fullmatch(r"sha256:[0-9a-f]{64}", value) for value in hashes), requirement


def test_lock_holds_every_dependency_that_the_package_declares() -> None:
    project: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    declared = project["dependencies"] + project["optional-dependencies"]["dev"]
    assert {package_name(requirement) for requirement in declared} <= {
        package_name(requirement) for requirement in locked()
    }


@pytest.mark.parametrize("name", ["requirements.lock.txt", "run.py", "Makefile", ".ci/run", "pyproject.toml"])
def test_files_that_install_name_no_host(name: str) -> None:
    text = (ROOT / name).read_text()
    assert "://" not in text
    # Nor by an option that would name one.
    assert not re.search(r"(index|find)-(url|links)", text)


# What is in the tree.


def repository_files() -> list[Path]:
    """Tracked files and those that could be added; everything but hidden folders where there is no git."""
    listing = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=ROOT, capture_output=True
    )
    if listing.returncode == 0:
        found = [ROOT / os.fsdecode(name) for name in listing.stdout.split(b"\0") if name]
    else:
        hidden = re.compile(r"\.(?!ci$|git(ignore|attributes)$)|__pycache__$|runs$|build$|dist$|.*\.egg-info$")
        found = [path for path in ROOT.rglob("*") if not any(map(hidden.match, path.relative_to(ROOT).parts))]
    return [path for path in found if path.is_file()]


def test_no_file_names_a_folder_of_somebodys_machine() -> None:
    # A home folder, or the folder that a build machine works in; "~/…" and relative paths are fine.
    private = re.compile(rb"(?<![\w.~-])/(?:root|work|Users/\w+|home/\w+)/\w")
    named = {
        str(path.relative_to(ROOT)): match.group().decode()
        for path in repository_files()
        if (match := private.search(path.read_bytes()))
    }
    assert named == {}


def test_no_file_of_ours_exceeds_a_megabyte() -> None:
    assert [path.name for path in repository_files() if path.stat().st_size > 2**20] == []


# The bootstrap, on a clone in miniature: the real run.py, a package of three lines and one locked dependency,
# all from local files, so that real environments are made and real hashes checked without a network.

BACKEND = textwrap.dedent(
    '''
    """A build back end of one function, so that the miniature needs no setuptools."""
    import os, zipfile

    def wheel(folder, name, files):
        info = name + "-1.0.dist-info/"
        files = dict(files)
        files[info + "METADATA"] = "Metadata-Version: 2.1\\nName: %s\\nVersion: 1.0\\n" % name
        files[info + "WHEEL"] = "Wheel-Version: 1.0\\nGenerator: test\\nRoot-Is-Purelib: true\\nTag: py3-none-any\\n"
        files[info + "RECORD"] = "".join(path + ",,\\n" for path in [*files, info + "RECORD"])
        path = name + "-1.0-py3-none-any.whl"
        with zipfile.ZipFile(os.path.join(folder, path), "w") as archive:
            for member, text in files.items():
                archive.writestr(member, text)
        return path

    def build_editable(folder, config_settings=None, metadata_directory=None):
        scripts = "[console_scripts]\\nburnish = burnish_cli:main\\n"
        source = os.path.join(os.getcwd(), "src") + "\\n"
        return wheel(folder, "burnish", {"burnish.pth": source, "burnish-1.0.dist-info/entry_points.txt": scripts})

    build_wheel = build_editable
    '''
)
PYPROJECT = """\
[build-system]
requires = []
build-backend = "backend"
backend-path = ["."]

[project]
name = "burnish"
version = "1.0"
"""
CLI = """\
import os, sys, time
import burnish_pebble  # The locked dependency.

def main():
    print(os.path.basename(sys.argv[0]), sys.argv[1:], os.getpid(), flush=True)
    if "--wait" in sys.argv:
        time.sleep(30)
    return 7
"""

Run = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """A miniature of this repository, in a folder with a space in its name."""
    folder = tmp_path / "a clone"
    (folder / "src").mkdir(parents=True)
    shutil.copy(RUN, folder)
    (folder / "pyproject.toml").write_text(PYPROJECT)
    (folder / "backend.py").write_text(BACKEND)
    (folder / "src" / "burnish_cli.py").write_text(CLI)
    wheels = tmp_path / "wheels"
    wheels.mkdir()
    backend: dict[str, Any] = {}
    exec(BACKEND, backend)
    wheel = wheels / backend["wheel"](wheels, "burnish_pebble", {"burnish_pebble.py": ""})
    digest = hashlib.sha256(wheel.read_bytes()).hexdigest()
    (folder / "requirements.lock.txt").write_text(f"burnish-pebble==1.0 --hash=sha256:{digest}\n")
    return folder


def environment(clone: Path, *, uv: bool) -> dict[str, str]:
    """Variables under which either installer finds the miniature's wheel and nothing else."""
    wheels = str(clone.parent / "wheels")
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PIP_", "UV_", "VIRTUAL_ENV"))}
    path = os.defpath
    if uv:
        found = shutil.which("uv", path=os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]]))
        assert found, "uv is among the development packages"
        path = os.pathsep.join([str(Path(found).parent), path])
    return kept | {
        "PATH": path,
        "PIP_NO_INDEX": "1",
        "PIP_FIND_LINKS": wheels,
        "PIP_CONFIG_FILE": os.devnull,
        "PIP_DISABLE_PIP_VERSION_CHECK": "1",
        "UV_OFFLINE": "1",
        "UV_NO_CONFIG": "1",
        "UV_FIND_LINKS": wheels,
        "UV_CACHE_DIR": str(clone.parent / "cache"),
    }


def call(clone: Path, *words: str, uv: bool = True) -> subprocess.CompletedProcess[str]:
    """``python run.py WORDS`` from another folder, as a user may call it."""
    command = [sys.executable, str(clone / "run.py"), *words]
    return subprocess.run(
        command, cwd=clone.parent, env=environment(clone, uv=uv), capture_output=True, text=True, timeout=120
    )


def test_run_sets_up_once_and_becomes_the_verb(clone: Path) -> None:
    first = call(clone, "polish", "--mould", "a b")
    assert first.returncode == 7, first.stderr
    assert first.stdout.startswith("burnish ['polish', '--mould', 'a b']")
    assert "Setting up .venv" in first.stderr

    second = call(clone, "polish")
    assert (second.returncode, second.stderr) == (7, "")


def test_ctrl_c_reaches_the_verb(clone: Path) -> None:
    assert call(clone, "setup").returncode == 0
    command = [sys.executable, str(clone / "run.py"), "polish", "--wait"]
    verb = subprocess.Popen(
        command,
        env=environment(clone, uv=True),
        stdout=subprocess.PIPE,
        text=True,
        # A test run in the background of a shell ignores Ctrl-C, and hands that down.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert verb.stdout is not None
    with verb.stdout as output:
        assert output.readline().split()[-1] == str(verb.pid)
        verb.send_signal(signal.SIGINT)
        assert verb.wait(timeout=10) in (-signal.SIGINT, 130)


def test_half_made_environment_is_made_afresh(clone: Path) -> None:
    half = clone / ".venv"
    (half / "lib").mkdir(parents=True)
    (half / "lib" / "left over").touch()
    (half / "set-up-unfinished").touch()
    assert call(clone, "polish").returncode == 7
    assert not (half / "lib" / "left over").exists()
    assert not (half / "set-up-unfinished").exists()


def test_environment_without_its_interpreter_is_made_afresh(clone: Path) -> None:
    assert call(clone, "setup").returncode == 0
    (clone / ".venv" / "bin" / "python").unlink()
    assert call(clone, "polish").returncode == 7


def test_changed_lock_is_installed_over_what_stands(clone: Path) -> None:
    assert call(clone, "setup").returncode == 0
    kept = clone / ".venv" / "kept"
    kept.touch()
    with (clone / "requirements.lock.txt").open("a") as lock:
        lock.write("# newer\n")
    again = call(clone, "polish")
    assert again.returncode == 7
    assert "Setting up .venv" in again.stderr
    assert kept.exists()


def test_moved_clone_is_set_up_again(clone: Path) -> None:
    assert call(clone, "setup").returncode == 0
    moved = clone.rename(clone.with_name("another clone"))
    again = call(moved, "polish")
    assert again.returncode == 7, again.stderr
    assert "Setting up .venv" in again.stderr


def test_wrong_hash_stops_the_set_up_and_leaves_no_stamp(clone: Path) -> None:
    (clone / "requirements.lock.txt").write_text(f"burnish-pebble==1.0 --hash=sha256:{'0' * 64}\n")
    refused = call(clone, "polish")
    assert refused.returncode == 1
    assert "hash" in refused.stderr.lower()
    assert refused.stderr.splitlines()[-1].startswith("run.py: setting up .venv failed")
    assert not (clone / ".venv" / "set-up").exists()
    assert refused.stdout == ""


def test_two_first_calls_at_once_set_up_one_after_the_other(clone: Path) -> None:
    command = [sys.executable, str(clone / "run.py"), "polish"]
    both = [
        subprocess.Popen(command, env=environment(clone, uv=True), stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        for _ in range(2)
    ]
    said = [process.communicate(timeout=60)[1].decode() for process in both]
    assert [process.returncode for process in both] == [7, 7], said
    assert sum("ready after" in text for text in said) == 1


@pytest.mark.slow
def test_run_sets_up_with_pip_alone(clone: Path) -> None:
    first = call(clone, "polish", uv=False)
    assert first.returncode == 7, first.stderr
    started = time.monotonic()
    second = call(clone, "polish", uv=False)
    assert (second.returncode, second.stderr) == (7, "")
    # Instant, for a person; making an environment takes several seconds.
    assert time.monotonic() - started < 2.0

    (clone / "requirements.lock.txt").write_text(f"burnish-pebble==1.0 --hash=sha256:{'0' * 64}\n")
    # What is already installed is not fetched again, so the wrong hash needs an empty environment to show.
    (clone / ".venv" / "set-up-unfinished").touch()
    refused = call(clone, "polish", uv=False)
    assert refused.returncode == 1
    assert "THESE PACKAGES DO NOT MATCH THE HASHES" in refused.stderr
    assert not (clone / ".venv" / "set-up").exists()


def pretending(clone: Path, change: str) -> subprocess.CompletedProcess[str]:
    """``run.py polish`` without uv, on an interpreter that ``change`` has altered first."""
    script = (
        f"import runpy, sys; {change}; sys.argv = ['run.py', 'polish']; runpy.run_path('run.py', run_name='__main__')"
    )
    return subprocess.run(
        [sys.executable, "-c", script], cwd=clone, env=environment(clone, uv=False), capture_output=True, text=True
    )


def test_python_without_ensurepip_is_told_what_to_install(clone: Path) -> None:
    # None in sys.modules is what the import system takes for "not there", as on Debian without python3-venv.
    refused = pretending(clone, "sys.modules['ensurepip'] = None")
    assert refused.returncode == 2
    assert len(refused.stderr.splitlines()) == 1
    assert "sudo apt install python3-venv" in refused.stderr
    assert not (clone / ".venv").exists()


@pytest.mark.parametrize("version", [(3, 9, 18), (3, 14, 0)])
def test_unsupported_python_is_told_so(clone: Path, version: tuple[int, int, int]) -> None:
    number = ".".join(map(str, version))
    refused = pretending(clone, f"sys.version_info = {version}; sys.version = '{number} (main)'")
    assert refused.returncode == 2
    assert refused.stderr.startswith(f"run.py: this is Python {number}; burnish needs 3.10 to 3.13")
    assert len(refused.stderr.splitlines()) == 1


@pytest.mark.parametrize("words", [[], ["--help"], ["-h"]])
def test_usage_needs_no_environment(clone: Path, words: list[str]) -> None:
    answer = call(clone, *words)
    assert answer.returncode == 0
    assert answer.stdout.startswith("usage: python3 run.py polish")
    assert not (clone / ".venv").exists()
