"""The arm at work as shapes: links, tool, mould coloured by removal, and the way that the tip went."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray

from burnish.analysis.mould_map import RemovalField, removal_colours
from burnish.analysis.shape import FELT, STEEL, TRACE, Shape, tube
from burnish.core import Array
from burnish.model.looks import looks
from burnish.model.model import Model
from burnish.model.tool import PolishingTool

TABLE = (0.80, 0.79, 0.77)
SENSOR = (0.62, 0.64, 0.66)


def arm_shapes(model: Model, q: Array, tool: PolishingTool) -> list[Shape]:
    """The JACO2 at joint positions ``q`` [rad] with its tool, in base axes."""
    poses = model.link_poses(q)
    shapes = [_shape("arm", poses[look.link], look.vertices, look.faces, look.colour) for look in looks()]
    hand = poses["end_effector"]
    across, height = tool.body_radius, 2.0 * tool.body_com
    plate = trimesh.creation.cylinder(1.5 * across, 0.012, sections=40)
    body = trimesh.creation.cylinder(across, height, sections=40)
    body.apply_translation([0.0, 0.0, 0.5 * height])
    tip = trimesh.creation.icosphere(4, tool.tip_radius)
    tip.apply_translation([0.0, 0.0, tool.tip_centre])
    for mesh, colour in ((plate, SENSOR), (body, STEEL), (tip, FELT)):
        shapes.append(_shape("tool", hand, mesh.vertices, mesh.faces, colour))
    return shapes


def mould_shapes(
    vertices: Array, faces: NDArray[np.int64], pose: Array, removal: RemovalField | None, height: float
) -> list[Shape]:
    """The mould on its pedestal, and its worked surface coloured by removal, in base axes.

    Args:
        vertices: of the whole mould, its frame [m], (V, 3).
        faces: (F, 3).
        pose: base ← mould, (4, 4).
        removal: what was taken off, or None.
        height: of the mould's lowest point above the floor [m].
    """
    shapes = [_shape("mould", pose, vertices, faces, STEEL)]
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    if height > 0.01:
        box = trimesh.creation.box([high[0] - low[0], high[1] - low[1], height])
        box.apply_translation([*(0.5 * (low + high))[:2], low[2] - 0.5 * height])
        shapes.append(_shape("table", pose, box.vertices, box.faces, TABLE, gloss=0.0))
    if removal is not None:
        # A hair above the steel, so that the colours win.
        lifted = removal.vertices + np.array([0.0, 0.0, 2e-4])
        shapes.append(_shape("removal", pose, lifted, removal.faces, removal_colours(removal), gloss=0.05))
    return shapes


def trace_shape(points: Array) -> Shape:
    """The way of the tip in base axes [m], (N, 3), as a thin tube."""
    return tube(points, 4e-4, TRACE, "path")


def _shape(
    name: str, pose: Array, vertices: ArrayLike, faces: ArrayLike, colour: ArrayLike, gloss: float = 0.25
) -> Shape:
    """A shape given in the frame of ``pose``, base ← frame, (4, 4)."""
    placed = np.asarray(vertices) @ pose[:3, :3].T + pose[:3, 3]
    return Shape(
        name=name, vertices=placed, faces=np.asarray(faces, dtype=np.int64), colour=np.asarray(colour), gloss=gloss
    )
