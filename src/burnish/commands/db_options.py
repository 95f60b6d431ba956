"""The options of ``burnish db``; they load nothing, so that the help is quick."""

from __future__ import annotations

import argparse


def add_db(parser: argparse.ArgumentParser) -> None:
    """What to do with the library, and which one."""
    parser.epilog = "Exit status: 0 done; 1 'check' or 'reindex' found something; 2 refused."
    parser.add_argument(
        "--library",
        metavar="DIR",
        help="the library's folder (default: BURNISH_LIBRARY, else 'burnish' in XDG_DATA_HOME or ~/.local/share)",
    )
    parser.add_argument(
        "--database",
        metavar="URL",
        help="its database, such as postgresql://user:password@host/name (default: BURNISH_DATABASE, else a file in "
        "the folder)",
    )
    tasks = parser.add_subparsers(dest="task", metavar="TASK", required=True)
    for name, text in (
        ("init", "make the library, or say what is in it"),
        ("check", "read every file, and say what is missing, altered or too much, and what to do"),
        ("reindex", "build the database anew from the files; what is nobody's is moved to the folder 'lost'"),
        ("upgrade", "bring the database of an older burnish to this one's version"),
    ):
        tasks.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
    text = "write all of it into one archive; others may go on meanwhile"
    backup = tasks.add_parser("backup", help=text, description=text[0].upper() + text[1:] + ".")
    backup.add_argument("file", metavar="FILE.zip", help="the archive, a new file")
    text = "put back what an archive holds"
    restore = tasks.add_parser("restore", help=text, description=text[0].upper() + text[1:] + ".")
    restore.add_argument("file", metavar="FILE.zip", help="an archive of 'burnish db backup'")
    restore.add_argument(
        "--overwrite", action="store_true", help="remove what the library holds (default: refuse if it holds anything)"
    )
