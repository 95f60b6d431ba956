"""``burnish db``: make, check, rebuild, save and bring back the library of moulds, recipes and runs."""

from __future__ import annotations

import argparse

from burnish.library import Library
from burnish.library.rows import KINDS

DONE, FOUND = 0, 1


def run(options: argparse.Namespace) -> int:
    """Do one of the tasks."""
    task = {
        "init": init,
        "check": check,
        "reindex": reindex,
        "upgrade": upgrade,
        "backup": backup,
        "restore": restore,
    }[options.task]
    return task(options)


def init(options: argparse.Namespace) -> int:
    """Make the library, or say what is in it."""
    with Library.open(options.library, options.database) as library:
        counts = {word: library.count(kind) for word, kind in KINDS.items()}
        print(f"{library.root}, database {library.database.shown}")
        print(", ".join(f"{count} {word}{'' if count == 1 else 's'}" for word, count in counts.items()))
    return DONE


def check(options: argparse.Namespace) -> int:
    """Read every file, and say what is wrong."""
    with Library.open(options.library, options.database) as library:
        findings = library.check()
        for finding in findings:
            print(finding)
        print(f"{len(findings)} findings" if findings else f"{library.root} is in order")
    return FOUND if findings else DONE


def reindex(options: argparse.Namespace) -> int:
    """Build the database anew."""
    with Library.at(options.library, options.database) as library:
        rebuilt = library.reindex()
        for finding in rebuilt.findings:
            print(finding)
        print(f"{rebuilt.rows} rows in {library.database.shown}")
    return FOUND if rebuilt.findings else DONE


def upgrade(options: argparse.Namespace) -> int:
    """Bring the database to this program's version."""
    with Library.at(options.library, options.database) as library:
        before = library.database.version()
        library.upgrade()
        print(f"{library.database.shown}: version {before or 'none'} → {library.database.version()}")
    return DONE


def backup(options: argparse.Namespace) -> int:
    """Write all of it into one archive."""
    with Library.open(options.library, options.database) as library:
        print(f"{library.backup(options.file)} rows with their files → {options.file}")
    return DONE


def restore(options: argparse.Namespace) -> int:
    """Put back what an archive holds."""
    with Library.open(options.library, options.database) as library:
        print(
            f"{library.restore_from(options.file, overwrite=options.overwrite)} rows with their files → {library.root}"
        )
    return DONE
