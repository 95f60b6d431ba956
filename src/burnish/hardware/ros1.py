"""`RosJaco2`: the real arm through a running kinova-ros driver (ROS 1), behind the `Robot` protocol."""

from __future__ import annotations

import numpy as np

from burnish.core import Array
from burnish.errors import HardwareError
from burnish.hardware import calibration
from burnish.hardware.arm import Arm
from burnish.hardware.clock import Clock
from burnish.hardware.ros1_driver import Driver
from burnish.hardware.ros1_link import RosLink
from burnish.hardware.ros1_torque import Following, RosTorqueEntry, RosTorqueSetup, send, to_position_mode
from burnish.hardware.torque_mode import ModeError
from burnish.model.model import Model


class RosJaco2(Arm):
    """A Kinova JACO2 at the rate at which its kinova-ros driver sends joint states.

    With a `RosTorqueSetup` the arm is taken into torque mode on entry, in the pose in which it stands, and takes
    `Torque`; without one it is in position mode and takes `JointPosition` and `JointVelocity`. However the block ends,
    the arm is left in position mode. Which master: ROS_MASTER_URI, as for every node.
    """

    _patience = 8.0

    def __init__(
        self,
        model: Model,
        *,
        robot: str = "j2n6s300",
        torque: RosTorqueSetup | None = None,
        clock: Clock | None = None,
    ) -> None:
        """An arm that is connected by ``with``, which raises `RosMissingError` where there is no ROS.

        Args:
            model: the arm with all that it carries; its weight is compared with the measured torques.
            robot: ``kinova_robotName`` of the driver's launch file; one driver has one arm.
            torque: how to set it up for torque commands; without it the arm stays in position mode.
            clock: for tests; the system's monotonic clock without it.

        Raises:
            InputError: if the model is not one of six joints.
        """
        super().__init__(model, clock)
        self._robot, self._setup = robot, torque
        self._following: Following | None = None
        self._sent = np.zeros(model.n)

    @property
    def in_torque_mode(self) -> bool:
        """Whether the arm takes torques."""
        return self._following is not None

    def start_torque(self, setup: RosTorqueSetup) -> None:
        """Go into torque mode, with all checks; it takes three seconds, in which nobody may touch the arm.

        The last joint turns by some tenths of a degree: nothing else shows over ROS that the arm takes torques.

        Raises:
            TorqueEntryError: if it is refused; the arm is in position mode and the text says why.
        """
        self.stop_torque()
        RosTorqueEntry(driver=self._driver, link=self._link, model=self._model, setup=setup).enter()
        self._following, self._sent = Following(), self._model.at(self._link.state).g

    def stop_torque(self) -> None:
        """Go into position mode, and see the arm stand.

        Raises:
            ModeError: if it does not.
        """
        self._following = None
        to_position_mode(self._driver, self._link)

    # In position mode.

    def home(self) -> None:
        """Go to the home pose that the arm holds, wait until it stands there; kinova-ros opens the hand as well."""
        self._need_position_mode("home")
        self._driver.home()
        self._until(lambda state: True, "it did not come home", patience=30.0)

    def zero_torques(self) -> None:
        """Take the torques that the sensors read now for zero: only in a pose in which gravity turns no joint.

        Raises:
            InputError: in any other pose, or if the arm moves.
            HardwareError: if the sensors do not read zero afterwards.
        """
        self._need_position_mode("zero_torques")
        calibration.zero_torques(self._driver.zero_torques, self._model, self._link.measure)

    # What the cycle is made of.

    _link: RosLink

    def _open(self) -> None:
        self._driver = Driver(self._robot)
        self._link = RosLink(self._driver, self._model, self._clock)
        try:
            self._link.connect()
        except BaseException:
            self._driver.close()
            raise

    def _start(self) -> None:
        self._driver.report_whole_torques()
        # A program that was killed may have left it in torque mode.
        self.stop_torque()
        if self._setup is not None:
            self.start_torque(self._setup)

    def _close(self) -> None:
        self._driver.close()

    def _send_torque(self, tau: Array) -> None:
        send(self._driver, self._model, self._link.state, tau)
        self._sent = tau

    def _send_position(self, q: Array) -> None:
        self._driver.send_position(q)

    def _send_velocity(self, dq: Array) -> None:
        self._driver.send_velocity(dq)

    def _erase(self) -> None:
        self._driver.erase()

    def _check_mode(self) -> None:
        """Whether joints still move when they have to."""
        if self._following is None or self._following.still(self._sent, self._driver.torques(), self._link.state.dq):
            return
        end = "it stands in position mode"
        try:
            self.stop_torque()
        except HardwareError as error:
            end = str(error)
        raise ModeError(
            f"the arm does not follow its torques: it went to position mode by itself, or something holds it; {end}. "
            "Find the cause, then start_torque"
        )
