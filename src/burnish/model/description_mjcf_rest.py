"""What an MJCF says and the engine's reader overlooks: gravity, where the base stands, joints without limits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from burnish.core import Array
from burnish.model.description_mjcf import defaults, resolved
from burnish.model.description_xml import Element, read
from burnish.rotation import exp, from_quaternion


@dataclass(frozen=True, kw_only=True)
class RestOfMJCF:
    """The rest of a description that `check_description` has passed."""

    gravity: Array
    """Acceleration of free fall, base axes [m/s²], (3,)."""
    p: Array
    """Where the base body stands in the world [m], (3,)."""
    R: Array
    """How it is turned, world ← base body, (3, 3)."""
    base_moves: bool
    """Whether the first body hangs on a joint itself; the engine's reader then knows where it is."""
    unlimited: NDArray[np.bool_]
    """Whether each joint is without limits although it may have a range, (n,)."""


def rest_of_mjcf(path: str | Path) -> RestOfMJCF:
    """Read it from a file that `check_description` has passed."""
    root = read(path)
    options, settings = _merged(root, "option"), _merged(root, "compiler")
    flags = [flag.attributes.get("gravity") for option in root.all("option") for flag in option.all("flag")]
    gravity = options.numbers("gravity", 3)
    joints = _joints(root)
    base = next(body for world in root.all("worldbody") for body in world.all("body"))
    pos = base.numbers("pos", 3)
    return RestOfMJCF(
        gravity=np.zeros(3) if "disable" in flags else np.array([0.0, 0.0, -9.81]) if gravity is None else gravity,
        p=np.zeros(3) if pos is None else pos,
        R=_rotation(base, settings.attributes),
        base_moves=bool(base.all("joint")),
        unlimited=np.array([j.get("limited", "auto") == "false" or "range" not in j for j in joints]),
    )


def _merged(root: Element, tag: str) -> Element:
    """All elements of a tag as one; what comes later counts."""
    attributes: dict[str, str] = {}
    for element in root.all(tag):
        attributes.update(element.attributes)
    return Element(tag, attributes, root.line)


def _joints(root: Element) -> list[Mapping[str, str]]:
    """The attributes of the joints, default classes included, from the base to the tool."""
    classes = defaults(root)
    joints: list[Mapping[str, str]] = []
    pending = [(world, "main") for world in root.all("worldbody")]
    for body, inherited in pending:
        childclass = body.attributes.get("childclass", inherited)
        joints += [resolved(joint, childclass, classes).attributes for joint in body.all("joint")]
        pending.extend((child, childclass) for child in body.all("body"))
    return joints


def _rotation(body: Element, settings: Mapping[str, str]) -> Array:
    """The rotation of a body in its parent, whichever of the five ways it is written in, (3, 3)."""
    unit = 1.0 if settings.get("angle", "degree") == "radian" else np.pi / 180.0
    if (quat := body.numbers("quat", 4)) is not None:
        return from_quaternion(quat / np.linalg.norm(quat))
    if (axisangle := body.numbers("axisangle", 4)) is not None:
        return exp(axisangle[:3] / np.linalg.norm(axisangle[:3]) * axisangle[3] * unit)
    if (euler := body.numbers("euler", 3)) is not None:
        R = np.eye(3)
        for letter, angle in zip(settings.get("eulerseq", "xyz"), euler * unit, strict=True):
            turn = exp(angle * np.eye(3)["xyz".index(letter.lower())])
            R = R @ turn if letter.islower() else turn @ R
        return R
    if (xyaxes := body.numbers("xyaxes", 6)) is not None:
        x = xyaxes[:3] / np.linalg.norm(xyaxes[:3])
        y = xyaxes[3:] - (x @ xyaxes[3:]) * x
        y = y / np.linalg.norm(y)
        return np.column_stack((x, y, np.cross(x, y)))
    if (zaxis := body.numbers("zaxis", 3)) is not None:
        z = zaxis / np.linalg.norm(zaxis)
        across = np.cross((0.0, 0.0, 1.0), z)
        size = float(np.linalg.norm(across))
        axis = across / size if size > 1e-12 else np.array([1.0, 0.0, 0.0])
        return exp(axis * np.arctan2(size, z[2]))
    return np.eye(3)
