"""The options of ``burnish campaign``."""

from __future__ import annotations

import argparse


def add_campaign(parser: argparse.ArgumentParser) -> None:
    """The options of ``burnish campaign``."""
    parser.epilog = "Exit status: 0 done; 1 done, and a torque sample was unsafe; 2 refused; 130 interrupted."
    parser.add_argument("--episodes", type=int, default=1000, metavar="N", help="how many (default: 1000)")
    parser.add_argument("--seed", type=int, default=0, metavar="S", help="seed of all that is drawn (default: 0)")
    parser.add_argument("--jobs", type=int, default=2, metavar="J", help="processes to run them in (default: 2)")
    parser.add_argument(
        "--nominal",
        action="store_true",
        help="episodes of 30 s of operating and polishing in which nothing is wrong; 1200 are 10 virtual hours",
    )
    parser.add_argument("--only", type=int, metavar="K", help="run episode K alone, and keep its log and its plot")
    parser.add_argument(
        "--out", metavar="DIR", help="folder for the results; what is done there is not done again (default: a new "
        "one under runs/)"
    )  # fmt: skip
