"""A running spacenavd with a played mouse, shared by the tests of a file that leave it whole."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from teleop.magellan import Spacenavd


@pytest.fixture(scope="module")
def shared_daemon() -> Iterator[Spacenavd]:
    with Spacenavd() as found:
        yield found


@pytest.fixture
def daemon(shared_daemon: Spacenavd) -> Spacenavd:
    """The daemon with its mouse at rest; a test that breaks it starts its own."""
    shared_daemon.mouse.move(0, 0, 0, 0, 0, 0)
    shared_daemon.mouse.press(0)
    return shared_daemon
