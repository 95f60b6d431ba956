"""The cell in three dimensions: the arm as its description draws it, the tool, the mould on its stand, the floor."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import trimesh
import viser

from burnish.core import Array
from burnish.gui.glb import Glb
from burnish.gui.paint import STEEL, Canvas, Paint
from burnish.model.looks import looks
from burnish.model.model import Model
from burnish.model.tool import PolishingTool
from burnish.paths.stroke import Stroke
from burnish.polish.cell import HOME, Placement, nominal_placement
from burnish.rotation import quaternion
from burnish.surface import Mould

TABLE, FELT, SENSOR = (0.62, 0.61, 0.58), (0.90, 0.84, 0.70), (0.62, 0.64, 0.66)
PATH, DONE, REFUSED = (30, 115, 190), (120, 150, 175), (214, 40, 40)
LIFT = 3e-4
"""How far lines hover above the surface, so that they are seen [m]."""
CAMERA, LOOK_AT, FIELD = (0.40, -0.98, 0.66), (0.02, -0.23, 0.32), 0.9
"""From where a cell is first seen [m], and how wide [rad]."""


class Scene:
    """What is drawn in the middle of the page, the same for everybody who watches."""

    def __init__(self, scene: viser.SceneApi) -> None:
        """The arm at home over an empty floor."""
        self._scene = scene
        self._model = Model.jaco2()
        self._links: dict[str, Any] = {}
        self._handles: list[Any] = []
        self._strokes: list[Any] = []
        self._glb: Any = None
        self._mesh: Glb | None = None
        self.paint: Paint | None = None
        scene.set_up_direction("+z")
        # Shadows double the work of a browser that draws without a graphics card, and say nothing about the job.
        scene.configure_default_lights(cast_shadow=False)
        scene.add_grid(
            "/floor", 3.0, 3.0, cell_size=0.1, section_size=0.5, cell_color=(150, 150, 150),
            section_color=(120, 120, 120), cell_thickness=0.6, section_thickness=1.0, fade_distance=3.0,
        )  # fmt: skip
        for number, look in enumerate(looks()):
            if look.link not in self._links:
                self._links[look.link] = scene.add_frame(f"/arm/{look.link}", show_axes=False)
            _mesh(scene, f"/arm/{look.link}/{number}", look.vertices, look.faces, look.colour)
        self._links["end_effector"] = self._links.get("end_effector") or scene.add_frame(
            "/arm/end_effector", show_axes=False
        )
        self._hold(PolishingTool())
        self.move(HOME)

    def move(self, q: Array) -> None:
        """Draw the arm at these joint positions [rad]."""
        poses = self._model.link_poses(q)
        for link, frame in self._links.items():
            frame.position, frame.wxyz = poses[link][:3, 3], quaternion(poses[link][:3, :3])

    def put(self, mould: Mould, canvas: Canvas, tool: PolishingTool) -> None:
        """Mount another mould, with nothing taken off."""
        self.clear()
        placement = _standing(mould)
        self._handles.append(
            self._scene.add_frame("/mould", show_axes=False, position=placement.p, wxyz=quaternion(placement.R))
        )
        low, high = mould.vertices.min(axis=0), mould.vertices.max(axis=0)
        height = float(placement.p[2])
        if height > 0.01:
            stand = trimesh.creation.box([high[0] - low[0], high[1] - low[1], height])
            stand.apply_translation([*(0.5 * (low + high))[:2], -0.5 * height])
            self._handles.append(_mesh(self._scene, "/mould/stand", stand.vertices, stand.faces, TABLE))
        self._handles.append(_mesh(self._scene, "/mould/body", mould.vertices - [0.0, 0.0, 2e-4], mould.faces, STEEL))
        self.paint = Paint(canvas=canvas, tool=tool)
        self._mesh = Glb(canvas.vertices, canvas.surface.normals, canvas.faces)
        self._glb = self._scene.add_glb("/mould/surface", self._mesh.paint(self.paint.colours()))
        self._handles.append(self._glb)

    def repaint(self) -> None:
        """Show what was taken off since the last time."""
        if self.paint is not None and self._mesh is not None:
            self._glb.glb_data = self._mesh.paint(self.paint.colours())

    def plan(self, strokes: Sequence[Stroke], refused_at: Array | None = None, why: str = "") -> None:
        """Draw strokes on the mould, and where a plan was refused, if it was; mould frame [m]."""
        self._drop(self._strokes)
        for number, stroke in enumerate(strokes):
            points = stroke.points + LIFT * stroke.normals
            pairs = np.stack([points[:-1], points[1:]], axis=1)
            self._strokes.append(
                self._scene.add_line_segments(
                    f"/mould/strokes/{number}", pairs, PATH if refused_at is None else DONE, thickness=3e-4
                )
            )
        if refused_at is not None:
            self._strokes.append(
                self._scene.add_icosphere("/mould/strokes/refused", 4e-3, REFUSED, position=tuple(refused_at))
            )
            self._strokes.append(
                self._scene.add_label(
                    "/mould/strokes/why", why, position=(refused_at[0], refused_at[1], refused_at[2] + 0.02)
                )
            )

    def show_plan(self, visible: bool) -> None:
        """Strokes can be hidden, to see what is below them."""
        for handle in self._strokes:
            handle.visible = visible

    def clear(self) -> None:
        """Take the mould away."""
        self._drop(self._strokes)
        self._drop(self._handles)
        self.paint, self._mesh, self._glb = None, None, None

    def _hold(self, tool: PolishingTool) -> None:
        """Draw the tool in the hand."""
        across, height = tool.body_radius, 2.0 * tool.body_com
        plate = trimesh.creation.cylinder(1.5 * across, 0.012, sections=40)
        body = trimesh.creation.cylinder(across, height, sections=40)
        body.apply_translation([0.0, 0.0, 0.5 * height])
        tip = trimesh.creation.icosphere(3, tool.tip_radius)
        tip.apply_translation([0.0, 0.0, tool.tip_centre])
        for name, mesh, colour in (("plate", plate, SENSOR), ("body", body, STEEL), ("tip", tip, FELT)):
            _mesh(self._scene, f"/arm/end_effector/{name}", mesh.vertices, mesh.faces, colour)

    @staticmethod
    def _drop(handles: list[Any]) -> None:
        # The parent goes last: it takes its children with it, and a handle may be removed once only.
        for handle in reversed(handles):
            handle.remove()
        handles.clear()


def _standing(mould: Mould) -> Placement:
    return nominal_placement(float(mould.vertices[:, 2].max()))


def _mesh(scene: viser.SceneApi, name: str, vertices: Any, faces: Any, colour: Sequence[float]) -> Any:
    red, green, blue = (round(255.0 * part) for part in colour)
    return scene.add_mesh_simple(
        name, np.asarray(vertices, dtype=np.float32), np.asarray(faces, dtype=np.uint32), color=(red, green, blue)
    )
