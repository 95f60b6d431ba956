"""What the engine's viewer is given to show: the whole arm, where it is; and the window on a display."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import mujoco
import numpy as np
import pytest
from PIL import ImageGrab

from burnish.errors import InputError
from burnish.model.looks import looks as triangles
from burnish.model.model import Model
from burnish.model.tool import PolishingTool
from burnish.sim.hand import Hand
from burnish.sim.robot import HOME, SimRobot
from burnish.sim.window import Window, draw, looks

PATIENCE = 60.0


def drawn(robot: SimRobot, tool: PolishingTool | None = None) -> mujoco.MjvScene:
    scene = mujoco.MjvScene(robot._model, 1000)
    draw(scene, robot._model, robot._data, looks(robot, tool))
    return scene


def middles(scene: mujoco.MjvScene) -> np.ndarray:
    return np.array([scene.geoms[i].pos for i in range(scene.ngeom)])


def test_every_shape_of_the_description_is_drawn_where_the_model_has_its_link() -> None:
    # The picture of the report takes the same file apart in a way of its own.
    poses = Model.jaco2().link_poses(HOME)
    expected = []
    for look in triangles():
        middle = 0.5 * (look.vertices.min(axis=0) + look.vertices.max(axis=0))
        expected.append(poses[look.link][:3, :3] @ middle + poses[look.link][:3, 3])
    found = middles(drawn(SimRobot()))
    assert len(found) == len(expected)
    apart = np.linalg.norm(found[:, None] - np.array(expected)[None], axis=2)
    # Single precision, and the extent of a shape that is turned askew.
    assert apart.min(axis=1).max() < 1e-3


def test_a_tool_is_drawn_with_its_tip_where_the_arm_has_it() -> None:
    tool = PolishingTool()
    robot = SimRobot(tool=tool)
    scene = drawn(robot, tool)
    assert scene.ngeom == drawn(SimRobot()).ngeom + 2
    pose = Model.jaco2().link_poses(HOME)["end_effector"]
    assert middles(scene)[-1] == pytest.approx(pose[:3, 3] + tool.tip_centre * pose[:3, 2], abs=1e-6)


def test_a_hand_that_moves_is_not_drawn_twice() -> None:
    robot = SimRobot(hand=Hand())
    own, hand = (sum(look.body == "link_6" for look in looks(arm)) for arm in (SimRobot(), robot))
    # What joins the hand to the wrist stays; palm and fingers are in the scene.
    assert 0 < hand < own - 6
    assert robot._model.ngeom == 7
    assert drawn(robot).ngeom > 15


def test_without_a_display_a_window_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(InputError, match="needs a display"):
        Window(SimRobot())


@pytest.fixture
def display() -> Iterator[str]:
    """A display that nobody looks at."""
    server = shutil.which("Xvfb")
    if server is None:
        why = "no display to open a window on (apt: xvfb libgl1 libgl1-mesa-dri)"
        pytest.fail(why) if os.environ.get("CI") else pytest.skip(why)
    read, write = os.pipe()
    words = [server, "-displayfd", str(write), "-screen", "0", "640x480x24", "-nolisten", "tcp"]
    with subprocess.Popen(words, pass_fds=[write], stderr=subprocess.DEVNULL) as process:
        os.close(write)
        with os.fdopen(read) as answer:
            number = answer.readline().strip()
        assert number, "Xvfb did not start"
        try:
            yield f":{number}"
        finally:
            process.terminate()


@pytest.mark.slow
@pytest.mark.parametrize("mould", [[], ["--mould", "plate"]], ids=["hand", "tool"])
def test_teleop_shows_the_arm_in_a_window_and_closes_it(mould: list[str], display: str, tmp_path: Path) -> None:
    script = tmp_path / "script.txt"
    script.write_text("t,x,y,z,turn_x,turn_y,turn_z,buttons\n0,0,0,0,0,0,0,00\n600,0,0,0,0,0,0,00\n")
    words = ["-m", "burnish", "teleop", "--view", "--device", str(script), *mould, "--out", str(tmp_path / "out")]
    environment = os.environ | {"DISPLAY": display}
    with subprocess.Popen([sys.executable, *words], env=environment, stdout=subprocess.DEVNULL) as program:
        deadline = time.monotonic() + PATIENCE
        seen = 0
        while seen < 2000:
            assert time.monotonic() < deadline, f"{seen} pixels were not of the background"
            assert program.poll() is None
            time.sleep(0.2)
            picture = np.asarray(ImageGrab.grab(xdisplay=display).convert("L"))
            seen = int((picture > 20).sum())
        program.terminate()
        assert program.wait(PATIENCE) == 130
