"""A library of each kind: on SQLite, and on a real PostgreSQL server."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from library.postgres import Server, programs

from burnish.library import Library


@pytest.fixture(scope="session")
def server() -> Iterator[Server]:
    """The server; without its programs the tests are skipped, where they have to be there they fail."""
    found = programs()
    if found is None:
        if os.environ.get("CI") == "true":
            pytest.fail("no PostgreSQL server; install the system's package 'postgresql'")
        pytest.skip("no PostgreSQL server")
    with Server(found) as running:
        yield running


@pytest.fixture(params=["sqlite", "postgresql"])
def url(request: pytest.FixtureRequest) -> str | None:
    """URL of an empty database; None is SQLite in the library's folder."""
    if request.param == "sqlite":
        return None
    running: Server = request.getfixturevalue("server")
    return running.database()


@pytest.fixture
def library(url: str | None, tmp_path: Path) -> Iterator[Library]:
    """An empty library."""
    with Library.open(tmp_path / "library", url) as opened:
        yield opened
