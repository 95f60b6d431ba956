"""Impedances: the tool as a mass on a spring and a damper, with the arm's own inertia or with a chosen one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from typing_extensions import Self

from burnish.control.checks import measured_wrench, need_inverse_of_jacobian, need_tool_reference
from burnish.control.error import OrientationError, pose_error
from burnish.control.gains import (
    DampingRatio,
    Gain,
    double_diagonal_damping,
    fit,
    joints,
    one,
    positive_definite,
    six,
)
from burnish.control.secondary import JointTask, total_acceleration
from burnish.control.task import SINGULAR_VALUE
from burnish.core import Array, Dynamics, ToolReference
from burnish.inverse import damped_inverse
from burnish.rotation import continuous_error


@dataclass(kw_only=True)
class SpringDamper:
    """Stiffness and damping of an impedance: ``w = K e + D (v_d − v)``, what three laws of thesis B share."""

    stiffness: Gain
    """K [N/m, N·m/rad]: one number, two (position, orientation) or six."""
    damping: Gain | DampingRatio
    """D [N·s/m, N·m·s/rad]: one number, two or six; or a `DampingRatio`, then D follows from inertia and K."""
    orientation_error: OrientationError = continuous_error
    """e_o of the errors of `burnish.rotation`."""
    _K: Array = field(init=False, repr=False)
    _D: Array | None = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._K = six(self, "stiffness", self.stiffness)
        self._D = None if isinstance(self.damping, DampingRatio) else np.diag(six(self, "damping", self.damping))

    @classmethod
    def from_stiffness(cls, stiffness: Gain, damping_ratio: float = 1.0, **others: Any) -> Self:
        """The damping by a ratio ζ of all modes of inertia and stiffness, double-diagonalised (`DampingRatio`)."""
        return cls(stiffness=stiffness, damping=DampingRatio(damping_ratio), **others)

    def wrench(self, arm: Dynamics, reference: ToolReference, inertia: Array | None = None) -> Array:
        """w [N, N·m], (6,), base axes; ``inertia`` is what D is for, Λ without it."""
        need_tool_reference(self, reference)
        e = pose_error(arm, reference, self.orientation_error)
        D = self._D
        if D is None:
            A = arm.Lambda if inertia is None else inertia
            D = double_diagonal_damping(A, np.diag(self._K), self.damping.ratio)  # type: ignore[union-attr]
        return self._K * e + D @ (reference.v - arm.v)


@dataclass(kw_only=True)
class Impedance(SpringDamper):
    """A spring and a damper at the tool: ``τ = Jᵀ w + s [Jᵀ Λ (a_d − J̇q̇) + h] + g``, with s = `feed_forward`.

    Needs no force sensor: pressed, the tool gives way as K, D and its own inertia Λ say. Gravity is included. Source:
    thesis B, eq. 4.19–4.21, that is s = 0; s = 1 makes it the same as the two laws below with A = Λ.
    """

    feed_forward: float = 0.0
    """s: share of the arm's own dynamics along the reference that is fed forward, 0 to 1."""
    joint_damping: Gain = 0.0
    """D_q [N·m·s/rad], (n,) or one number, of an added −D_q q̇: what calms the self-motion of a redundant arm."""
    _D_q: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        one(self, "feed_forward", self.feed_forward)
        self._D_q = joints(self, "joint_damping", self.joint_damping)

    def reset(self, arm: Dynamics) -> None:
        """No memory.

        Raises:
            InputError: if the joint damping does not fit the arm.
        """
        fit(self, arm, joint_damping=self._D_q)

    def torque(self, arm: Dynamics, reference: ToolReference) -> Array:
        """Joint torques [N·m], (n,), gravity included."""
        tau = arm.J.T @ self.wrench(arm, reference) + arm.g - self._D_q * arm.dq
        if self.feed_forward > 0.0:
            along = arm.J.T @ (arm.Lambda @ (reference.a - arm.dJdq)) + arm.h
            tau = tau + self.feed_forward * along
        return np.asarray(tau)


@dataclass(kw_only=True)
class ShapedImpedance(SpringDamper):
    """An impedance with a freely chosen inertia: ``A (v̇ − a_d) = w + F``; what the two laws below share."""

    inertia: ArrayLike | None = None
    """A [kg, kg·m, kg·m²], (6, 6), base axes; None keeps the arm's own Λ: then no wrench needs to be measured."""
    _A: Array | None = field(init=False, repr=False)
    _A_inverse: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._A = None if self.inertia is None else positive_definite(self, "inertia", self.inertia)
        if self._A is not None:
            self._A_inverse = np.asarray(np.linalg.inv(self._A), dtype=np.float64)

    def reset(self, arm: Dynamics) -> None:
        """No memory.

        Raises:
            InputError: if A is chosen and nothing has estimated the contact wrench.
        """
        if self._A is not None:
            measured_wrench(self, arm)

    def acceleration(self, arm: Dynamics, reference: ToolReference) -> tuple[Array, Array]:
        """a = a_d + A⁻¹(w + F), and JᵀF that the torque has to take away again; with A = Λ without F, which cancels."""
        w = self.wrench(arm, reference, self._A)
        if self._A is None:
            return reference.a + arm.J @ (arm.Minv_JT @ w), np.zeros(len(arm.q))
        F = measured_wrench(self, arm)
        return reference.a + self._A_inverse @ (w + F), arm.J.T @ F


@dataclass(kw_only=True)
class InertiaShapingImpedance(ShapedImpedance):
    """Impedance with force sensing, by J⁻¹: ``τ = M J⁻¹ (a_d + A⁻¹(w + F) − J̇q̇) − Jᵀ F + h + g``.

    Gravity is included. Next to a singularity J⁻¹ is damped. Source: thesis B, eq. 4.25–4.29; it drops h and J̇q̇ and
    runs A = Λ only.
    """

    def reset(self, arm: Dynamics) -> None:
        """No memory.

        Raises:
            InputError: if the arm has no J⁻¹, or A is chosen and nothing has estimated the contact wrench.
        """
        need_inverse_of_jacobian(self, arm, "RedundantImpedance")
        super().reset(arm)

    def torque(self, arm: Dynamics, reference: ToolReference) -> Array:
        """Joint torques [N·m], (n,), gravity included."""
        a, tau_F = self.acceleration(arm, reference)
        J_inverse = damped_inverse(arm.J, SINGULAR_VALUE)
        return np.asarray(arm.M @ (J_inverse @ (a - arm.dJdq)) - tau_F + arm.h + arm.g)


@dataclass(kw_only=True)
class RedundantImpedance(ShapedImpedance):
    """Impedance with force sensing, by Λ: ``τ = Jᵀ Λ (a_d + A⁻¹(w + F) − J̇q̇) − Jᵀ F + (I − Jᵀ J̄ᵀ) M α + h + g``.

    For any number of joints. α is the acceleration that ``null_space`` asks for; without such a task the self-motion of
    a redundant arm is not damped. Gravity is included. Source: thesis B, eq. 4.38–4.41; the null space is ours.
    """

    null_space: Sequence[JointTask] = ()
    """What the joints shall do with the freedom that is left: `Posture`, `LimitAvoidance`."""

    def reset(self, arm: Dynamics) -> None:
        """No memory.

        Raises:
            InputError: if A is chosen and nothing has estimated the contact wrench, or a task does not fit the arm.
        """
        super().reset(arm)
        for task in self.null_space:
            task.reset(arm)

    def torque(self, arm: Dynamics, reference: ToolReference) -> Array:
        """Joint torques [N·m], (n,), gravity included."""
        a, tau_F = self.acceleration(arm, reference)
        alpha = total_acceleration(self.null_space, arm)
        # (I − Jᵀ J̄ᵀ) M α is M α − Jᵀ Λ J α.
        tau_task = arm.J.T @ (arm.Lambda @ (a - arm.dJdq - arm.J @ alpha))
        return np.asarray(tau_task + arm.M @ alpha - tau_F + arm.h + arm.g)
