"""`Kinova`: the vendor's calls in SI units. Degrees and finger units end in this file."""

from __future__ import annotations

import ctypes
from ctypes import c_float, c_int
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Self

from burnish.core import Array
from burnish.errors import HardwareError
from burnish.hardware.kinova_library import Library
from burnish.hardware.kinova_types import (
    CODE_VERSIONS,
    FINGER_CLOSED,
    FINGER_CLOSED_DEG,
    GRAVITY_PARAMETERS,
    JOINT_ADDRESSES,
    TORQUE_BUFFER,
    ControlMode,
    GravityType,
    HandMode,
    Inactivity,
    PositionType,
    TorqueControl,
    TrajectoryFifo,
)
from burnish.hardware.network import Network

JOINTS = 6
UNITS_PER_RADIAN = FINGER_CLOSED / np.deg2rad(FINGER_CLOSED_DEG)


@dataclass(frozen=True, kw_only=True)
class Device:
    """A connected arm."""

    serial: str
    """Serial number."""
    model: str
    """What the arm calls itself."""
    firmware: tuple[int, int, int]
    """Version of its firmware."""


class Kinova:
    """An open command layer: joint angles [rad], speeds [rad/s], torques [N·m], (6,); fingers [rad], (3,).

    Every method raises `VendorError` if the vendor's call does not return 1. The methods of the control cycle use
    buffers made once.
    """

    def __init__(self, library: Library, network: Network | None = None) -> None:
        """Start the library; the network's addresses are for the Ethernet layer only."""
        self.library = library
        self._call = library.call
        layout = library.layout
        self._angles = layout.AngularPosition()
        self._angles_reference = ctypes.byref(self._angles)
        floats = _view(self._angles)
        self._joints, self._finger_units = floats[:JOINTS], floats[layout.actuators :]
        self._point = layout.TrajectoryPoint()
        self._buffer = (c_float * TORQUE_BUFFER)()
        self._torque = _view(self._buffer)[:JOINTS]
        self._estimate_buffer = (c_float * TORQUE_BUFFER)()
        self._estimate = _view(self._estimate_buffer)[:JOINTS]
        self._mode = c_int()
        self._mode_reference = ctypes.byref(self._mode)
        if library.ethernet:
            self._call("InitEthernetAPI", ctypes.byref((network or Network()).configuration()))
        else:
            self._call("InitAPI")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the library; a program that leaves it open keeps the next one from the arm."""
        self._call("CloseAPI")

    # The device.

    def devices(self) -> list[Device]:
        """All connected arms."""
        return [
            Device(
                serial=_text(entry.SerialNumber),
                model=_text(entry.Model),
                firmware=(entry.VersionMajor, entry.VersionMinor, entry.VersionRelease),
            )
            for entry in self.library.devices()
        ]

    def choose(self, serial: str) -> None:
        """Talk to the arm with this serial number from now on.

        Raises:
            HardwareError: if there is none.
        """
        entries = {_text(entry.SerialNumber): entry for entry in self.library.devices()}
        if serial not in entries:
            raise HardwareError(
                f"no arm has the serial number {serial}; connected: {', '.join(entries) or 'none'}. Give the right "
                "one, or see 'burnish doctor'"
            )
        self._call("SetActiveDevice", entries[serial])

    def start(self) -> None:
        """Take control from the joystick, in joint space."""
        self._call("StartControlAPI")
        self._call("SetAngularControl")

    def versions(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Of the library (5.2.0 in both layouts), and the firmware codes of base and actuators."""
        library, codes = (c_int * 3)(), (c_int * CODE_VERSIONS)()
        self._call("GetAPIVersion", library)
        self._call("GetCodeVersion", codes)
        return tuple(library), tuple(codes)

    # What it measures.

    def positions(self) -> Array:
        """Joint angles as they are reported, multi-turn or wrapped [rad]."""
        self._call("GetAngularPosition", self._angles_reference)
        return np.deg2rad(self._joints, dtype=np.float64)

    def fingers(self) -> Array:
        """Angles of the finger joints, 0 when open [rad], (3,)."""
        self._call("GetAngularPosition", self._angles_reference)
        return np.asarray(self._finger_units / UNITS_PER_RADIAN, dtype=np.float64)

    def torques(self) -> Array:
        """Measured joint torques, gravity included [N·m]."""
        self._call("GetAngularForce", self._angles_reference)
        return self._joints.astype(np.float64)

    def gravity_estimate(self) -> Array:
        """The torque by which the base holds the arm's weight, as it adds it in torque mode [N·m]."""
        self._call("GetAngularTorqueGravityEstimation", self._estimate_buffer)
        return self._estimate.astype(np.float64)

    def mode(self) -> ControlMode:
        """The mode that the arm is in, read back."""
        self._call("GetTrajectoryTorqueMode", self._mode_reference)
        return ControlMode.TORQUE if self._mode.value == ControlMode.TORQUE else ControlMode.POSITION

    def queued(self) -> int:
        """Trajectory points that wait in the arm; it takes one velocity every 10 ms."""
        fifo = TrajectoryFifo()
        self._call("GetGlobalTrajectoryInfo", ctypes.byref(fifo))
        return int(fifo.TrajectoryCount)

    # What it is told.

    def switch(self, mode: ControlMode) -> None:
        """Ask for a mode. The arm may refuse and say nothing: read `mode` back."""
        self._call("SwitchTrajectoryTorque", int(mode))

    def send_torque(self, tau: Array) -> None:
        """Joint torques [N·m]; what the base adds for gravity comes on top."""
        self._torque[:] = tau
        self._call("SendAngularTorqueCommand", self._buffer)

    def send_position(self, q: ArrayLike) -> None:
        """Append a joint position, as angles are reported [rad], to the arm's queue."""
        self._send(PositionType.ANGULAR_POSITION, np.rad2deg(q), HandMode.NO_MOVEMENT, np.zeros(3))

    def send_velocity(self, dq: ArrayLike) -> None:
        """Append a joint velocity of 10 ms [rad/s] to the arm's queue."""
        self._send(PositionType.ANGULAR_VELOCITY, np.rad2deg(dq), HandMode.NO_MOVEMENT, np.zeros(3))

    def send_fingers(self, angles: ArrayLike) -> None:
        """Move the finger joints to these angles [rad], (3,), with the arm where it is commanded to be."""
        self._call("GetAngularCommand", self._angles_reference)
        hold = self._joints.astype(np.float64)
        self._send(PositionType.ANGULAR_POSITION, hold, HandMode.POSITION, UNITS_PER_RADIAN * np.asarray(angles))

    def erase(self) -> None:
        """Empty the arm's queue; it stops."""
        self._call("EraseAllTrajectories")

    def home(self) -> None:
        """Send the arm to the home pose that it holds."""
        self._call("MoveHome")

    def open_fingers(self) -> None:
        """Find the fingers' zero and open the hand."""
        self._call("InitFingers")

    # How it is set up. The base forgets all of this when it is switched off.

    def set_direct_torque(self) -> None:
        """Torque commands shall be torques, not set points of the base's impedance."""
        self._call("SetTorqueControlType", int(TorqueControl.DIRECT))

    def set_actuators(self, gain: float, damping: float) -> None:
        """Feedback gain and damping of the actuators' own torque loops, one number for all."""
        for name, value in (("SetTorqueActuatorGain", gain), ("SetTorqueActuatorDamping", damping)):
            self._call(name, _buffer(np.full(JOINTS, value), TORQUE_BUFFER))

    def set_safety_factor(self, factor: float) -> None:
        """Speed, as a share of the largest, at which the base falls back to position mode; 1 is never."""
        self._call("SetTorqueSafetyFactor", factor)

    def set_vibration_controller(self, share: float) -> None:
        """Strength of the base's vibration observer, 0 to 1."""
        self._call("SetTorqueVibrationController", share)

    def set_inactivity(self, kind: Inactivity) -> None:
        """What happens in torque mode after 250 ms without a command."""
        self._call("SetTorqueInactivityType", int(kind))

    def set_torque_limits(self, tau: ArrayLike) -> None:
        """Largest joint torques that the base lets through [N·m]."""
        info, count = self.library.layout.AngularInfo, self.library.layout.actuators
        most = np.zeros(count)
        most[:JOINTS] = tau
        self._call("SetAngularTorqueMinMax", info(*(-most).tolist()), info(*most.tolist()))

    def set_gravity(self, optimal_z: ArrayLike, payload: float, com: ArrayLike) -> None:
        """The base's gravity compensation: 16 identified numbers (zeros: none), a payload [kg, m]; in position mode."""
        self._call("SetGravityPayload", (c_float * 4)(payload, *np.asarray(com).tolist()))
        self._call("SetGravityOptimalZParam", _buffer(optimal_z, GRAVITY_PARAMETERS))
        self._call("SetGravityType", int(GravityType.OPTIMAL))

    def zero_torque(self, joint: int) -> None:
        """Take what the sensor of a joint (0 to 5) reads now for zero."""
        self._call("SetTorqueZero", JOINT_ADDRESSES[joint])

    def zero_position(self, joint: int) -> None:
        """Take the angle of a joint (0 to 5) for its calibration angle."""
        self._call("SetJointZero", JOINT_ADDRESSES[joint])

    def _send(self, kind: PositionType, joints_deg: Array, hand: HandMode, finger_units: Array) -> None:
        """Append one point to the arm's queue."""
        place = self._point.Position
        place.Type, place.HandMode = int(kind), int(hand)
        place.Actuators = self.library.layout.AngularInfo(*joints_deg.tolist())
        place.Fingers.Finger1, place.Fingers.Finger2, place.Fingers.Finger3 = finger_units.tolist()
        self._call("SendBasicTrajectory", self._point)


def _view(floats: ctypes.Structure | ctypes.Array[c_float]) -> NDArray[np.float32]:
    """The memory of a struct or a buffer of floats as one vector."""
    view: NDArray[np.float32] = np.frombuffer(memoryview(floats).cast("B"), np.float32)
    return view


def _text(characters: bytes) -> str:
    """A name from the device list; ctypes has cut it at its first zero, if it has one."""
    return characters.decode("ascii", "replace").strip()


def _buffer(values: ArrayLike, length: int) -> ctypes.Array[c_float]:
    """The values, and zeros up to the length that the vendor reads."""
    numbers = np.asarray(values, np.float64).tolist()
    return (c_float * length)(*numbers)
