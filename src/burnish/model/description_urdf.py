"""What a URDF has to satisfy to be a fixed-base serial arm."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from burnish.errors import DescriptionError
from burnish.model.description_chain import Frame, check_chain
from burnish.model.description_xml import Element, check_inertia, fault, quoted

MOVING = ("revolute", "continuous", "prismatic")

_NUMERIC = {
    "origin": {"xyz": (3,), "rpy": (3,)},
    "axis": {"xyz": (3,)},
    "limit": {"lower": (1,), "upper": (1,), "effort": (1,), "velocity": (1,)},
    "dynamics": {"damping": (1,), "friction": (1,)},
    "calibration": {"rising": (1,), "falling": (1,)},
    "safety_controller": dict.fromkeys(("soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity"), (1,)),
    "mass": {"value": (1,)},
    "inertia": dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), (1,)),
    "color": {"rgba": (4,)},
    "mesh": {"scale": (3,)},
    "box": {"size": (3,)},
    "cylinder": {"radius": (1,), "length": (1,)},
    "capsule": {"radius": (1,), "length": (1,)},
    "sphere": {"radius": (1,)},
}
"""Elements inside links, joints and materials whose numbers are read, and how many each attribute has."""

_SHAPES = ("box", "cylinder", "capsule", "sphere", "mesh")


def check(root: Element, tool: str | None) -> None:
    """Refuse what `check_description` says, for the root element of a URDF."""
    root.text("name")
    for element in root.walk():
        if element.tag.startswith("xacro:"):
            raise fault(element, f"<{quoted(element.tag)[1:-1]}>", "plain URDF", "run xacro on the file first")
    links, joints = _by_name(root, "link"), _by_name(root, "joint")
    if not links:
        raise DescriptionError("found no <link>; expected an arm: give another file")
    for element in root.all("link", "joint", "material"):
        _check_numbers(element)
    for material in root.all("material"):
        material.text("name")
    parents: dict[str, Element] = {}
    children = defaultdict(list)
    for joint in joints.values():
        _check_joint(joint)
        parent, child = (_reference(joint, tag, links) for tag in ("parent", "child"))
        if child in parents:
            others = f"{quoted(parents[child].text('name'))} and {quoted(joint.text('name'))}"
            raise fault(joint, f"two parents for link {quoted(child)}, joints {others}", "one", "delete one joint")
        parents[child] = joint
        children[parent].append(child)
    order = _from_root(links, parents, children)
    index = {name: i for i, name in enumerate(order)}
    frames: list[Frame] = []
    moving: set[str] = set()
    for name in order:
        above = parents.get(name)
        parent = "" if above is None else above.need("parent").text("link")
        moves = above is not None and above.attributes["type"] in MOVING
        if moves or parent in moving:
            moving.add(name)
        frames.append(
            Frame(
                name=name,
                element=links[name],
                parent=index.get(parent, -1),
                joints=(above.text("name"),) if moves and above is not None else (),
                has_mass=_check_link(links[name], moves=name in moving),
            )
        )
    check_chain(frames, tool)


def _by_name(root: Element, tag: str) -> dict[str, Element]:
    """The children of a tag by their names, which must differ."""
    named: dict[str, Element] = {}
    for element in root.all(tag):
        name = element.text("name")
        if name in named:
            first = f"the other is in line {named[name].line}"
            raise fault(element, f"a second {tag} {quoted(name)} ({first})", "different names", "rename one")
        named[name] = element
    return named


def _from_root(links: dict[str, Element], parents: dict[str, Element], children: dict[str, list[str]]) -> list[str]:
    """All links, parents before children; refuses loops and separate trees."""
    roots = [name for name in links if name not in parents]
    if len(roots) > 1:
        names = ", ".join(quoted(name) for name in roots[:10])
        raise fault(links[roots[1]], f"{len(roots)} links without a parent: {names}", "one, the base", "join them up")
    order = list(roots)
    for name in order:
        order.extend(children.get(name, ()))
    lost = links.keys() - set(order)
    if lost:
        name = min(lost)
        raise fault(links[name], f"a loop of joints through link {quoted(name)}", "an open chain", "cut the loop")
    return order


def _check_numbers(top: Element) -> None:
    """Refuse numbers that cannot be read, and shapes without one."""
    for element in top.walk():
        for attribute, sizes in _NUMERIC.get(element.tag, {}).items():
            values = element.numbers(attribute, *sizes)
            if sizes == (1,) and element.attributes.get(attribute, "").strip() != element.attributes.get(attribute, ""):
                raise fault(element, f"blanks in {attribute} of <{element.tag}>", "a number alone", "delete them")
            if values is not None and element.tag in _SHAPES and attribute != "scale" and values.min() <= 0.0:
                raise fault(element, f"{attribute} {values.min():g} m of a {element.tag}", "more than 0", "mend it")
        if element.tag in ("visual", "collision"):
            element.only("origin")
            shapes = element.need("geometry").all(*_SHAPES)
            if len(shapes) != 1:
                raise fault(element, f"{len(shapes)} shapes in a <geometry>", "one", "mend it")
            for attribute in _NUMERIC[shapes[0].tag]:
                if attribute != "scale":
                    shapes[0].required(attribute, *_NUMERIC[shapes[0].tag][attribute])
            if shapes[0].tag == "mesh":
                shapes[0].text("filename")


def _check_joint(joint: Element) -> None:
    """Refuse a joint of another type, without an axis, or with limits that leave it no room."""
    who = f"joint {quoted(joint.text('name'))}"
    kind = joint.text("type")
    if kind not in (*MOVING, "fixed"):
        raise fault(
            joint, f"type {quoted(kind)} of {who}", "revolute, continuous, prismatic or fixed", "model it with those"
        )
    for tag in ("origin", "dynamics"):
        joint.only(tag)
    if kind == "fixed":
        return
    if joint.only("mimic") is not None:
        raise fault(joint, f"{who} that mimics another", "joints that move on their own", "make it fixed")
    axis = joint.only("axis")
    if axis is not None and np.linalg.norm(axis.required("xyz", 3)) < 1e-6:
        raise fault(axis, f"a zero axis of {who}", "a direction", "give one")
    for dynamics in joint.all("dynamics"):
        for attribute in ("damping", "friction"):
            if (dynamics.number(attribute) or 0.0) < 0.0:
                raise fault(dynamics, f"negative {attribute} of {who}", "0 or more", "mend it")
    limit = joint.only("limit")
    if limit is None:
        if kind != "continuous":
            raise fault(joint, f"no <limit> of {who}", "lower, upper, effort and velocity", "add it")
        return
    for attribute in ("effort", "velocity"):
        if limit.required(attribute, 1)[0] < 0.0:
            raise fault(limit, f"negative {attribute} of {who}", "0 or more", "mend it")
    lower, upper = limit.number("lower") or 0.0, limit.number("upper") or 0.0
    if kind != "continuous" and lower >= upper:
        raise fault(limit, f"lower {lower:g} and upper {upper:g} of {who}", "lower below upper", "mend the <limit>")


def _check_link(link: Element, *, moves: bool) -> bool:
    """Refuse an impossible mass or inertia; whether the link has mass."""
    inertial = link.only("inertial")
    if inertial is None:
        return False
    inertial.only("origin")
    mass = float(inertial.need("mass").required("value", 1)[0])
    tensor = inertial.need("inertia")
    xx, xy, xz, yy, yz, zz = (float(tensor.required(name, 1)[0]) for name in _NUMERIC["inertia"])
    who = f"link {quoted(link.text('name'))}"
    if moves:
        check_inertia(inertial, who, mass, np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
    elif mass < 0.0:
        raise fault(inertial, f"mass {mass:g} kg of {who}", "0 or more", "mend it")
    return mass > 0.0


def _reference(joint: Element, tag: str, links: dict[str, Element]) -> str:
    """The link that a joint names as its parent or child."""
    name = joint.need(tag).text("link")
    if name not in links:
        who = f"joint {quoted(joint.text('name'))}"
        raise fault(joint, f"{tag} {quoted(name)} of {who}, which is no link", "a link of this file", "mend the name")
    return name
