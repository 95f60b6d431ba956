"""Options that several verbs share, and checks of what was given."""

from __future__ import annotations

import argparse
import os
import tempfile
from datetime import datetime
from pathlib import Path

from burnish.errors import InputError

PATTERNS = ("raster", "cross_hatch", "spiral", "contour", "geodesic")
"""Patterns that need no further figures."""
MOULDS = "plate, dome, wave or mould, or the path of an STL, OBJ, PLY or 3MF file"


def add_polish(parser: argparse.ArgumentParser) -> None:
    """The options of ``burnish polish``."""
    _add_work(parser)
    parser.add_argument(
        "--arm",
        default="honest",
        choices=("ideal", "honest", "honest-stiff"),
        help="the simulated arm: the model itself; with friction, delay, biased sensors, wrong masses and a moved "
        "mould; or the same with twice the friction (default: honest)",
    )
    parser.add_argument(
        "--sensor",
        default="wrist",
        choices=("wrist", "joint"),
        help="where the contact force comes from: a wrist sensor, or tared joint torques (default: wrist)",
    )
    parser.add_argument(
        "--rate", type=float, metavar="HZ", help="control rate, 50 to 1000 Hz (default: 100, ideal arm 1000)"
    )
    parser.add_argument("--seed", type=int, default=0, metavar="K", help="seed of all random errors (default: 0)")
    parser.add_argument("--out", metavar="DIR", help="folder for the results (default: a new one under runs/)")
    add_live(parser)
    parser.add_argument(
        "--pace",
        type=float,
        default=0.0,
        metavar="X",
        help="times real time, 0.1 to 100; 0 is as fast as it can (default: 0)",
    )
    _add_course(parser)


def add_live(parser: argparse.ArgumentParser) -> None:
    """Whether a job is watched and commanded from outside."""
    parser.add_argument(
        "--live",
        metavar="FILE",
        help="shown and commanded through this file, which 'burnish gui' makes; the arm is held where the commander's "
        "beats end (default: none, Ctrl-C ends it)",
    )


def _add_course(parser: argparse.ArgumentParser) -> None:
    """How a job is run."""
    parser.add_argument(
        "--recipe", metavar="FILE.toml", help="tool, spindle, passes, force, feed, depth and limits (default: none)"
    )
    parser.add_argument("--pattern", choices=PATTERNS, help="how the mould is covered (default: parallel lines)")
    parser.add_argument("--passes", type=int, default=1, metavar="N", help="how often it is done, 1 to 20 (default: 1)")
    parser.add_argument(
        "--skip",
        type=stroke_numbers,
        default=(),
        metavar="K,K",
        help="numbers of strokes that are left out, from 1 (default: none)",
    )
    parser.add_argument(
        "--abrasive-life",
        type=float,
        metavar="M",
        help="path that an abrasive does before the job stops for a new one, m (default: no limit)",
    )
    parser.add_argument(
        "--search",
        action="store_true",
        help="look for a mould up to 50 mm and 30° off, by up to 12 touches (default: up to 2 mm and 2°)",
    )
    parser.add_argument(
        "--stands",
        type=three_numbers,
        default=(0.0, 0.0, 0.0),
        metavar="DX,DY,YAW",
        help="where the simulated mould really stands off its place, m,m,° (default: 0,0,0)",
    )
    parser.add_argument(
        "--resume",
        metavar="DIR",
        help="go on with the job of this folder where it stopped; its journal says all else (default: a new job)",
    )
    parser.add_argument(
        "--repair",
        metavar="DIR",
        help="work again what the job of this folder left under target, as a job of its own; the tool has to spin, and "
        "the folder says all else (default: a new job)",
    )


def stroke_numbers(text: str) -> tuple[int, ...]:
    """``3,5`` as whole numbers, for argparse.

    Raises:
        ValueError: it is none.
    """
    return tuple(int(number) for number in text.split(","))


def three_numbers(text: str) -> tuple[float, float, float]:
    """``0.03,-0.02,15`` as numbers, for argparse.

    Raises:
        ValueError: it is none.
    """
    x, y, yaw = (float(number) for number in text.split(","))
    return x, y, yaw


def add_connected(parser: argparse.ArgumentParser) -> None:
    """The options of ``burnish doctor`` and ``burnish devices``."""
    parser.add_argument(
        "--lib",
        metavar="FILE.so",
        help="Kinova's command layer, USB or Ethernet (default: BURNISH_KINOVA_LIB, or where its installer puts it)",
    )


def add_reproduce(parser: argparse.ArgumentParser) -> None:
    """The options of ``burnish reproduce``."""
    parser.add_argument("names", nargs="*", metavar="NAME", help="experiments to run (default: all of them)")
    parser.add_argument("--list", action="store_true", help="print the names and titles, and run nothing")
    parser.add_argument("--jobs", type=int, default=2, metavar="J", help="processes to run trials in (default: 2)")
    parser.add_argument("--out", metavar="DIR", help="folder for the results (default: a new one under runs/)")


def add_verify(parser: argparse.ArgumentParser) -> None:
    """The options of ``burnish verify``."""
    parser.epilog = "Exit status: 0 bit-exact; 1 not exact, and where; 2 refused: of another model, mould or version."
    parser.add_argument("recording", metavar="RECORDING", help="run.mcap of a simulated 'burnish polish' or 'replay'")
    parser.add_argument("--taught", metavar="FILE", help="of a replay: what was replayed (default: none)")
    parser.add_argument("--mould", metavar="FILE", help="the mould's file (default: none, a bundled mould)")


def add_recover(parser: argparse.ArgumentParser) -> None:
    """The options of ``burnish recover``."""
    parser.add_argument("file", metavar="FILE", help="the recording; it is only read")
    parser.add_argument("--out", metavar="FILE", help="the new file (default: FILE.recovered.mcap beside it)")


def add_export(parser: argparse.ArgumentParser) -> None:
    """The options of ``burnish export``."""
    parser.add_argument("file", metavar="FILE", help="the recording")
    parser.add_argument(
        "--to",
        required=True,
        choices=("parquet", "csv", "txt"),
        help="parquet and csv: one row a cycle, SI units; txt: the desired tool poses, px py pz εx εy εz η a line, m",
    )
    parser.add_argument("--out", metavar="FILE", help="the new file (default: FILE with the form as its ending)")


def add_unit(parser: argparse.ArgumentParser) -> None:
    """The unit of a mould's file."""
    parser.add_argument(
        "--unit",
        default="auto",
        choices=("auto", "mm", "m", "inch"),
        help="unit of a file that names none; auto takes mm, or what the part's size says (default: auto)",
    )


def _add_work(parser: argparse.ArgumentParser) -> None:
    """What to work on, and how."""
    parser.add_argument("--mould", default="dome", metavar="NAME|FILE", help=f"{MOULDS} (default: dome)")
    add_unit(parser)
    parser.add_argument("--force", type=float, default=10.0, metavar="N", help="contact force, 2 to 20 N (default: 10)")
    parser.add_argument(
        "--feed",
        type=float,
        default=0.02,
        metavar="M/S",
        help="speed on the surface, 0.005 to 0.08 m/s (default: 0.02)",
    )


def output_folder(given: str | None, verb: str) -> Path:
    """The folder for the results, made and tried, or a new one under ``runs/``.

    Raises:
        InputError: if it cannot be written.
    """
    folder = Path(given) if given else Path("runs") / f"{datetime.now():%Y-%m-%d_%H-%M-%S}_{verb}"
    check_writable(folder)
    return folder


def check_writable(folder: Path) -> None:
    """Refuse a folder that cannot be made or written; leaves nothing behind.

    Raises:
        InputError: says which part of the path is in the way.
    """
    if folder.exists() and not folder.is_dir():
        raise InputError(f"--out {folder} is a file; expected a folder, new or existing")
    nearest = next(parent for parent in (folder, *folder.absolute().parents) if parent.exists())
    try:
        if not nearest.is_dir():
            raise NotADirectoryError(f"{nearest} is a file")
        with tempfile.TemporaryFile(dir=nearest):
            pass
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(f"--out {folder} cannot be written ({reason}: {nearest}); choose another folder") from error


def relative(path: Path) -> str:
    """The path as a person would type it from here."""
    return os.path.relpath(path) if path.is_absolute() else str(path)
