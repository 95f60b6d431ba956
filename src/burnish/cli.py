"""The command line: finds the verb, reads its options, and turns a refusal into one line and exit status 2."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import NoReturn

from burnish.commands.campaign_options import add_campaign
from burnish.commands.db_options import add_db
from burnish.commands.gui_options import add_gui
from burnish.commands.options import (
    add_connected,
    add_export,
    add_polish,
    add_recover,
    add_reproduce,
    add_verify,
)
from burnish.commands.plan_options import add_plan
from burnish.commands.teach_options import add_replay, add_teach
from burnish.commands.teleop_options import add_teleop
from burnish.errors import BurnishError, InputError

VERBS = {
    "polish": ("plan a path over a mould, rub along it at a held force, and report what was polished", add_polish),
    "plan": ("write the tool path alone, checked for reach and speed, as JSON", add_plan),
    "teleop": (
        "move the tool of an arm by hand, with a SpaceMouse, a gamepad or the keyboard, and record it",
        add_teleop,
    ),
    "teach": ("show the arm a job on a mould once, and store it", add_teach),
    "replay": ("repeat what was taught, with the force that was shown or open loop", add_replay),
    "reproduce": ("run the theses' and the blog's experiments, ours beside theirs, and report them", add_reproduce),
    "campaign": ("run random tasks with random faults on the simulated arm, and judge what the arm did", add_campaign),
    "verify": ("run a simulated recording again and say whether it comes out the same, bit by bit", add_verify),
    "recover": ("mend a recording that was cut off or damaged: all its whole messages in a new file", add_recover),
    "export": ("write a recording as a table, one row a cycle, or its desired poses as text", add_export),
    "gui": ("open the workshop in a browser: moulds, plans, jobs, demonstrations and runs, with the arm live", add_gui),
    "db": ("look after the library of moulds, recipes, demonstrations and runs", add_db),
    "doctor": ("say what the real arm and operator devices need, what is missing, and the next step", add_connected),
    "devices": ("list the arms and operator devices that are connected, with their serial numbers", add_connected),
}
"""Verb to what it does and to its options."""
REFUSED = 2
INTERRUPTED = 130


class Parser(argparse.ArgumentParser):
    """An argument parser that says what is wrong in one line."""

    def error(self, message: str) -> NoReturn:
        """Raise instead of printing the usage."""
        raise InputError(f"{message}. See '{self.prog} --help'")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a verb; returns its exit status.

    0 done; 1 `verify` found a difference; 2 the input is refused; 3 the supervisor stopped the arm; 130 interrupted.
    """
    parser = Parser(
        prog="burnish",
        description="Operational-space force control for robot arms; surface finishing from a mesh to a report.",
        epilog="'burnish VERB --help' lists a verb's options with their units and defaults.",
    )
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    words = list(sys.argv[1:] if arguments is None else arguments)
    for name, (text, add_options) in VERBS.items():
        verb = verbs.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
        add_options(verb)
    try:
        options = parser.parse_args(words)
        # A verb's module brings its engines; only the one that is asked for is loaded.
        return int(import_module(f"burnish.commands.{options.verb}").run(options))
    except BurnishError as error:
        print(f"burnish: {' '.join(str(error).split())}", file=sys.stderr)
        return REFUSED
    except KeyboardInterrupt:
        print("burnish: interrupted", file=sys.stderr)
        return INTERRUPTED


if __name__ == "__main__":
    sys.exit(main())
