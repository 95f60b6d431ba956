"""`SimRobot`: the arm in MuJoCo behind the `Robot` protocol, as late, biased and stiff as its plant."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from math import isfinite
from time import perf_counter

import mujoco
import numpy as np
from numpy.typing import ArrayLike
from typing_extensions import Self

from burnish.core import Array, Command, State, Torque
from burnish.errors import InputError, SimulationError
from burnish.model.tool import PolishingTool
from burnish.sim.contact import Touch, Vector, contact_of, plain
from burnish.sim.hand import Fingers, Hand
from burnish.sim.plant import Plant
from burnish.sim.scene import TIMESTEP, Workpiece, build
from burnish.sim.things import Table, Thing, body_of
from burnish.sim.truth import Truth

HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
"""The vendor's home pose [rad] (thesis B, eq. 5.1)."""
WRIST_FILTER = 4e-3
"""The wrist sensor averages its samples over this time [s], or over one control period if that is shorter."""
BODY = int(mujoco.mjtObj.mjOBJ_BODY)
SENSORS_OFF = int(mujoco.mjtDisableBit.mjDSBL_SENSOR)
"""The engine's force sensors cost a pass over the tree; they run only while the wrist sensor averages."""


class SimRobot:
    """A simulated JACO2 with a polishing tool, with a hand that moves its fingers, or bare.

    `read` runs the physics up to the next sample and returns what the sensors say; `write` sends a torque, which
    acts after the plant's delay. The truth is in `truth`, for metrics and reports only. ``late_cycles`` counts the
    cycles in which the controller took longer than a period.
    """

    def __init__(
        self,
        q: Array = HOME,
        *,
        rate: float = 1000.0,
        plant: Plant | None = None,
        tool: PolishingTool | None = None,
        workpiece: Workpiece | None = None,
        hand: Hand | None = None,
        things: Sequence[Thing] = (),
    ) -> None:
        """An arm at rest at ``q`` [rad], held by its gravity torque, sampled at ``rate`` [Hz].

        Args:
            q: joint positions at the start [rad], (n,).
            rate: sampling rate [Hz].
            plant: what the arm really is; the ideal one, equal to `Model.jaco2`, without it.
            tool: the tool in its hand, with a wrist sensor; a bare arm without wrist sensor without it.
            workpiece: the mould under the tool.
            hand: a hand whose fingers move and touch; a stiff one with open fingers, which touches nothing, without it.
            things: what stands around the hand.

        Raises:
            InputError: if the rate is out of range, there is a mould but no tool, there are things but no hand, a tool
                and a hand, or two things of one name.
        """
        if not 20.0 <= rate <= 1.0 / TIMESTEP:
            raise InputError(f"rate {rate} Hz is out of range; expected 20 to {1.0 / TIMESTEP:.0f} Hz")
        self._plant = plant if plant is not None else Plant.ideal()
        if workpiece is not None and tool is None:
            raise InputError("a work-piece without a tool: nothing would touch it; give SimRobot a PolishingTool")
        _check_hand(hand, tool, things)
        scene = build(tool, self._plant, workpiece, hand, things)
        self._n, self._tip, self._tool_body = scene.n, scene.tip, scene.tool
        self._model = scene.model
        self._data = mujoco.MjData(scene.model)
        self._data.qpos[: self._n] = q
        self._limit = scene.effort_limit.tolist()
        self.period = 1.0 / rate
        self.late_cycles = 0
        self._read_at = 0.0
        self._draws = self._plant.clock_errors()
        self._errors = self._plant.sensor_errors()
        self._queue: deque[tuple[float, Array]] = deque()
        self._feels = tool is not None
        self._window = max(1, round(min(WRIST_FILTER, self.period) / TIMESTEP))
        self._velocity = np.zeros(6)
        # Views into the engine's memory, made once: to look one up anew costs more than to read it.
        data, n = self._data, self._n
        self._tip_centre, self._push = data.xpos[self._tip], data.xfrc_applied[self._tip]
        self._on_hand, self._base = data.xfrc_applied[scene.hand], data.xmat[scene.base].reshape(3, 3)
        # The third column of the tool's rotation.
        self._axis = data.xmat[self._tool_body][2::3]
        self._contact = None
        if workpiece is not None and tool is not None:
            self._contact = contact_of(workpiece.grid, tool, self._axis)
        self._qpos, self._qvel, self._qacc = data.qpos[:n], data.qvel[:n], data.qacc[:n]
        self._applied, self._constraint, self._passive = (
            data.qfrc_applied[:n],
            data.qfrc_constraint[:n],
            data.qfrc_passive[:n],
        )
        self._fingers = None
        if hand is not None:
            self._fingers = Fingers(hand, self._model, data)
            # The engine's own vector also holds what the contacts do to the joints, which is no friction.
            self._constraint = np.zeros(n)
        self._sensed, self._warnings = data.sensordata, data.warning.number
        self._option = scene.model.opt
        counts = self._plant.encoder_counts
        self._per_radian = None if counts is None else counts / (2.0 * np.pi)
        self._touching = False
        self._steps = 0
        self._started = False
        self._q_before = self._encoders()
        self._t_before = 0.0
        self._loose = [thing.name for thing in things if not isinstance(thing, Table)]
        self.truth = Truth(timestep=TIMESTEP)
        mujoco.mj_forward(self._model, self._data)
        self._wrench = np.array(self._data.sensordata)
        # At rest the arm is held where it is, tip included, until the first command acts.
        self._applied[:] = self._data.qfrc_bias[: self._n]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self._queue.clear()

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._steps * TIMESTEP

    def truth_dq(self) -> Array:
        """True joint speeds at this instant [rad/s], (n,): for a judge, never for a controller."""
        return np.array(self._qvel)

    def fingers(self) -> Array:
        """Angles of the finger drives, 0 when open [rad], (3,).

        Raises:
            InputError: if the arm has no hand that moves.
        """
        return self._hand().angles()

    def move_fingers(self, angles: ArrayLike) -> None:
        """Send the finger drives to these angles [rad], (3,), 0 to 1.396; does not wait.

        Raises:
            InputError: if they are not three finite numbers, or the arm has no hand that moves.
        """
        self._hand().go_to(angles)

    def truth_grip(self) -> Array:
        """True normal force of each finger [N], (3,), thumb first: for a judge, never for a controller."""
        return self._hand().grip()

    def truth_pose(self, name: str) -> tuple[Array, Array]:
        """Where a thing truly is: p (3,) [m] and R (3, 3), base axes; for a judge, never for a controller.

        Raises:
            InputError: if there is no such thing.
        """
        if name not in self._loose:
            raise InputError(f"no thing {name!r}; there are: {', '.join(self._loose) or 'none'}")
        body = self._data.body(body_of(name))
        return np.array(body.xpos), np.array(body.xmat).reshape(3, 3)

    def read(self) -> State:
        """Run the physics to the next sample; what the sensors read then.

        Raises:
            SimulationError: if the physics left the finite numbers.
        """
        if self._started:
            off = self._plant.period_jitter * (2.0 * next(self._draws) - 1.0) if self._plant.period_jitter else 0.0
            steps = max(1, round(self.period * (1.0 + off) / TIMESTEP))
            if self._fingers is not None:
                self._fingers.drive(steps * TIMESTEP)
            self._advance(steps)
        if self._fingers is not None:
            self._constraint[:] = self._fingers.dry_friction(self._n)
        self._started = True
        state = self._measure()
        self._read_at = perf_counter()
        return state

    def write(self, command: Command) -> Array:
        """Send a torque; it acts after the plant's delay. Returns the torque after the driver's last clamp [N·m].

        Raises:
            InputError: if the torque is not finite, or the command is none: this arm has no position mode.
        """
        if not isinstance(command, Torque):
            raise InputError(f"the simulated arm takes a Torque; it has no position mode for {type(command).__name__}")
        asked = command.tau.tolist()
        if not all(map(isfinite, asked)):
            raise InputError(f"torque command {command.tau} is not finite; the driver does not send it")
        limits = zip(asked, self._limit, strict=True)
        tau = np.array([-most if a < -most else most if a > most else a for a, most in limits])
        # Simulated time waits for the controller; a real arm would not.
        self.late_cycles += perf_counter() - self._read_at > self.period
        late = self._plant.delay
        if self._plant.jitter:
            late += self._plant.jitter * next(self._draws)
        self._queue.append((self.time + late * self.period, tau))
        return tau

    def push(self, F: Array) -> None:
        """Somebody pushes the hand from now on: a wrench about the tool frame's origin, base axes [N, N·m], (6,)."""
        self._on_hand[:3], self._on_hand[3:] = self._base @ F[:3], self._base @ F[3:]

    def _hand(self) -> Fingers:
        """The drives of the fingers."""
        if self._fingers is None:
            raise InputError("this simulated arm has no fingers that move; give SimRobot a Hand()")
        return self._fingers

    def _advance(self, steps: int) -> None:
        """``steps`` physics steps with the queued commands and the contact."""
        model, data, queue, option = self._model, self._data, self._queue, self._option
        force = self.truth.normal_force.append
        touch = None
        read_from = steps - self._window
        self._wrench[:] = 0.0
        always = read_from <= 0
        if always:
            option.disableflags &= ~SENSORS_OFF
        for step in range(steps):
            if step == read_from and not always:
                option.disableflags &= ~SENSORS_OFF
            while queue and queue[0][0] <= self._steps * TIMESTEP + 1e-9:
                self._applied[:] = queue.popleft()[1]
            mujoco.mj_step1(model, data)
            touch = self._touch()
            mujoco.mj_step2(model, data)
            self._steps += 1
            force(0.0 if touch is None else touch.normal_force)
            if step >= read_from:
                self._wrench += self._sensed
        if not always:
            option.disableflags |= SENSORS_OFF
        self._wrench /= min(steps, self._window)
        if any(self._warnings.tolist()) or not all(map(isfinite, self._qvel.tolist())):
            raise SimulationError(f"the simulated arm diverged at t = {self.time:.3f} s; its numbers cannot be used")
        self._log(touch)

    def _measure(self) -> State:
        """The sensors at this instant."""
        plant, n = self._plant, self._n
        q, t = self._encoders(), self.time
        if plant.encoder_counts is None:
            dq = np.array(self._qvel)
        else:
            dq = (q - self._q_before) / (t - self._t_before) if t > self._t_before else np.zeros(n)
        self._q_before, self._t_before = q, t
        link_side = self._applied + self._constraint + self._passive - plant.armature * self._qacc
        # The engine's sensor gives what the arm exerts on the tool; a wrist sensor is read the other way round.
        off = next(self._errors)
        felt = off[n:] - self._wrench if self._feels else None
        return State.of(t, q, dq, link_side + off[:n], felt)

    def _encoders(self) -> Array:
        """Joint positions as the encoders count them [rad]."""
        if self._per_radian is None:
            return np.array(self._qpos)
        return np.asarray(np.rint(self._qpos * self._per_radian) / self._per_radian)

    def _touch(self) -> Touch | None:
        """The contact at this instant, applied to the tip."""
        contact = self._contact
        if contact is None:
            return None
        cx, cy, cz = self._tip_centre.tolist()
        touch = contact.touch((cx, cy, cz), self._tip_motion)
        if touch is not None:
            (fx, fy, fz), (px, py, pz), (mx, my, mz) = touch.force, touch.point, touch.moment
            rx, ry, rz = px - cx, py - cy, pz - cz
            self._push[:] = (fx, fy, fz, mx + ry * fz - rz * fy, my + rz * fx - rx * fz, mz + rx * fy - ry * fx)
            self._touching = True
        elif self._touching:
            self._push[:] = 0.0
            self._touching = False
        return touch

    def _tip_motion(self) -> tuple[Vector, Vector]:
        """Velocity of the tip's centre [m/s] and its angular velocity [rad/s]."""
        # [angular; linear] velocity at the origin of the tip's body, which is the centre of the sphere.
        mujoco.mj_objectVelocity(self._model, self._data, BODY, self._tip, self._velocity, 0)
        wx, wy, wz, vx, vy, vz = self._velocity.tolist()
        return (vx, vy, vz), (wx, wy, wz)

    def _log(self, touch: Touch | None) -> None:
        """Write the truth of the cycle that ends now."""
        truth, nowhere = self.truth, (np.nan, np.nan, np.nan)
        truth.cycle_step.append(self._steps)
        truth.time.append(self.time)
        truth.point.append(nowhere if touch is None else touch.point)
        truth.normal.append(nowhere if touch is None else touch.normal)
        truth.slip.append(0.0 if touch is None else touch.slip)
        truth.axis.append(plain(self._axis))


def _check_hand(hand: Hand | None, tool: PolishingTool | None, things: Sequence[Thing]) -> None:
    """Refuse a cell that cannot be.

    Raises:
        InputError: if hand, tool and things do not go together.
    """
    if hand is not None and tool is not None:
        raise InputError("a polishing tool and a moving hand: the tool is where the fingers would be; give one of them")
    if hand is None and things:
        raise InputError("things without a hand: nothing would touch them; give SimRobot a Hand()")
    names = [thing.name for thing in things]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError(f"two things are called {', '.join(twice)}; give each a name of its own")
