"""The peers that a control step is compared with: each from the package registry, in an environment of its own.

`python benchmarks/peers.py` installs them below .venv-peers/; `step.py` uses those that are there. They are no
dependency of burnish, and their versions of NumPy and MuJoCo stay theirs.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import venv
from pathlib import Path
from types import TracebackType

from typing_extensions import Self

from burnish.model.model import JACO2_URDF

HERE = Path(__file__).resolve().parent
FOLDER = HERE.parent / ".venv-peers"
PACKAGES = {
    "mink": ("mink>=1.3", "daqp"),
    # robosuite 1.5.2 does not start with MuJoCo 3.4 or later.
    "robosuite": ("robosuite==1.5.2", "mujoco<3.4"),
}
STEP_NAMES = {"mink": "mink: update + solve_ik (JACO2)", "robosuite": "robosuite: OSC_POSE (UR5e)"}


def python_of(name: str) -> Path:
    """The interpreter of a peer's environment."""
    return FOLDER / name / "bin" / "python"


def install(name: str) -> None:
    """Make a peer's environment anew.

    Raises:
        subprocess.CalledProcessError: if a package cannot be had.
    """
    venv.create(FOLDER / name, clear=True, with_pip=True)
    subprocess.run([str(python_of(name)), "-m", "pip", "install", "--quiet", *PACKAGES[name]], check=True)


class Peer:
    """A peer's process, ready to be timed; use it as a context manager."""

    def __init__(self, name: str) -> None:
        """Start it and wait until its first steps are done.

        Raises:
            FileNotFoundError: if it is not installed.
            RuntimeError: if it ended instead of getting ready.
        """
        self.name = name
        command = [str(python_of(name)), str(HERE / "peer_steps.py"), name, str(JACO2_URDF)]
        threads = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(
            command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, text=True, env=os.environ | threads
        )
        if self._line() != "ready":
            raise RuntimeError(f"{name} ended before it was ready; try it by hand: {' '.join(command)}")

    def time(self, count: int) -> list[float]:
        """Times of this many steps [µs]."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{count}\n")
        self._process.stdin.flush()
        times: list[float] = json.loads(self._line())
        return times

    def _line(self) -> str:
        assert self._process.stdout is not None
        return self._process.stdout.readline().strip()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._process.communicate(timeout=30)


def main() -> int:
    """Install."""
    cli = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    cli.add_argument("names", nargs="*", metavar="NAME", help=f"which (default: all of {', '.join(PACKAGES)})")
    names = cli.parse_args().names or list(PACKAGES)
    if unknown := set(names) - set(PACKAGES):
        cli.error(f"found {', '.join(sorted(unknown))}; expected names of {', '.join(PACKAGES)}")
    for name in names:
        print(f"installing {name} ...", file=sys.stderr, flush=True)
        try:
            install(name)
        except subprocess.CalledProcessError as error:
            print(f"peers: {name} could not be installed: {error}", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
