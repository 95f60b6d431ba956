"""Train and execute in closed loop: the order, stopping in any phase, and what came of the force."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import cast

import numpy as np
import pytest
from teach.cells import TOOL, cell_of, dome, shown

from burnish.core import Array, Dynamics, ToolReference
from burnish.runtime.operating import operator
from burnish.sim.robot import SimRobot
from burnish.teach.cleanup import cleaned
from burnish.teach.execute import Execute
from burnish.teach.judge import ReplayLog, as_cleaned, followed, seen_from
from burnish.teach.replay import Track
from burnish.teach.session import Key, Session
from burnish.teach.train import Train
from burnish.teleop.device import AT_REST, Axes, Reading
from burnish.teleop.modes import Panel
from burnish.teleop.modes_b import ModesB
from burnish.teleop.reference import Pace
from burnish.trajectory import HoldPose

LONGEST = 40_000
FAST: Axes = (0.0, 0.5, 0.0, 0.0, 0.0, 0.0)
"""Half a deflection away from the operator."""
DOWN: Axes = (0.0, 0.0, -0.15, 0.0, 0.0, 0.0)
"""A little, down to the dome."""


class Wave:
    """An operator who moves the tool to and fro at up to 0.1 m/s."""

    def __init__(self) -> None:
        self._pose = HoldPose()

    def reset(self, arm: Dynamics) -> None:
        self._pose.reset(arm)
        self._t0 = arm.t

    def at(self, arm: Dynamics) -> ToolReference:
        still, t = self._pose.at(arm), arm.t - self._t0
        away = np.array([0.04 * (1.0 - np.cos(2.5 * t)), 0.0, 0.0])
        v = np.array([0.1 * np.sin(2.5 * t), 0.0, 0.0, 0.0, 0.0, 0.0])
        return ToolReference(p=still.p + away, R=still.R, v=v, a=np.zeros(6))


def train() -> Train:
    cell = cell_of()
    rig, _ = cell.rig()
    return cell.train(rig, Wave(), lambda: "polishing")


def execute(repeats: int = 1) -> Execute:
    cell = cell_of()
    rig, _ = cell.rig()
    return cell.hold_force(rig, cleaned(shown(), dome()[1], TOOL), repeats=repeats, speed=1.0)


def drive(session: Session, each: Callable[[int], None]) -> tuple[list[str], list[Array]]:
    """Run to the end; phases in order and true joint speeds of every cycle."""
    names: list[str] = []
    speeds = []
    robot = cast(SimRobot, session.rig.robot)
    for count, _ in enumerate(session.run(), 1):
        name = " ".join(session.phase.split()[:1]) if session.phase.startswith("record") else session.phase
        if not names or names[-1] != name:
            names.append(name)
        speeds.append(np.abs(robot.truth_dq()))
        assert count < LONGEST, f"it never ends: {names}"
        each(count)
    return names, speeds


def answers(session: Session, *order: Key) -> Callable[[int], None]:
    """Presses the next key as soon as it is waited for."""
    left = list(order)

    def each(count: int) -> None:
        if left and left[0] in session.waits_for:
            session.press(left.pop(0))

    return each


def test_train_is_in_the_thesis_order_and_says_which_cycles_were_shown() -> None:
    session = train()
    recorded = 0

    def each(count: int) -> None:
        nonlocal recorded
        if session.phase.startswith("record"):
            recorded += 1
            if recorded == 150:
                session.press(Key.STORE)
        elif session.waits_for and session.waits_for[0] is Key.RECORD:
            session.press(Key.RECORD if session.phase == "ready" else Key.GO_ON)

    names, speeds = drive(session, each)
    assert names == ["home", "to ready", "ready", "tare", "record", "stop", "lift", "to home", "stop"] or names == [
        "home", "to ready", "ready", "tare", "record", "stop", "to home", "stop"]  # fmt: skip
    assert session.stored is not None
    assert session.stored[1] - session.stored[0] + 1 == 150
    assert session.completed
    assert speeds[-1].max() < np.deg2rad(1.0)
    assert session.arm().q == pytest.approx(session.home, abs=np.deg2rad(1.5))


def test_space_forgets_what_was_shown_and_r_begins_anew() -> None:
    session = train()
    order = [Key.RECORD, Key.CANCEL, Key.RECORD, Key.STORE]
    since = 0

    def each(count: int) -> None:
        nonlocal since
        since += 1
        wait = 60 if session.phase.startswith("record") else 5
        if order and since > wait and order[0] in session.waits_for and (
            order[0] is not Key.CANCEL or session.phase.startswith("record")
        ):  # fmt: skip
            session.press(order.pop(0))
            since = 0

    names, _ = drive(session, each)
    assert names.count("home") == 2
    assert names.count("record") == 2
    assert not order
    assert session.stored is not None
    first, last = session.stored
    # Twice a tare, the first showing, and the way home.
    assert first > 200
    assert last - first < 100


@pytest.mark.parametrize("phase", ["home", "to ready", "ready", "tare", "record free polishing"])
@pytest.mark.parametrize("how", ["interrupt", "space"])
def test_a_session_of_teaching_is_at_rest_within_300_ms_in_any_phase(phase: str, how: str) -> None:
    session = train()
    robot = cast(SimRobot, session.rig.robot)
    seen, asked, rest = 0, None, None
    for _ in session.run():
        if asked is None and session.waits_for[:1] == (Key.RECORD,):
            session.press(Key.RECORD if session.phase == "ready" else Key.GO_ON)
        seen += session.phase == phase
        # In the middle of it, where the tool is fast.
        if asked is None and seen == 50:
            session.interrupt() if how == "interrupt" else session.press(Key.CANCEL)
            asked = robot.time
        if asked is not None:
            still = np.abs(robot.truth_dq()).max() < np.deg2rad(1.0)
            if still and session.phase == "stop":
                rest = robot.time
                break
        if phase in ("home", "ready") and asked is None and session.phase == phase:
            session.interrupt() if how == "interrupt" else session.press(Key.CANCEL)
            asked = robot.time
    assert asked is not None
    assert rest is not None
    assert rest - asked <= 0.3


@pytest.mark.slow
@pytest.mark.parametrize("phase", ["move", "touch", "lift", "tare", "approach", "pass", "free"])
def test_a_replay_is_at_rest_within_300_ms_in_any_phase(phase: str) -> None:
    session = execute()
    robot = cast(SimRobot, session.rig.robot)
    seen, asked, rest = 0, None, None
    for _ in session.run():
        if Key.GO_ON in session.waits_for:
            session.press(Key.GO_ON)
        seen += session.phase == phase
        if asked is None and seen == (150 if phase == "pass" else 40):
            session.interrupt()
            asked = robot.time
        if asked is not None and rest is None and np.abs(robot.truth_dq()).max() < np.deg2rad(1.0):
            rest = robot.time
    assert asked is not None
    assert rest is not None
    assert robot.time - asked <= 0.3
    assert rest - asked <= 0.3
    assert np.abs(robot.truth_dq()).max() < np.deg2rad(1.0)


@pytest.mark.slow
def test_a_replay_holds_the_force_that_was_shown_where_it_was_shown() -> None:
    session = execute(repeats=2)
    cell, robot, log = cell_of(), cast(SimRobot, session.rig.robot), ReplayLog()
    names: list[str] = []
    for sample in session.run():
        if not names or names[-1] != session.phase:
            names.append(session.phase)
        along = session.along
        on = session.phase == "pass" and along is not None and along.settled >= along.track.settle
        log.add(sample, session.repeat if on else 0, session.piece, along.s if on and along is not None else -1.0)
        if Key.GO_ON in session.waits_for:
            session.press(Key.GO_ON)
    assert names[:3] == ["home", "to ready", "ready"]
    assert names.count("touch") == 5
    assert names.count("pass") == names.count("approach") == 2
    assert names[-2:] == ["to home", "stop"]
    assert session.completed
    taught = cleaned(shown(), dome()[1], TOOL)
    point = seen_from(np.asarray(robot.truth.point), cell.stands(), session.placement)
    figures = followed(log, robot.truth, point, taught.pieces, as_cleaned(taught, TOOL.tip_radius)).figures()
    assert figures["repeats"] == 2
    assert figures["force_rms_N"] < 1.0
    assert figures["position_rms_mm"] < 2.0
    assert figures["contact_lost_pct"] == 0.0


@pytest.mark.slow
def test_a_mould_that_is_not_there_ends_the_replay_at_home_with_a_reason() -> None:
    cell = cell_of()
    plant = replace(cell.arm.plant, mould_shift=np.array([0.0, 0.0, -0.05]))
    gone = replace(cell, arm=replace(cell.arm, plant=plant))
    rig, _ = gone.rig()
    session = gone.hold_force(rig, cleaned(shown(), dome()[1], TOOL), repeats=1, speed=1.0)
    names, speeds = drive(session, answers(session, Key.GO_ON, Key.GO_ON))
    assert session.failure is not None
    assert "nothing was touched" in session.failure
    assert not session.completed
    assert names[-2:] == ["to home", "stop"]
    assert speeds[-1].max() < np.deg2rad(1.0)


@pytest.mark.slow
def test_open_loop_gives_back_the_poses_and_asks_for_no_force() -> None:
    cell = cell_of()
    rig, robot = cell.rig()
    demonstration = shown()
    # 30 mm above the mould: what matters here are the poses.
    above = replace(demonstration, p_d=demonstration.p_d + np.array([0.0, 0.0, 0.03]))
    session = cell.open_loop(rig, Track.by_time(above, above.placement), repeats=1)
    asked, forces = [], []
    for sample in session.run():
        if session.phase == "poses":
            asked.append(np.linalg.norm(sample.reference.p - sample.arm.p))
            forces.append(sample.reference.force)
        if Key.GO_ON in session.waits_for:
            session.press(Key.GO_ON)
    assert session.completed
    assert max(forces) == 0.0
    assert np.sqrt(np.mean(np.square(asked))) < 5e-3
    assert robot.truth.cycle_force().max() == 0.0


class Stick:
    """A device that is pushed, and pulled out when somebody says so."""

    def __init__(self) -> None:
        self.axes: Axes = AT_REST
        self.connected = True

    def read(self) -> Reading:
        return Reading(t=0.0, axes=self.axes, buttons=(), age=0.0, connected=self.connected)


@pytest.mark.parametrize("touching", [False, True], ids=["free", "contact"])
def test_a_device_that_is_pulled_out_while_recording_leaves_an_arm_at_rest_and_what_was_shown(touching: bool) -> None:
    cell, stick = cell_of(), Stick()
    rig, robot = cell.rig()
    panel = Panel(modes=ModesB(fitted=False))
    moved = operator(read=stick.read, panel=panel, supervisor=rig.supervisor, pace=Pace())
    session = cell.train(rig, moved, lambda: "polishing")
    order = [Key.GO_ON, Key.RECORD]
    along_since = gone_at = None
    phase_then = ""
    after: list[float] = []
    for _ in session.run():
        if order and order[0] in session.waits_for:
            session.press(order.pop(0))
        if not session.phase.startswith("record"):
            continue
        now = session.arm().t
        if gone_at is None:
            # Down until it presses well, then along, and off the dome soon; or along from the first cycle on.
            if along_since is None and (not touching or session.arm().F[2] > 12.0):
                along_since = now
            stick.axes = FAST if along_since is not None else DOWN
            assert now < 30.0, "it never touched and moved at once"
            if along_since is not None and now > along_since + 0.25:
                assert np.linalg.norm(robot.truth_dq()) > 0.2
                stick.connected, gone_at, phase_then = False, now, session.phase
        elif now > gone_at + 0.3:
            after.append(float(np.abs(robot.truth_dq()).max()))
            if len(after) == 100:
                session.press(Key.STORE)
    assert phase_then == f"record {'contact' if touching else 'free'} polishing"
    assert max(after) < np.deg2rad(1.0)
    assert not rig.supervisor.tripped
    assert session.stored is not None
    assert session.completed
