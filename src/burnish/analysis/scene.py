"""Shapes in one picture: a still PNG, or a page that turns under the mouse."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from burnish.analysis.render import Camera, Triangles, png, render
from burnish.analysis.shape import Shape
from burnish.analysis.viewer import pack, viewer_html
from burnish.errors import InputError

VIEW = (0.75, -1.0, 0.55)
"""From where a scene is seen when nobody says: from the front right, a little above."""


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Shapes, and from where they are seen first."""

    shapes: tuple[Shape, ...]
    camera: Camera

    @classmethod
    def of(cls, shapes: Sequence[Shape], direction: tuple[float, float, float] = VIEW) -> Scene:
        """All shapes that have a face, seen whole from ``direction`` (from the scene to the camera)."""
        drawn = tuple(shape for shape in shapes if len(shape.faces))
        if not drawn:
            raise InputError("Scene: none of the shapes has a face; give at least one triangle")
        points = np.concatenate([shape.vertices[np.unique(shape.faces)] for shape in drawn])
        return cls(shapes=drawn, camera=Camera.framing(points, direction))

    def still(self, width: int = 1280, height: int = 800) -> bytes:
        """A picture as a PNG file."""
        triangles = Triangles(
            corners=np.concatenate([shape.corners for shape in self.shapes]),
            normals=np.concatenate([shape.corner_normals for shape in self.shapes]),
            colours=np.concatenate([shape.corner_colours for shape in self.shapes]),
            gloss=np.concatenate([np.full(len(shape.faces), shape.gloss) for shape in self.shapes]),
        )
        return png(render(triangles, self.camera, width, height))

    def interactive(self) -> str:
        """A piece of HTML that shows the shapes with WebGL, from the file system and without any network."""
        return viewer_html(pack(self.shapes), self.camera)
