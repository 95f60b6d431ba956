"""MuJoCo's viewer beside a simulated arm that somebody else drives."""

from __future__ import annotations

import os
import threading
import time
from typing import Any, NamedTuple

import mujoco
import numpy as np
from typing_extensions import Self

from burnish.core import Array
from burnish.errors import InputError
from burnish.model.model import JACO2_URDF
from burnish.model.tool import PolishingTool
from burnish.sim.hand import PALM
from burnish.sim.robot import SimRobot

REFRESH = 1.0 / 30.0
"""Time between two pictures [s]."""
CLOSING = 5.0
"""Time that the viewer's thread gets to close its window [s]; an interpreter that ends under it would crash."""
SEEN_FROM = 1.6, 40.0, -15.0
"""At first: distance from the middle of the arm [m], the direction about z and the height above it [deg]."""
LAST_LINK = "link_6"
"""The link whose looks have the palm and the open fingers of the description."""
OFF_AXIS = 5e-3
"""What is further from that link's axis is a part of a finger [m]."""
STEEL, FELT = (0.75, 0.76, 0.78, 1.0), (0.93, 0.90, 0.82, 1.0)


class Look(NamedTuple):
    """A shape that is drawn, fixed to a body of the arm's scene."""

    body: str
    """Name of the body."""
    kind: int
    """mujoco.mjtGeom."""
    size: Array
    """As the engine has it for that kind [m], (3,)."""
    p: Array
    """Where it is on the body [m], (3,)."""
    R: Array
    """How it is turned, body ← shape, (3, 3)."""
    colour: tuple[float, float, float, float]
    """Red, green, blue, opacity."""


def looks(robot: SimRobot, tool: PolishingTool | None = None) -> list[Look]:
    """What the arm's scene does not hold, because nothing touches it: the links, and a tool.

    A hand that moves has shapes of its own, which touch things; then the open one is left out.
    """
    # The engine drops what is only looked at while it reads a URDF, unless the file itself says otherwise.
    described = JACO2_URDF.read_text().replace("<compiler ", '<compiler discardvisual="false" ', 1)
    model = mujoco.MjSpec.from_string(described).compile()
    has_hand = robot._fingers is not None
    found = []
    for i in range(model.ngeom):
        body = model.body(int(model.geom_bodyid[i])).name
        if not (has_hand and body == LAST_LINK and _of_open_hand(model.geom_pos[i])):
            R = np.zeros(9)
            mujoco.mju_quat2Mat(R, model.geom_quat[i])
            size, p, colour = (np.array(rows[i]) for rows in (model.geom_size, model.geom_pos, model.geom_rgba))
            found.append(Look(body, int(model.geom_type[i]), size, p, R.reshape(3, 3), tuple(colour.tolist())))
    if tool is not None:
        upright, height = np.eye(3), tool.body_com
        cylinder, sphere = int(mujoco.mjtGeom.mjGEOM_CYLINDER), int(mujoco.mjtGeom.mjGEOM_SPHERE)
        body_size, tip_size = np.array([tool.body_radius, height, 0.0]), np.array([tool.tip_radius, 0.0, 0.0])
        found.append(Look("tool", cylinder, body_size, np.array([0.0, 0.0, height]), upright, STEEL))
        found.append(Look("tip", sphere, tip_size, np.zeros(3), upright, FELT))
    return found


def _of_open_hand(p: Array) -> bool:
    """Whether a shape of the last link is of its palm or a finger: all but what is on its axis before the palm."""
    return bool(np.hypot(p[0], p[1]) > OFF_AXIS or p[2] < PALM[0])


def draw(scene: Any, model: Any, data: Any, shapes: list[Look]) -> None:
    """Add shapes to a mujoco.MjvScene, where their bodies are in ``data``."""
    for shape in shapes:
        body = model.body(shape.body).id
        R = data.xmat[body].reshape(3, 3)
        p, turned = data.xpos[body] + R @ shape.p, (R @ shape.R).ravel()
        colour = np.array(shape.colour, dtype=np.float32)
        mujoco.mjv_initGeom(scene.geoms[scene.ngeom], shape.kind, shape.size, p, turned, colour)
        scene.ngeom += 1


class Window:
    """The engine's passive viewer: it shows arm, hand or tool, and changes nothing. A mould is no body of its scene."""

    def __init__(self, robot: SimRobot, tool: PolishingTool | None = None) -> None:
        """Refuse at once where nothing can be shown.

        Raises:
            InputError: if there is no display.
        """
        if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
            raise InputError("--view needs a display, and there is none here (DISPLAY is not set); leave it out")
        self._robot, self._looks, self._next = robot, looks(robot, tool), 0.0
        # A state of its own: whatever somebody pulls in the window, the arm's stays as it is.
        self._shown = mujoco.MjData(robot._model)
        self._viewer: Any = None
        self._threads: set[threading.Thread] = set()

    def __enter__(self) -> Self:
        # It brings a window system with it, so it is loaded by those who want one.
        import mujoco.viewer

        before = set(threading.enumerate())
        self._viewer = mujoco.viewer.launch_passive(
            self._robot._model, self._shown, show_left_ui=False, show_right_ui=False
        )
        self._threads = set(threading.enumerate()) - before
        with self._viewer.lock():
            # By itself the engine looks at the shapes of its scene, and of an arm that touches nothing there are none.
            self._viewer.cam.lookat[:] = self._shown.xpos[1:].mean(axis=0)
            self._viewer.cam.distance, self._viewer.cam.azimuth, self._viewer.cam.elevation = SEEN_FROM
        return self

    def __exit__(self, *exception: object) -> None:
        self._viewer.close()
        for thread in self._threads:
            thread.join(CLOSING)

    def update(self) -> None:
        """Show the arm as it is now, at most 30 times a second; cheap enough for every control cycle."""
        now = time.monotonic()
        if now < self._next or not self._viewer.is_running():
            return
        self._next = now + REFRESH
        with self._viewer.lock():
            self._shown.qpos[:] = self._robot._data.qpos
            mujoco.mj_kinematics(self._robot._model, self._shown)
            self._viewer.user_scn.ngeom = 0
            draw(self._viewer.user_scn, self._robot._model, self._shown, self._looks)
        self._viewer.sync()
