from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
from numpy.testing import assert_allclose
from typing_extensions import Self

from burnish.control.joint import ComputedTorque
from burnish.control.wrench import WristSense
from burnish.core import Array, Command, Dynamics, JointReference, Robot, Sample, Source, State
from burnish.model.model import Model
from burnish.model.tool import PolishingTool
from burnish.runtime.loop import Rig, control
from burnish.runtime.supervisor import Limits, Supervisor
from burnish.sim.robot import HOME, SimRobot
from burnish.trajectory import Cubic, Hold, Sine

TOOL = PolishingTool()
MODEL = TOOL.on(Model.jaco2())


class MockRobot:
    """An arm that stands at home, ticks every 10 ms, and notes what is asked of it."""

    def __init__(self, calls: list[str]) -> None:
        self.calls, self.t, self.sent = calls, 0.0, [np.zeros(6)]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        pass

    def read(self) -> State:
        self.calls.append("read")
        self.t += 0.01
        return State(t=self.t, q=HOME, dq=np.zeros(6), F=np.zeros(6))

    def write(self, command: Command) -> Array:
        self.calls.append("write")
        self.sent.append(command.tau)
        return command.tau - 0.5


class NotingSource(Hold):
    """`Hold` that notes what is asked of it."""

    def __init__(self, calls: list[str]) -> None:
        super().__init__()
        self.calls = calls

    def reset(self, arm: Dynamics) -> None:
        self.calls.append("source.reset")
        super().reset(arm)

    def at(self, arm: Dynamics) -> JointReference:
        self.calls.append("source.at")
        return super().at(arm)


class NotingLaw:
    """A torque of 99 N·m on every joint, and a note."""

    def __init__(self, calls: list[str]) -> None:
        self.calls = calls

    def reset(self, arm: Dynamics) -> None:
        self.calls.append("law.reset")

    def torque(self, arm: Dynamics, reference: JointReference) -> Array:
        self.calls.append("law.torque")
        return np.full(6, 99.0)


def rig_of(robot: Robot) -> Rig:
    # No speed limit: the laws of these tests ask for what would throw the arm.
    limits = replace(Limits.of(MODEL), speed=np.full(6, 1e9))
    return Rig(robot=robot, model=MODEL, supervisor=Supervisor(limits=limits))


def mock_run(cycles: int) -> tuple[list[str], MockRobot, list[Sample]]:
    calls: list[str] = []
    robot = MockRobot(calls)
    return calls, robot, list(islice(control(rig_of(robot), NotingSource(calls), NotingLaw(calls)), cycles))


def stiff() -> ComputedTorque:
    return ComputedTorque.at_frequency(25.0)


# One cycle.


def test_cycle_reads_refers_computes_and_writes_in_that_order() -> None:
    calls, _, _ = mock_run(3)
    cycle = ["source.at", "law.torque", "write"]
    assert calls == ["read", "source.reset", "law.reset", *cycle, "read", *cycle, "read", *cycle]


def test_what_is_sent_has_passed_the_supervisor() -> None:
    _, robot, _ = mock_run(3)
    assert_allclose(robot.sent[1:], [Limits.of(MODEL).torque] * 3)


def test_sample_holds_what_the_law_asked_and_what_the_robot_applied() -> None:
    _, robot, samples = mock_run(3)
    for sample, sent in zip(samples, robot.sent[1:], strict=True):
        assert_allclose(sample.commanded, np.full(6, 99.0))
        assert_allclose(sample.applied, sent - 0.5)


def test_sample_belongs_to_one_instant() -> None:
    _, _, samples = mock_run(3)
    assert [sample.arm.t for sample in samples] == pytest.approx([0.01, 0.02, 0.03])


def test_condition_that_holds_at_once_writes_nothing() -> None:
    calls: list[str] = []
    assert list(control(rig_of(MockRobot(calls)), Hold(), stiff(), until=lambda arm: True)) == []
    assert "write" not in calls


def test_sense_of_the_rig_feels_every_state() -> None:
    rig = rig_of(MockRobot([]))
    rig.sense = WristSense(mass=TOOL.mass, com=TOOL.com, offset=TOOL.length)
    for sample in islice(control(rig, Hold(), stiff()), 3):
        assert sample.arm.F is not None
        # The mock's sensor reads nothing at all, so what seems to touch carries the weight.
        assert np.linalg.norm(sample.arm.F[:3]) == pytest.approx(9.81 * TOOL.mass)


def test_feeling_again_after_a_tare_reads_nothing_new() -> None:
    calls: list[str] = []
    rig = rig_of(MockRobot(calls))
    sense = WristSense(mass=TOOL.mass, com=TOOL.com, offset=TOOL.length)
    rig.sense = sense
    arm = rig.read()
    assert rig.state is not None
    sense.tare([(arm, rig.state)])
    again = rig.feel()
    assert calls == ["read"]
    assert again.F is not None
    assert_allclose(again.F, np.zeros(6), atol=1e-12)


# Behaviours one after the other.


def steps(rig: Rig, sources: list[Source[JointReference]], duration: float) -> list[Sample]:
    """Each source for as long as that, one after the other."""
    samples: list[Sample] = []
    for source in sources:
        start = rig.arm.t if rig.arm is not None else 0.0

        def over(arm: Dynamics, start: float = start) -> bool:
            return arm.t - start >= duration - 1e-9

        samples += control(rig, source, stiff(), until=over)
    return samples


@pytest.mark.parametrize(
    "robot", [lambda: MockRobot([]), lambda: SimRobot(tool=TOOL, rate=500.0)], ids=["mock", "simulated"]
)
def test_behaviours_follow_each_other_without_a_gap(robot: Callable[[], Robot]) -> None:
    rig = rig_of(robot())
    sources = [Hold(), Cubic(q=HOME + 0.05, duration=0.08), Sine(amplitude=0.01, period=1.0), Hold()]
    t = np.array([sample.arm.t for sample in steps(rig, sources, 0.1)])
    assert len(t) >= 39
    assert_allclose(np.diff(t), np.full(len(t) - 1, t[1] - t[0]), atol=1e-12)


def test_every_measurement_is_answered_once() -> None:
    calls: list[str] = []
    rig = rig_of(MockRobot(calls))
    steps(rig, [Hold(), Sine(amplitude=0.01, period=1.0)], 0.1)
    moves = [call for call in calls if call in ("read", "write")]
    assert moves[:-1] == ["read", "write"] * (len(moves) // 2)
    # The last measurement waits for the next behaviour.
    assert moves[-1] == "read"


# Closed loop on the ideal arm.


@pytest.mark.parametrize(
    ("source", "bound"),
    [
        # At rest there is nothing to track but the tip, which settles on its spring.
        (Hold(), 1e-4),
        # A torque held for 1 ms acts half a millisecond late on average, which at 0.4 rad/s is 0.2 mrad.
        (Cubic(q=HOME + [0.3, -0.2, 0.2, 0.3, -0.3, 0.3], duration=1.5), 1e-3),
        (Sine(amplitude=[0.1, 0.05, 0.05, 0.1, 0.1, 0.1], period=2.0), 1e-3),
    ],
    ids=["hold", "cubic", "sine"],
)
def test_computed_torque_tracks_on_the_ideal_arm(source: Source[JointReference], bound: float) -> None:
    rig = rig_of(SimRobot(tool=TOOL))
    errors = [
        np.abs(sample.reference.q - sample.arm.q).max()
        for sample in control(rig, source, stiff(), until=lambda arm: arm.t >= 1.6)
        # A sine starts at full speed from an arm that rests: half a second to catch up.
        if sample.arm.t > 0.5
    ]
    assert max(errors) < bound


@pytest.mark.parametrize("source", [Hold(), Cubic(q=HOME + 0.1, duration=1.5)], ids=["hold", "cubic"])
def test_gentle_motion_never_meets_the_supervisor(source: Source[JointReference]) -> None:
    rig = rig_of(SimRobot(tool=TOOL))
    for _ in control(rig, source, stiff(), until=lambda arm: arm.t >= 1.1):
        pass
    assert rig.supervisor.event is None
    assert rig.supervisor.clamped == 0


class Breaking(NotingLaw):
    """A law that raises in its third cycle."""

    def torque(self, arm: Dynamics, reference: JointReference) -> Array:
        if self.calls.count("law.torque") == 2:
            raise ZeroDivisionError("a gain of nothing")
        return super().torque(arm, reference)


def test_law_that_raises_is_heard_once_what_holds_the_arm_has_been_sent() -> None:
    calls: list[str] = []
    robot = MockRobot(calls)
    rig = rig_of(robot)
    with pytest.raises(ZeroDivisionError, match="a gain of nothing"):
        list(control(rig, NotingSource(calls), Breaking(calls)))
    assert calls[-1] == "write"
    assert rig.supervisor.tripped
    assert np.isfinite(robot.sent[-1]).all()


class Blinking(MockRobot):
    """An arm whose second reading is none."""

    def read(self) -> State:
        state = super().read()
        return (
            State(t=state.t, q=np.full(6, np.nan), dq=state.dq, F=state.F) if self.calls.count("read") == 3 else state
        )


def test_law_that_breaks_on_a_broken_reading_leaves_the_arm_held_and_the_loop_going() -> None:
    class Choosy(NotingLaw):
        def torque(self, arm: Dynamics, reference: JointReference) -> Array:
            if not np.isfinite(arm.q).all():
                raise ValueError("this is no reading")
            return super().torque(arm, reference)

    calls: list[str] = []
    robot = Blinking(calls)
    rig = rig_of(robot)
    samples = list(islice(control(rig, NotingSource(calls), Choosy(calls)), 6))
    assert len(samples) == 6
    assert rig.supervisor.tripped
    assert np.isfinite(robot.sent).all()
