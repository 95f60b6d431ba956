"""Draw docs/images/hand.png: the arm of examples/11_pick_and_place.py with the box lifted, its target on the table.

python scripts/plot_hand.py
"""

from __future__ import annotations

import argparse
from pathlib import Path
from runpy import run_path

import mujoco
import numpy as np
import trimesh
from numpy.typing import ArrayLike

from burnish import CubicPose, HoldPose, Limits, Model, Rig, SimRobot, Supervisor, control
from burnish.analysis.render import Camera
from burnish.analysis.scene import Scene
from burnish.analysis.shape import CARBON, Shape
from burnish.control import OperationalSpace
from burnish.core import Source, ToolReference
from burnish.model.ik import inverse_kinematics
from burnish.polish.cell import READY, tool_down
from burnish.sim import arms
from burnish.sim.hand import Hand
from burnish.sim.things import Box, Table
from burnish.sim.window import looks

ROOT = Path(__file__).resolve().parents[1]
WIDTH, HEIGHT = 1000, 640
TABLE, MARK, BOX = (0.86, 0.85, 0.82), (0.12, 0.45, 0.70), (0.85, 0.42, 0.10)
EYE = np.eye(3)
KINDS = {int(getattr(mujoco.mjtGeom, f"mjGEOM_{name}")) for name in ("BOX", "CAPSULE", "CYLINDER")}
"""What of the engine's scene is drawn: the plane of the table is drawn as a plate."""


def lifted() -> tuple[SimRobot, np.ndarray]:
    """The simulated arm with the example's box 100 mm above its table, and where it is to be put down [m]."""
    example = run_path(str(ROOT / "examples" / "11_pick_and_place.py"))
    start, grip, up = example["BOX"], example["GRIPPED"], example["UP"]
    arm = arms.honest(seed=1)
    model = Model.jaco2().with_armature(arm.armature)
    R = tool_down(model)
    size = np.array([0.05, 0.05, 0.09])
    box = Box(name="box", size=size, mass=0.3, p=start, R=R @ np.diag([1.0, -1.0, -1.0]))
    q = inverse_kinematics(model, start + grip, R, READY)
    robot = SimRobot(q, rate=arm.rate, plant=arm.plant, hand=Hand(), things=[Table(), box])
    rig = Rig(robot, model, Supervisor(limits=Limits.of(model)))
    law = OperationalSpace.at_frequency(15.0, ki=600.0, friction=arm.friction)

    def drive(source: Source[ToolReference], seconds: float) -> None:
        end = robot.time + seconds
        for _ in control(rig, source, law, until=lambda now: now.t >= end):
            pass

    with robot:
        robot.move_fingers(example["SHUT"])
        drive(HoldPose(), 1.3)
        drive(CubicPose(p=start + grip + up, R=R, duration=1.5), 1.8)
    return robot, example["TARGET"]


def shapes(robot: SimRobot, target: np.ndarray) -> list[Shape]:
    """Links, hand, box, table and target, in base axes."""
    model, data = robot._model, robot._data
    found = [solid(TABLE, trimesh.creation.box([1.1, 1.1, 0.03]), [0.1, -0.25, -0.015])]
    found.append(solid(MARK, trimesh.creation.box([0.05, 0.05, 1e-3]), [*target[:2], 5e-4]))
    for look in looks(robot):
        body = model.body(look.body).id
        R = data.xmat[body].reshape(3, 3)
        found.append(solid(look.colour[:3], mesh(look.kind, look.size), data.xpos[body] + R @ look.p, R @ look.R))
    for i in range(model.ngeom):
        kind = int(model.geom_type[i])
        if kind in KINDS:
            colour = BOX if kind == mujoco.mjtGeom.mjGEOM_BOX else CARBON
            found.append(solid(colour, mesh(kind, model.geom_size[i]), data.geom_xpos[i], data.geom_xmat[i]))
    return found


def mesh(kind: int, size: np.ndarray) -> trimesh.Trimesh:
    """The engine's shape as triangles."""
    a, b, c = size.tolist()
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        return trimesh.creation.box([2.0 * a, 2.0 * b, 2.0 * c])
    if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
        return trimesh.creation.icosphere(3, a)
    make = trimesh.creation.capsule if kind == mujoco.mjtGeom.mjGEOM_CAPSULE else trimesh.creation.cylinder
    return make(radius=a, height=2.0 * b)


def solid(colour: ArrayLike, body: trimesh.Trimesh, p: ArrayLike, R: ArrayLike = EYE) -> Shape:
    """A mesh where it is, about its middle."""
    middle = body.bounds.mean(axis=0)
    vertices = (body.vertices - middle) @ np.reshape(R, (3, 3)).T + np.asarray(p)
    return Shape(name="scene", vertices=vertices, faces=body.faces, colour=np.array(colour))


def main() -> None:
    """Draw it, and write it as a PNG file."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    default = ROOT / "docs" / "images" / "hand.png"
    parser.add_argument("--out", type=Path, default=default, help="the picture (default: docs/images/hand.png)")
    options = parser.parse_args()
    camera = Camera(eye=np.array([-0.45, -1.15, 0.5]), target=np.array([0.02, -0.25, 0.2]))
    scene = Scene(shapes=tuple(shapes(*lifted())), camera=camera)
    options.out.write_bytes(scene.still(WIDTH, HEIGHT))


if __name__ == "__main__":
    main()
