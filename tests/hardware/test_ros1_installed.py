"""Where rospy is found, and what it is given to speak: checksums that kinova-ros's own builds have."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from hardware import ros_graph

from burnish.commands import doctor
from burnish.hardware import ros1_installed
from burnish.hardware.ros1_installed import RosMissingError, find
from burnish.hardware.ros1_node import types

PYTHON = f"python{sys.version_info.major}.{sys.version_info.minor}"
SHOW = """
import sys
before = list(sys.path)
from burnish.hardware.ros1_installed import PACKAGES, rospy
rospy()
import numpy
print(sys.path[: len(before)] == before, numpy.__file__.startswith(str(PACKAGES)))
"""
CHECKSUMS = {
    "JointState": "3066dcd76a6cfaef579bd0f34173e9fd",
    "JointTorque": "bf16c4e5154848a0767d1aaab0a4796b",
    "JointVelocity": "bf16c4e5154848a0767d1aaab0a4796b",
    "GoalID": "302881f31927c1df708a2dbab0e80ee8",
    "SetTorqueControlMode": "891b541ef99af7889d0f22a062410be8",
    "SetTorqueControlParameters": "c22f2a1ed8654a0b365f1bb3f7ff2c0f",
    "ZeroTorques": "c22f2a1ed8654a0b365f1bb3f7ff2c0f",
    "ClearTrajectories": "c22f2a1ed8654a0b365f1bb3f7ff2c0f",
    "HomeArm": "46e470f2c1a7177398c57a43eafe8d67",
}
"""As in the code that ROS generates for the public packages of these names."""


def test_the_distributions_rospy_is_found(tmp_path: Path) -> None:
    (tmp_path / "packages" / "rospy").mkdir(parents=True)
    (tmp_path / "lib" / PYTHON).mkdir(parents=True)
    assert find(tmp_path / "packages", tmp_path / "lib") == tmp_path / "packages"


def test_without_rospy_the_line_of_apt_is_said(tmp_path: Path) -> None:
    with pytest.raises(RosMissingError, match="rospy is not installed; as root: apt install python3-rospy"):
        find(tmp_path, tmp_path)


def test_a_rospy_for_another_python_is_refused(tmp_path: Path) -> None:
    (tmp_path / "packages" / "rospy").mkdir(parents=True)
    (tmp_path / "lib" / "python3.1").mkdir(parents=True)
    with pytest.raises(RosMissingError, match=f"is not for {PYTHON}, which runs now"):
        find(tmp_path / "packages", tmp_path / "lib")


def test_nothing_of_the_environment_is_taken_from_the_distribution(ros_master: str) -> None:
    done = subprocess.run([sys.executable, "-c", SHOW], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["True", "False"]


def test_messages_and_services_have_the_checksums_of_the_public_packages(ros_master: str) -> None:
    assert {name: getattr(types(), name)._md5sum for name in CHECKSUMS} == CHECKSUMS


def test_doctor_names_the_line_of_apt_where_ros_is_absent(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(doctor, "installed", lambda: find(tmp_path))
    (finding,) = doctor.ros()
    assert finding.verdict == doctor.NOTE
    assert finding.what == "rospy is not installed, and only kinova-ros needs it"
    assert finding.remedy.startswith("as root: apt install python3-rospy")


def test_doctor_says_where_rospy_is(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(doctor, "installed", lambda: tmp_path)
    (finding,) = doctor.ros()
    assert finding == (doctor.GOOD, f"rospy in {tmp_path}, for an arm behind kinova-ros", "")


@pytest.mark.parametrize(("ci", "outcome"), [("true", pytest.fail.Exception), ("", pytest.skip.Exception)])
def test_without_ros_tests_are_skipped_but_not_in_ci(
    monkeypatch: pytest.MonkeyPatch, ci: str, outcome: type[BaseException]
) -> None:
    monkeypatch.setenv("CI", ci)
    with pytest.raises(outcome, match="apt install"):
        ros_graph.missing(ros1_installed.HOW_TO_GET_IT)
