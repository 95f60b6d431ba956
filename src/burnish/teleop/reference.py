"""`Operator`: what a hand asks for, as a tool reference that the arm can follow."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import hypot, inf, radians, sqrt

import numpy as np

from burnish.core import Array, Dynamics, ToolReference, read_only
from burnish.errors import InputError
from burnish.model.jaco2_parts import FINGERS_CLOSED
from burnish.rotation import exp, log
from burnish.teleop.device import AT_REST, Reading
from burnish.teleop.limits import ASIDE, Bounds, Mobility, Slowed, before_end
from burnish.teleop.modes import Frame, Panel, Wanted
from burnish.teleop.smooth import Smooth

FINGER_SPEED = FINGERS_CLOSED
"""Largest speed of the fingers [rad/s]: thesis A's 6800 vendor's units a second, of which 6800 close it."""
FINGER_ACCELERATION, FINGER_JERK = 10.0, 200.0
"""Of the fingers [rad/s², rad/s³]; a choice: at full speed in a fifth of a second."""
FINGER_BRAKING = 0.2
"""Time constant with which the fingers come to their ends [s]."""
LEASH_BRAKING = 0.03
"""Time constant with which the reference comes to the end of its leash [s]."""
EASY = 0.5
"""Share of the allowed force up to which pressing is not slowed down."""
SHARE = 0.85
"""Of a speed at which the arm would be stopped; a supervisor brakes from 0.9 of it."""
LONGEST = 0.05
"""Longest step that is integrated [s]: after a pause the reference does not leap."""


Closing = Callable[[Array], tuple[float, float]]
"""The way until the arm is too near itself [m], and how fast joint speeds dq, (n,), close it [m/s]."""


@dataclass(frozen=True, kw_only=True)
class Pace:
    """How fast the operator may move the tool, and how suddenly.

    The speeds are thesis A's. They bound the whole vector and not each axis. Acceleration and jerk are a choice: full
    speed, or rest, in 0.2 s; less where a joint would have to be accelerated too much for it.
    """

    linear: float = 0.2
    """[m/s]."""
    angular: float = 1.0
    """[rad/s]."""
    linear_acceleration: float = 2.0
    """[m/s²]."""
    angular_acceleration: float = 8.0
    """[rad/s²]."""
    linear_jerk: float = 40.0
    """[m/s³]."""
    angular_jerk: float = 160.0
    """[rad/s³]."""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not 0.0 < value < 1e6:
                raise InputError(f"Pace: {name} = {value}; expected a finite number more than 0")

    @classmethod
    def near_people(cls) -> Pace:
        """0.126 m/s: nine tenths of 0.14 m/s, at which a contact is below what all of a body bears (ISO/TS 15066).

        The supervisor brakes from here on, and stops the arm at 0.14 m/s.
        """
        return cls(linear=0.126)


@dataclass(frozen=True, kw_only=True)
class Leash:
    """How far the reference may get from the tool as it is measured: nothing winds up while the arm is held."""

    position: float = 0.012
    """[m]; a law as stiff as 1800 N/m pulls with 22 N at its end, less than what stops the arm."""
    angle: float = radians(8.0)
    """[rad]."""
    joints: float = radians(8.0)
    """Way that the joints may have to catch up, all together [rad]. Next to a singularity they stick while the tool is
    a little behind, and then make up for it: the farther, the faster."""

    def __post_init__(self) -> None:
        if not all(0.0 < value < 1.0 for value in vars(self).values()):
            raise InputError(
                f"Leash: {self.position} m, {self.angle} rad, {self.joints} rad of the joints; expected more "
                "than 0 and less than 1"
            )


@dataclass(kw_only=True)
class Operator:
    """A `Source` of tool references from the readings of a device.

        v_d = S(share · [R₁ v_max push; R₂ ω_max turn]),    ṗ_d = v_d,    Ṙ_d = [ω_d]× R_d

    R₁ and R₂ take the mode's frames to base axes: base as the operator stands to it, or the tool's as it is turned in
    the reference. The share slows the operator down before joint limits, singularities and the end of the leash; S
    makes the velocity smooth. R_d stays a rotation: it is turned by exp. What is read in a cycle acts in the reference
    of that cycle. Time is that of the arm.

    Source: thesis A, eq. 6.1 and 6.2, and thesis B, section 3.3, which integrates the pose.
    """

    read: Callable[[], Reading]
    """The device, asked once a cycle."""
    panel: Panel
    """Modes and deadman; it changes as buttons are pressed."""
    bounds: Bounds
    """Where the arm shall not get to."""
    pace: Pace = field(default_factory=Pace)
    """How fast."""
    leash: Leash = field(default_factory=Leash)
    """How far ahead of the tool."""
    press: float = inf
    """Force beyond which nobody presses harder by moving on [N]; for an arm that feels."""
    R_base_operator: Array = field(default_factory=lambda: np.eye(3))
    """From the operator's frame (right, away, up; see `Reading`) to base axes, (3, 3)."""
    taken: Callable[[], bool] = lambda: False
    """Whether somebody else has the arm, a supervisor that has tripped: the reference then goes with the arm.
    Afterwards the device has to be seen at rest, and the deadman to be pressed anew."""
    allowed_speed: Callable[[Dynamics, Array], float] = lambda arm, v: inf
    """How fast the tool point may be where the arm is, along v [m/s]; the operator gets `SHARE` of it."""
    clearance: Callable[[Dynamics], Closing] = lambda arm: lambda dq: (inf, 0.0)
    """How near itself the arm is where it is."""
    fingers: float = 0.0
    """Angle of the finger joints, open is 0 [rad]."""
    slowed: Slowed = field(default=Slowed(), init=False)
    """What held the operator back in the last cycle."""
    reading: Reading = field(init=False)
    """The last reading."""
    _rested: bool = field(default=False, init=False, repr=False)
    _stopped: bool = field(default=False, init=False, repr=False)
    _smooth: Smooth = field(init=False, repr=False)
    _p: Array = field(init=False, repr=False)
    _R: Array = field(init=False, repr=False)
    _t: float = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self.reading = Reading(t=0.0, axes=AT_REST, buttons=(), age=0.0)
        R = self.R_base_operator = read_only(self.R_base_operator)
        if R.shape != (3, 3) or not np.abs(R @ R.T - np.eye(3)).max() < 1e-6 or not np.linalg.det(R) > 0.0:
            raise InputError(f"Operator: R_base_operator = {R.tolist()}; expected a rotation matrix")
        pace = self.pace
        self._smooth = Smooth(
            [pace.linear_acceleration] * 3 + [pace.angular_acceleration] * 3 + [FINGER_ACCELERATION],
            [pace.linear_jerk] * 3 + [pace.angular_jerk] * 3 + [FINGER_JERK],
        )

    def stop(self) -> None:
        """Come to rest as fast as `pace` allows, whatever the operator does; until the next `reset`."""
        self._stopped = True

    def reset(self, arm: Dynamics) -> None:
        """Start at rest from this instant and pose; the device has to be seen at rest before it moves anything.

        Raises:
            InputError: if the bounds are those of another number of joints.
        """
        if len(self.bounds.lower) != len(arm.q):
            raise InputError(f"Operator: bounds of {len(self.bounds.lower)} joints; the arm has {len(arm.q)}")
        self._stopped = False
        self._go_with(arm)

    def at(self, arm: Dynamics) -> ToolReference:
        """The reference at the instant of ``arm``, with what the device says now."""
        # First what does not depend on the hand: it is then the later read, and the sooner obeyed.
        here, itself = Mobility(arm.J), self.clearance(arm)
        self.reading = self.read()
        self.panel = self.panel.step(self.reading.buttons)
        if self.taken():
            self.panel, self.slowed = self.panel.let_go(), Slowed()
            self._go_with(arm)
            return ToolReference(p=self._p, R=self._R, v=np.zeros(6), a=np.zeros(6))
        wanted = self._wanted()
        twist = self._twist(wanted)
        slower = (
            self.bounds.slowed(arm, here, twist),
            _before_itself(itself, here, twist),
            self._as_allowed(arm, twist),
            self._as_hard_as_allowed(arm, twist),
            self._before_leash_ends(arm, here, twist),
        )
        self.slowed = min(slower, key=lambda slowed: slowed.share)
        target = np.array([*(self.slowed.share * twist).tolist(), self._finger_speed(wanted.close)])
        ease = here.ease(self._smooth.v[:6], target[:6], self._smooth.acceleration[:6])
        way, v, a = self._smooth.step(target, min(max(0.0, arm.t - self._t), LONGEST), ease)
        over = self.bounds.overshot(here, v[:6])
        if over > 1.0:
            way, v, a = way / over, v / over, np.zeros(len(a))
            self._smooth.go_on_with(v, a)
        self._t = max(self._t, arm.t)
        self._p, self._R = self._p + way[:3], exp(way[3:6]) @ self._R
        self._on_leash(arm, here, v, a)
        self.fingers = min(max(self.fingers + float(way[6]), 0.0), FINGERS_CLOSED)
        return ToolReference(p=self._p, R=self._R, v=v[:6], a=a[:6])

    def _wanted(self) -> Wanted:
        """What the operator asks for; nothing from a device that has gone, or was not seen at rest yet."""
        self._rested = self._rested or self.reading.axes == AT_REST
        if self._stopped or not self._rested or not self.reading.connected:
            return Wanted()
        return self.panel.wanted(self.reading.axes)

    def _twist(self, wanted: Wanted) -> Array:
        """In base axes, within the speeds [m/s, rad/s], (6,)."""
        mode, twist = self.panel.modes.mode, np.zeros(6)
        for part, frame, values, fastest in (
            (twist[:3], mode.translation, wanted.push, self.pace.linear),
            (twist[3:], mode.rotation, wanted.turn, self.pace.angular),
        ):
            if frame is not None and any(values):
                R = self._R if frame is Frame.TOOL else self.R_base_operator
                part[:] = R.dot(fastest * _within_one(values))
        return twist

    def _finger_speed(self, close: float) -> float:
        """Slower towards the ends [rad/s]."""
        left = FINGERS_CLOSED - self.fingers if close > 0.0 else self.fingers
        return float(close * min(FINGER_SPEED, left / FINGER_BRAKING))

    def _as_allowed(self, arm: Dynamics, twist: Array) -> Slowed:
        """No faster than the tool may be here."""
        speed = _length(twist[:3])
        most = SHARE * self.allowed_speed(arm, twist[:3]) if speed > 0.0 else inf
        return Slowed(most / speed, "people near by") if speed > most else Slowed()

    def _as_hard_as_allowed(self, arm: Dynamics, twist: Array) -> Slowed:
        """Further into what is pressed only up to the force that is allowed."""
        if arm.F is None:
            return Slowed()
        F, v = arm.F[:3], twist[:3]
        size, soft = _length(F), EASY * self.press
        # Against the force, and not across it as friction is.
        if size <= soft or -float(F @ v) <= 0.5 * size * _length(v):
            return Slowed()
        return Slowed(max(0.0, (self.press - size) / (self.press - soft)), "pressing hard")

    def _before_leash_ends(self, arm: Dynamics, here: Mobility, twist: Array) -> Slowed:
        """The rule of `Bounds` for the leash."""
        slowed, tool = Slowed(), self._ahead(arm, twist)
        catch_up = here.joint_speeds(np.concatenate([tool[0][0], tool[1][0]]))
        for ahead, speed, most in (*tool, (catch_up, here.joint_speeds(twist), self.leash.joints)):
            far = _length(ahead)
            reach = LEASH_BRAKING * float(ahead @ speed) / far if far > 0.0 else 0.0
            left = max(most - far, 0.0)
            if reach > left and left / reach < slowed.share:
                slowed = Slowed(left / reach, "the arm does not follow")
        return slowed

    def _on_leash(self, arm: Dynamics, here: Mobility, v: Array, a: Array) -> None:
        """Pull the reference to the end of the leash where it is beyond, and take what leads further out of v and a."""
        ahead = np.concatenate([self._p - arm.p, log(self._R @ arm.R.T)])
        far = _length(here.joint_speeds(ahead)) / self.leash.joints
        if far > 1.0:
            self._p, self._R = arm.p + ahead[:3] / far, exp(ahead[3:] / far) @ arm.R
        pulled = []
        for k, (ahead, _, most) in enumerate(self._ahead(arm, v)):
            far = _length(ahead)
            pulled.append(ahead * (most / far) if far > most else None)
            if far > most:
                out = ahead / far
                for motion in (v[3 * k : 3 * k + 3], a[3 * k : 3 * k + 3]):
                    motion -= max(float(out @ motion), 0.0) * out
        position, turn = pulled
        if position is not None:
            self._p = arm.p + position
        if turn is not None:
            self._R = exp(turn) @ arm.R
        if position is not None or turn is not None:
            self._smooth.go_on_with(v, a)

    def _ahead(self, arm: Dynamics, twist: Array) -> tuple[tuple[Array, Array, float], tuple[Array, Array, float]]:
        """For position and orientation: how far the reference is ahead, the twist's part, the leash."""
        return (
            (self._p - arm.p, twist[:3], self.leash.position),
            (log(self._R @ arm.R.T), twist[3:6], self.leash.angle),
        )

    def _go_with(self, arm: Dynamics) -> None:
        self._p, self._R, self._t = arm.p, arm.R, arm.t
        self._rested = False
        self._smooth.rest()


def _before_itself(itself: Closing, here: Mobility, twist: Array) -> Slowed:
    """The rule of `Bounds` for the arm's own parts."""
    dq = here.joint_speeds(twist)
    way, speed = itself(dq)
    return before_end(way, speed - ASIDE * float(np.abs(dq).max()), "the arm itself")


def _within_one(values: tuple[float, float, float]) -> Array:
    """A vector no longer than 1, in its direction: corners of the cap's range are no faster than its axes."""
    return np.array(values) / max(1.0, hypot(*values))


def _length(vector: Array) -> float:
    return sqrt(float(vector.dot(vector)))
