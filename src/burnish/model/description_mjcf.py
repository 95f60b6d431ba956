"""What an MJCF has to satisfy to be a fixed-base serial arm."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeAlias

import numpy as np

from burnish.errors import DescriptionError
from burnish.model.description_chain import Frame, check_chain
from burnish.model.description_xml import Element, check_inertia, fault, quoted

_PLACED: dict[str, tuple[int, ...]] = {
    "pos": (3,),
    "quat": (4,),
    "axisangle": (4,),
    "xyaxes": (6,),
    "zaxis": (3,),
    "euler": (3,),
}
_SCALARS: dict[str, tuple[int, ...]] = {
    "armature": (1,),
    "frictionloss": (1,),
    "ref": (1,),
    "springref": (1,),
    "margin": (1,),
}
_NUMERIC: dict[str, dict[str, tuple[int, ...]]] = {
    "body": _PLACED,
    "joint": {"pos": (3,), "axis": (3,), "range": (2,), "damping": (1, 2, 3), "stiffness": (1, 2, 3), **_SCALARS},
    "inertial": {"mass": (1,), "diaginertia": (3,), "fullinertia": (6,), **_PLACED},
    "geom": {"size": (1, 2, 3), "mass": (1,), "density": (1,), "fromto": (6,), "rgba": (4,), **_PLACED},
    "site": {"size": (1, 2, 3), "fromto": (6,), "rgba": (4,), **_PLACED},
    "option": {"gravity": (3,)},
}
"""Elements whose numbers are read, and how many each attribute has."""

_WORDS = ("type", "limited", "mesh")
_NOT_NEGATIVE = ("armature", "frictionloss", "damping", "mass", "density")
_MACROS = ("include", "attach", "replicate", "composite", "flexcomp", "plugin", "frame")
_REWEIGHED = {"settotalmass": "-1", "inertiafromgeom": "auto", "inertiagrouprange": "0 5"}
"""Compiler attributes that change masses behind the engine's back, and the values that do not."""
_MASSLESS = ("plane", "hfield")
_SIZELESS = ("plane", "hfield", "mesh", "sdf")

Classes: TypeAlias = dict[str, dict[str, dict[str, str]]]
"""For each default class the attributes that it gives to each tag."""


def check(root: Element, tool: str | None) -> None:
    """Refuse what `check_description` says, for the root element of an MJCF."""
    for element in root.walk():
        if element.tag in _MACROS:
            raise fault(element, f"<{element.tag}>", "one file without macros", "save the compiled model instead")
    for tie in (tie for equality in root.all("equality") for tie in equality.children):
        raise fault(tie, f"bodies or joints tied by <{quoted(tie.tag)[1:-1]}>", "an open chain, no loop", "delete it")
    worlds = root.all("worldbody")
    if not worlds:
        raise DescriptionError("found no <worldbody>; expected an arm: give another file")
    for element in (*root.all("compiler"), *root.all("option")):
        _check_setting(element)
    _check_place(worlds)
    classes = defaults(root)
    named = {("mesh", name): mesh for mesh, name in _named_meshes(root)}
    weighs_geoms = all(compiler.attributes.get("inertiafromgeom") != "false" for compiler in root.all("compiler"))
    frames: list[Frame] = []
    pending = [(world, -1, False, "main") for world in worlds]
    for body, parent, moved, inherited in pending:
        index = len(frames)
        childclass = body.attributes.get("childclass", inherited)
        inside = [resolved(element, childclass, classes) for element in body.children]
        for element in (body, *(element for element in inside if element.tag != "body")):
            _check_numbers(element)
            _register(element, named)
        joints = [element for element in inside if element.tag in ("joint", "freejoint")]
        for joint in joints:
            _check_joint(joint)
        if len(joints) > 1:
            who = f"{len(joints)} joints of body {quoted(body.attributes.get('name', 'unnamed'))}"
            raise fault(joints[1], who, "one a body", "put each joint into a body of its own")
        if body.attributes.get("mocap") == "true":
            raise fault(body, "a mocap body", "a body that hangs on joints or is fixed", "delete mocap")
        moves = moved or bool(joints)
        geoms = [element for element in inside if element.tag == "geom"]
        weight = _check_inertial(body, moves=moves)
        weighed = sum(_geom_mass(geom, needed=moves and not weight) for geom in geoms)
        weight = weight or (weighed if weighs_geoms else 0.0)
        frames.append(
            Frame(
                name=body.attributes.get("name", "world" if parent < 0 else ""),
                element=body,
                parent=parent,
                joints=tuple(joint.attributes.get("name", "unnamed") for joint in joints),
                has_mass=weight > 0.0,
            )
        )
        sites = (element for element in inside if element.tag == "site")
        frames.extend(Frame(name=s.attributes.get("name", ""), element=s, parent=index) for s in sites)
        pending.extend((element, index, moves, childclass) for element in inside if element.tag == "body")
    _check_references(root, named)
    check_chain(frames, tool)


def defaults(root: Element) -> Classes:
    """For each default class the attributes that it gives to each tag; only those that are read here."""
    classes: Classes = {"main": {}}
    pending = [(default, "main", True) for default in root.all("default")]
    for default, parent, top in pending:
        name = default.attributes.get("class", "main") if top else default.text("class")
        if not top and name in classes:
            raise fault(default, f"a second default class {quoted(name)}", "different names", "rename one")
        merged = dict(classes[parent])
        for element in default.children:
            if element.tag in _NUMERIC:
                _check_numbers(element)
                known = (*_NUMERIC[element.tag], *_WORDS)
                own = {key: value for key, value in element.attributes.items() if key in known}
                merged[element.tag] = {**merged.get(element.tag, {}), **own}
        classes[name] = merged
        if top:
            classes["main"] = merged
        pending.extend((element, name, False) for element in default.children if element.tag == "default")
    return classes


def resolved(element: Element, childclass: str, classes: Classes) -> Element:
    """The element with what its default class gives it; a body as it is."""
    if element.tag == "body":
        return element
    name = element.attributes.get("class", childclass)
    if name not in classes:
        raise fault(element, f"no default class {quoted(name)}, which <{element.tag}> names", "one", "mend the name")
    inherited = classes[name].get(element.tag, {})
    return Element(element.tag, {**inherited, **element.attributes}, element.line, element.children)


def _check_numbers(element: Element) -> None:
    """Refuse numbers that cannot be read, or that are negative where they must not be."""
    for attribute, sizes in _NUMERIC.get(element.tag, {}).items():
        values = element.numbers(attribute, *sizes)
        if values is None:
            continue
        if attribute in _NOT_NEGATIVE and values[0] < 0.0:
            raise fault(element, f"{attribute} {values[0]:g} in <{element.tag}>", "0 or more", "mend it")
        if attribute in ("quat", "axisangle", "zaxis") and np.linalg.norm(values[:4]) < 1e-6:
            raise fault(element, f"a zero {attribute} in <{element.tag}>", "a direction", "mend it")
        if attribute == "axisangle" and abs(np.linalg.norm(values[:3]) - 1.0) > 1e-6:
            found = f"an axisangle whose axis is {np.linalg.norm(values[:3]):.6g} long"
            raise fault(element, found, "one of length 1, to the sixth digit", "divide it by its length")


def _check_setting(element: Element) -> None:
    """Refuse a compiler that changes masses, and settings that cannot be read."""
    _check_numbers(element)
    for attribute, harmless in _REWEIGHED.items():
        value = element.attributes.get(attribute, harmless)
        if value not in (harmless, "false"):
            found = f"{attribute}={quoted(value)}"
            raise fault(element, found, "masses as they are written", "save the compiled model")
    sequence, angle = element.attributes.get("eulerseq", "xyz"), element.attributes.get("angle", "degree")
    if len(sequence) != 3 or not set(sequence) <= set("xyzXYZ") or angle not in ("degree", "radian"):
        found = f"eulerseq={quoted(sequence)} and angle={quoted(angle)}"
        raise fault(element, found, "three of xyzXYZ, and degree or radian", "mend it")


def _check_place(worlds: list[Element]) -> None:
    """Refuse an arm that is not in the first body of the world: the engine's reader looks nowhere else."""
    bodies = [body for world in worlds for body in world.all("body")]
    for body in bodies[1:]:
        if any(element.tag in ("joint", "freejoint") for element in body.walk()):
            raise fault(body, "moving joints in the second body of the world", "the arm in the first", "move it there")


def _register(element: Element, named: dict[tuple[str, str], Element]) -> None:
    """Refuse a second element of the same tag and name."""
    name = element.attributes.get("name")
    if name is None:
        return
    first = named.setdefault((element.tag, name), element)
    if first is not element:
        where = f"the other is in line {first.line}"
        raise fault(element, f"a second {element.tag} {quoted(name)} ({where})", "different names", "rename one")


def _check_joint(joint: Element) -> None:
    """Refuse a joint of another type, without an axis, or with a range that leaves it no room."""
    who = f"joint {quoted(joint.attributes.get('name', 'unnamed'))}"
    kind = "free" if joint.tag == "freejoint" else joint.attributes.get("type", "hinge")
    if kind not in ("hinge", "slide"):
        raise fault(joint, f"type {quoted(kind)} of {who}", "hinge or slide", "model it with those on a fixed base")
    axis = joint.numbers("axis", 3)
    if axis is not None and np.linalg.norm(axis) < 1e-6:
        raise fault(joint, f"a zero axis of {who}", "a direction", "give one")
    limited = joint.attributes.get("limited", "auto")
    if limited not in ("true", "false", "auto"):
        raise fault(joint, f"limited={quoted(limited)} of {who}", "true, false or auto", "mend it")
    bounds = joint.numbers("range", 2)
    if limited == "true" and bounds is None:
        raise fault(joint, f"no range of {who}, which is limited", "a range", "give one, or limited='false'")
    if limited != "false" and bounds is not None and bounds[0] >= bounds[1]:
        raise fault(joint, f"range {bounds[0]:g} {bounds[1]:g} of {who}", "lower below upper", "mend the range")


def _check_inertial(body: Element, *, moves: bool) -> float:
    """Refuse an impossible mass or inertia; the mass that the body is given [kg], 0 where none is."""
    inertial = body.only("inertial")
    if inertial is None:
        return 0.0
    mass = float(inertial.required("mass", 1)[0])
    full = inertial.numbers("fullinertia", 6)
    if full is None:
        tensor = np.diag(inertial.required("diaginertia", 3))
    else:
        xx, yy, zz, xy, xz, yz = full
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if moves:
        check_inertia(inertial, f"body {quoted(body.attributes.get('name', 'unnamed'))}", mass, tensor)
    return mass


def _geom_mass(geom: Element, *, needed: bool) -> float:
    """Something above zero where a geom gives its body mass; refuses a geom without a size, or a mesh to be weighed."""
    kind = geom.attributes.get("type", "sphere")
    size = geom.numbers("size", 1, 2, 3)
    if kind not in _SIZELESS and (size is None or size[0] <= 0.0):
        found = "no size" if size is None else f"size {size[0]:g}"
        raise fault(geom, f"{found} of a {quoted(kind)} geom", "a size above 0", "give one")
    if kind in _MASSLESS:
        return 0.0
    if needed and kind in ("mesh", "sdf"):
        raise fault(geom, f"a {kind} geom to be weighed", "mass and inertia in numbers", "add an <inertial>")
    mass, density = geom.number("mass"), geom.number("density")
    return mass if mass is not None else 1000.0 if density is None else density


def _named_meshes(root: Element) -> Iterator[tuple[Element, str]]:
    """The meshes that geoms may name: by their own name, or by that of their file."""
    for mesh in (mesh for asset in root.all("asset") for mesh in asset.all("mesh")):
        file = mesh.attributes.get("file", "").replace("\\", "/").rsplit("/", 1)[-1]
        yield mesh, mesh.attributes.get("name", file.rsplit(".", 1)[0])


def _check_references(root: Element, named: dict[tuple[str, str], Element]) -> None:
    """Refuse geoms of a mesh, and actuators of a joint, that the file does not have."""
    wanted = [("mesh", world) for world in root.all("worldbody")] + [("joint", group) for group in root.all("actuator")]
    for tag, group in wanted:
        for element in group.walk():
            name = element.attributes.get(tag)
            if name is not None and (tag, name) not in named:
                raise fault(element, f"no {tag} {quoted(name)}, which <{element.tag}> names", "one", "mend the name")
