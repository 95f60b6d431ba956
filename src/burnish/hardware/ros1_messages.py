"""The messages and services of kinova-ros, built while we run: nobody has to build its packages to talk to its driver.

ROS lets two nodes talk only if the checksums of their definitions agree, so the fields below are kinova-ros's, name by
name. Angles are in degrees here; they end in `burnish.hardware.ros1_driver`.
"""

from __future__ import annotations

import os
import sys
from importlib import import_module
from typing import Any, NamedTuple

SEVEN_JOINTS = "\n".join(f"float32 joint{i}" for i in range(1, 8))
"""Also for an arm of six; the seventh is 0."""
MESSAGES = {
    "kinova_msgs/ArmJointAnglesActionGoal": (
        "std_msgs/Header header\nactionlib_msgs/GoalID goal_id\nkinova_msgs/ArmJointAnglesGoal goal"
    ),
    "kinova_msgs/ArmJointAnglesGoal": "kinova_msgs/JointAngles angles",
    "kinova_msgs/JointAngles": SEVEN_JOINTS,
    "kinova_msgs/JointVelocity": SEVEN_JOINTS,
    "kinova_msgs/JointTorque": SEVEN_JOINTS,
    "sensor_msgs/JointState": (
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort"
    ),
    "actionlib_msgs/GoalID": "time stamp\nstring id",
    "std_msgs/Header": "uint32 seq\ntime stamp\nstring frame_id",
}
"""Definitions by type."""
SERVICES = {
    "kinova_msgs/SetTorqueControlMode": ("uint16 state", ""),
    "kinova_msgs/SetTorqueControlParameters": ("", "string result"),
    "kinova_msgs/ZeroTorques": ("", "string result"),
    "kinova_msgs/ClearTrajectories": ("", "string result"),
    "kinova_msgs/HomeArm": ("", "string homearm_result"),
}
"""Request and answer by type."""
BETWEEN = "\n" + "=" * 80 + "\n"


class Types(NamedTuple):
    """Classes for rospy."""

    JointState: Any
    JointTorque: Any
    JointVelocity: Any
    JointAnglesGoal: Any
    GoalID: Any
    SetTorqueControlMode: Any
    SetTorqueControlParameters: Any
    ZeroTorques: Any
    ClearTrajectories: Any
    HomeArm: Any


def build() -> Types:
    """Build all classes; rospy has been imported before."""
    requests = {f"{name}Request": request for name, (request, _) in SERVICES.items()}
    answers = {f"{name}Response": answer for name, (_, answer) in SERVICES.items()}
    classes = _generate(MESSAGES | requests | answers)
    services = {name: _service(name, classes) for name in SERVICES}
    return Types(
        JointState=classes["sensor_msgs/JointState"],
        JointTorque=classes["kinova_msgs/JointTorque"],
        JointVelocity=classes["kinova_msgs/JointVelocity"],
        JointAnglesGoal=classes["kinova_msgs/ArmJointAnglesActionGoal"],
        GoalID=classes["actionlib_msgs/GoalID"],
        SetTorqueControlMode=services["kinova_msgs/SetTorqueControlMode"],
        SetTorqueControlParameters=services["kinova_msgs/SetTorqueControlParameters"],
        ZeroTorques=services["kinova_msgs/ZeroTorques"],
        ClearTrajectories=services["kinova_msgs/ClearTrajectories"],
        HomeArm=services["kinova_msgs/HomeArm"],
    )


def _generate(definitions: dict[str, str]) -> dict[str, Any]:
    """Message classes by type; the first definition may use all others."""
    first, *others = definitions
    text = BETWEEN.join([definitions[first] + "\n", *(f"MSG: {name}\n{definitions[name]}\n" for name in others)])
    before = list(sys.path)
    classes: dict[str, Any] = import_module("genpy.dynamic").generate_dynamic(first, text)
    # The generated file has been imported; its temporary folder need not stay on the search path.
    sys.path[:] = before
    return classes


def _service(name: str, classes: dict[str, Any]) -> Any:
    """A class as rospy expects one for a service."""
    loader, tools = import_module("genmsg.msg_loader"), import_module("genmsg.gentools")
    context = loader.MsgContext.create_default()
    specification = loader.load_srv_from_string(context, "\n---\n".join(SERVICES[name]), name)
    return type(
        os.path.basename(name),
        (),
        {
            "_type": name,
            "_md5sum": tools.compute_md5(context, specification),
            "_request_class": classes[f"{name}Request"],
            "_response_class": classes[f"{name}Response"],
        },
    )
