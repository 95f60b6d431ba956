"""The control loop: one generator, in which the robot keeps the time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from burnish.control.wrench import ContactSense, NoSense
from burnish.core import Controller, Dynamics, Ref, Robot, Sample, Source, State, Torque
from burnish.model.model import Model
from burnish.runtime.supervisor import Supervisor


@dataclass
class Rig:
    """What a loop drives: a robot, the model of it, a supervisor, and what it feels with."""

    robot: Robot
    model: Model
    supervisor: Supervisor
    sense: ContactSense = field(default_factory=NoSense)
    state: State | None = field(default=None, init=False, repr=False)
    """The last measured state; the next behaviour goes on from here without a gap."""
    arm: Dynamics | None = field(default=None, init=False, repr=False)
    """The model at that state, with what is felt."""
    _model_arm: Dynamics | None = field(default=None, init=False, repr=False)

    def read(self) -> Dynamics:
        """The model at the next measurement, with the contact wrench if something feels it."""
        self.state = self.robot.read()
        self._model_arm = self.model.at(self.state)
        return self.feel()

    def feel(self) -> Dynamics:
        """The last measurement felt again, after a tare."""
        assert self.state is not None, "read comes first"
        assert self._model_arm is not None, "read comes first"
        self.arm = self.sense.feel(self._model_arm, self.state)
        return self.arm


def never(arm: Dynamics) -> bool:
    """An `until` that goes on for ever."""
    return False


def control(
    rig: Rig, source: Source[Ref], controller: Controller[Ref], until: Callable[[Dynamics], bool] = never
) -> Iterator[Sample]:
    """Drive the rig along a source with a law, one sample a cycle, until ``until(arm)`` is true.

    Behaviours follow each other without a gap: the next call goes on from the last measurement. Between two
    ``next()`` nobody writes; the robot then holds its last command.

    A cycle without a torque of the law is one in which the supervisor holds the arm. If it was the measurement that no
    law can work with, the loop goes on with the arm held; else what the source or the law raised is raised once the
    holding torque is on its way.
    """
    arm = rig.arm if rig.arm is not None else rig.read()
    source.reset(arm)
    controller.reset(arm)
    reference, failure = None, None
    while not until(arm):
        try:
            reference = source.at(arm)
            torque = controller.torque(arm, reference)
        except Exception as error:  # noqa: BLE001  Whatever it is, the arm comes first.
            torque, failure = np.full(len(arm.q), np.nan), error
        applied = rig.robot.write(Torque(rig.supervisor.filter(arm, torque)))
        if failure is not None and (reference is None or rig.supervisor.sound):
            raise failure
        failure = None
        yield Sample(arm, reference, torque, applied)
        arm = rig.read()
