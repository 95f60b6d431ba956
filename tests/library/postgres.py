"""A PostgreSQL server of our own: in a temporary folder, reached by a socket there and by nothing else."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from itertools import count
from pathlib import Path

from sqlalchemy import create_engine, text
from typing_extensions import Self

PROGRAMS = Path("/usr/lib/postgresql")


def programs() -> Path | None:
    """Where the newest server's programs are; None where there is none."""
    found = [path.parent for path in PROGRAMS.glob("*/bin/initdb")]
    return max(found, key=lambda path: int(path.parent.name), default=None)


class Server:
    """It runs as long as the block does. Files are not forced onto the disk: nobody takes the power away here."""

    def __init__(self, programs: Path) -> None:
        self._programs = programs
        self.folder = Path(tempfile.mkdtemp(prefix="burnish-postgres-"))
        # The server refuses to be root.
        self._user = "postgres" if os.geteuid() == 0 else None
        if self._user is not None:
            shutil.chown(self.folder, self._user, self._user)
        self._numbers = count(1)

    def __enter__(self) -> Self:
        self._run("initdb", "--pgdata", "data", "--username", "burnish", "--auth", "trust", "--no-sync", "-E", "UTF8")
        options = f"-c listen_addresses='' -k {self.folder} -c fsync=off"
        self._run("pg_ctl", "--pgdata", "data", "-w", "-t", "60", "-l", "log", "-o", options, "start")
        return self

    def __exit__(self, *exception: object) -> None:
        self._run("pg_ctl", "--pgdata", "data", "-m", "immediate", "stop")
        shutil.rmtree(self.folder)

    def database(self) -> str:
        """URL of a new, empty database."""
        name = f"library_{next(self._numbers)}"
        engine = create_engine(self._url("postgres"), isolation_level="AUTOCOMMIT")
        with engine.connect() as connection:
            connection.execute(text(f"CREATE DATABASE {name}"))
        engine.dispose()
        return self._url(name)

    def _url(self, name: str) -> str:
        return f"postgresql+pg8000://burnish@/{name}?unix_sock={self.folder}/.s.PGSQL.5432"

    def _run(self, program: str, *words: str) -> None:
        command = [str(self._programs / program), *words]
        done = subprocess.run(
            command, cwd=self.folder, user=self._user, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
        )
        assert done.returncode == 0, done.stderr
