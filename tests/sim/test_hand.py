from __future__ import annotations

from dataclasses import dataclass, replace

import mujoco
import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.control.operational import OperationalSpace
from burnish.core import Array, State
from burnish.errors import InputError
from burnish.model.ik import inverse_kinematics
from burnish.model.model import Model
from burnish.model.tool import PolishingTool
from burnish.polish.cell import READY, tool_down
from burnish.runtime.limits import Limits
from burnish.runtime.loop import Rig, control
from burnish.runtime.supervisor import Supervisor
from burnish.sim import arms
from burnish.sim.hand import CLOSED, Hand
from burnish.sim.plant import Plant
from burnish.sim.robot import SimRobot
from burnish.sim.scene import build
from burnish.sim.things import Box, Cylinder, Table
from burnish.trajectory import CubicPose, HoldPose

HONEST = arms.honest(1)
MODEL = Model.jaco2().with_armature(HONEST.armature)
DOWN = tool_down(MODEL)
HALF = 0.045
"""Half the height of the things that are gripped [m]."""
PLACE = np.array([0.0, -0.40, HALF])
GRIPPED = np.array([0.0, 0.0, 0.01])
"""From the middle of a thing to the tool point that holds it [m]."""
START = inverse_kinematics(MODEL, PLACE + GRIPPED, DOWN, READY)
UPRIGHT = DOWN @ np.diag([1.0, -1.0, -1.0])
BOX = Box(name="box", size=np.array([0.05, 0.05, 2 * HALF]), mass=0.3, p=PLACE, R=UPRIGHT)
CAN = Cylinder(name="box", size=np.array([0.05, 2 * HALF]), mass=0.3, p=PLACE)
VENDORS_TIME, VENDORS_GRIP = 1.2, 25.0


@dataclass
class Cell:
    """The honest arm around a thing on the table, under a law that keeps its pose."""

    robot: SimRobot
    rig: Rig
    law: OperationalSpace

    @classmethod
    def of(cls, thing: Box | Cylinder = BOX, hand: Hand | None = None, plant: Plant = HONEST.plant) -> Cell:
        robot = SimRobot(START, rate=100.0, plant=plant, hand=hand or Hand(), things=[Table(), thing])
        rig = Rig(robot, MODEL, Supervisor(limits=Limits.of(MODEL)))
        return cls(robot, rig, OperationalSpace.at_frequency(15.0, ki=600.0, friction=HONEST.friction))

    def drive(self, source: CubicPose | HoldPose, seconds: float) -> None:
        end = self.robot.time + seconds
        for _ in control(self.rig, source, self.law, until=lambda arm: arm.t >= end):
            pass
        assert not self.rig.supervisor.tripped, self.rig.supervisor.event

    def close(self) -> None:
        self.robot.move_fingers(np.full(3, CLOSED))
        self.drive(HoldPose(), 1.2)

    def lift(self, by: float = 0.06) -> None:
        self.drive(CubicPose(p=PLACE + GRIPPED + [0.0, 0.0, by], R=DOWN, duration=1.0), 1.2)

    def held_at(self) -> Array:
        """The thing's place as the tool sees it [m], (3,)."""
        assert self.rig.arm is not None
        return self.rig.arm.R.T @ (self.robot.truth_pose("box")[0] - self.rig.arm.p)


def moved(robot: SimRobot, wanted: Array, seconds: float) -> Array:
    """Angles of the fingers at every cycle on the way to where they are sent, of an arm that nobody holds."""
    robot.read()
    robot.move_fingers(wanted)
    return np.array([(robot.read(), robot.fingers())[1] for _ in range(round(seconds / robot.period))])


# The hand is the model's.


def test_arm_with_open_fingers_has_mass_matrix_and_gravity_of_the_model() -> None:
    model = build(None, Plant.ideal(), None, Hand()).model
    data = mujoco.MjData(model)
    rng, M = np.random.default_rng(0), np.zeros((model.nv, model.nv))
    for q in rng.uniform(-np.pi, np.pi, (20, 6)):
        data.qpos[:6] = q
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, M)
        arm = Model.jaco2().at(State(t=0.0, q=q, dq=np.zeros(6)))
        # What rounding in the tables of the parts leaves; the largest entries are 1.2 kg·m² and 18 N·m.
        assert_allclose(M[:6, :6], arm.M, rtol=0.0, atol=5e-8)
        assert_allclose(data.qfrc_bias[:6], arm.g, rtol=0.0, atol=5e-8)


def test_springs_hold_the_tips_straight_against_their_stops() -> None:
    model = build(None, Plant.ideal(), None, Hand()).model
    model.opt.gravity = 0.0
    data = mujoco.MjData(model)
    data.qpos[7::2] = 0.3  # the tips; the fingers are before them
    for _ in range(1000):
        mujoco.mj_step(model, data)
    assert_allclose(data.qpos[6:], 0.0, atol=1e-3)


def test_a_drawn_hand_is_heavier_with_all_its_fingers() -> None:
    plant = replace(Plant.ideal(), mass_scale=np.array([1.0] * 5 + [1.1, 1.0]))
    bare, drawn = (build(None, p, None, Hand()).model for p in (Plant.ideal(), plant))
    link = bare.body("link_6").id
    assert_allclose(drawn.body_subtreemass[link] / bare.body_subtreemass[link], 1.1, rtol=1e-12)


# The fingers move.


def test_fingers_close_in_the_time_that_the_vendor_says() -> None:
    angles = moved(SimRobot(rate=100.0, hand=Hand()), np.full(3, CLOSED), 1.5)
    last = np.argmax(angles.min(axis=1) > CLOSED - 1e-3)
    assert abs(0.01 * (last + 1) - VENDORS_TIME) <= 0.03
    assert np.abs(np.diff(angles, axis=0)).max() <= 0.01 * CLOSED / VENDORS_TIME + 1e-9


def test_fingers_go_where_they_are_sent_each_by_itself_and_not_beyond_their_ends() -> None:
    angles = moved(SimRobot(rate=100.0, hand=Hand()), np.array([-1.0, 0.5, 9.0]), 1.5)
    assert_allclose(angles[-1], [0.0, 0.5, CLOSED], atol=1e-6)
    assert angles.min() >= -1e-6
    assert angles.max() <= CLOSED + 1e-6


def test_fingers_that_are_not_sent_anywhere_stay_open() -> None:
    robot = SimRobot(rate=100.0, hand=Hand())
    for _ in range(30):
        robot.read()
    assert_allclose(robot.fingers(), 0.0, atol=1e-9)
    assert_allclose(robot.truth_grip(), 0.0, atol=0.0)


# They grip.


@pytest.fixture(scope="module")
def lifted() -> Cell:
    """The box, gripped and lifted."""
    cell = Cell.of()
    cell.close()
    cell.lift()
    return cell


def test_thumb_presses_as_hard_as_the_vendor_says() -> None:
    cell = Cell.of()
    cell.close()
    # A fifth: the vendor's figure is round, and the box may touch the pads higher or lower.
    assert abs(cell.robot.truth_grip()[0] - VENDORS_GRIP) <= 0.2 * VENDORS_GRIP


def test_thumb_bears_what_the_two_fingers_press(lifted: Cell) -> None:
    thumb, *fingers = lifted.robot.truth_grip()
    assert_allclose(thumb, sum(fingers), rtol=0.05)


def test_a_drive_that_has_stalled_does_not_press_harder_and_harder() -> None:
    cell = Cell.of()
    cell.close()
    before = cell.robot.truth_grip()[0]
    cell.lift()
    cell.drive(HoldPose(), 3.0)
    assert cell.robot.truth_grip()[0] < 1.2 * before


def test_fingers_stop_at_what_they_hold(lifted: Cell) -> None:
    assert np.all(lifted.robot.fingers() < np.deg2rad(70.0))


@pytest.mark.parametrize("thing", [BOX, CAN], ids=lambda thing: type(thing).__name__)
def test_what_is_held_goes_where_the_hand_goes(thing: Box | Cylinder) -> None:
    cell = Cell.of(thing)
    cell.close()
    before = cell.held_at()
    cell.lift()
    assert cell.robot.truth_pose("box")[0][2] > HALF + 0.055
    assert np.linalg.norm(cell.held_at() - before) < 2e-3


def test_torque_sensors_feel_the_weight_of_what_is_held_and_not_the_friction_before_them() -> None:
    # Without offset and noise; the arm rests where stiction lets it.
    plant = replace(Plant.ideal(), friction=HONEST.friction, armature=HONEST.armature)
    cell = Cell.of(plant=plant)
    cell.close()
    cell.lift()
    cell.drive(HoldPose(), 0.5)
    arm, state = cell.rig.arm, cell.rig.state
    assert arm is not None
    assert state is not None
    com = cell.held_at()
    weight = MODEL.with_payload(BOX.mass, com).at(state).g - arm.g
    assert np.abs(weight).max() > 0.5
    assert_allclose(state.tau - arm.g, weight, atol=0.1)


@pytest.mark.parametrize(("mass", "held"), [(0.3, True), (1.2, False)])
def test_what_is_too_heavy_for_slippery_pads_stays_behind(mass: float, held: bool) -> None:
    # Three pads at µ = 0.15 carry about 0.15 · 2 · 24 N = 7 N, which is 0.7 kg.
    cell = Cell.of(replace(BOX, mass=mass), Hand(friction=0.15))
    cell.close()
    cell.lift()
    risen = cell.robot.truth_pose("box")[0][2] - HALF
    assert (risen > 0.05) == held
    assert (risen < 0.02) == (not held)


def test_what_is_let_go_falls_on_the_table_and_stays_there(lifted: Cell) -> None:
    lifted.robot.move_fingers(np.zeros(3))
    lifted.drive(HoldPose(), 1.2)
    assert_allclose(lifted.robot.truth_pose("box")[0][2], HALF, atol=1e-3)
    assert_allclose(lifted.robot.truth_grip(), 0.0, atol=0.0)


# What cannot be is refused.


@pytest.mark.parametrize(
    ("cell", "said"),
    [
        ({"hand": Hand(), "tool": PolishingTool()}, "polishing tool and a moving hand"),
        ({"things": [BOX]}, "things without a hand"),
        ({"hand": Hand(), "things": [BOX, CAN]}, "called box"),
        ({"hand": Hand(), "things": [Table(), Table(height=0.1)]}, "called table"),
    ],
)
def test_a_cell_that_cannot_be_is_refused(cell: dict[str, object], said: str) -> None:
    with pytest.raises(InputError, match=said):
        SimRobot(**cell)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "wrong",
    [{"size": np.zeros(3)}, {"size": np.ones(2)}, {"mass": 0.0}, {"friction": -0.1}, {"R": 2 * np.eye(3)}]
    + [{"p": np.array([0.0, np.nan, 0.0])}, {"R": np.diag([1.0, 1.0, -1.0])}, {"mass": np.inf}],
    ids=lambda wrong: next(iter(wrong)),
)
def test_a_thing_that_cannot_be_is_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(InputError, match="Box 'box'"):
        replace(BOX, **wrong)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["speed", "torque", "friction"])
def test_a_hand_that_cannot_be_is_refused(name: str) -> None:
    with pytest.raises(InputError, match=name):
        Hand(**{name: 0.0})


@pytest.mark.parametrize("angles", [[0.1, 0.2], 0.3, [0.0, np.nan, 0.0]])
def test_angles_that_are_not_three_numbers_are_refused_and_change_nothing(angles: object) -> None:
    robot = SimRobot(rate=100.0, hand=Hand())
    with pytest.raises(InputError, match="three angles"):
        robot.move_fingers(angles)  # type: ignore[arg-type]
    robot.read()
    robot.read()
    assert_allclose(robot.fingers(), 0.0, atol=1e-9)


def test_an_arm_without_a_moving_hand_says_so() -> None:
    robot = SimRobot()
    for ask in (robot.fingers, lambda: robot.move_fingers(np.zeros(3)), robot.truth_grip):
        with pytest.raises(InputError, match=r"Hand\(\)"):
            ask()


def test_a_thing_that_is_not_there_is_named_with_those_that_are() -> None:
    robot = SimRobot(hand=Hand(), things=[Table(), BOX])
    with pytest.raises(InputError, match="'cup'; there are: box"):
        robot.truth_pose("cup")
