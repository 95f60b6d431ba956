import numpy as np

from burnish.gui import arm
from burnish.hardware.calibration import CALIBRATION_POSE
from burnish.polish.cell import HOME
from burnish.runtime.limits import Limits

SAID = """ok       Python 3.11.2, burnish 0.1.0
missing  Kinova's library is not in /usr/lib
         → install Kinova's JACO2 SDK
note     no SpaceMouse and no spacenavd
         → plug one in

next: install Kinova's JACO2 SDK
"""


def test_the_doctors_lines_become_findings_with_their_remedies() -> None:
    assert list(arm.findings(SAID)) == [
        ("ok", "Python 3.11.2, burnish 0.1.0", ""),
        ("missing", "Kinova's library is not in /usr/lib", "install Kinova's JACO2 SDK"),
        ("note", "no SpaceMouse and no spacenavd", "plug one in"),
    ]


def test_the_real_doctor_is_understood() -> None:
    found = list(arm.findings(arm.doctor()))
    assert found[0][0] == "ok"
    assert "burnish" in found[0][1]


def test_a_pose_leaves_free_joints_at_home() -> None:
    q = arm.joints(arm.POSES[1])
    free = np.isnan(CALIBRATION_POSE)
    assert (q[free] == HOME[free]).all()
    assert (q[~free] == CALIBRATION_POSE[~free]).all()


def test_limits_are_told_with_units_and_their_fingerprint() -> None:
    limits = Limits.jaco2()
    rows = arm.joint_limits(limits)
    assert len(rows) == 6
    assert rows[0][1] == "free"
    assert all(row[3].endswith("°/s") and row[4].endswith("N·m") for row in rows)
    assert dict(arm.other_limits(limits))["fingerprint of the limits"] == limits.hash[:16]
