"""An arm with the habits of the vendor's firmware: what the base and the actuators do, on the simulated honest arm.

Written from what is known of the firmware; a figure that is a guess says so. Inside, joints count in radians from where
the arm really is; what the library sees is in degrees, from where the encoders were zeroed.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from hardware.memory import FUNCTIONS, JOINTS, SLOTS, TRACE, Memory

from burnish.core import Array, State, Torque
from burnish.model.model import Model
from burnish.model.tool import PolishingTool
from burnish.polish.cell import nominal_placement
from burnish.sim import arms
from burnish.sim.plant import Plant
from burnish.sim.robot import HOME, SimRobot
from burnish.sim.scene import Workpiece
from burnish.surface import DistanceGrid, Mould

ACTUATOR_PERIOD = 1e-3
DSP_PERIOD = 0.01
INACTIVITY = 0.25
QUEUE = 2000
SPEED = np.deg2rad([36.0] * 3 + [48.0] * 3)
TORQUE = np.array([30.5] * 3 + [6.8] * 3)
ACCELERATION = 2.0
"""Of the base's own trajectories [rad/s²]; a guess."""
STIFFNESS, DAMPING = np.repeat([4000.0, 600.0], 3), np.repeat([200.0, 20.0], 3)
"""Of the actuators' position loops [N·m/rad, N·m·s/rad]; a guess that carries a kilogram within 2 mm."""
LOWER, UPPER = np.full(6, -np.inf), np.full(6, np.inf)
LOWER[1:3], UPPER[1:3] = np.deg2rad([47.0, 19.0]), np.deg2rad([313.0, 341.0])
POSITION, VELOCITY = 2, 8
FINGER_SPEED = 5667.0
"""Finger units a second: a closing hand takes about 1.2 s."""


@dataclass(frozen=True, kw_only=True)
class Options:
    """What kind of arm stands there; a test's words."""

    arm: str = "honest"
    seed: int = 1
    q: tuple[float, ...] = tuple(HOME)
    payload: float = 0.0
    bias: float = 1.0
    """The torque sensors' offsets over those of the drawn arm."""
    wrapped: bool = False
    """Whether angles are reported within a turn, from −180° to 180°."""
    joint_zero_at: float = 180.0
    """SetJointZero takes a joint to stand at the nearest multiple of this [deg]; 0: at 0."""
    mould: str = ""
    """File of a mould that lies before the arm, which then has the polishing tool in its hand."""
    mould_top: float = 0.0
    """Height of the mould [m]: it is placed by it."""
    realtime: bool = False

    def plant(self) -> Plant:
        """The arm as it really is; delays come from the base's clock, not from the plant."""
        plant = getattr(arms, self.arm)(self.seed).plant
        bias = self.bias * plant.torque_bias
        return replace(plant, delay=0.0, jitter=0.0, period_jitter=0.0, payload=self.payload, torque_bias=bias)

    def workpiece(self) -> Workpiece | None:
        """What lies before the arm."""
        if not self.mould:
            return None
        placement = nominal_placement(self.mould_top)
        return Workpiece(grid=DistanceGrid.of(Mould.load(self.mould)), p=placement.p, R=placement.R)


@dataclass
class Settings:
    """What the base has been told; back to this at every start."""

    inactivity: int = 1
    safety_factor: float = 1.0
    damping: Array = field(default_factory=lambda: np.zeros(6))
    optimal_z: Array | None = None
    """None: the factory's parameters, which hold the arm."""
    payload: Array = field(default_factory=lambda: np.zeros(4))
    most: Array = field(default_factory=lambda: TORQUE.copy())


class Firmware:
    """The base at 100 Hz and the actuators at 1 kHz, driven by `advance`."""

    def __init__(self, memory: Memory, options: Options) -> None:
        self._memory = memory
        self._options = options
        tool = PolishingTool() if options.mould else None
        self._robot = SimRobot(
            np.array(options.q),
            rate=1.0 / ACTUATOR_PERIOD,
            plant=options.plant(),
            tool=tool,
            workpiece=options.workpiece(),
        )
        self._bare = self._nominal = tool.on(Model.jaco2()) if tool else Model.jaco2()
        self._rng = np.random.default_rng([options.seed, 11])
        self.settings = Settings()
        self.torque_mode = False
        self.queue: deque[tuple[int, Array]] = deque()
        self._state = self._robot.read()
        self._q_command, self._dq_command = self._state.q.copy(), np.zeros(6)
        self._torque = np.zeros(6)
        self._fingers, self._fingers_goal = np.zeros(3), np.zeros(3)
        self._angle_zero, self._torque_zero = np.zeros(6), np.zeros(6)
        self._weight = self._compensation = self._nominal.at(self._state).g
        self._seen_torques = memory.torque_sequence
        if options.payload:
            # The position loops sink a little under it.
            for _ in range(500):
                self._actuators()
        self._next_dsp = self.time
        memory.state_sequence = 0
        memory.tail, memory.traced, memory.torque_taken_at = memory.head, 0, -1.0
        memory.frozen = memory.refuse_torque_mode = memory.drop_to_position = 0
        memory.slowest = memory.fastest = 1.0 / DSP_PERIOD
        self._publish()

    @property
    def time(self) -> float:
        return self._state.t

    def advance(self, until: float) -> None:
        """Let the arm live to this time [s]."""
        while self.time < until - 1e-9:
            if self.time >= self._next_dsp - 1e-9:
                self._dsp()
            self._actuators()

    def _actuators(self) -> None:
        """One millisecond of the actuators' loops."""
        state = self._state
        if self.torque_mode:
            silence = state.t - self._memory.torque_taken_at
            if silence >= INACTIVITY - 1e-9:
                if self.settings.inactivity == 0:
                    self._to_position()
                else:
                    self._torque[:] = 0.0
            if self.settings.safety_factor < 1.0 and np.any(np.abs(state.dq) > self.settings.safety_factor * SPEED):
                self._to_position()
        if self.torque_mode:
            asked = np.clip(self._torque, -self.settings.most, self.settings.most)
            tau = asked + self._compensation - self.settings.damping * state.dq
        else:
            error = self._q_command - state.q
            tau = self._weight + STIFFNESS * error + DAMPING * (self._dq_command - state.dq)
            self._q_command = self._q_command + ACTUATOR_PERIOD * self._dq_command
        # The actuators' own limit, and the arm's friction, come from the simulated arm.
        self._robot.write(Torque(tau))
        self._state = self._robot.read()

    def _dsp(self) -> None:
        """One tick of the base: calls, queue, measurement."""
        memory = self._memory
        head = memory.head
        for slot in range(memory.tail, head):
            entry = memory.ring[slot % SLOTS]
            getattr(self, f"_on_{FUNCTIONS[entry.function]}", self._ignore)(np.array(entry.value))
        memory.tail = head
        if memory.torque_sequence != self._seen_torques:
            self._seen_torques = memory.torque_sequence
            self._torque = np.array(memory.torque_command, np.float64)
            memory.torque_taken_at = self.time
        if memory.drop_to_position:
            memory.drop_to_position = 0
            self._to_position()
        self._fingers += np.clip(self._fingers_goal - self._fingers, -FINGER_SPEED * 0.01, FINGER_SPEED * 0.01)
        self._follow_queue()
        q = self._state.q
        self._weight = self._nominal.at(State(t=0.0, q=q, dq=np.zeros(6))).g
        self._compensation = self._weight if self.settings.optimal_z is None else self._identified(q)
        self._publish()
        rate = self._rng.uniform(min(memory.slowest, memory.fastest), memory.fastest)
        self._next_dsp += round(1.0 / rate / ACTUATOR_PERIOD) * ACTUATOR_PERIOD

    def _identified(self, q: Array) -> Array:
        """Gravity by the identified parameters: the whole weight or, with zeros, nothing at all."""
        if not np.any(self.settings.optimal_z):
            return np.zeros(JOINTS)
        return self._weight

    def _follow_queue(self) -> None:
        """The speed at which the base moves the position command in this tick."""
        wanted = np.zeros(6)
        # Somebody at the joystick: joint 1 turns at this speed [rad/s], whatever the library says.
        wanted[0] = self._memory.joystick
        if self.queue and not self.torque_mode:
            kind, values = self.queue[0]
            if kind == VELOCITY:
                self.queue.popleft()
                wanted = values
            else:
                off = values - self._q_command
                if np.abs(off).max() < 1e-5:
                    self.queue.popleft()
                else:
                    # Along the straight line, braking in time: v² = 2 a d.
                    most = np.minimum(SPEED, np.sqrt(2.0 * 0.8 * ACCELERATION * np.abs(off)))
                    share = np.min(np.where(np.abs(off) > 1e-9, most / np.maximum(np.abs(off), 1e-9), np.inf))
                    wanted = off * min(share, 1.0 / DSP_PERIOD)
        wanted = np.clip(wanted, -SPEED, SPEED)
        step = ACCELERATION * DSP_PERIOD
        speed = self._dq_command + np.clip(wanted - self._dq_command, -step, step)
        if np.abs(wanted).max() < 0.02 and np.abs(self._dq_command).max() < 0.02:
            speed = wanted
        ahead = self._q_command + DSP_PERIOD * speed
        self._dq_command = np.where((ahead < LOWER) & (speed < 0) | (ahead > UPPER) & (speed > 0), 0.0, speed)

    def _to_position(self) -> None:
        if self.torque_mode:
            self.torque_mode = False
            self._q_command, self._dq_command = self._state.q.copy(), np.zeros(6)

    def _publish(self) -> None:
        """What the library may read, and the trace, which the switches do not touch."""
        memory, state, q = self._memory, self._state, self._state.q
        if not memory.frozen:
            memory.state_sequence += 1
            shown = np.rad2deg(q - self._angle_zero)
            if self._options.wrapped:
                shown = (shown + 180.0) % 360.0 - 180.0
            memory.position[:] = shown.tolist()
            memory.velocity[:] = np.rad2deg(state.dq).tolist()
            assert state.tau is not None
            memory.torque[:] = (state.tau - self._torque_zero).tolist()
            memory.gravity[:] = self._compensation.tolist()
            memory.command[:] = np.rad2deg(self._q_command - self._angle_zero).tolist()
            memory.fingers[:] = self._fingers.tolist()
            memory.queued = len(self.queue)
            memory.mode = int(self.torque_mode)
            memory.time = state.t
            memory.state_sequence += 1
        memory.trace[memory.traced % TRACE][:] = (state.t, *q.tolist(), float(self.torque_mode))
        memory.traced += 1

    # The calls.

    def _ignore(self, value: Array) -> None:
        """A call without effect on the motion."""

    def _on_SwitchTrajectoryTorque(self, value: Array) -> None:
        if value[0] == 0:
            self._to_position()
        elif not self._memory.refuse_torque_mode:
            if self.time - self._memory.torque_taken_at >= INACTIVITY:
                # Nothing to go on from: the silence begins now.
                self._torque[:] = 0.0
                self._memory.torque_taken_at = self.time
            self.torque_mode = True
            self.queue.clear()

    def _on_SendBasicTrajectory(self, value: Array) -> None:
        if value[1] == 1:
            self._fingers_goal = value[8:11].astype(np.float64)
        if len(self.queue) < QUEUE and not self.torque_mode:
            joints = np.deg2rad(value[2:8], dtype=np.float64)
            if value[0] == POSITION:
                joints = np.clip(self._turn(joints) + self._angle_zero, LOWER, UPPER)
            self.queue.append((int(value[0]), joints))

    def _turn(self, joints: Array) -> Array:
        """Wrapped angles mean the nearest turn."""
        if not self._options.wrapped:
            return joints
        here = self._q_command - self._angle_zero
        return here + (joints - here + np.pi) % (2.0 * np.pi) - np.pi

    def _on_EraseAllTrajectories(self, value: Array) -> None:
        self.queue.clear()

    def _on_MoveHome(self, value: Array) -> None:
        if not self.torque_mode:
            self.queue.clear()
            self.queue.append((POSITION, HOME.copy()))

    def _on_InitFingers(self, value: Array) -> None:
        self._fingers_goal = np.zeros(3)

    def _on_SetTorqueInactivityType(self, value: Array) -> None:
        self.settings.inactivity = int(value[0])

    def _on_SetTorqueSafetyFactor(self, value: Array) -> None:
        self.settings.safety_factor = float(value[0])

    def _on_SetTorqueActuatorDamping(self, value: Array) -> None:
        self.settings.damping = value[:6].astype(np.float64)

    def _on_SetAngularTorqueMinMax(self, value: Array) -> None:
        self.settings.most = value[6:12].astype(np.float64)

    def _on_SetGravityOptimalZParam(self, value: Array) -> None:
        if not self.torque_mode:
            self.settings.optimal_z = value[:16].astype(np.float64)

    def _on_SetGravityPayload(self, value: Array) -> None:
        mass, *com = value[:4].astype(float).tolist()
        self._nominal = self._bare.with_payload(mass, com) if mass > 0.0 else self._bare

    def _on_SetTorqueZero(self, value: Array) -> None:
        joint = int(value[0]) - 16
        assert self._state.tau is not None
        self._torque_zero[joint] = self._state.tau[joint]

    def _on_SetJointZero(self, value: Array) -> None:
        joint, step = int(value[0]) - 16, np.deg2rad(self._options.joint_zero_at)
        shown = self._state.q[joint] - self._angle_zero[joint]
        at = step * np.round(shown / step) if step > 0.0 else 0.0
        self._angle_zero[joint] = self._state.q[joint] - at


def options_of(words: dict[str, Any]) -> Options:
    """The options that came as JSON."""
    return Options(**{name: tuple(value) if isinstance(value, list) else value for name, value in words.items()})
