"""Torque zero and joint zero: only in the checked poses, and read back."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hardware.standin import StandIn

from burnish.core import State
from burnish.errors import HardwareError, InputError
from burnish.hardware.calibration import TORQUE_POSES
from burnish.hardware.jaco2 import Jaco2
from burnish.hardware.torque_mode import TorqueEntryError, TorqueSetup
from burnish.model.model import Model
from burnish.sim.robot import HOME

CANDLE = np.deg2rad([40.0, 180.0, 180.0, 0.0, 0.0, 180.0])


@pytest.mark.parametrize("pose", TORQUE_POSES)
def test_gravity_turns_no_joint_in_the_poses_for_torque_zero(pose: np.ndarray) -> None:
    q = np.nan_to_num(pose, nan=1.0)
    # 0.05 N·m is a sixth of what a sensor may drift.
    assert np.abs(Model.jaco2().at(State(t=0.0, q=q, dq=np.zeros(6))).g).max() < 0.055


def test_sensors_that_are_off_keep_the_arm_out_of_torque_mode_until_they_are_zeroed(
    standin: StandIn, jaco2: Callable[..., Jaco2]
) -> None:
    standin.reset(q=CANDLE, bias=5.0)
    with jaco2() as arm:
        with pytest.raises(TorqueEntryError, match="zero the torques in a candle pose"):
            arm.start_torque(TorqueSetup.thesis_a())
        arm.zero_torques()
        assert np.abs(np.array(standin.memory.torque)).max() < 0.2
        arm.start_torque(TorqueSetup.thesis_a())
        assert standin.memory.mode == 1


def test_torque_zero_is_refused_in_any_other_pose(standin: StandIn, jaco2: Callable[..., Jaco2]) -> None:
    with jaco2() as arm, pytest.raises(InputError, match=r"zero_torques at .*: no pose for it; go to"):
        arm.zero_torques()
    assert standin.calls("SetTorqueZero") == 0


def test_torque_zero_is_refused_with_a_load_that_turns_a_joint(standin: StandIn, jaco2: Callable[..., Jaco2]) -> None:
    standin.reset(q=CANDLE)
    loaded = Model.jaco2().with_payload(1.0, (0.1, 0.1, 0.0))
    with jaco2(model=loaded) as arm, pytest.raises(InputError, match=r"turns joint \d by .*take it off"):
        arm.zero_torques()
    assert standin.calls("SetTorqueZero") == 0


def test_torque_zero_that_does_nothing_is_noticed(standin: StandIn, jaco2: Callable[..., Jaco2]) -> None:
    standin.reset(q=CANDLE, bias=5.0)
    standin.fail("SetTorqueZero", 1)  # lost on its way
    with jaco2() as arm, pytest.raises(HardwareError, match=r"joint \d still reads"):
        arm.zero_torques()


def test_joint_zero_takes_out_what_a_hard_stop_has_shifted(standin: StandIn, jaco2: Callable[..., Jaco2]) -> None:
    standin.reset(q=CANDLE + np.deg2rad([0.0, 1.0, -2.0, 0.5, 3.0, -1.5]))
    with jaco2() as arm:
        before = standin.trace()[1][-1]
        arm.zero_joints()
        np.testing.assert_allclose(arm.read().q[1:], CANDLE[1:], atol=1e-4)
        # It is the count that changes: the arm does not move.
        np.testing.assert_allclose(standin.trace()[1][-1], before, atol=1e-4)
    assert standin.calls("SetJointZero") == 5


def test_joint_zero_is_refused_elsewhere_and_for_a_moving_arm(standin: StandIn, jaco2: Callable[..., Jaco2]) -> None:
    with jaco2() as arm:
        with pytest.raises(InputError, match=r"zero_joints at .*expected within 5°"):
            arm.zero_joints()
        for _ in range(60):
            arm._kinova.send_velocity([0.2, 0, 0, 0, 0, 0])
        with pytest.raises(InputError, match=r"while the arm moves at \d+\.\d°/s"):
            arm.zero_joints()
    assert standin.calls("SetJointZero") == 0


def test_a_firmware_that_counts_from_elsewhere_is_noticed(standin: StandIn, jaco2: Callable[..., Jaco2]) -> None:
    standin.reset(q=CANDLE, joint_zero_at=0.0)
    with jaco2() as arm, pytest.raises(HardwareError, match="its firmware counts from elsewhere"):
        arm.zero_joints()


def test_calibration_is_refused_in_torque_mode(standin: StandIn, jaco2: Callable[..., Jaco2]) -> None:
    standin.reset(q=HOME)
    with jaco2(torque=TorqueSetup.thesis_a()) as arm:
        for calibrate in (arm.zero_torques, arm.zero_joints):
            with pytest.raises(InputError, match="while the arm is in torque mode; stop_torque comes first"):
                calibrate()
