"""The options of ``burnish gui``."""

from __future__ import annotations

import argparse


def add_gui(parser: argparse.ArgumentParser) -> None:
    """Where it serves, and which library it shows."""
    parser.epilog = (
        "Only this computer can reach it, and only with the address that is printed, which works once. From another "
        "computer go through an SSH tunnel. The stop on the page is no emergency stop. Ctrl-C ends it."
    )
    parser.add_argument(
        "--port", type=int, default=8080, metavar="N", help="port on 127.0.0.1, or the next free one (default: 8080)"
    )
    parser.add_argument(
        "--library",
        metavar="DIR",
        help="folder of the library (default: BURNISH_LIBRARY, or burnish in the user's data folder)",
    )
    parser.add_argument("--no-browser", action="store_true", help="print the address and open no browser")
