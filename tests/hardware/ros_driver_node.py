"""A stand-in of kinova-ros's driver: ``python ros_driver_node.py SWITCHES LIBRARY``.

Like the real one it is a ROS node above the vendor's library, here the stand-in of that library, and so the arm behind
it has the firmware's habits; its own are the switches. It lives by the arm's time, simulated or real: a joint state
follows a tick of the arm when one is due.
"""

from __future__ import annotations

import contextlib
import mmap
import os
import sys
import time
from ctypes import Structure, c_double, c_float, c_int32, c_uint32, sizeof
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np
from hardware.memory import TRACE, Memory, attach
from hardware.standin import VARIABLE

from burnish.hardware.kinova import Kinova
from burnish.hardware.kinova_library import Library
from burnish.hardware.kinova_types import ControlMode, Inactivity
from burnish.hardware.ros1_installed import rospy
from burnish.hardware.ros1_node import types

ROBOT = "j2n6s300"
NAMES = [f"{ROBOT}_joint_{i}" for i in range(1, 7)]
NAMES += [f"{ROBOT}_joint_finger{tip}_{i}" for tip in ("", "_tip") for i in range(1, 4)]
LOOK, NAP = 2e-4, 5e-3
"""From one look at the arm to the next [s], and the same when nothing has happened for a while."""
IDLE = 500
"""Looks until then."""


class Switches(Structure):
    """What node and tests share."""

    _fields_ = [
        ("ready", c_int32),
        # How far the node has looked at the arm, and the stamp of its last joint state [s, of the arm].
        ("seen_at", c_double),
        ("sent_at", c_double),
        # How many commands were taken from topics.
        ("handled", c_uint32),
        # Time between two joint states [s].
        ("interval", c_double),
        # Joints come in another order, or under another robot's name; joint states come no more.
        ("reordered", c_int32),
        ("renamed", c_int32),
        ("silent", c_int32),
        # Services end without an answer, as those of the real driver that forget to return one; or not at all.
        ("wordless", c_int32),
        ("hung", c_int32),
        # Whether the arm is told to hold its position when no torque comes; kinova-ros does not do that.
        ("holds", c_int32),
    ]


def attach_switches(path: Path | str) -> Switches:
    """The switches in the file at ``path``."""
    with open(path, "r+b") as file:
        file.truncate(sizeof(Switches))
        return Switches.from_buffer(mmap.mmap(file.fileno(), sizeof(Switches)))


def ticked_at(memory: Memory) -> float:
    """Time of the arm's last tick [s], whether it shows its state or not."""
    return float(memory.trace[(memory.traced - 1) % TRACE][0])


class Node:
    """Topics and services of the driver."""

    def __init__(self, switches: Switches, kinova: Kinova, memory: Memory) -> None:
        self._switches, self._kinova, self._memory = switches, kinova, memory
        self._ros, self._types = rospy(), types()
        base, kinds = f"/{ROBOT}_driver", self._types
        self._base = base
        self._out = self._ros.Publisher(f"{base}/out/joint_state", kinds.JointState, queue_size=2, tcp_nodelay=True)
        for topic, kind, on in (
            ("in/joint_torque", kinds.JointTorque, self._on_torque),
            ("in/joint_velocity", kinds.JointVelocity, self._on_velocity),
            ("joints_action/joint_angles/goal", kinds.JointAnglesGoal, self._on_goal),
        ):
            self._ros.Subscriber(f"{base}/{topic}", kind, self._counted(on), queue_size=100)
        for name, kind, on in (
            ("set_torque_control_mode", kinds.SetTorqueControlMode, self._on_mode),
            ("set_torque_control_parameters", kinds.SetTorqueControlParameters, self._on_parameters),
            ("clear_trajectories", kinds.ClearTrajectories, lambda _: self._kinova.erase()),
            ("set_zero_torques", kinds.ZeroTorques, lambda _: [kinova.zero_torque(joint) for joint in range(6)]),
            ("home_arm", kinds.HomeArm, self._on_home),
        ):
            self._ros.Service(f"{base}/in/{name}", kind, self._answering(on, kind._response_class))

    def run(self) -> None:
        """Send joint states until somebody ends us."""
        switches, last, due, looks = self._switches, 0, 0.0, 0
        switches.ready = 1
        while not self._ros.is_shutdown():
            ticks = self._memory.traced
            if ticks in (last, 0):
                looks += 1
                time.sleep(LOOK if looks < IDLE else NAP)
                continue
            last, looks, now = ticks, 0, ticked_at(self._memory)
            if now < due - switches.interval:
                # Another arm, just switched on.
                due = now
            if now >= due - 1e-6 and not switches.silent:
                due = now + switches.interval
                self._send(now)
                switches.sent_at = now
            switches.seen_at = now

    def _send(self, now: float) -> None:
        message = self._types.JointState()
        order = list(range(len(NAMES)))
        if self._switches.reordered:
            order = order[::-1]
        prefix = "left_" if self._switches.renamed else ""
        # kinova-ros passes angles of any number of turns on, and the base adds up turns.
        q = [*self._kinova.positions().tolist(), *self._kinova.fingers().tolist(), 0.0, 0.0, 0.0]
        tau = self._kinova.torques()
        if self._ros.get_param_cached(
            f"{self._base}/torque_parameters/publish_torque_with_gravity_compensation", False
        ):
            tau = tau - self._kinova.gravity_estimate()
        effort = [*tau.tolist(), *[0.0] * 6]
        message.header.stamp = self._ros.Time.from_sec(now)
        message.name = [prefix + NAMES[i] for i in order]
        message.position, message.effort = [q[i] for i in order], [effort[i] for i in order]
        message.velocity = [0.0] * len(NAMES)
        with contextlib.suppress(self._ros.ROSException):
            self._out.publish(message)

    # What it is told.

    def _counted(self, on: Any) -> Any:
        def handle(message: Any) -> None:
            on(message)
            self._switches.handled += 1

        return handle

    def _answering(self, on: Any, answer: Any) -> Any:
        def handle(request: Any) -> Any:
            while self._switches.hung:
                time.sleep(NAP)
            on(request)
            return None if self._switches.wordless else answer()

        return handle

    def _on_torque(self, message: Any) -> None:
        self._kinova.send_torque(six(message))

    def _on_velocity(self, message: Any) -> None:
        self._kinova.send_velocity(np.deg2rad(six(message)))

    def _on_goal(self, message: Any) -> None:
        self._kinova.erase()
        self._kinova.send_position(np.deg2rad(six(message.goal.angles)))

    def _on_mode(self, request: Any) -> None:
        if self._switches.holds:
            self._kinova.set_inactivity(Inactivity.HOLD_POSITION)
        self._kinova.switch(ControlMode.TORQUE if request.state else ControlMode.POSITION)

    def _on_home(self, request: Any) -> None:
        self._kinova.home()
        self._kinova.open_fingers()

    def _on_parameters(self, request: Any) -> None:
        get, kinova = self._ros.get_param, self._kinova
        base = f"{self._base}/torque_parameters"
        kinova.set_safety_factor(get(f"{base}/safety_factor", 1.0))
        payload = get(f"{self._base}/payload", None)
        if payload is not None:
            mass, *com = payload
            kinova.library.call("SetGravityPayload", (c_float * 4)(mass, *com))
        most = get(f"{base}/torque_max", None)
        if most is not None:
            kinova.set_torque_limits(np.array(most))
        identified = get(f"{base}/com_parameters", None)
        if identified is not None:
            kinova.library.call("SetGravityOptimalZParam", (c_float * 42)(*identified))


def six(message: Any) -> np.ndarray:
    """The numbers of six joints."""
    return np.array([getattr(message, f"joint{i}") for i in range(1, 7)])


def main() -> None:
    switches, memory = attach_switches(sys.argv[1]), attach(os.environ[VARIABLE])
    rospy().init_node(f"{ROBOT}_driver", argv=[])
    with Kinova(Library(Path(sys.argv[2]))) as kinova:
        Node(switches, kinova, memory).run()


if __name__ == "__main__":
    main()
