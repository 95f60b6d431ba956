"""One episode: the arm is driven as a user would drive it, and what is left of it is a log of the plant."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from math import inf
from typing import Any

import numpy as np
from typing_extensions import Self

from burnish.campaign import tasks
from burnish.campaign.draw import Episode
from burnish.campaign.fault import Fault, FaultyLaw
from burnish.campaign.tasks import Setting, Task
from burnish.control.wrench import WristSense
from burnish.core import Array, Command, Sample, State, Torque
from burnish.errors import SimulationError
from burnish.model.model import Model
from burnish.runtime.limits import Limits
from burnish.runtime.loop import Rig
from burnish.runtime.supervisor import Supervisor
from burnish.sim import arms, faulty
from burnish.sim.faulty import FaultyRobot, Hang, Intermittent, Slow
from burnish.sim.robot import SimRobot

TRUTH_EVERY = 0.01
"""Time between two rows of which weight and energy are logged [s]."""


@dataclass(frozen=True, kw_only=True)
class Log:
    """The raw log of an episode: what the judge reads."""

    columns: dict[str, Array]
    """Plain numbers, a row a measurement; see `burnish.campaign.judge`."""
    header: dict[str, Any]
    """What was drawn, and what the supervisor said, in plain values."""


def run(episode: Episode) -> Log:
    """Run an episode as a user would run the arm, with the plant looked at from outside."""
    rng = np.random.default_rng([episode.seed, episode.number, 2])
    arm = (arms.honest_stiff if episode.stiff else arms.honest)(int(rng.integers(2**31)))
    setting = Setting(
        arm=arm,
        rate=episode.rate,
        duration=episode.duration,
        near_edge=any(fault.near_edge for fault in episode.faults),
        near_limit=any(fault.near_limit for fault in episode.faults),
        plunge=next((fault.plunge for fault in episode.faults if fault.plunge is not None), None),
    )
    task = episode.task(rng, setting)
    plant = arm.plant
    for fault in episode.faults:
        plant = plant if fault.plant is None else fault.plant(plant)
    tool = tasks.tool()
    witness = Witness(SimRobot(task.q, rate=episode.rate, plant=plant, tool=tool, workpiece=task.workpiece))
    spells: list[faulty.Fault] = [spell for fault in episode.faults for spell in fault.reading]
    # What loses readings comes first: what another fault makes of a reading is not to be lost with it.
    spells.sort(key=lambda spell: not isinstance(spell, Hang | Intermittent | Slow))
    robot = FaultyRobot(robot=witness, faults=spells)
    supervisor = Supervisor(limits=Limits.jaco2(), period=1.0 / episode.rate)
    model = _model(sum(fault.believed_payload for fault in episode.faults))
    rig = Rig(robot, model, supervisor, WristSense(mass=tool.mass, com=tool.com, offset=tool.length))
    trouble = _drive(episode, task, rig, witness)
    event, urgent = supervisor.event, witness.urgent
    header = {
        "seed": episode.seed,
        "episode": episode.number,
        "task": episode.task.__name__,
        "fault": episode.name,
        "text": "; ".join(fault.text for fault in episode.faults),
        "rate": episode.rate,
        "fault_at": episode.fault_at if urgent is None else urgent[0],
        "urgency": None if urgent is None else urgent[1].urgency,
        "mode": supervisor.mode.value,
        "cause": None if event is None else event.cause,
        "trouble": trouble,
    }
    return Log(columns=witness.columns(), header=header)


def _drive(episode: Episode, task: Task, rig: Rig, witness: Witness) -> str | None:
    """Drive the arm to the end of the episode; says what broke on the way, or None."""
    supervisor, trouble, end = rig.supervisor, None, episode.duration
    cycles = task.run(rig, lambda law: FaultyLaw(law=law, faults=episode.faults))
    # What a broken measurement does to arithmetic is the supervisor's business.
    with np.errstate(all="ignore"), witness:
        while witness.time < end:
            try:
                next(cycles)
            except SimulationError as error:
                return f"simulation: {error}"
            except Exception as error:  # noqa: BLE001  The outermost edge: whatever a law raises, the arm is made safe.
                if trouble is not None:
                    return f"{trouble}; and nothing could be sent: {error}"
                trouble = f"{type(error).__name__}: {error}"
                # The loop has sent what holds the arm before it let this through.
                cycles = _made_safe(rig)
            assert rig.state is not None
            witness.note(supervisor.tripped, rig.state.t, episode.urgent)
            if supervisor.tripped and end == episode.duration:
                end = max(end, witness.time + episode.after + 0.01)
    return trouble


def _made_safe(rig: Rig) -> Iterator[Sample]:
    """What is left without a law: the supervisor holds the arm; the loop has done so in the cycle that failed."""
    nothing = np.full(rig.model.n, np.nan)
    while True:
        arm = rig.read()
        applied = rig.robot.write(Torque(rig.supervisor.filter(arm, nothing)))
        yield Sample(arm, None, nothing, applied)


@cache
def _model(believed_payload: float) -> Model:
    """The model that the controller has."""
    model = tasks.nominal_model()
    if believed_payload:
        model = model.with_payload(believed_payload)
    return model.with_armature(arms.honest(0).armature)


@dataclass
class Witness:
    """A simulated arm with somebody who writes down what really happens to it."""

    robot: SimRobot
    urgent: tuple[float, Fault] | None = field(default=None, init=False)
    """The first fault that must stop the arm of those that reached the controller, and the time of that cycle [s]."""
    _rows: list[tuple[float, float, list[float], list[float]]] = field(default_factory=list, init=False)
    """Time, largest contact force, q and dq of each measurement."""
    _sent: dict[int, list[float]] = field(default_factory=dict, init=False)
    """Row to the torque that was sent in it."""
    _held: dict[int, bool] = field(default_factory=dict, init=False)
    _told: dict[int, float] = field(default_factory=dict, init=False)
    _forces: int = field(default=0, init=False)

    def __enter__(self) -> Self:
        self.robot.__enter__()
        return self

    def __exit__(self, *exception: object) -> None:
        self.robot.__exit__(*exception)

    @property
    def time(self) -> float:
        """The plant's time [s]."""
        return self.robot.time

    def read(self) -> State:
        """As the robot does; the truth of this instant is written down."""
        state = self.robot.read()
        forces = self.robot.truth.normal_force
        most = max(forces[self._forces :], default=0.0)
        self._forces = len(forces)
        self._rows.append((state.t, most, state.q.tolist(), self.robot.truth_dq().tolist()))
        return state

    def write(self, command: Command) -> Array:
        """As the robot does; what was sent is written down before the driver can refuse it."""
        assert isinstance(command, Torque)
        self._sent[len(self._rows) - 1] = command.tau.tolist()
        return self.robot.write(command)

    def note(self, held: bool, told: float, urgent: Sequence[Fault]) -> None:
        """Write down what the supervisor said in this cycle, and the time stamp that the controller was given.

        ``urgent`` are the faults of which one may have been in it.
        """
        self._held[len(self._rows) - 1] = held
        self._told[len(self._rows) - 1] = told
        if self.urgent is None:
            self.urgent = next(((self.time, fault) for fault in urgent if fault.reaches(told)), None)

    def columns(self) -> dict[str, Array]:
        """The log; see `burnish.campaign.judge`."""
        model = _model(0.0)
        t, force, q, dq = (np.array(column, dtype=float) for column in zip(*self._rows, strict=True))
        count, n = q.shape
        tau, told, held = np.full((count, n), np.nan), np.full(count, np.nan), np.zeros(count)
        p, weight, energy = np.full((count, 3), np.nan), np.full((count, n), np.nan), np.full(count, np.nan)
        looked = -inf
        for row in range(count):
            before = max(row - 1, 0)
            tau[row] = _as_joints(self._sent[row], n) if row in self._sent else tau[before]
            told[row], held[row] = self._told.get(row, told[before]), self._held.get(row, held[before])
            if t[row] > looked + 0.9 * TRUTH_EVERY or held[row] != held[before]:
                arm = model.at(State(t=0.0, q=q[row], dq=dq[row]))
                p[row], weight[row], energy[row] = arm.p, arm.g, 0.5 * dq[row] @ arm.M @ dq[row]
                looked = t[row]
        sent = np.isin(np.arange(count), list(self._sent)).astype(float)
        return {
            "t": t, "told": told, "q": q, "dq": dq, "tau": tau, "sent": sent, "held": held, "p": p,
            "weight": weight, "force": force, "energy": energy,
        }  # fmt: skip


def _as_joints(tau: list[float], n: int) -> list[float]:
    """The torque, or no number for each joint where it is one for other joints."""
    return tau if len(tau) == n else [np.nan] * n
