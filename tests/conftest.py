"""How the tests are shared out among processes, and where what they make is kept."""

from __future__ import annotations

import os
import shutil
import tempfile

import pytest


def pytest_configure(config: pytest.Config) -> None:
    """Runs enter what they make into the library: into one of the tests, not into that of whoever runs them."""
    os.environ.pop("BURNISH_DATABASE", None)
    os.environ["BURNISH_LIBRARY"] = tempfile.mkdtemp(prefix="burnish-library-")


def pytest_unconfigure(config: pytest.Config) -> None:
    """It goes with the tests."""
    shutil.rmtree(os.environ["BURNISH_LIBRARY"], ignore_errors=True)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """A file's tests stay together, and all of ROS does: a process can belong to one master only."""
    for item in items:
        file = item.nodeid.partition("::")[0]
        item.add_marker(pytest.mark.xdist_group("ros" if "test_ros1" in file else file))
