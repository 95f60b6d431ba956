"""Zero of the torque sensors and of the joint angles, each in a pose that was checked before."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from burnish.core import Array, State
from burnish.errors import HardwareError, InputError
from burnish.hardware.kinova import JOINTS, Kinova
from burnish.model.model import Model

FREE = np.nan
"""A joint that may stand anywhere."""
CALIBRATION_POSE = np.deg2rad([FREE, 180.0, 180.0, 0.0, 0.0, 180.0])
"""The straight candle (thesis A, section 5.1): no joint carries weight, and the angles are those of the calibration."""
TORQUE_POSES = (
    CALIBRATION_POSE,
    np.deg2rad([FREE, 180.0, 180.0, 180.0, 180.0, 180.0]),
    np.deg2rad([FREE, 180.0, 180.0, 180.0, 0.0, 90.0]),
)
"""Poses in which gravity turns no joint: of thesis A; of thesis B, eq. 5.5, and kinova-ros; of the vendor's maintenance
guide. Joint 1 has a vertical axis and may stand anywhere."""
NEAR_FOR_TORQUE = np.deg2rad(1.0)
"""1° off, the weight of the arm turns joint 2 by 0.3 N·m."""
NEAR_FOR_JOINTS = np.deg2rad(5.0)
WEIGHT = 0.4
"""Most that the model's gravity may turn a joint while sensors are zeroed [N·m]: their own precision."""
REST = np.deg2rad(1.0)
READ_AS_ZERO = 0.3
"""What a zeroed sensor may read beside the model [N·m]."""
READ_AS_POSE = np.deg2rad(0.5)
AVERAGED = 20


def zero_torques(zero: Callable[[], None], model: Model, measure: Callable[[], State]) -> None:
    """Zero all torque sensors by ``zero``, and look whether they read zero.

    Raises:
        InputError: if the arm moves, or gravity turns a joint in this pose.
        HardwareError: if a sensor does not read zero afterwards.
    """
    state = _at_rest(measure)
    if not any(_off(state.q, pose) <= NEAR_FOR_TORQUE for pose in TORQUE_POSES):
        raise InputError(
            f"zero_torques at {np.rad2deg(state.q).round(1)}°: no pose for it; go to {np.rad2deg(CALIBRATION_POSE)}° "
            "(nan: any)"
        )
    g = model.at(state).g
    if np.any(np.abs(g) > WEIGHT):
        joint = int(np.argmax(np.abs(g)))
        raise InputError(
            f"zero_torques: what the hand carries turns joint {joint + 1} by {g[joint]:.2f} N·m in this pose, "
            f"{WEIGHT} at most; take it off"
        )
    zero()
    off = np.abs(np.mean([_torque(measure()) for _ in range(AVERAGED)][AVERAGED // 4 :], axis=0) - g)
    if np.any(off > READ_AS_ZERO + np.abs(g)):
        joint = int(np.argmax(off))
        raise HardwareError(
            f"zero_torques: joint {joint + 1} still reads {off[joint]:.2f} N·m; restart the arm and repeat, or have it "
            "serviced"
        )


def zero_joints(kinova: Kinova, measure: Callable[[], State], begin: Callable[[], None]) -> None:
    """Zero the angles of joints 2 to 6, and look whether they read the calibration pose.

    ``begin`` forgets the old angles. Which angle the firmware gives a zeroed joint is not documented: the look
    afterwards decides.

    Raises:
        InputError: if the arm moves, or is not within 5° of the calibration pose.
        HardwareError: if a joint does not read its angle of that pose afterwards.
    """
    state = _at_rest(measure)
    if _off(state.q, CALIBRATION_POSE) > NEAR_FOR_JOINTS:
        raise InputError(
            f"zero_joints at {np.rad2deg(state.q).round(1)}°: expected within {np.rad2deg(NEAR_FOR_JOINTS):.0f}° of "
            f"{np.rad2deg(CALIBRATION_POSE)}° (nan: any)"
        )
    for joint in range(1, JOINTS):
        kinova.zero_position(joint)
    # The angles jump now, and they may.
    for _ in range(5):
        begin()
        try:
            measure()
        except HardwareError:
            continue
    begin()
    state = measure()
    if _off(state.q, CALIBRATION_POSE) > READ_AS_POSE:
        raise HardwareError(
            f"zero_joints: the arm now reads {np.rad2deg(state.q).round(1)}° where {np.rad2deg(CALIBRATION_POSE)}° was "
            "expected: its firmware counts from elsewhere. Do not move it; restart it, and calibrate with the vendor's "
            "tool"
        )


def _at_rest(measure: Callable[[], State]) -> State:
    """The state, if the arm stands still for a fifth of a second."""
    states = [measure() for _ in range(AVERAGED)]
    fastest = max(float(np.abs(state.dq).max()) for state in states)
    if fastest > REST:
        raise InputError(f"calibration while the arm moves at {np.rad2deg(fastest):.1f}°/s; wait until it is at rest")
    return states[-1]


def _off(q: Array, pose: Array) -> float:
    """Largest distance from a pose, whole turns apart [rad]; free joints do not count."""
    return float(np.nanmax(np.abs((q - pose + np.pi) % (2.0 * np.pi) - np.pi)))


def _torque(state: State) -> Array:
    """The measured torques [N·m], (6,)."""
    assert state.tau is not None
    return state.tau
