"""`Driver`: the topics and services of kinova-ros in SI units. Degrees end in this file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from burnish.core import Array
from burnish.errors import InputError
from burnish.hardware.ros1_installed import rospy
from burnish.hardware.ros1_node import NODE, DriverError, ask, start_node, types

JOINTS = 6
ANSWER = 2.0
"""Longest wait for the answer of a service [s]."""
SLOW_ANSWER = 30.0
"""The same of the one that sends the arm home and opens the hand."""
CONNECTED = 5.0
"""Longest wait until the driver listens to what is published [s]."""


@dataclass(frozen=True, kw_only=True)
class Reading:
    """One joint state, in the order of our joints."""

    stamp: float
    """When the driver sent it, on its own clock [s]."""
    q: Array
    """Joint angles as they are reported [rad], (6,)."""
    tau: Array
    """Joint torques as they are reported [N·m], (6,)."""


class Driver:
    """A running kinova-ros driver: joint angles [rad], speeds [rad/s], torques [N·m], (6,).

    What comes in is kept by ROS's threads, the newest only; `positions` and `torques` take it, once.
    """

    def __init__(self, robot: str) -> None:
        """Find the driver of the robot of this name, as in ``kinova_robotName`` of its launch file.

        Raises:
            InputError: if the name is none.
            RosMissingError: if there is no rospy.
            DriverError: if there is no master, no driver, or it speaks another language.
        """
        if not robot.replace("_", "").isalnum():
            raise InputError(f"robot name '{robot}'; expected that of kinova_robot.launch, such as j2n6s300")
        self._rospy = rospy()
        self._types = types()
        self._base = f"/{robot}_driver"
        self._names = [f"{robot}_joint_{i}" for i in range(1, JOINTS + 1)]
        self._newest: tuple[int, Any] = (0, None)
        self._taken = 0
        self._reading: Reading | None = None
        self._goals = 0
        start_node(self._rospy)
        self._torque = self._publisher("in/joint_torque", self._types.JointTorque)
        self._velocity = self._publisher("in/joint_velocity", self._types.JointVelocity)
        self._goal = self._publisher("joints_action/joint_angles/goal", self._types.JointAnglesGoal)
        self._states = self._rospy.Subscriber(
            f"{self._base}/out/joint_state", self._types.JointState, self._take, queue_size=1, tcp_nodelay=True
        )

    def close(self) -> None:
        """Speak and listen no more."""
        for end in (self._states, self._torque, self._velocity, self._goal):
            end.unregister()

    # What it measures.

    @property
    def arrived(self) -> int:
        """How many joint states have come."""
        return self._newest[0]

    @property
    def has_news(self) -> bool:
        """Whether a joint state has come since the last was taken."""
        return self._newest[0] != self._taken

    @property
    def stamp(self) -> float:
        """Time stamp of the newest joint state, on the driver's clock [s]; 0 before the first."""
        message = self._newest[1]
        return 0.0 if message is None else float(message.header.stamp.to_sec())

    def positions(self) -> Array:
        """Take the newest joint state: angles as they are reported [rad].

        Raises:
            DriverError: if there is none that has not been taken before, or it lacks a joint.
        """
        count, message = self._newest
        if count == self._taken:
            raise DriverError(
                "out/joint_state", f"no new joint state from {self._base}; look whether the driver runs, and its cable"
            )
        self._taken, self._reading = count, self._in_our_order(message)
        return self._reading.q

    def torques(self) -> Array:
        """Measured torques of the joint state that was taken last [N·m]."""
        assert self._reading is not None, "positions comes first"
        return self._reading.tau

    # What it is told.

    def send_torque(self, tau: Array) -> None:
        """Joint torques [N·m]; the base adds what holds the arm's weight."""
        self._publish(self._torque, self._types.JointTorque(*tau.tolist(), 0.0))

    def send_velocity(self, dq: Array) -> None:
        """A joint velocity for 10 ms [rad/s]."""
        self._publish(self._velocity, self._types.JointVelocity(*np.rad2deg(dq).tolist(), 0.0))

    def send_position(self, q: Array) -> None:
        """Go to angles as they are reported [rad]; takes the place of the goal before, at its next look."""
        message = self._types.JointAnglesGoal()
        self._goals += 1
        message.goal_id.id = f"{NODE}-{self._goals}"
        angles = message.goal.angles
        for name, angle in zip(angles.__slots__, np.rad2deg(q).tolist(), strict=False):
            setattr(angles, name, angle)
        self._publish(self._goal, message)

    def switch(self, torque: bool) -> None:
        """Ask for torque or position mode. What the driver answers says nothing about the arm: look at its motion.

        Raises:
            DriverError: if the driver cannot be asked.
        """
        # Published drivers end this call without an answer, right or wrong as it may have been.
        self._call("in/set_torque_control_mode", self._types.SetTorqueControlMode, int(torque), believed=False)

    def set_torque_parameters(self, parameters: dict[str, Any]) -> None:
        """Write parameters of the driver by their names, and let it pass them on to the arm."""
        for name, value in parameters.items():
            self._set(name, value)
        self._call("in/set_torque_control_parameters", self._types.SetTorqueControlParameters, believed=False)

    def parameter(self, name: str) -> Any:
        """A parameter of the driver as its launch file left it; None if there is none."""
        try:
            return self._rospy.get_param(f"{self._base}/{name}", None)
        except OSError as error:
            raise DriverError(name, f"the ROS master does not answer ({error}); look whether it runs") from error

    def report_whole_torques(self) -> None:
        """Let joint states hold the torques as they are measured, gravity included."""
        self._set("torque_parameters/publish_torque_with_gravity_compensation", False)

    def erase(self) -> None:
        """Empty the arm's queue; it stops."""
        self._call("in/clear_trajectories", self._types.ClearTrajectories, believed=False)

    def home(self) -> None:
        """Send the arm to the home pose that it holds, and open the hand."""
        self._call("in/home_arm", self._types.HomeArm)

    def zero_torques(self) -> None:
        """Take what the torque sensors read now for zero."""
        self._call("in/set_zero_torques", self._types.ZeroTorques)

    # What holds it together.

    def _publisher(self, topic: str, kind: Any) -> Any:
        # A queue of one: a command that could not be sent gives way to the next.
        return self._rospy.Publisher(f"{self._base}/{topic}", kind, queue_size=1, tcp_nodelay=True)

    def _publish(self, publisher: Any, message: Any) -> None:
        if publisher.get_num_connections() == 0:
            raise DriverError(publisher.name, f"nobody listens to {publisher.name}; look whether the driver runs")
        publisher.publish(message)

    @property
    def is_heard(self) -> bool:
        """Whether the driver has connected to all that is published."""
        return all(end.get_num_connections() > 0 for end in (self._torque, self._velocity, self._goal))

    def _take(self, message: Any) -> None:
        """Called by a thread of ROS; one assignment, so that nobody sees half of it."""
        self._newest = self._newest[0] + 1, message

    def _in_our_order(self, message: Any) -> Reading:
        """A joint state by the names of its joints, whatever their order."""
        places = {name: place for place, name in enumerate(message.name)}
        try:
            order = [places[name] for name in self._names]
            q, tau = ([values[place] for place in order] for values in (message.position, message.effort))
        except (KeyError, IndexError):
            raise DriverError(
                "out/joint_state",
                f"joint states of {', '.join(message.name) or 'nothing'}; expected angles and torques of "
                f"{self._names[0]} to {self._names[-1]}: give the robot's name",
            ) from None
        return Reading(stamp=message.header.stamp.to_sec(), q=np.array(q), tau=np.array(tau))

    def _set(self, name: str, value: Any) -> None:
        try:
            self._rospy.set_param(f"{self._base}/{name}", value)
        except OSError as error:
            raise DriverError(name, f"the ROS master does not answer ({error}); look whether it runs") from error

    def _call(self, name: str, kind: Any, *request: Any, believed: bool = True) -> None:
        patience = SLOW_ANSWER if kind is self._types.HomeArm else ANSWER
        ask(self._rospy, f"{self._base}/{name}", kind, *request, patience=patience, believed=believed)
