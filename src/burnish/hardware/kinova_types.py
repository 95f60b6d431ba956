"""The structs and numbers of Kinova's command layer, in both layouts that were shipped.

Natural alignment, enumerations as 32-bit integers, references as pointers. The layout for seven actuators is that of
the SDK 6.0.1 and of kinova-ros, the one for six that of older SDKs; the sizes of the former were read off the vendor's
own libraries, those of the latter off its headers. Both report the same version, so a symbol tells them apart.
"""

from __future__ import annotations

from ctypes import Structure, c_char, c_float, c_int32, c_uint32, c_ulong, c_ushort
from dataclasses import dataclass
from enum import IntEnum

SUCCESS = 1
"""What a call returns when it worked. Zero is not a success."""
MOST_DEVICES = 20
TORQUE_BUFFER = 70
"""Floats in every buffer of torques or of gains; a shorter one is read beyond its end."""
GRAVITY_PARAMETERS = 42
"""Floats in a buffer of gravity parameters, whatever their number."""
CODE_VERSIONS = 42
FINGER_CLOSED = 6800.0
"""Finger position when closed [finger units]; open is 0."""
FINGER_CLOSED_DEG = 80.0
"""The same as an angle of the finger's joint [deg] (driver of kinova-ros)."""
JOINT_ADDRESSES = (16, 17, 18, 19, 20, 21)
SEVEN_ACTUATOR_SYMBOL = "RunGravityZEstimationSequence7DOF"
"""Exported by libraries with the layout for seven actuators only."""
ETHERNET_PREFIX = "Ethernet_"


class PositionType(IntEnum):
    """What a trajectory point is."""

    ANGULAR_POSITION = 2
    ANGULAR_VELOCITY = 8


class HandMode(IntEnum):
    """What a trajectory point tells the fingers."""

    NO_MOVEMENT = 0
    POSITION = 1


class ControlMode(IntEnum):
    """What the arm's base follows."""

    POSITION = 0
    TORQUE = 1


class TorqueControl(IntEnum):
    """What a torque command means; only the direct one is used here."""

    DIRECT = 0


class GravityType(IntEnum):
    """Where the base takes its gravity parameters from."""

    MANUAL = 0
    OPTIMAL = 1


class Inactivity(IntEnum):
    """What the base does in torque mode after 250 ms without a command."""

    HOLD_POSITION = 0
    ZERO_TORQUE = 1
    """The vendor's default for the JACO2. The arm then floats, or falls if its gravity compensation is off."""


class CartesianInfo(Structure):
    """A tool pose [m, rad] or twist."""

    _fields_ = [(name, c_float) for name in ("X", "Y", "Z", "ThetaX", "ThetaY", "ThetaZ")]


class FingersPosition(Structure):
    """Finger positions [finger units]."""

    _fields_ = [(f"Finger{i}", c_float) for i in (1, 2, 3)]


class Limitation(Structure):
    """Limits of a trajectory point; unused, and left at zero."""

    _fields_ = [(f"{kind}Parameter{i}", c_float) for kind in ("speed", "force", "acceleration") for i in (1, 2, 3)]


class KinovaDevice(Structure):
    """A connected arm."""

    _fields_ = [
        ("SerialNumber", c_char * 20),
        ("Model", c_char * 20),
        ("VersionMajor", c_int32),
        ("VersionMinor", c_int32),
        ("VersionRelease", c_int32),
        ("DeviceType", c_int32),
        ("DeviceID", c_int32),
    ]


class TrajectoryFifo(Structure):
    """How full the queue of trajectory points is."""

    _fields_ = [("TrajectoryCount", c_uint32), ("UsedPercentage", c_float), ("MaxSize", c_uint32)]


class EthernetCommConfig(Structure):
    """Addresses of an arm on the network; IP addresses as inet_addr gives them."""

    _fields_ = [
        ("localIpAddress", c_ulong),
        ("subnetMask", c_ulong),
        ("robotIpAddress", c_ulong),
        ("localCmdport", c_ushort),
        ("localBcastPort", c_ushort),
        ("robotPort", c_ushort),
        ("rxTimeOutInMs", c_ulong),
    ]


@dataclass(frozen=True, kw_only=True)
class Layout:
    """The structs that depend on how many actuators a library was built for."""

    actuators: int
    AngularInfo: type[Structure]
    """One float an actuator: degrees, degrees per second or N·m."""
    AngularPosition: type[Structure]
    """Actuators and fingers."""
    UserPosition: type[Structure]
    """Where a trajectory point leads."""
    TrajectoryPoint: type[Structure]
    """One entry of the arm's queue."""

    @classmethod
    def of(cls, actuators: int) -> Layout:
        """The layout for six or for seven actuators."""

        def struct(name: str, *fields: tuple[str, type]) -> type[Structure]:
            return type(name, (Structure,), {"_fields_": list(fields)})

        angular_info = struct("AngularInfo", *((f"Actuator{i}", c_float) for i in range(1, actuators + 1)))
        user_position = struct(
            "UserPosition",
            ("Type", c_int32),
            ("Delay", c_float),
            ("CartesianPosition", CartesianInfo),
            ("Actuators", angular_info),
            ("HandMode", c_int32),
            ("Fingers", FingersPosition),
        )
        return cls(
            actuators=actuators,
            AngularInfo=angular_info,
            AngularPosition=struct("AngularPosition", ("Actuators", angular_info), ("Fingers", FingersPosition)),
            UserPosition=user_position,
            TrajectoryPoint=struct(
                "TrajectoryPoint",
                ("Position", user_position),
                ("LimitationsActive", c_int32),
                ("SynchroType", c_int32),
                ("Limitations", Limitation),
            ),
        )
