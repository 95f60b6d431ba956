"""Run a trial on the simulated arm."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter_ns
from typing import Any

import numpy as np

from burnish.core import Array, Controller, Dynamics
from burnish.errors import SimulationError
from burnish.runtime.loop import Rig, control
from burnish.runtime.supervisor import Event, Limits, Supervisor
from burnish.sim.robot import SimRobot
from burnish.trials.experiment import Trial
from burnish.trials.record import Record


@dataclass(kw_only=True)
class Timed:
    """A law with the wall time of its last call."""

    law: Controller[Any]
    took_us: float = 0.0

    def reset(self, arm: Dynamics) -> None:
        """As the law does."""
        self.law.reset(arm)

    def torque(self, arm: Dynamics, reference: Any) -> Array:
        """As the law does."""
        start = perf_counter_ns()
        tau = self.law.torque(arm, reference)
        self.took_us = 1e-3 * (perf_counter_ns() - start)
        return tau


RACING = 3.0
"""Multiple of a joint's speed limit at which a trial ends: a law that oscillates is to be seen doing it."""


@dataclass(kw_only=True)
class Onlooker(Supervisor):
    """Ends a trial, and changes nothing before: what is measured is the law's doing, and the driver's clamp."""

    def filter(self, arm: Dynamics, torque: Array) -> Array:
        """The torque as it is; the arm's weight once the trial is over."""
        if self.event is None:
            joint = int(np.argmax(np.abs(arm.dq) / self.limits.speed))
            speed, most = abs(float(arm.dq[joint])), RACING * float(self.limits.speed[joint])
            if not speed <= most:
                cause = f"joint {joint + 1} raced at {speed:.2f} rad/s, beyond {most:.2f} rad/s"
                self.event = Event(t=arm.t, cause=cause)
            elif not np.isfinite(torque).all():
                self.event = Event(t=arm.t, cause="the law gave a torque that is not finite")
        return torque if self.event is None else arm.g


def run(trial: Trial, on_progress: Callable[[float], None] = lambda share: None) -> Record:
    """The record of a trial; ends early, and says why, where a joint races or the simulation leaves its ground."""
    rate = trial.arm.rate if trial.rate is None else trial.rate
    robot = SimRobot(trial.q, rate=rate, plant=trial.arm.plant)
    rig = Rig(robot, trial.model, Onlooker(limits=Limits.of(trial.model)))
    law, record = Timed(law=trial.law), Record(model=trial.model)
    try:
        with robot:
            for sample in control(rig, trial.source, law, until=lambda arm: arm.t >= trial.duration):
                record.add(sample, law.took_us)
                if rig.supervisor.event is not None:
                    record.stopped = rig.supervisor.event.cause
                    break
                if trial.push is not None:
                    robot.push(trial.push(sample.arm.t))
                on_progress(sample.arm.t / trial.duration)
    except SimulationError as error:
        record.stopped = str(error)
    return record
