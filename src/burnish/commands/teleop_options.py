"""The options of ``burnish teleop``; they load nothing, so that the help is quick."""

from __future__ import annotations

import argparse

from burnish.commands.options import MOULDS, add_unit


def add_teleop(parser: argparse.ArgumentParser) -> None:
    """The options of ``burnish teleop``."""
    parser.epilog = (
        "Exit status: 0 done; 2 refused; 3 the supervisor stopped the arm; 130 interrupted, the terminal was closed or "
        "the device went away. The arm is brought to rest and the recording kept in every case. A real arm moves only "
        "after somebody at the terminal has typed the end of its serial number; once the supervisor has stopped it, it "
        "holds by its position mode, and the program ends."
    )
    parser.add_argument(
        "--robot",
        default="simulated",
        choices=("simulated", "jaco2"),
        help="jaco2: the real arm through Kinova's library, always as with --near-people, without --arm, --mould, "
        "--rate, --seed and --view (default: simulated)",
    )
    parser.add_argument(
        "--serial", metavar="S", help="serial number of the real arm (default: the only one that is connected)"
    )
    parser.add_argument(
        "--lib",
        metavar="FILE.so",
        help="Kinova's command layer (default: BURNISH_KINOVA_LIB, or where its installer puts it)",
    )
    parser.add_argument(
        "--device",
        default="auto",
        metavar="NAME|FILE",
        help="spacenav, spacemouse, gamepad, keyboard, auto for the first of them that is there, or a file to play "
        "(default: auto)",
    )
    parser.add_argument(
        "--modes",
        default="b",
        choices=("a", "b"),
        help="a: free, translation, rotation on button 2, fingers on button 1; b: polishing, turn about tool, all in "
        "base, all in tool on button 1 (default: b)",
    )
    parser.add_argument(
        "--deadman", type=int, metavar="BUTTON", help="button that has to be held for anything to move (default: none)"
    )
    parser.add_argument(
        "--near-people", action="store_true", help="0.126 m/s and less where the arm is heavy, instead of 0.2 m/s"
    )
    parser.add_argument(
        "--law",
        default="OperationalSpace",
        metavar="NAME",
        help="any law of burnish.control that follows tool poses (default: OperationalSpace)",
    )
    parser.add_argument(
        "--arm",
        default="honest",
        choices=("ideal", "honest", "honest-stiff"),
        help="the simulated arm, as for polish (default: honest)",
    )
    parser.add_argument(
        "--mould",
        metavar="NAME|FILE.stl",
        help=f"what lies under the polishing tool: {MOULDS} (default: none, and a bare hand)",
    )
    add_unit(parser)
    parser.add_argument(
        "--rate", type=float, metavar="HZ", help="control rate, 50 to 1000 Hz (default: 100, ideal arm 1000)"
    )
    parser.add_argument("--seed", type=int, default=0, metavar="K", help="seed of all random errors (default: 0)")
    parser.add_argument(
        "--seconds", type=float, metavar="S", help="end after this time [s] (default: when q is pressed)"
    )
    parser.add_argument("--view", action="store_true", help="show the arm in MuJoCo's viewer")
    parser.add_argument("--out", metavar="DIR", help="folder for the recording (default: a new one under runs/)")
