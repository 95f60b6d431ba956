"""The options of ``burnish teach`` and ``burnish replay``; they load nothing, so that the help is quick."""

from __future__ import annotations

import argparse

from burnish.commands.options import MOULDS, add_live, add_unit

ENDINGS = (
    "The arm is simulated. Exit status: 0 done; 2 refused; 3 the supervisor stopped the arm; 130 interrupted or the "
    "terminal was closed. The arm is brought to rest and the recording kept in every case."
)


def add_teach(parser: argparse.ArgumentParser) -> None:
    """The options of ``burnish teach``."""
    parser.epilog = f"Enter: to the ready pose. R: record. E: store and go home. Space: cancel. {ENDINGS}"
    parser.add_argument("--mould", default="dome", metavar="NAME|FILE.stl", help=f"{MOULDS} (default: dome)")
    add_unit(parser)
    parser.add_argument(
        "--device",
        default="auto",
        metavar="NAME|FILE",
        help="as for teleop: spacenav, spacemouse, gamepad, keyboard, auto, or a file to play; 'hand', a simulated "
        "operator who presses and slides; or 'jog', the workshop's buttons with --live (default: auto)",
    )
    parser.add_argument(
        "--modes", default="b", choices=("a", "b"), help="what the device's buttons change, as for teleop (default: b)"
    )
    parser.add_argument(
        "--arm", default="honest", choices=("ideal", "honest", "honest-stiff"), help="as for polish (default: honest)"
    )
    parser.add_argument("--sensor", default="wrist", choices=("wrist", "joint"), help="as for polish (default: wrist)")
    parser.add_argument("--rate", type=float, metavar="HZ", help="control rate, 50 to 1000 Hz (default: the arm's own)")
    parser.add_argument("--seed", type=int, default=0, metavar="K", help="seed of all random errors (default: 0)")
    _add_running(parser, "go to the ready pose, record, and store when a file or the hand has ended")


def add_replay(parser: argparse.ArgumentParser) -> None:
    """The options of ``burnish replay``."""
    parser.epilog = (
        f"Enter: to the ready pose, and again to play. P: pause and go on. Space: stop, and go home. {ENDINGS}"
    )
    parser.add_argument(
        "recording", metavar="RECORDING", help="run.mcap of 'burnish teach', or a desired_poses.txt (open loop only)"
    )
    parser.add_argument("--repeats", type=int, default=1, metavar="N", help="how often, 1 to 1000 (default: 1)")
    parser.add_argument(
        "--speed", type=float, default=1.0, metavar="X", help="times as fast as shown, 0.25 to 2 (default: 1)"
    )
    parser.add_argument(
        "--open-loop", action="store_true", help="replay the poses that were asked for by an impedance, without force"
    )
    parser.add_argument(
        "--mould-at",
        type=float,
        nargs=6,
        metavar=("X", "Y", "Z", "RX", "RY", "RZ"),
        help="how the mould was moved since: shift [m] and rotation vector [rad] about its own origin, base axes "
        "(default: not at all)",
    )
    parser.add_argument(
        "--mould",
        metavar="NAME|FILE.stl",
        help="the mould's file if it is not bundled (default: that of the recording)",
    )
    add_unit(parser)
    parser.add_argument(
        "--arm", choices=("ideal", "honest", "honest-stiff"), help="simulated arm (default: that of the recording)"
    )
    parser.add_argument("--sensor", choices=("wrist", "joint"), help="as for polish (default: that of the recording)")
    parser.add_argument("--rate", type=float, metavar="HZ", help="control rate, 50 to 1000 Hz (default: as recorded)")
    parser.add_argument("--seed", type=int, metavar="K", help="seed of all random errors (default: as recorded)")
    _add_running(parser, "press Enter wherever it is waited for")


def _add_running(parser: argparse.ArgumentParser, yes: str) -> None:
    """How it is run."""
    add_live(parser)
    parser.add_argument("--yes", action="store_true", help=f"nobody is there: {yes}")
    parser.add_argument(
        "--pace",
        type=float,
        metavar="X",
        help="times real time, 0.1 to 100; 0 is as fast as it can (default: 1; 0 with --yes and no device to hold)",
    )
    parser.add_argument("--out", metavar="DIR", help="folder for the results (default: a new one under runs/)")
