"""One process with an arm for all tests of a run; each test gets a new arm in it."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from ctypes import memset, sizeof
from pathlib import Path
from typing import Any

import pytest
from hardware.ros_graph import node, ros_clock, ros_jaco2, ros_master, ros_node  # noqa: F401
from hardware.standin import SERIAL, StandIn, SteppedClock, build

from burnish.hardware.jaco2 import Jaco2
from burnish.hardware.kinova import Kinova
from burnish.hardware.kinova_library import VARIABLE, Library
from burnish.model.model import Model


@pytest.fixture(scope="session")
def compiler() -> str:
    """The system's C compiler; without one these tests are skipped, where it has to be there they fail."""
    found = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if found is None:
        why = "no C compiler: the stand-in of the vendor's library cannot be built (apt: gcc libc6-dev)"
        pytest.fail(why) if os.environ.get("CI") else pytest.skip(why)
    return found


@pytest.fixture(scope="session")
def libraries(compiler: str, tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[int, bool], Path]:
    """All four libraries, by actuators and whether it is the Ethernet layer."""
    folder = tmp_path_factory.mktemp("standin")
    return {(n, ethernet): build(compiler, folder, n, ethernet) for n in (7, 6) for ethernet in (False, True)}


@pytest.fixture(scope="session")
def process(compiler: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[StandIn]:
    standin = StandIn(tmp_path_factory.mktemp("arm"))
    yield standin
    standin.stop()


@pytest.fixture
def standin(
    process: StandIn, libraries: dict[tuple[int, bool], Path], monkeypatch: pytest.MonkeyPatch
) -> Iterator[StandIn]:
    """A freshly switched on honest arm on simulated time, and the environment that leads to its library."""
    monkeypatch.setenv(VARIABLE, str(libraries[7, False]))
    process.reset()
    yield process
    process.off()


@pytest.fixture
def clock(standin: StandIn) -> SteppedClock:
    return SteppedClock(standin)


@pytest.fixture
def jaco2(standin: StandIn, clock: SteppedClock) -> Callable[..., Jaco2]:
    """Makes the driver of the stand-in's arm on its simulated time."""

    def make(**options: Any) -> Jaco2:
        return Jaco2(**({"model": Model.jaco2(), "serial": SERIAL, "clock": clock} | options))

    return make


@pytest.fixture
def kinova(standin: StandIn, libraries: dict[tuple[int, bool], Path]) -> Iterator[Kinova]:
    """The vendor's calls in SI units."""
    with Kinova(Library(libraries[7, False])) as kinova:
        kinova.choose(SERIAL)
        yield kinova
        # Whatever a test made the calls return, the library is closed.
        memset(standin.memory.times, 0, sizeof(standin.memory.times))
