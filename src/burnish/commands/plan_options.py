"""The options of ``burnish plan``."""

from __future__ import annotations

import argparse

from burnish.commands.options import MOULDS, PATTERNS, add_unit


def add_plan(parser: argparse.ArgumentParser) -> None:
    """What to work on, how, and where the plan goes; a recipe brings force, feed and pattern."""
    parser.add_argument("--mould", default="dome", metavar="NAME|FILE", help=f"{MOULDS} (default: dome)")
    add_unit(parser)
    parser.add_argument(
        "--recipe", metavar="FILE.toml", help="tool, spindle, passes, force, feed, depth, limits (default: as polish)"
    )
    parser.add_argument("--pattern", choices=PATTERNS, help="how the mould is covered (default: the raster of polish)")
    parser.add_argument("--force", type=float, metavar="N", help="contact force, 2 to 20 N (default: 10)")
    parser.add_argument(
        "--feed", type=float, metavar="M/S", help="speed on the surface, 0.005 to 0.08 m/s (default: 0.02)"
    )
    parser.add_argument(
        "--repair",
        metavar="DIR",
        help="plan what a finished or stopped job of this folder left under target (default: a new job)",
    )
    parser.add_argument("--out", required=True, metavar="FILE.json", help="file for the plan: mould frame, m, m/s, N")
