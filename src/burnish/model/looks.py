"""What the arm looks like: the visual shapes of a description as triangles."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from burnish.core import Array
from burnish.model.model import JACO2_URDF
from burnish.rotation import exp

GREY = (0.5, 0.5, 0.5)
SECTIONS = 40
"""Sides of a round shape."""


@dataclass(frozen=True, kw_only=True)
class Look:
    """One visual shape of a link, in the link's frame."""

    link: str
    """Name of the link."""
    vertices: Array
    """[m], (V, 3)."""
    faces: NDArray[np.int64]
    """(F, 3)."""
    colour: tuple[float, float, float]
    """Red, green, blue, 0 to 1."""


def looks(path: Path = JACO2_URDF) -> list[Look]:
    """The cylinders, spheres and boxes of a URDF; meshes of other files are left out."""
    root = ElementTree.parse(path).getroot()
    colours = {m.get("name"): _colour(m) for m in root.findall("material")}
    found = []
    for link in root.findall("link"):
        for visual in link.findall("visual"):
            mesh = _mesh(visual.find("geometry"))
            if mesh is None:
                continue
            placed = mesh.vertices @ _rotation(visual).T + _numbers(visual.find("origin"), "xyz")
            material = visual.find("material")
            name = None if material is None else material.get("name")
            look = Look(
                link=str(link.get("name")),
                vertices=np.asarray(placed),
                faces=np.asarray(mesh.faces, dtype=np.int64),
                colour=colours.get(name, GREY),
            )
            found.append(look)
    return found


def _mesh(geometry: ElementTree.Element | None) -> Any:
    """A trimesh, or None for a shape that is not drawn."""
    shape = None if geometry is None or len(geometry) == 0 else geometry[0]
    if shape is None:
        return None
    if shape.tag == "cylinder":
        return trimesh.creation.cylinder(float(shape.get("radius", 0)), float(shape.get("length", 0)), SECTIONS)
    if shape.tag == "sphere":
        return trimesh.creation.icosphere(3, float(shape.get("radius", 0)))
    if shape.tag == "box":
        return trimesh.creation.box(_numbers(shape, "size"))
    return None


def _rotation(visual: ElementTree.Element) -> Array:
    """R = Rz(yaw) Ry(pitch) Rx(roll) of the visual's origin."""
    roll, pitch, yaw = _numbers(visual.find("origin"), "rpy")
    x, y, z = (np.eye(3)[i] for i in range(3))
    return exp(yaw * z) @ exp(pitch * y) @ exp(roll * x)


def _numbers(element: ElementTree.Element | None, key: str) -> Array:
    text = None if element is None else element.get(key)
    return np.zeros(3) if text is None else np.array([float(word) for word in text.split()])


def _colour(material: ElementTree.Element) -> tuple[float, float, float]:
    element = material.find("color")
    words = "" if element is None else element.get("rgba", "")
    values = [float(word) for word in words.split()]
    return (values[0], values[1], values[2]) if len(values) >= 3 else GREY
