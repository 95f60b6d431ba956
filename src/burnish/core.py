"""The data that crosses borders between layers, and the protocols that connect them.

Notation: joint position ``q`` [rad], velocity ``dq`` [rad/s], torque ``tau`` [N·m]; tool position ``p``
[m] and rotation ``R`` (base ← tool); twist ``v = [linear; angular]`` [m/s, rad/s] of the tool point in base
axes; ``F`` a wrench ``[force; moment]`` [N, N·m] that the environment exerts on the tool, in base axes
about the tool point. The plant is ``M q̈ + h + g + friction = tau + Jᵀ F``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Protocol, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import lapack
from typing_extensions import Self

from burnish.errors import InputError
from burnish.inverse import task_inertia

Array: TypeAlias = NDArray[np.float64]

SINGULAR_MOBILITY = 0.01
"""Eigenvalue of J M⁻¹ Jᵀ [1/kg, 1/(kg·m²)] below which Λ is damped: a tool that feels heavier than about
100 kg in some direction is next to a singularity there. A choice, far from both (a JACO2 is 1–10 kg)."""


def read_only(values: ArrayLike) -> Array:
    """A private float64 copy of ``values`` that nobody can write to."""
    array = np.array(values, np.float64)
    array.setflags(write=False)
    return array


@dataclass(frozen=True, slots=True, kw_only=True)
class State:
    """What a robot measured at one instant; arrays are copied and made read-only."""

    t: float
    """Time of the measurement on the robot's monotonic clock [s]."""
    q: Array
    """Joint positions, multi-turn [rad], shape (n,)."""
    dq: Array
    """Joint velocities [rad/s], shape (n,)."""
    tau: Array | None = None
    """Joint torques measured on the link side of the gears [N·m], shape (n,); None without sensors."""
    F: Array | None = None
    """Wrist sensor reading [N, N·m], shape (6,): the wrench that all beyond the sensor (contact, weight of
    the tool, bias) exerts on the arm, in **sensor** axes about the sensor's origin; None without a sensor."""

    @classmethod
    def of(cls, t: float, q: Array, dq: Array, tau: Array | None, F: Array | None) -> Self:
        """A state of arrays that nobody else holds: taken as they are, and made read-only."""
        state, own = object.__new__(cls), object.__setattr__
        own(state, "t", t)
        for name, values in (("q", q), ("dq", dq), ("tau", tau), ("F", F)):
            if values is not None:
                values.setflags(write=False)
            own(state, name, values)
        return state

    def __post_init__(self) -> None:
        own = object.__setattr__
        own(self, "q", read_only(self.q))
        own(self, "dq", read_only(self.dq))
        if self.tau is not None:
            own(self, "tau", read_only(self.tau))
        if self.F is not None:
            own(self, "F", read_only(self.F))
        if self.q.ndim != 1 or self.dq.shape != self.q.shape:
            raise InputError(
                f"State: q has shape {self.q.shape} and dq {self.dq.shape}; expected two vectors of one length"
            )


@dataclass(frozen=True, kw_only=True)
class Dynamics:
    """The model evaluated at one State: having one is the proof that its terms belong together.

    All terms satisfy ``M q̈ + h + g = tau + Jᵀ F``; rotor inertia that the model was given is inside ``M``.
    """

    t: float
    """Time of the state [s]."""
    q: Array
    """Joint positions [rad], (n,)."""
    dq: Array
    """Joint velocities [rad/s], (n,)."""
    p: Array
    """Tool position in the base frame [m], (3,)."""
    R: Array
    """Tool rotation, base ← tool, (3, 3)."""
    J: Array
    """Geometric Jacobian of the tool point, linear rows first, base axes, (6, n)."""
    dJdq: Array
    """J̇ q̇, the tool acceleration at zero joint acceleration [m/s², rad/s²], (6,)."""
    M: Array
    """Mass matrix [kg·m²], (n, n)."""
    h: Array
    """Coriolis and centrifugal torque C(q, q̇) q̇ [N·m], (n,)."""
    g: Array
    """Gravity torque [N·m], (n,): the torque that holds the arm still."""
    tau: Array | None = None
    """Measured joint torques, as in State [N·m], (n,)."""
    F: Array | None = None
    """Contact wrench, base axes about the tool point [N, N·m], (6,); None until something has estimated it."""

    @classmethod
    def of(cls, **terms: Any) -> Self:
        """The terms as they are, by name: what the constructor makes, in a third of its time."""
        arm = object.__new__(cls)
        arm.__dict__.update(terms)
        return arm

    def feeling(self, F: Array) -> Dynamics:
        """This with a contact wrench F; what was computed before is kept, because none of it depends on F."""
        felt = object.__new__(Dynamics)
        felt.__dict__.update(self.__dict__, F=F)
        return felt

    @cached_property
    def v(self) -> Array:
        """Tool twist J q̇ [m/s, rad/s], (6,)."""
        return np.asarray(self.J.dot(self.dq))

    @cached_property
    def Minv_JT(self) -> Array:
        """M⁻¹ Jᵀ, (n, 6)."""
        _, solution, info = lapack.dposv(self.M, self.J.T, lower=1)
        if info != 0:
            raise InputError("the mass matrix is not positive definite: the model's inertias are not physical")
        return np.asarray(solution)

    @cached_property
    def _task(self) -> tuple[Array, Array]:
        return task_inertia(self.J, self.M, SINGULAR_MOBILITY)

    @property
    def Lambda(self) -> Array:
        """Operational-space inertia (J M⁻¹ Jᵀ)⁻¹, damped next to a singularity, (6, 6) [kg, kg·m, kg·m²]."""
        return self._task[0]

    @property
    def J_bar(self) -> Array:
        """Dynamically consistent generalised inverse M⁻¹ Jᵀ Λ, (n, 6)."""
        return self._task[1]


@dataclass(frozen=True, slots=True, kw_only=True)
class JointReference:
    """Where the joints shall be, and how they shall move."""

    q: Array
    """Desired joint positions [rad], (n,)."""
    dq: Array
    """Desired joint velocities [rad/s], (n,)."""
    ddq: Array
    """Desired joint accelerations [rad/s²], (n,)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ToolReference:
    """Where the tool shall be, how it shall move, and how hard it shall press."""

    p: Array
    """Desired tool position, base frame [m], (3,)."""
    R: Array
    """Desired tool rotation, base ← tool, (3, 3)."""
    v: Array
    """Desired twist, base axes [m/s, rad/s], (6,)."""
    a: Array
    """Desired acceleration, base axes [m/s², rad/s²], (6,)."""
    normal: Array | None = None
    """Outward unit normal of the surface under the tool, base axes, (3,); None where nothing is pressed."""
    force: float = 0.0
    """Wanted contact force along the normal [N]; positive presses the tool into the surface."""
    stiffness: float = 1.0
    """Share of the law's stiffness with which the tool is held here, more than 0; `ForceMotion` heeds it."""


@dataclass(frozen=True, slots=True)
class Torque:
    """A command to the joints of a torque-controlled arm; gravity included."""

    tau: Array
    """Joint torques [N·m], (n,)."""


@dataclass(frozen=True, slots=True)
class JointPosition:
    """A command to an arm in position mode: go there, at the arm's own pace; the next one takes its place."""

    q: Array
    """Joint positions, multi-turn [rad], (n,)."""


@dataclass(frozen=True, slots=True)
class JointVelocity:
    """A command to an arm in position mode: move like this for one control period."""

    dq: Array
    """Joint velocities [rad/s], (n,)."""


Command: TypeAlias = Torque | JointPosition | JointVelocity


class Sample(NamedTuple):
    """One cycle: the model at the measured state, what was wanted, commanded, and really applied."""

    arm: Dynamics
    reference: Any
    commanded: Array
    applied: Array


Ref = TypeVar("Ref")
Ref_co = TypeVar("Ref_co", covariant=True)
Ref_contra = TypeVar("Ref_contra", contravariant=True)


class Source(Protocol[Ref_co]):
    """Time (or an operator) to a reference: a trajectory, teleoperation, a replay."""

    def reset(self, arm: Dynamics) -> None:
        """Start from this instant and this pose."""

    def at(self, arm: Dynamics) -> Ref_co:
        """The reference at the instant of ``arm``."""


class Controller(Protocol[Ref_contra]):
    """A control law: the model at a state and a reference in, a joint torque out."""

    def reset(self, arm: Dynamics) -> None:
        """Clear the memory; refuse, before motion, an arm that the law cannot drive."""

    def torque(self, arm: Dynamics, reference: Ref_contra) -> Array:
        """Joint torques [N·m], (n,), gravity included."""


class Robot(Protocol):
    """An arm: simulated, real or a mock. It paces the loop, and refuses the kinds of command that it cannot do."""

    def __enter__(self) -> Self:
        """Take the arm."""

    def __exit__(self, *exception: object) -> None:
        """Leave the arm safe, whatever happened."""

    def read(self) -> State:
        """Block until the next measurement and return it."""

    def write(self, command: Command) -> Array:
        """Send a command; returns what of it is really applied, in its own unit, (n,): of a `Torque` N·m."""
