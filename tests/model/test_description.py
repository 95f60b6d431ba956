from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from model.arms import load

from burnish.core import State
from burnish.errors import BurnishError, DescriptionError
from burnish.model.description import check_description
from burnish.model.model import JACO2_URDF

DATA = Path(__file__).parent.parent / "data"
ARMS = {
    DATA / "ur5e_like.urdf": "tool0",
    DATA / "seven_dof.urdf": "tool0",
    DATA / "seven_dof.xml": "tool0",
    DATA / "prismatic.urdf": "tip",
    JACO2_URDF: "end_effector",
}


def arm(*changes: tuple[str, str], file: str = "prismatic.urdf") -> str:
    """The text of a good description after replacing each first text, which must be there, by the second."""
    text = (DATA / file).read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    return text


def refusal(tmp_path: Path, text: str | bytes, tool: str | None = "tip") -> str:
    """The one line with which a description is refused."""
    path = tmp_path / "arm.urdf"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(DescriptionError) as caught:
        check_description(path, tool)
    message = str(caught.value)
    assert "\n" not in message
    assert "arm.urdf" in message
    assert isinstance(caught.value, BurnishError)
    return message


@pytest.mark.parametrize(("path", "tool"), ARMS.items(), ids=lambda value: Path(value).name)
def test_good_arms_pass_with_their_tool_and_without(path: Path, tool: str) -> None:
    check_description(path, tool)
    check_description(path)
    check_description(str(path))


URDF_FAULTS = {
    "mass of −3 kg": (('<mass value="2.0"/>', '<mass value="-3"/>'), "mass -3 kg of link 'forearm'"),
    "mass of 0": (('<mass value="2.0"/>', '<mass value="0"/>'), "mass 0 kg of link 'forearm'"),
    "no mass": (('<mass value="2.0"/>', ""), "no <mass> in <inertial>"),
    "mass that is a word": (('value="2.0"', 'value="heavy"'), "value='heavy'"),
    "mass with an underscore": (('value="2.0"', 'value="2_0"'), "value='2_0'"),
    "mass with a comma": (('value="2.0"', 'value="2,0"'), "value='2,0'"),
    "mass NaN": (('value="2.0"', 'value="nan"'), "value='nan'"),
    "mass infinite": (('value="2.0"', 'value="-Infinity"'), "value='-Infinity'"),
    "mass that overflows": (('value="2.0"', 'value="1e999"'), "numbers of at most 1e+12"),
    "inertia not positive definite": (('ixy="0"', 'ixy="1"'), "principal moments"),
    "inertia against the triangle inequality": (
        ('<inertia ixx="0.00375"', '<inertia ixx="0.5"'),
        "the largest to be at most the sum",
    ),
    "inertia zero": (('ixx="0.00375" ixy="0" ixz="0" iyy="0.024375"', 'ixx="0" ixy="0" ixz="0" iyy="0"'), "above 0"),
    "inertia with a number missing": (('ixy="0" ', ""), "no 'ixy' in <inertia>"),
    "NaN in an element that we do not read": (('<robot name="prismatic">', '<robot name="p"><x y="1 NaN"/>'), "NaN"),
    "lower above upper": (('lower="-2.5"', 'lower="2.6"'), "lower 2.6 and upper 2.5 of joint 'shoulder'"),
    "lower equal to upper": (('lower="-2.5"', 'lower="2.5"'), "lower 2.5 and upper 2.5"),
    "limits left at their default": (('lower="-2.5" upper="2.5" ', ""), "lower 0 and upper 0"),
    "no limit": (('<limit lower="-2.5" upper="2.5" effort="60" velocity="3"/>', ""), "no <limit> of joint 'shoulder'"),
    "negative effort": (('effort="60"', 'effort="-60"'), "negative effort"),
    "zero axis": (('<axis xyz="0 0.6 0.8"/>', '<axis xyz="0 0 0"/>'), "a zero axis of joint 'elbow'"),
    "axis with two numbers": (('<axis xyz="0 0.6 0.8"/>', '<axis xyz="0 1"/>'), "expected 3 numbers"),
    "floating joint": (('"elbow" type="revolute"', '"elbow" type="floating"'), "type 'floating' of joint 'elbow'"),
    "planar joint": (('"elbow" type="revolute"', '"elbow" type="planar"'), "type 'planar'"),
    "mimic joint": (('<axis xyz="0 0.6 0.8"/>', '<mimic joint="shoulder"/>'), "mimics another"),
    "second link of a name": (('<link name="quill">', '<link name="arm">'), "a second link 'arm'"),
    "second joint of a name": (('<joint name="elbow"', '<joint name="shoulder"'), "a second joint 'shoulder'"),
    "missing parent": (('<parent link="arm"/>', '<parent link="leg"/>'), "parent 'leg' of joint 'elbow'"),
    "missing child": (('<child link="quill"/>', '<child link="quilt"/>'), "child 'quilt'"),
    "no child": (('<child link="quill"/>', ""), "no <child>"),
    "two parents": (('<child link="tip"/>', '<child link="arm"/>'), "two parents for link 'arm'"),
    "disconnected link": (('<link name="tip"/>', '<link name="tip"/><link name="lost"/>'), "2 links without a parent"),
    "blank before a number": (('lower="-2.5"', 'lower=" -2.5"'), "blanks in lower of <limit>"),
    "xacro": (('<link name="tip"/>', '<xacro:link name="tip"/>'), "run xacro"),
    "second inertial": (("<inertial>", "<inertial/><inertial>"), "a second <inertial>"),
    "another root": (('<robot name="prismatic">', '<sdf name="prismatic">'), "mismatched tag"),
}


@pytest.mark.parametrize("name", URDF_FAULTS)
def test_urdf_is_refused_for(name: str, tmp_path: Path) -> None:
    change, message = URDF_FAULTS[name]
    assert message in refusal(tmp_path, arm(change))


def test_loop_is_refused(tmp_path: Path) -> None:
    text = arm(('<parent link="base"/>', '<parent link="tip"/>'), ('<link name="base"/>', ""))
    assert "a loop of joints" in refusal(tmp_path, text)
    apart = '<joint name="a" type="fixed"><parent link="p"/><child link="q"/></joint>'
    back = '<joint name="b" type="fixed"><parent link="q"/><child link="p"/></joint>'
    links = '<link name="p"/><link name="q"/>'
    assert "a loop of joints" in refusal(tmp_path, arm(("</robot>", f"{links}{apart}{back}</robot>")))


def test_moving_link_without_mass_is_refused_unless_something_rigid_on_it_has_some(tmp_path: Path) -> None:
    without = re.sub(r'<link name="forearm">.*?</link>', '<link name="forearm"/>', arm(), flags=re.DOTALL)
    assert "no mass on 'forearm'" in refusal(tmp_path, without)
    heavy = """<link name="motor"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>
        </inertial></link><joint name="m" type="fixed"><parent link="forearm"/><child link="motor"/></joint></robot>"""
    path = tmp_path / "arm.urdf"
    path.write_text(without.replace("</robot>", heavy))
    check_description(path, "tip")


def test_moving_joints_beside_or_beyond_the_tool_are_refused_and_fixed_ones_are_not(tmp_path: Path) -> None:
    assert "not on the way to 'forearm': stroke, turn" in refusal(tmp_path, arm(), tool="forearm")
    finger = re.sub(r".*(<link name=\"spindle\">.*?</link>).*", r"\1", arm(), flags=re.DOTALL).replace(
        "spindle", "finger"
    )
    joint = """<joint name="grip" type="{}"><parent link="quill"/><child link="finger"/><axis xyz="1 0 0"/>
        <limit lower="0" upper="1" effort="1" velocity="1"/></joint></robot>"""
    branched = arm(("</robot>", finger + joint.format("revolute")))
    assert "not on the way to 'tip': grip" in refusal(tmp_path, branched)
    assert "grip" in refusal(tmp_path, branched, tool=None) or "turn" in refusal(tmp_path, branched, tool=None)
    path = tmp_path / "arm.urdf"
    path.write_text(arm(("</robot>", finger + joint.format("fixed"))))
    check_description(path, "tip")


def test_missing_tool_frame_is_answered_with_the_frames_that_there_are(tmp_path: Path) -> None:
    message = refusal(tmp_path, arm(), tool="tool0")
    assert "no tool frame 'tool0'" in message
    assert message.endswith("base, arm, forearm, quill, spindle, tip")
    assert "tool0" in refusal(tmp_path, arm(file="seven_dof.xml"), tool="flange").split("expected one of")[1]


def test_arm_without_moving_joints_is_refused(tmp_path: Path) -> None:
    assert "no joint that moves" in refusal(tmp_path, '<robot name="r"><link name="a"/></robot>', tool="a")


MJCF_FAULTS = {
    "mass of −3 kg": (('mass="4.0"', 'mass="-3"'), "mass -3 in <inertial>"),
    "mass of 0": (('mass="4.0"', 'mass="0"'), "mass 0 kg of body 'link_1'"),
    "mass NaN": (('mass="4.0"', 'mass="NaN"'), "mass='NaN'"),
    "inertia not positive": (('diaginertia="0.02103', 'diaginertia="-0.02103'), "above 0"),
    "inertia against the triangle inequality": (('diaginertia="0.02103', 'diaginertia="0.2103'), "the largest"),
    "full inertia not positive": (("diaginertia=", 'fullinertia="1 1 1 2 0 0" d='), "above 0"),
    "inertia missing": (("diaginertia=", "d="), "no 'diaginertia'"),
    "range the wrong way round": (('range="-2.9 2.9"', 'range="2.9 -2.9"'), "range 2.9 -2.9 of joint 'joint_1'"),
    "limits without a range": (('range="-2.9 2.9"', 'limited="true"'), "no range"),
    "zero axis in a default": (('axis="0 0 1"', 'axis="0 0 0"'), "a zero axis of joint 'joint_1'"),
    "ball joint": (('name="joint_3"', 'name="joint_3" type="ball"'), "type 'ball'"),
    "ball joint in a default": (('type="hinge"', 'type="ball"'), "type 'ball'"),
    "free joint": (('<joint name="joint_1"', '<freejoint/><joint name="joint_1"'), "type 'free'"),
    "second joint of a name": (('"joint_2"', '"joint_1"'), "a second joint 'joint_1'"),
    "second body of a name": (('"link_2"', '"link_1"'), "a second body 'link_1'"),
    "missing default class": (('childclass="arm"', 'childclass="leg"'), "no default class 'leg'"),
    "missing mesh": (("<site", '<geom type="mesh" mesh="hand"/><site'), "no mesh 'hand'"),
    "missing joint of an actuator": (("</mujoco>", '<actuator><motor joint="j"/></actuator></mujoco>'), "no joint 'j'"),
    "loop": (("</mujoco>", '<equality><connect body1="base" body2="link_7"/></equality></mujoco>'), "no loop"),
    "include": (("<worldbody>", '<include file="/etc/passwd"/><worldbody>'), "<include>"),
    "replicate": (("<site", '<replicate count="9999999"/><site'), "<replicate>"),
    "negative armature": (('type="hinge"', 'type="hinge" armature="-1"'), "armature -1"),
    "massless body": (
        ('<site name="tool0"', '<body name="m"><joint/><site name="tool0"/></body><site'),
        "no mass on 'm'",
    ),
    "geom of no size": (("<site", "<geom/><site"), "no size of a 'sphere' geom"),
    "mocap": (('name="link_1"', 'name="link_1" mocap="true"'), "mocap"),
    "no worldbody": (("<worldbody>", "<world>"), "mismatched tag"),
    "frame": (("<site", '<frame pos="0 0 1"><site name="f"/></frame><site'), "<frame>"),
    "two joints in a body": (("<inertial", "<joint/><inertial"), "2 joints of body 'link_1'"),
    "second arm": (("</worldbody>", "<body><joint/><geom size='1'/></body></worldbody>"), "second body of the world"),
    "mass left to a mesh": (
        ('<inertial pos="0 0.03 0.12" mass="4.0" diaginertia="0.0210333 0.0210333 0.0098"/>', '<geom type="mesh"/>'),
        "a mesh geom to be weighed",
    ),
    "masses changed in total": (("autolimits=", 'settotalmass="9" autolimits='), "settotalmass='9'"),
    "masses from geoms after all": (("autolimits=", 'inertiafromgeom="true" autolimits='), "inertiafromgeom='true'"),
    "axis of an angle of another length": (('euler="-1.57', 'axisangle="0 3 4 1" e="'), "axis is 5 long"),
    "sequence of Euler angles": (("autolimits=", 'eulerseq="abc" autolimits='), "eulerseq='abc'"),
    "gravity of two numbers": (('gravity="0 0 -9.81"', 'gravity="0 -9.81"'), "gravity='0 -9.81'"),
    "branch": (("<site", '<body><joint name="a"/><geom size="1"/></body><site'), "not on the way to 'tool0': a"),
}


@pytest.mark.parametrize("name", MJCF_FAULTS)
def test_mjcf_is_refused_for(name: str, tmp_path: Path) -> None:
    change, message = MJCF_FAULTS[name]
    assert message in refusal(tmp_path, arm(change, file="seven_dof.xml"), tool="tool0")


def test_mjcf_body_may_get_its_mass_from_geoms_and_its_joint_from_a_default_class(tmp_path: Path) -> None:
    path = tmp_path / "arm.xml"
    path.write_text(
        """<mujoco><default><default class="slider"><joint type="slide" axis="1 0 0" range="0 1"/></default></default>
        <worldbody><body name="cart" pos="0 0 1" childclass="slider"><joint/><geom size="0.1"/>
        <body><joint class="main" axis="0 1 0"/><geom type="capsule" size="0.1" fromto="0 0 0 0 0 1"/><site name="tip"/>
        </body></body></worldbody></mujoco>"""
    )
    check_description(path, "tip")


MiB = 2**20
LINKS = "".join(
    f'<link name="l{i}"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
    f'</inertial></link><joint name="j{i}" type="continuous"><parent link="l{i - 1}"/><child link="l{i}"/></joint>'
    for i in range(1, 1400)
)
ENTITIES = "".join(f'<!ENTITY {chr(98 + i)} "{("&" + chr(97 + i) + ";") * 10}">' for i in range(20))
HOSTILE = {
    "empty": ("", "empty"),
    "blanks": (" \n" * 9, "empty"),
    "no xml": ("not a description", "well-formed XML"),
    "binary": ("\x7fELF\x00\x01", "binary"),
    "invalid UTF-8": (b'<robot name="\xff\xfe"/>', "well-formed XML"),
    "claims another encoding": ('<?xml version="1.0" encoding="utf-7"?><robot name="r"/>', "no <link>"),
    "entity bomb": (f'<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa">{ENTITIES}]><robot name="&t;"/>', "DOCTYPE"),
    "external entity": ('<!DOCTYPE r [<!ENTITY a SYSTEM "file:///etc/passwd">]><robot name="&a;"/>', "DOCTYPE"),
    "external DTD": ('<!DOCTYPE r SYSTEM "http://127.0.0.1/r.dtd"><robot name="r"/>', "DOCTYPE"),
    "undefined entity": ('<robot name="&lol;"/>', "undefined entity"),
    "deep nesting": ("<robot>" + "<a>" * 5000, "100 levels"),
    "deep nesting closed": ("<mujoco><worldbody>" + "<body>" * 5000 + "</body>" * 5000, "100 levels"),
    "a million elements": ("<robot>" + "<a/>" * MiB, "10000 elements"),
    "many elements": ("<robot>" + "<a/>" * 20_000, "10000 elements"),
    "many links": (
        "<robot name='r'>" + "".join(f"<link name='{i}'/>" for i in range(9_900)) + "</robot>",
        "9900 links",
    ),
    "long chain": (f"<robot name='r'><link name='l0'/>{LINKS}</robot>", "no tool frame 'tip'"),
    "many bodies": (
        "<mujoco><worldbody><body>" + "<body><joint/><geom size='1'/></body>" * 3000 + "</body></worldbody></mujoco>",
        "tip",
    ),
    "many attributes": ("<robot " + "".join(f"a{i}='' " for i in range(99_000)) + "/>", "no 'name'"),
    "too many attributes": ("<robot " + "".join(f"a{i}='' " for i in range(200_000)) + "/>", "100000 attributes"),
    "endless name": ("<robot name='" + "x" * 9 * MiB + "'/>", "4 MiB of attributes"),
    "endless number": (arm(('value="2.0"', f'value="{"1" * 3 * MiB}"')), "numbers"),
    "endless list of numbers": (arm(('xyz="0.15 0 0.03"', f'xyz="{"1 " * MiB}"')), "3 numbers"),
    "endless text": ("<robot name='r'>" + "x" * 9 * MiB + "</robot>", "no <link>"),
    "unclosed": ("<robot name='" + "x" * 9 * MiB, "unclosed token"),
    "too large": (b"\0" * 60 * MiB, "60 MiB; expected at most 10"),
    "name with a line break": (arm(('name="elbow"', 'name="el&#10;bow" x="nan"')), "finite"),
    "name of control characters": (arm(('"elbow" type="revolute"', '"&#9;&#x202e;" type="ball"')), "type 'ball'"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_file_is_refused_in_no_time(name: str, tmp_path: Path) -> None:
    text, message = HOSTILE[name]
    begin = time.process_time()
    assert message in refusal(tmp_path, text)
    assert time.process_time() - begin < 1.5  # it takes below 0.7 s; what is asked for is 2 s


def test_what_is_no_file_is_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "fifo")  # opening it would wait for a writer for ever
    for path in (tmp_path, tmp_path / "missing.urdf", tmp_path / "fifo", "/dev/zero", "a\0b", "x" * 5000, ""):
        with pytest.raises(DescriptionError):
            check_description(path, "tip")


def test_refusal_needs_little_memory(tmp_path: Path) -> None:
    names = ("endless name", "many links", "many attributes")
    paths = [tmp_path / f"{i}.urdf" for i in range(len(names))]
    for path, name in zip(paths, names, strict=True):
        path.write_text(str(HOSTILE[name][0]))
    script = """
import resource, sys
from burnish.errors import DescriptionError
from burnish.model.description import check_description
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
for path in sys.argv[1:]:
    try:
        check_description(path, "tip")
    except DescriptionError:
        print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024)
"""
    answer = subprocess.run([sys.executable, "-c", script, *paths], capture_output=True, text=True, check=True)
    mebibytes = [float(line) for line in answer.stdout.split()]
    assert len(mebibytes) == len(names)
    assert max(mebibytes) < 200.0


NASTY = (
    "nan -inf 1e999 -1 0 1e-320 1e12 2e12 --1 1_0 0x10 ١ 1,5 NaN(1) 1e 1.e5 .5 fixed floating ball free planar "
    "revolute continuous prismatic hinge slide true false auto base arm tip link_1 joint_1 tool0 elbow"
).split() + [
    "",
    " ",
    "0 0 0",
    "1 2",
    "1 2 3 4",
    "nan 0 0",
    "1 0 0",
    "&#10;",
    "&lt;",
    "%s",
    "9" * 400,
    "\u202e",
    "é",
    "🤖",
]


def mutated(text: str, random: np.random.Generator) -> bytes:
    """A description after one to three slips of the pen, or after damage to its bytes."""
    if random.random() < 0.25:
        return damaged(text.encode(), random)
    for _ in range(random.integers(1, 4)):
        pieces = list(re.finditer(r'[\w:]+="[^"]*"|<[^<>]*/>|<[^<>]*>', text))
        if not pieces:
            break
        piece = pieces[random.integers(len(pieces))]
        old, other = piece.group(), pieces[random.integers(len(pieces))].group()
        key = old.split("=")[0]
        nasty = NASTY[random.integers(len(NASTY))]
        number = f"{random.normal() * 10.0 ** random.integers(-6, 6):.6g}"
        choices = [f'{key}="{nasty}"', f'{key}="{number}"', "", old + other, other]
        text = text[: piece.start()] + choices[random.integers(len(choices))] + text[piece.end() :]
    return text.encode("utf-8", "surrogatepass")


def damaged(data: bytes, random: np.random.Generator) -> bytes:
    """Bytes changed, cut out, put in or doubled."""
    for _ in range(random.integers(1, 4)):
        i, j = sorted(random.integers(0, len(data) + 1, 2))
        j = min(j, i + 40) if random.random() < 0.8 else j
        noise = random.bytes(int(random.integers(0, 4)))
        choices = [
            data[:i] + data[j:],
            data[:i] + noise + data[i:],
            data[:j] + data[i:],
            data[:i] + noise + data[j:],
            data[:i],
        ]
        data = choices[random.integers(len(choices))]
    return data


@pytest.mark.slow
def test_twelve_thousand_mutated_descriptions_become_a_model_or_are_refused_and_nothing_else(tmp_path: Path) -> None:
    random = np.random.default_rng(2026)
    texts = [(path.read_text(), tool, path.suffix) for path, tool in ARMS.items()]
    passed, refusals = 0, []
    for _ in range(12_000):
        text, tool, suffix = texts[random.integers(len(texts))]
        path = tmp_path / f"arm{suffix}"
        path.write_bytes(mutated(text, random))
        try:
            model = load(path, tool)
            arm_there = model.at(State(t=0.0, q=np.full(model.n, 0.1), dq=np.ones(model.n)))
            assert np.linalg.eigvalsh(arm_there.M)[0] > 0.0
            passed += 1
        except DescriptionError as refused:
            refusals.append(str(refused))
    assert max(map(len, refusals)) < 4000
    assert all(line.isascii() and line.isprintable() for line in refusals)
    assert 1000 < passed < 11_000  # both outcomes are really exercised
