"""A file that a user brings: it is the arm that MuJoCo reads in it, or it is refused in one line."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from model.arms import DATA, MuJoCo, load, random_states
from numpy.testing import assert_allclose

from burnish.errors import DescriptionError
from burnish.model.model import Model

URDF = (DATA / "prismatic.urdf").read_text()
MJCF = (DATA / "seven_dof.xml").read_text()
LAST = '<inertial pos="0 0 0.02" mass="0.3" diaginertia="0.00016 0.00016 0.00024"/>'
MESH = '<{0}><geometry><mesh filename="{1}" scale="0.001 0.001 0.001"/></geometry></{0}>'
MESHES = MESH.format("visual", "package://nowhere/meshes/arm.dae") + MESH.format("collision", "missing/arm.stl")
INERTIA = '<inertia ixx="0.002" ixy="0.0001" ixz="0" iyy="0.002" iyz="0" izz="0.0015"/>'
ROS = """<gazebo reference="arm"><material>Gazebo/Orange</material></gazebo>
<transmission name="t"><type>transmission_interface/SimpleTransmission</type><joint name="elbow">
<hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface></joint></transmission>
<ros2_control name="x" type="system"><joint name="elbow"><command_interface name="effort"/></joint></ros2_control>"""
GRIPPER = f"""<link name="hand"><inertial><origin xyz="0 0 0.1" rpy="0.3 0.2 0.1"/><mass value="0.4"/>{INERTIA}
</inertial></link><joint name="a" type="fixed"><parent link="spindle"/><child link="hand"/>
<origin xyz="0.1 0.2 0.3" rpy="1 2 3"/></joint><link name="finger"><inertial><mass value="0.02"/>{INERTIA}</inertial>
</link><joint name="b" type="fixed"><parent link="hand"/><child link="finger"/></joint>"""


def changed(text: str, *pairs: tuple[str, str]) -> str:
    """The text after replacing the first of each pair, which must be there, by the second."""
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new, 1)
    return text


URDFS = {
    "meshes that are not there": (('<link name="arm">', f'<link name="arm">{MESHES}'),),
    "meshes of the base": (('<link name="base"/>', f'<link name="base">{MESHES}</link>'),),
    "tags of ROS": (("</robot>", f"{ROS}</robot>"),),
    "traces of xacro": (
        ('<robot name="prismatic">', '<robot name="prismatic" xmlns:xacro="http://www.ros.org/wiki/xacro">'),
        ('<link name="tip"/>', '<!-- | from arm.xacro: <xacro:arm prefix="${p}"> é | --><link name="tip"/>'),
    ),
    "gripper of fixed links": (("</robot>", f"{GRIPPER}</robot>"),),
    "world below the base": (
        (
            '<link name="base"/>',
            (
                '<link name="world"/><joint name="w" type="fixed"><parent link="world"/><child link="base"/>'
                '<origin xyz="1 2 3" rpy="0.1 0.2 0.3"/></joint><link name="base"/>'
            ),
        ),
    ),
    "base with a mass": (
        ('<link name="base"/>', f'<link name="base"><inertial><mass value="4"/>{INERTIA}</inertial></link>'),
    ),
    "fixed link in the middle": (
        ('<child link="forearm"/>', '<child link="adapter"/>'),
        (
            "</robot>",
            (
                '<link name="adapter"/><joint name="c" type="fixed"><parent link="adapter"/><child link="forearm"/>'
                '<origin xyz="0.1 0 0" rpy="0.1 0.2 0.3"/></joint></robot>'
            ),
        ),
    ),
    "axis of another length": (('xyz="0 0.6 0.8"', 'xyz="0 6 8"'),),
    "no axis": (('<axis xyz="0 0.6 0.8"/>', ""),),
    "joint and link of one name": (('<joint name="elbow"', '<joint name="forearm"'),),
    "inertia in turned axes": (('<origin xyz="0.12 0 -0.02"/>', '<origin xyz="0.12 0 -0.02" rpy="0.3 0.2 0.1"/>'),),
    "soft limits and calibration": (
        ("<axis", '<safety_controller k_velocity="2" soft_upper_limit="1"/><calibration rising="0"/><axis'),
    ),
    "continuous joint with limits": (('<limit effort="8"', '<limit lower="-1" upper="1" effort="8"'),),
    "continuous joint without any": (('<limit effort="8" velocity="12"/>', ""),),
    "names in other letters": (('<link name="arm">', '<material name="Füße"/><link name="arm">'),),
    "byte order mark": (("<?xml", "\ufeff<?xml"),),
}


def assert_is_the_arm_of_mujoco(path: Path, tool: str) -> Model:
    """The model of the file, once all its terms are MuJoCo's."""
    model = load(path, tool)
    # MuJoCo opens meshes, and takes a byte order mark for text: it gets the file without them.
    text = path.read_text(encoding="utf-8").removeprefix("\ufeff")
    plain = path.with_stem("plain")
    plain.write_text(
        re.sub(r"<(visual|collision)>.*?</\1>|<geom type=.mesh.*?/>|<mesh .*?/>", "", text), encoding="utf-8"
    )
    theirs = MuJoCo(plain, tool)
    for state in random_states(model, 1, 5):
        found, expected = model.at(state), theirs.at(state.q, state.dq)
        for term in ("p", "R", "J", "M", "g", "h"):
            assert_allclose(getattr(found, term), expected[term], rtol=0.0, atol=1e-9, err_msg=term)
    assert path.suffix == ".urdf" or np.array_equal([model.lower, model.upper], theirs.limits)
    return model


@pytest.mark.parametrize("name", URDFS)
def test_urdf_loads_with(name: str, tmp_path: Path) -> None:
    path = tmp_path / "own arm.urdf"
    path.write_text(changed(URDF, *URDFS[name]), encoding="utf-8")
    model = assert_is_the_arm_of_mujoco(path, "tip")
    assert model.upper.tolist() == [2.5, 2.6, 0.18, np.inf]


JOINT_1 = 'name="joint_1" range="-2.9 2.9"'
BASE = '<body name="base" '
MJCFS = {
    "continuous joint": ((JOINT_1, 'name="joint_1"'),),
    "range that does not limit": ((JOINT_1, f'{JOINT_1} limited="false"'),),
    "range of a class that does not limit": (
        ('axis="0 0 1"/>', 'axis="0 0 1" range="-1 1"/>'),
        (JOINT_1, 'name="joint_1" limited="false"'),
    ),
    "slide without limits along no axis of the frame": ((JOINT_1, 'name="joint_1" type="slide" axis="0 1 2"'),),
    "rotors": (('axis="0 0 1"', 'axis="0 0 1" armature="0.1"'),),
    "gravity of a wall mount": (('gravity="0 0 -9.81"', 'gravity="0 9 -2"'),),
    "gravity switched off": (('-9.81"/>', '-9.81"><flag gravity="disable"/></option>'),),
    "gravity left at its default": (('gravity="0 0 -9.81"', ""),),
    "base turned by Euler angles": ((BASE, f'{BASE} pos="1 2 3" euler="0.1 0.2 0.3" '),),
    "base turned by other Euler angles": (
        (BASE, f'{BASE} euler="0.1 0.2 0.3" '),
        ("<compiler ", '<compiler eulerseq="zYx" '),
    ),
    "base turned in degrees": ((BASE, f'{BASE} euler="10 20 30" '), ('angle="radian"', 'angle="degree"')),
    "base turned by a quaternion": ((BASE, f'{BASE} quat="1 2 3 4" '),),
    "base turned about an axis": ((BASE, f'{BASE} axisangle="0 0.6 0.8 0.5" '),),
    "base turned by two axes": ((BASE, f'{BASE} xyaxes="1 2 3 0.4 0 1" '),),
    "base turned by its z": ((BASE, f'{BASE} zaxis="1 2 3" '),),
    "base turned by its z downwards": ((BASE, f'{BASE} zaxis="0 0 -1" '),),
    "fixed body in between": (
        ('<body name="link_1"', '<body name="adapter" pos="0 1 0" euler="1 2 3"><body name="link_1"'),
        ("</body>\n  </worldbody>", "</body></body>\n  </worldbody>"),
    ),
    "mass from shapes": (
        (
            LAST,
            '<geom type="capsule" size="0.03" fromto="0 0 0 0 0.01 0.1"/><geom size="0.05" mass="0.4" pos="0.1 0 0"/>',
        ),
    ),
    "inertia in turned axes": (('diaginertia="0.00016', 'euler="0.3 0.2 0.1" diaginertia="0.00016'),),
    "full inertia": (('diaginertia="0.00016 0.00016 0.00024"', 'fullinertia="2e-4 2e-4 3e-4 2e-5 1e-5 -3e-5"'),),
    "joint beside its body's origin": (('<joint name="joint_2"', '<joint pos="0.1 0.2 0.3" name="joint_2"'),),
    "zero shifted": (('axis="0 0 1"', 'axis="0 0 1" ref="0.3"'),),
    "floor, lamp and table": (
        ("<worldbody>", '<worldbody><geom type="plane" size="1 1 1"/><light pos="0 0 1"/>'),
        ("</worldbody>", '<body name="table"><geom type="box" size="1 1 1"/></body></worldbody>'),
    ),
    "motors, sensors, keys": (
        (
            "</mujoco>",
            (
                '<actuator><motor joint="joint_1"/></actuator><sensor><jointpos joint="joint_1"/></sensor>'
                '<contact><exclude body1="link_1" body2="link_2"/></contact></mujoco>'
            ),
        ),
    ),
    "mesh that is not there": (
        ("<worldbody>", '<asset><mesh name="m" file="m.stl"/></asset><worldbody>'),
        (LAST, f'<geom type="mesh" mesh="m"/>{LAST}'),
    ),
}


@pytest.mark.parametrize("name", MJCFS)
def test_mjcf_loads_with(name: str, tmp_path: Path) -> None:
    path = tmp_path / "own arm.xml"
    path.write_text(changed(MJCF, *MJCFS[name]), encoding="utf-8")
    assert_is_the_arm_of_mujoco(path, "tool0")


def test_continuous_joints_of_an_mjcf_are_continuous(tmp_path: Path) -> None:
    path = tmp_path / "arm.xml"
    path.write_text(
        changed(MJCF, (JOINT_1, 'name="joint_1"'), ('range="-2.0 2.0"', 'limited="false" range="-2.0 2.0"'))
    )
    model = Model.from_mjcf(path, "tool0")
    assert np.isneginf(model.lower).tolist() == [True, True, False, False, False, False, False]
    assert np.isposinf(model.upper).tolist() == [True, True, False, False, False, False, False]


def test_rotors_of_an_mjcf_are_the_armature_of_the_model(tmp_path: Path) -> None:
    path = tmp_path / "arm.xml"
    path.write_text(changed(MJCF, (JOINT_1, f'{JOINT_1} armature="0.4"')))
    assert_allclose(Model.from_mjcf(path, "tool0").armature, [0.4, 0, 0, 0, 0, 0, 0])


@pytest.mark.parametrize(
    ("file", "text", "found"),
    [
        ("arm.urdf", MJCF, "no tool frame 'tip'"),
        ("arm.urdf", changed(URDF, ('rpy="0 1.0 0"', 'rpy="0 ${pi/2} 0"')), r"rpy='0 \$\{pi/2\} 0'"),
        ("arm.urdf", changed(URDF, ('effort="60" ', "")), "no 'effort' in <limit>"),
        ("arm.urdf", changed(URDF, ('<link name="tip"/>', '<link name="tool"/>')), "'tip' of joint 'tip_mount'"),
        ("arm.xml", changed(MJCF, (LAST, '<geom size="0.1" shellinertia="true"/>')), "Shell inertia"),
        (
            "arm.urdf",
            changed(MJCF, ('"tool0"', '"tip"')),
            "root element <mujoco>; expected <robot>: use Model.from_mjcf",
        ),
        ("arm.xml", URDF.replace('"tip"', '"tool0"'), "root element <robot>; expected <mujoco>: use Model.from_urdf"),
    ],
    ids=["no tool", "xacro", "no effort", "no tip", "shell", "other format", "other way round"],
)
def test_file_is_refused_in_one_line_with_its_name(file: str, text: str, found: str, tmp_path: Path) -> None:
    path = tmp_path / file
    path.write_text(text)
    with pytest.raises(DescriptionError, match=found) as refused:
        load(path, "tool0" if file == "arm.xml" else "tip")
    assert file in str(refused.value)
    assert "\n" not in str(refused.value)
