"""ROS for the tests: a master of their own, the stand-in of the driver's node, and the driver's clock."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hardware.firmware import ACTUATOR_PERIOD as STEP
from hardware.ros_driver_node import ROBOT, Switches, attach_switches, ticked_at
from hardware.standin import StandIn, SteppedClock

from burnish.hardware.ros1 import RosJaco2
from burnish.hardware.ros1_driver import Driver
from burnish.hardware.ros1_installed import RosMissingError, rospy
from burnish.model.model import Model

NODE = Path(__file__).resolve().parent / "ros_driver_node.py"
PATIENCE = 30.0
"""Until another process counts as dead [s]; on an idle machine each of these waits is a few milliseconds."""


def wait_until(what: Callable[[], bool], failure: str) -> None:
    """Look again and again; nothing depends on how long it takes."""
    until = time.monotonic() + PATIENCE
    while not what():
        assert time.monotonic() < until, failure
        time.sleep(1e-4)


class RosClock(SteppedClock):
    """A stepped clock that lets messages arrive between two steps: what was sent counts before time goes on."""

    def __init__(self, standin: StandIn, switches: Switches) -> None:
        super().__init__(standin)
        self._switches, self._first = switches, switches.handled
        self.sent = 0
        self.driver: Driver | None = None

    def wait(self, until: float) -> None:
        # The arm lives by whole steps, and the clock with it.
        steps = np.ceil((until - self._now) / STEP - 1e-6)
        if steps <= 0:
            return
        switches = self._switches
        wait_until(lambda: switches.handled - self._first >= self.sent, "the driver's node takes no commands")
        if self.driver is not None:
            states = self.driver._states
            wait_until(lambda: states.get_num_connections() > 0, "the driver's node is not connected")
            # The node hears of us by real messages, which stepped time must not outrun.
            wait_until(lambda: self.driver.is_heard, "the driver's node does not listen")
        super().wait(self._now + steps * STEP)
        memory = self._standin.memory
        wait_until(lambda: switches.seen_at == ticked_at(memory), "the driver's node has died")
        if self.driver is not None and self.driver.arrived:
            wait_until(lambda: self.driver.stamp >= switches.sent_at - 1e-6, "a joint state was lost")


@pytest.fixture(scope="session")
def ros_master(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A ROS master on a free port, and the environment that leads to it; where there is no ROS, the test is skipped."""
    master = shutil.which("rosmaster")
    try:
        rospy()
    except RosMissingError as error:
        missing(str(error))
    if master is None:
        missing("no rosmaster; as root: apt install python3-rosmaster")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    home = tmp_path_factory.mktemp("ros")
    with pytest.MonkeyPatch.context() as environment:
        environment.setenv("ROS_MASTER_URI", f"http://127.0.0.1:{port}")
        environment.setenv("ROS_IP", "127.0.0.1")
        environment.setenv("ROS_HOME", str(home))
        environment.delenv("ROS_LOG_DIR", raising=False)
        with (home / "master.log").open("w") as log:
            process = subprocess.Popen([str(master), "--core", "-p", str(port)], stdout=log, stderr=log)
        graph = import_module("rosgraph")
        wait_until(graph.is_master_online, f"the ROS master did not start; see {home}/master.log")
        yield os.environ["ROS_MASTER_URI"]
        if rospy().core.is_initialized():
            rospy().signal_shutdown("the tests are over")
        process.terminate()
        process.wait(10.0)


def missing(what: str) -> None:
    """Skip; but where all has to be there, fail."""
    if os.environ.get("CI"):
        pytest.fail(f"{what}. CI has to have ROS")
    pytest.skip(what)


@pytest.fixture(scope="session")
def ros_node(
    ros_master: str,
    process: StandIn,
    libraries: dict[tuple[int, bool], Path],
    tmp_path_factory: pytest.TempPathFactory,
) -> Iterator[Switches]:
    """The driver's node; it serves whatever arm the stand-in has."""
    folder = tmp_path_factory.mktemp("node")
    path = folder / "switches"
    path.touch()
    switches = attach_switches(path)
    with (folder / "node.log").open("w") as log:
        node = subprocess.Popen(
            [sys.executable, str(NODE), str(path), str(libraries[7, False])], stdout=log, stderr=log
        )
    wait_until(
        lambda: bool(switches.ready) or node.poll() is not None, f"the driver's node did not start; see {folder}"
    )
    assert node.poll() is None, (folder / "node.log").read_text()
    yield switches
    node.terminate()
    node.wait(10.0)


@pytest.fixture
def node(ros_node: Switches, ros_master: str, standin: StandIn) -> Iterator[Switches]:
    """The node with its switches off, at 100 Hz, and without parameters of an earlier test."""
    ros_node.interval = 0.01
    for name in ("reordered", "renamed", "silent", "wordless", "hung", "holds"):
        setattr(ros_node, name, 0)
    yield ros_node
    ros_node.hung = 0
    graph = import_module("rosgraph")
    master = graph.Master("/tests", ros_master)
    if master.hasParam("/j2n6s300_driver"):
        master.deleteParam("/j2n6s300_driver")


def set_parameter(name: str, value: Any) -> None:
    """Set a parameter of the driver, as its launch file would."""
    import_module("rosgraph").Master("/tests").setParam(f"/{ROBOT}_driver/{name}", value)


@pytest.fixture
def ros_clock(standin: StandIn, node: Switches, monkeypatch: pytest.MonkeyPatch) -> RosClock:
    """The clock of an arm on simulated time; it knows what the driver sends."""
    clock = RosClock(standin, node)
    publish, begin, end = Driver._publish, Driver.__init__, Driver.close

    def counted(driver: Driver, publisher: Any, message: Any) -> None:
        publish(driver, publisher, message)
        clock.sent += 1

    def known(driver: Driver, robot: str) -> None:
        begin(driver, robot)
        # The node serves one robot; for another nothing ever comes.
        clock.driver = driver if robot == ROBOT else None

    def forgotten(driver: Driver) -> None:
        clock.driver = None
        end(driver)

    monkeypatch.setattr(Driver, "_publish", counted)
    monkeypatch.setattr(Driver, "__init__", known)
    monkeypatch.setattr(Driver, "close", forgotten)
    return clock


@pytest.fixture
def ros_jaco2(ros_clock: RosClock) -> Callable[..., RosJaco2]:
    """Makes the driver of the stand-in's arm over ROS, on its simulated time."""

    def make(**options: Any) -> RosJaco2:
        return RosJaco2(**({"model": Model.jaco2(), "clock": ros_clock} | options))

    return make
