"""One program on the simulated arm and, with stand-ins, on both drivers of the real one: the constructor differs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from runpy import run_path
from typing import Any

import numpy as np
import pytest
from hardware.standin import StandIn
from scipy.spatial import KDTree

from burnish import Limits, Supervisor
from burnish.control import ComputedTorque, Impedance, OperationalSpace
from burnish.core import Array, Dynamics, JointPosition, JointVelocity, Robot, ToolReference
from burnish.errors import InputError
from burnish.hardware.jaco2 import Jaco2
from burnish.hardware.ros1 import RosJaco2
from burnish.hardware.ros1_torque import RosTorqueSetup
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
from burnish.trajectory.move import minimum_jerk

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "02_impedance.py"
SEED = 1
AGREE = 2e-3
"""How far apart the tool may be at any time [m]."""
FAITHFUL = 4e-3
"""How far from what was taught the plain replay of this file may lead the tool, gear friction included [m]."""


@dataclass(frozen=True)
class Program:
    """A law and where it leads the arm."""

    law: Callable[[arms.Arm], Any]
    source: Callable[[Any], Any]
    seconds: float

    def run(self, robot: Robot, nominal: arms.Arm, model: Model) -> tuple[Array, Array]:
        """Times [s], (cycles,), and the tool's path [m], (cycles, 3)."""
        model = model.with_armature(nominal.armature)
        rig = Rig(robot, model, Supervisor(limits=Limits.of(model)))
        times, path = [], []
        with robot:
            source = self.source(rig.read())
            for sample in control(rig, source, self.law(nominal), until=lambda arm: arm.t >= self.seconds):
                times.append(sample.arm.t)
                path.append(sample.arm.p)
        assert not rig.supervisor.tripped, rig.supervisor.event
        return np.array(times), np.array(path)


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


@pytest.fixture(params=["Jaco2", pytest.param("RosJaco2", marks=pytest.mark.slow)])
def real(request: pytest.FixtureRequest, standin: StandIn) -> Callable[..., Robot]:
    """Makes a driver of the real arm in torque mode, with a new stand-in of the same drawn arm behind it."""
    name = request.param
    make = request.getfixturevalue("jaco2" if name == "Jaco2" else "ros_jaco2")
    setup = TorqueSetup.thesis_a() if name == "Jaco2" else RosTorqueSetup()

    def new(**options: Any) -> Robot:
        model = options.pop("model", Model.jaco2())
        standin.reset(seed=SEED, **options)
        return make(model=model, torque=setup)  # type: ignore[no-any-return]

    return new


def simulated() -> SimRobot:
    """The same drawn arm in simulation."""
    return SimRobot(rate=100.0, plant=arms.honest(SEED).plant)


def furthest_apart(name: str, one: tuple[Array, Array], other: tuple[Array, Array]) -> float:
    """How far apart the tool was at the same time by each robot's own clock [m]; of each: times and path."""
    times = np.arange(0.0, min(one[0][-1], other[0][-1]), 0.01)
    assert times[-1] > max(one[0][-1], other[0][-1]) - 0.1
    places = [np.array([np.interp(times, t, x) for x in p.T]).T for t, p in (one, other)]
    apart = np.linalg.norm(places[0] - places[1], axis=1)
    print(f"{name}: {1e3 * apart.max():.2f} mm apart at most, {1e3 * np.sqrt(np.mean(apart**2)):.2f} mm RMS")
    return float(apart.max())


@pytest.mark.parametrize("name", PROGRAMS)
def test_the_tool_goes_the_same_way_on_both_robots(real: Callable[..., Robot], name: str) -> None:
    arm, model = arms.honest(SEED), Model.jaco2()
    paths = [PROGRAMS[name].run(robot, arm, model) for robot in (simulated(), real())]
    assert furthest_apart(name, *paths) <= AGREE


def test_the_example_goes_the_same_way_on_both_robots(real: Callable[..., Robot]) -> None:
    example = run_path(str(EXAMPLE))
    model = Model.jaco2().with_armature(arms.honest(SEED).armature)
    paths = [example["lift"](robot, model)[:2] for robot in (simulated(), real())]
    assert np.ptp(paths[0][1][:, 2]) > 0.03
    assert furthest_apart("examples/02_impedance.py", *paths) <= AGREE


def test_the_example_makes_the_robot_that_the_command_line_names() -> None:
    example = run_path(str(EXAMPLE))
    made = [type(example["chosen"](words, Model.jaco2())) for words in ([], ["jaco2", "PJ1"], ["ros", "j2n6s300"])]
    assert made == [SimRobot, Jaco2, RosJaco2]


@dataclass
class Operator:
    """A hand that leads the tool on a figure of eight, and stays where it ends."""

    seconds: float = 4.0

    def reset(self, arm: Dynamics) -> None:
        self.p, self.R, self.t = arm.p, arm.R, arm.t

    def at(self, arm: Dynamics) -> ToolReference:
        s, ds, dds = minimum_jerk((arm.t - self.t) / self.seconds, self.seconds)
        w = 2.0 * np.pi
        shape = np.array([0.02 * np.sin(w * s), 0.01 * np.sin(2.0 * w * s), 0.0])
        slope = np.array([0.02 * w * np.cos(w * s), 0.02 * w * np.cos(2.0 * w * s), 0.0])
        bend = np.array([-0.02 * w**2 * np.sin(w * s), -0.04 * w**2 * np.sin(2.0 * w * s), 0.0])
        rest = np.zeros(3)
        v, a = np.concatenate([slope * ds, rest]), np.concatenate([slope * dds + bend * ds**2, rest])
        return ToolReference(p=self.p + shape, R=self.R, v=v, a=a)


@dataclass
class Replay:
    """Recorded tool poses, at the times at which they were recorded; still at both ends."""

    times: Array
    p: Array
    R: Array

    def reset(self, arm: Dynamics) -> None:
        self.t = arm.t

    def at(self, arm: Dynamics) -> ToolReference:
        t = arm.t - self.t + self.times[0]
        p, before = (np.array([np.interp(at, self.times, x) for x in self.p.T]) for at in (t, t - 0.02))
        # The poses are measured: their slope over two cycles is quiet enough.
        v = np.concatenate([(p - before) / 0.02, np.zeros(3)])
        return ToolReference(p=p, R=self.R, v=v, a=np.zeros(6))


def teach(robot: Robot) -> tuple[Array, Array, Array, Array]:
    """Hold at home, be led, record; go home, play back. Times [s], path of the tool, as led, as played back [m]."""
    model = Model.jaco2().with_armature(arms.honest(SEED).armature)
    rig = Rig(robot, model, Supervisor(limits=Limits.of(model)))
    law = OperationalSpace(kp=400.0, kd=40.0, ki=800.0)
    times: list[float] = []
    path: list[Array] = []

    def run(source: Any, seconds: float) -> slice:
        first = len(times)
        end = rig.arm.t + seconds  # type: ignore[union-attr]
        for sample in control(rig, source, law, until=lambda at: at.t >= end):
            times.append(sample.arm.t)
            path.append(sample.arm.p)
        return slice(first, len(times))

    with robot:
        home = rig.read()
        run(HoldPose(), 0.5)
        led = run(Operator(), 4.5)
        run(CubicPose(p=home.p, R=home.R, duration=1.0), 1.5)
        played = run(Replay(np.array(times[led]), np.array(path[led]), home.R), 4.5)
    assert not rig.supervisor.tripped, rig.supervisor.event
    tool = np.array(path)
    return np.array(times), tool, tool[led], tool[played]


def test_what_was_taught_is_played_back_the_same_way_on_both_robots(real: Callable[..., Robot]) -> None:
    (*path, led, played), (*other, _, _) = [teach(robot) for robot in (simulated(), real())]
    assert np.ptp(led[:, 0]) > 0.03
    assert KDTree(led).query(played)[0].max() <= FAITHFUL
    assert furthest_apart("teach and replay", tuple(path), tuple(other)) <= AGREE  # type: ignore[arg-type]


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
def test_a_polishing_job_goes_the_same_way_on_both_robots(real: Callable[..., Robot], tmp_path: Path) -> None:
    arm, tool, recipe = arms.honest(SEED), PolishingTool(), Recipe(force=8.0, feed=0.02)
    plate = small_plate(tmp_path / "plate.stl")
    mould = Mould.load(str(plate))
    grid = DistanceGrid.of(mould)
    strokes = plan_strokes(mould, grid, recipe, tool)[:1]
    top = max(float(stroke.points[:, 2].max()) for stroke in strokes)
    paths, phases = [], []
    for on_stand_in in (False, True):
        phases.append([])
        felt, on_phase = JointFelt(), phases[-1].append
        job, _ = simulated_job(grid, strokes, arm, rate=100.0, felt=felt, tool=tool, on_phase=on_phase)
        if on_stand_in:
            model = tool.on(Model.jaco2()).with_armature(arm.armature)
            job.rig.robot = real(model=model, mould=str(plate), mould_top=top)
        with job.rig.robot:
            paths.append(np.array([sample.arm.p for sample in job.run()]))
        assert not job.rig.supervisor.tripped, job.rig.supervisor.event
    assert phases[0] == phases[1]
    # A touch comes a few cycles earlier here or there: what is compared is where the tool went, not when.
    apart = max(KDTree(path).query(other)[0].max() for path, other in (paths, paths[::-1]))
    print(f"polish: {1e3 * apart:.2f} mm apart at most, {len(paths[0]) / 100:.0f} s")
    assert apart <= AGREE
