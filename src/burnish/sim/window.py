"""MuJoCo's viewer beside a simulated arm that somebody else drives."""

from __future__ import annotations

import os
import time
from typing import Any

from typing_extensions import Self

from burnish.errors import InputError
from burnish.sim.robot import SimRobot

REFRESH = 1.0 / 30.0
"""Time between two pictures [s]."""


class Window:
    """The engine's passive viewer: it shows arm and tool, and changes nothing. A mould is no body of its scene."""

    def __init__(self, robot: SimRobot) -> None:
        """Refuse at once where nothing can be shown.

        Raises:
            InputError: if there is no display.
        """
        if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
            raise InputError("--view needs a display, and there is none here (DISPLAY is not set); leave it out")
        self._robot, self._next = robot, 0.0
        self._viewer: Any = None

    def __enter__(self) -> Self:
        # It brings a window system with it, so it is loaded by those who want one.
        import mujoco.viewer

        self._viewer = mujoco.viewer.launch_passive(
            self._robot._model, self._robot._data, show_left_ui=False, show_right_ui=False
        )
        return self

    def __exit__(self, *exception: object) -> None:
        self._viewer.close()

    def update(self) -> None:
        """Show the arm as it is now, at most 30 times a second; cheap enough for every control cycle."""
        now = time.monotonic()
        if now >= self._next and self._viewer.is_running():
            self._next = now + REFRESH
            self._viewer.sync()
