"""References of an operator: frames, speeds, smoothness, leash, and what makes them stand still."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from subprocess import run

import numpy as np
import pytest

from burnish.core import Array, Dynamics, State, ToolReference
from burnish.errors import InputError
from burnish.model.model import Model
from burnish.rotation import exp, log
from burnish.teleop.device import AT_REST, Axes, Reading
from burnish.teleop.limits import BRAKING, OVERSHOT, Bounds, Mobility
from burnish.teleop.modes import Mode, Panel
from burnish.teleop.modes_a import FINGERS, FREE, ModesA
from burnish.teleop.modes_b import BASE, MIXED, TOOL, ModesB
from burnish.teleop.reference import FINGER_SPEED, FINGERS_CLOSED, Leash, Operator, Pace

MODEL = Model.jaco2()
READY = np.array([4.532, 3.254, 1.369, 5.85, 1.492, 1.3233])
DT = 0.01
NONE = Bounds(lower=np.full(6, -np.inf), upper=np.full(6, np.inf), speed=np.full(6, np.inf))
AXES = np.eye(6)


class Desk:
    """A device that shows what the test says, and an arm that is where its reference is, or stands."""

    def __init__(self, mode: Mode = BASE, **others: object) -> None:
        self.axes: Axes = AT_REST
        self.buttons: tuple[bool, ...] = (False, False, False)
        self.connected = True
        self.reads = 0
        machine = ModesA(mode=mode) if mode in (FREE, FINGERS) else ModesB(mode=mode)
        given = {"panel": Panel(modes=machine), "bounds": NONE} | others
        self.operator = Operator(read=self.read, **given)  # type: ignore[arg-type]
        self.arm = MODEL.at(State(t=0.0, q=READY, dq=np.zeros(6)))
        self.operator.reset(self.arm)
        self.references: list[ToolReference] = []

    def read(self) -> Reading:
        self.reads += 1
        return Reading(t=0.0, axes=self.axes, buttons=self.buttons, age=0.0, connected=self.connected)

    def push(self, axes: Array, seconds: float, *, follow: bool = True, dt: float = DT) -> ToolReference:
        self.axes = tuple(np.asarray(axes, dtype=float).tolist())
        for _ in range(round(seconds / dt)):
            self.arm = replace(self.arm, t=self.arm.t + dt)
            reference = self.operator.at(self.arm)
            self.references.append(reference)
            if follow:
                self.arm = replace(self.arm, p=reference.p, R=reference.R)
        return reference

    def rest(self, seconds: float = DT, **how: bool) -> ToolReference:
        return self.push(np.zeros(6), seconds, **how)


def ready(mode: Mode = BASE, **others: object) -> Desk:
    desk = Desk(mode, **others)
    desk.rest()
    return desk


@pytest.mark.parametrize("axis", range(6))
def test_full_push_reaches_the_speeds_of_thesis_a_along_and_about_base_axes(axis: int) -> None:
    reference = ready().push(AXES[axis], 2.0)
    np.testing.assert_allclose(reference.v, AXES[axis] * (0.2 if axis < 3 else 1.0), atol=1e-9)


def test_near_people_the_tool_is_slower_than_0_15_metres_a_second() -> None:
    reference = ready(pace=Pace.near_people()).push(AXES[1], 2.0)
    assert reference.v[1] == pytest.approx(0.9 * 0.14)


def test_the_operator_is_no_faster_than_the_tool_may_be_along_the_motion() -> None:
    desk = ready(allowed_speed=lambda arm, v: 0.1 if v[0] > 0.0 else 1.0)
    assert desk.push(AXES[0], 2.0).v[0] == pytest.approx(0.85 * 0.1)
    assert desk.operator.slowed.cause == "people near by"
    assert desk.push(-AXES[0], 2.0).v[0] == pytest.approx(-0.2)


@pytest.mark.parametrize(("force", "share"), [(9.0, 1.0), (15.0, 0.5), (30.0, 0.0)])
def test_what_is_pressed_is_pressed_no_harder_than_is_allowed(force: float, share: float) -> None:
    desk = ready(press=20.0)
    desk.arm = desk.arm.feeling(np.array([0.3 * force, 0.0, 0.95 * force, 0.0, 0.0, 0.0]))
    assert desk.push(-AXES[2], 2.0).v[2] == pytest.approx(-0.2 * share, rel=0.02, abs=1e-9)
    # Across, against the friction, and away the tool goes as fast as ever.
    assert desk.push(-AXES[0], 2.0).v[0] == pytest.approx(-0.2)
    assert desk.push(AXES[2], 2.0).v[2] == pytest.approx(0.2)


def test_the_corner_of_the_caps_range_is_no_faster_than_an_axis() -> None:
    v = ready().push(np.ones(6), 2.0).v
    assert np.linalg.norm(v[:3]) == pytest.approx(0.2)
    assert np.linalg.norm(v[3:]) == pytest.approx(1.0)


@pytest.mark.parametrize("axis", range(6))
@pytest.mark.parametrize(("mode", "moved", "turned"), [(FREE, "base", "tool"), (MIXED, "base", "tool"),
                                                       (TOOL, "tool", "tool"), (BASE, "base", "base")])  # fmt: skip
def test_frames_are_those_of_the_mode(mode: Mode, moved: str, turned: str, axis: int) -> None:
    desk = ready(mode)
    start = desk.arm.R
    v = desk.push(AXES[axis], 2.0).v
    # About an axis of its own the tool's frame turns, and that axis does not.
    frame = start if (moved if axis < 3 else turned) == "tool" else np.eye(3)
    expected = np.concatenate([0.2 * frame @ AXES[axis][:3], 1.0 * frame @ AXES[axis][3:]])
    # The generator's phases agree to about 1e-6.
    np.testing.assert_allclose(v, expected, atol=1e-5)


def test_base_is_meant_as_the_operator_stands_to_it() -> None:
    round_the_table = exp(np.array([0.0, 0.0, np.pi]))
    v = ready(R_base_operator=round_the_table).push([1, 0, 0, 0, 1, 0], 2.0).v
    np.testing.assert_allclose(v, [-0.2, 0, 0, 0, -1.0, 0], atol=1e-9)


def test_the_tools_frame_is_that_of_the_reference_and_turns_with_it() -> None:
    desk = ready(TOOL)
    desk.push(AXES[5], 1.5)
    desk.rest(0.5)
    turned = desk.references[-1].R
    assert np.linalg.norm(log(turned @ MODEL.kinematics(READY)[1].T)) > 0.5
    np.testing.assert_allclose(desk.push(AXES[0], 2.0).v[:3], 0.2 * turned[:, 0], atol=1e-6)


def test_the_pose_is_the_integral_of_the_velocity_and_stays_a_rotation() -> None:
    desk = ready()
    rng = np.random.default_rng(4)
    for _ in range(40):
        desk.push(rng.uniform(-1, 1, 6), 0.1)
    p, R = MODEL.kinematics(READY)[:2]
    for before, after in zip(desk.references, desk.references[1:], strict=False):
        # The trapezium rule is off by a dt²/12 at most, in every step.
        mean = 0.5 * (before.v + after.v)
        np.testing.assert_allclose(after.p - before.p, mean[:3] * DT, atol=40 * DT**3 / 12 + 1e-12)
        np.testing.assert_allclose(log(after.R @ before.R.T), mean[3:] * DT, atol=160 * DT**3 / 12 + 1e-12)
    last = desk.references[-1]
    np.testing.assert_allclose(last.R @ last.R.T, np.eye(3), atol=1e-12)
    assert np.linalg.norm(last.p - p) > 0.01
    assert np.linalg.norm(log(last.R @ R.T)) > 0.05


def test_acceleration_and_jerk_stay_within_the_pace() -> None:
    desk, pace = ready(), Pace()
    rng = np.random.default_rng(5)
    for _ in range(40):
        desk.push(rng.uniform(-1, 1, 6), 0.05)
    a = np.array([r.a for r in desk.references])
    most = np.repeat([pace.linear_acceleration, pace.angular_acceleration], 3)
    jerk = np.repeat([pace.linear_jerk, pace.angular_jerk], 3)
    assert (np.abs(a) <= most + 1e-9).all()
    assert (np.abs(np.diff(a, axis=0)) <= jerk * DT + 1e-9).all()
    np.testing.assert_allclose(np.diff([r.v for r in desk.references], axis=0), 0.5 * (a[1:] + a[:-1]) * DT, atol=3e-3)


@pytest.mark.parametrize("how", ["released", "gone", "stopped"])
def test_from_full_speed_the_reference_stands_within_a_fifth_of_a_second(how: str) -> None:
    desk = ready(bounds=replace(NONE, speed=np.array([0.63] * 3 + [0.84] * 3)))
    desk.push(np.ones(6), 0.5)
    if how == "released":
        reference = desk.rest(0.2)
    else:
        desk.connected = how != "gone"
        if how == "stopped":
            desk.operator.stop()
        reference = desk.push(np.ones(6), 0.2)
    np.testing.assert_allclose(reference.v, 0.0, atol=1e-9)
    assert (desk.rest(0.2).p == reference.p).all()


def test_what_is_read_in_a_cycle_acts_in_the_reference_of_that_cycle() -> None:
    desk = ready()
    assert (desk.rest().v == 0.0).all()
    reads = desk.reads
    assert desk.push(AXES[0], DT).v[0] > 0.0
    assert desk.reads == reads + 1


def test_a_cap_that_is_pushed_at_the_start_moves_nothing_until_it_was_let_go() -> None:
    desk = Desk()
    assert (desk.push(np.ones(6), 0.3).v == 0.0).all()
    desk.rest()
    assert desk.push(np.ones(6), 0.3).v[0] > 0.02


def test_nothing_moves_without_the_deadman() -> None:
    desk = ready(panel=Panel(modes=ModesB(mode=BASE), deadman=3))
    assert (desk.push(np.ones(6), 0.3).v == 0.0).all()
    desk.buttons = (False, False, True)
    assert desk.push(np.ones(6), 0.3).v[0] > 0.02
    desk.buttons = (False, False, False)
    np.testing.assert_allclose(desk.push(np.ones(6), 0.5).v, 0.0, atol=1e-12)


def test_the_fingers_follow_the_twist_within_their_range_and_the_arm_stands() -> None:
    desk = ready(FINGERS)
    reference = desk.push(np.ones(6), 0.6)
    assert (reference.v == 0.0).all()
    assert (reference.p == desk.arm.p).all()
    half = desk.operator.fingers
    # A fifth of a second to full speed, and 0.2 s before the end, are slower.
    assert 0.25 * FINGER_SPEED < half < 0.6 * FINGER_SPEED
    desk.push(np.ones(6), 3.0)
    assert desk.operator.fingers == pytest.approx(FINGERS_CLOSED, abs=1e-3)
    desk.push(-np.ones(6), 4.0)
    assert desk.operator.fingers == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("axes", [*np.eye(6), np.ones(6), -np.ones(6)], ids=str)
def test_the_reference_of_an_arm_that_is_held_stays_on_the_leash(axes: Array) -> None:
    leash = Leash()
    desk = ready(leash=leash)
    desk.push(axes, 2.0, follow=False)
    for r in desk.references:
        assert np.linalg.norm(r.p - desk.arm.p) <= leash.position + 1e-12
        assert np.linalg.norm(log(r.R @ desk.arm.R.T)) <= leash.angle + 1e-12
    last = desk.references[-1]
    ahead = np.concatenate([last.p - desk.arm.p, log(last.R @ desk.arm.R.T)]) / np.repeat(
        [leash.position, leash.angle], 3
    )
    behind = Mobility(desk.arm.J).joint_speeds(ahead * np.repeat([leash.position, leash.angle], 3)) / leash.joints
    assert np.linalg.norm(behind) <= 1.0 + 1e-9
    ends = [np.linalg.norm(part) for part in (ahead[:3], ahead[3:], behind)]
    assert max(ends) > 0.9, "it did not get to any end"
    assert np.abs(last.v).max() < 1e-2
    assert desk.operator.slowed.cause == "the arm does not follow"


def test_an_arm_that_is_pushed_away_takes_its_reference_along() -> None:
    desk = ready()
    for _ in range(50):
        desk.arm = replace(desk.arm, p=desk.arm.p + [0.005, 0.0, 0.0], R=exp(np.array([0.0, 0.05, 0.0])) @ desk.arm.R)
        reference = desk.rest(follow=False)
        assert np.linalg.norm(reference.p - desk.arm.p) <= Leash().position + 1e-12
        assert np.linalg.norm(log(reference.R @ desk.arm.R.T)) <= Leash().angle + 1e-12


def test_pulling_back_from_the_end_of_the_leash_is_not_slowed() -> None:
    desk = ready()
    desk.push(AXES[0], 2.0, follow=False)
    assert desk.push(-AXES[0], 0.1, follow=False).v[0] < -0.03


def test_while_the_arm_is_taken_the_reference_goes_with_it_and_the_operator_starts_afresh() -> None:
    held = [False]
    desk = ready(panel=Panel(modes=ModesB(mode=BASE), deadman=3), taken=lambda: held[0])
    desk.buttons = (False, False, True)
    desk.push(np.ones(6), 0.5)
    held[0] = True
    desk.arm = replace(desk.arm, p=desk.arm.p + [0.1, 0.0, 0.0])
    reference = desk.push(np.ones(6), 0.1, follow=False)
    assert (reference.p == desk.arm.p).all()
    assert (reference.v == 0.0).all()
    held[0] = False
    assert (desk.push(np.ones(6), 0.3).v == 0.0).all(), "the cap was not let go"
    desk.rest()
    assert (desk.push(np.ones(6), 0.3).v == 0.0).all(), "the deadman was not pressed anew"
    desk.buttons = (False, False, False)
    desk.rest()
    desk.buttons = (False, False, True)
    assert desk.push(np.ones(6), 0.3).v[0] > 0.02


def test_after_a_pause_the_reference_does_not_leap() -> None:
    desk = ready()
    desk.push(AXES[0], 0.5)
    before = desk.references[-1].p
    desk.arm = replace(desk.arm, t=desk.arm.t + 10.0)
    after = desk.push(AXES[0], DT).p
    assert np.linalg.norm(after - before) <= 0.2 * 0.05 + 1e-12


def test_two_runs_of_the_same_readings_are_bit_exact() -> None:
    def one() -> bytes:
        desk = ready()
        rng = np.random.default_rng(6)
        for _ in range(50):
            desk.push(rng.uniform(-1, 1, 6), 0.05)
        return b"".join(r.p.tobytes() + r.R.tobytes() + r.v.tobytes() + r.a.tobytes() for r in desk.references)

    assert one() == one()


def drive(lower: Array, upper: Array, axes: Array, seconds: float) -> tuple[Array, Operator]:
    """Joint positions of an arm that follows by its inverse Jacobian, away from READY."""
    axes_now: list[Axes] = [AT_REST]
    operator = Operator(
        read=lambda: Reading(t=0.0, axes=axes_now[0], buttons=(), age=0.0),
        panel=Panel(modes=ModesB(mode=BASE)),
        bounds=Bounds(lower=lower, upper=upper, speed=np.array([0.63] * 3 + [0.84] * 3)),
    )
    q, dq, rows = READY, np.zeros(6), []
    operator.reset(MODEL.at(State(t=0.0, q=q, dq=dq)))
    for k in range(round(seconds / DT)):
        arm: Dynamics = MODEL.at(State(t=k * DT, q=q, dq=dq))
        reference = operator.at(arm)
        e = np.concatenate([reference.p - arm.p, log(reference.R @ arm.R.T)])
        dq = np.linalg.solve(arm.J, reference.v + 10.0 * e)
        q = q + dq * DT
        rows.append(np.concatenate([q, dq]))
        axes_now[0] = tuple(axes.tolist())
    return np.array(rows), operator


@pytest.mark.parametrize("axes", [*np.eye(6), *-np.eye(6)], ids=str)
def test_pushing_on_for_ever_ends_at_a_limit_at_rest_and_passes_none(axes: Array) -> None:
    lower, upper = READY - 0.5, READY + 0.5
    rows, operator = drive(lower, upper, axes, 12.0)
    q, dq = rows[:, :6], rows[:, 6:]
    # What the arm is behind its reference it may overshoot by.
    assert (q > lower - 0.01).all()
    assert (q < upper + 0.01).all()
    assert (np.abs(dq) < [0.63] * 3 + [0.84] * 3).all()
    assert np.abs(dq[-1]).max() < 0.05
    assert operator.slowed.cause != ""


def test_pushing_into_the_stretched_arm_slows_down_before_the_singularity() -> None:
    free = np.full(6, np.inf)
    rows, operator = drive(-free, free, np.array([0.0, -1.0, 0.0, 0, 0, 0]), 10.0)
    assert operator.slowed.cause in ("singularity", "speed of joint 3", "speed of joint 2")
    assert (np.abs(rows[:, 6:]) < [0.63] * 3 + [0.84] * 3).all()


def test_the_arms_own_parts_slow_the_operator_down_and_let_him_go() -> None:
    left = 0.02
    # Along x the way to itself is closed as fast as the tool moves.
    desk = ready(clearance=lambda arm: lambda dq: (left, float(arm.J[0] @ dq)))
    assert desk.push(AXES[0], 1.0).v[0] == pytest.approx(left / BRAKING, rel=0.05)
    assert desk.operator.slowed.cause == "the arm itself"
    assert desk.push(-AXES[0], 1.0).v[0] == pytest.approx(-desk.operator.pace.linear, rel=0.01)
    left = 0.0
    assert desk.push(AXES[0], 1.0).v[0] == pytest.approx(0.0, abs=1e-9)


def test_no_joint_of_the_reference_is_faster_than_its_share_between_two_twists() -> None:
    rng = np.random.default_rng(3)
    speed = np.array([0.63] * 3 + [0.84] * 3)
    desk = ready(bounds=Bounds(lower=NONE.lower, upper=NONE.upper, speed=speed), leash=Leash(joints=0.9))
    for _ in range(30):
        desk.push(rng.uniform(-1.0, 1.0, 6), 0.2, follow=False)
    found = [np.abs(Mobility(desk.arm.J).joint_speeds(r.v)) / speed for r in desk.references]
    assert 0.6 < np.max(found) <= OVERSHOT + 1e-9


def test_a_clock_that_is_no_number_does_not_stop_the_operator_for_good() -> None:
    desk = ready()
    t = desk.arm.t
    desk.arm = replace(desk.arm, t=np.nan)
    desk.push(AXES[0], DT)
    desk.arm = replace(desk.arm, t=t + DT)
    assert desk.push(AXES[0], 0.5).v[0] == pytest.approx(desk.operator.pace.linear)


@pytest.mark.parametrize("bad", [{"R_base_operator": 2.0 * np.eye(3)}, {"R_base_operator": -np.eye(3)}])
def test_a_frame_that_is_no_rotation_is_refused(bad: dict[str, Array]) -> None:
    with pytest.raises(InputError, match="rotation matrix"):
        Desk(**bad)


@pytest.mark.parametrize("make", [lambda: Pace(linear=-1.0), lambda: Pace(linear_jerk=float("inf")),
                                  lambda: Leash(position=0.0), lambda: Leash(angle=float("nan"))])  # fmt: skip
def test_paces_and_leashes_that_are_none_are_refused(make: Callable[[], object]) -> None:
    with pytest.raises(InputError):
        make()


def test_bounds_of_another_arm_are_refused_before_motion() -> None:
    seven = Bounds(lower=np.full(7, -1.0), upper=np.ones(7), speed=np.ones(7))
    with pytest.raises(InputError, match="7 joints; the arm has 6"):
        Desk(bounds=seven)


def test_references_bring_no_engine_and_modes_no_clock() -> None:
    code = "import sys, burnish.teleop.reference; assert not {'mujoco', 'pinocchio'} & set(sys.modules)"
    run([sys.executable, "-c", code], check=True)
    for name in ("modes", "modes_a", "modes_b", "limits", "smooth", "reference"):
        text = (Path("src/burnish/teleop") / f"{name}.py").read_text()
        assert "import time" not in text
        assert "threading" not in text
