"""One program on the simulated arm and on the real arm's driver with the stand-in: only the constructor differs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hardware.standin import StandIn
from scipy.spatial import KDTree

from burnish import Limits, Supervisor
from burnish.control import ComputedTorque, Impedance, OperationalSpace
from burnish.core import Array, JointPosition, JointVelocity, Robot
from burnish.errors import InputError
from burnish.hardware.jaco2 import Jaco2
from burnish.hardware.torque_mode import TorqueSetup
from burnish.model.model import Model
from burnish.model.tool import PolishingTool
from burnish.polish.cellsim import JointFelt, plan_strokes, simulated_job
from burnish.polish.recipe import Recipe
from burnish.runtime.loop import Rig, control
from burnish.sim import arms
from burnish.sim.robot import SimRobot
from burnish.surface import DistanceGrid, Mould
from burnish.trajectory import CubicPose, HoldPose, Sine

SEED = 1
AGREE = 2e-3
"""How far apart the tool may be at any time [m]."""


@dataclass(frozen=True)
class Program:
    """A law and where it leads the arm."""

    law: Callable[[arms.Arm], Any]
    source: Callable[[Any], Any]
    seconds: float

    def run(self, robot: Robot, nominal: arms.Arm, model: Model) -> Array:
        """The tool's path [m], (cycles, 3)."""
        model = model.with_armature(nominal.armature)
        rig = Rig(robot, model, Supervisor(limits=Limits.of(model)))
        path = []
        with robot:
            source = self.source(rig.read())
            for sample in control(rig, source, self.law(nominal), until=lambda arm: arm.t >= self.seconds):
                path.append(sample.arm.p)
        assert not rig.supervisor.tripped, rig.supervisor.event
        return np.array(path)


PROGRAMS = {
    "hold by an impedance": Program(
        law=lambda arm: Impedance(stiffness=(600.0, 30.0), damping=(60.0, 3.0)),
        source=lambda at: HoldPose(),
        seconds=2.0,
    ),
    "move 50 mm in 4 s": Program(
        law=lambda arm: OperationalSpace(kp=400.0, kd=40.0, ki=800.0),
        source=lambda at: CubicPose(p=at.p + [0.03, 0.0, 0.04], R=at.R, duration=4.0),
        seconds=5.0,
    ),
    "swing all joints, as in the second example": Program(
        law=lambda arm: ComputedTorque.at_frequency(10.0, friction=arm.friction),
        source=lambda at: Sine(amplitude=np.deg2rad(10.0), period=8.0),
        seconds=4.0,
    ),
}


@pytest.mark.parametrize("command", [JointPosition(np.zeros(6)), JointVelocity(np.zeros(6))])
def test_the_simulated_arm_says_that_it_has_no_position_mode(command: JointPosition | JointVelocity) -> None:
    with SimRobot() as robot, pytest.raises(InputError, match="takes a Torque; it has no position mode for Joint"):
        robot.write(command)


@pytest.mark.parametrize("name", PROGRAMS)
def test_the_tool_goes_the_same_way_on_both_robots(standin: StandIn, jaco2: Callable[..., Jaco2], name: str) -> None:
    arm, model = arms.honest(SEED), Model.jaco2()
    standin.reset(seed=SEED)
    paths = [
        PROGRAMS[name].run(robot, arm, model)
        for robot in (SimRobot(rate=100.0, plant=arm.plant), jaco2(torque=TorqueSetup.thesis_a()))
    ]
    assert len(paths[0]) == pytest.approx(len(paths[1]), abs=25)
    # The simulated arm's clock is 5 % uncertain, cycle by cycle; compared is the place after the same number of cycles.
    n = min(map(len, paths))
    apart = np.linalg.norm(paths[0][:n] - paths[1][:n], axis=1)
    print(f"{name}: {1e3 * apart.max():.2f} mm apart at most, {1e3 * np.sqrt(np.mean(apart**2)):.2f} mm RMS")
    assert apart.max() <= AGREE


def small_plate(path: Path) -> Path:
    """A plate of 30 × 30 × 10 mm as an ASCII STL file."""
    x, h = 15.0, 10.0
    p = [(-x, -x, 0), (x, -x, 0), (x, x, 0), (-x, x, 0), (-x, -x, h), (x, -x, h), (x, x, h), (-x, x, h)]
    quads = [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex {} {} {}\n".format(*p[k]) for k in triangle)
        + "endloop\nendfacet\n"
        for a, b, c, d in quads
        for triangle in ((a, b, c), (a, c, d))
    )
    path.write_text(f"solid plate\n{facets}endsolid plate\n")
    return path


@pytest.mark.slow
def test_a_polishing_job_goes_the_same_way_on_both_robots(
    standin: StandIn, jaco2: Callable[..., Jaco2], tmp_path: Path
) -> None:
    arm, tool, recipe = arms.honest(SEED), PolishingTool(), Recipe(force=8.0, feed=0.02)
    plate = small_plate(tmp_path / "plate.stl")
    mould = Mould.load(str(plate))
    grid = DistanceGrid.of(mould)
    strokes = plan_strokes(mould, grid, recipe, tool)[:1]
    top = max(float(stroke.points[:, 2].max()) for stroke in strokes)
    standin.reset(seed=SEED, mould=str(plate), mould_top=top)
    paths, phases = [], []
    for real in (False, True):
        phases.append([])
        felt, on_phase = JointFelt(), phases[-1].append
        job, _ = simulated_job(grid, strokes, arm, rate=100.0, felt=felt, tool=tool, on_phase=on_phase)
        if real:
            model = tool.on(Model.jaco2()).with_armature(arm.armature)
            job.rig.robot = jaco2(model=model, torque=TorqueSetup.thesis_a())
        with job.rig.robot:
            paths.append(np.array([sample.arm.p for sample in job.run()]))
        assert not job.rig.supervisor.tripped, job.rig.supervisor.event
    assert phases[0] == phases[1]
    # A touch comes a few cycles earlier here or there: what is compared is where the tool went, not when.
    apart = max(KDTree(path).query(other)[0].max() for path, other in (paths, paths[::-1]))
    print(f"polish: {1e3 * apart:.2f} mm apart at most, {len(paths[0]) / 100:.0f} s")
    assert apart <= AGREE
