"""The planar two-link arm of the blog: small enough to check by hand, large enough for every idea.

Both joints turn about z, the arm moves in the x–y plane, and gravity, where there is any, pulls along −y.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from burnish.core import Array, Dynamics, State, read_only
from burnish.errors import InputError
from burnish.inverse import damped_spd_inverse

DOF_NAMES = ("x", "y", "z", "rx", "ry", "rz")
"""The six degrees of freedom of a tool, in the order of a twist: linear, then angular."""

CONTROLLABLE = ("x", "y", "rz")
"""What a planar arm can move at all; the other rows of its Jacobian are zero."""

SINGULAR_MOBILITY = 0.001
"""Eigenvalue of J M⁻¹ Jᵀ below which Λ is damped. With links of 1 kg and 1 m the mobility is near 1; a choice."""


def mask(*dof: str) -> Array:
    """The rows of the identity that pick degrees of freedom: ``mask("x", "y") @ J`` is the stripped Jacobian, (k, 6).

    Raises:
        InputError: for a name that is none of x, y, z, rx, ry, rz, or for a name given twice.
    """
    unknown = [name for name in dof if name not in DOF_NAMES]
    if unknown or len(set(dof)) != len(dof):
        raise InputError(f"degrees of freedom {', '.join(dof)}; expected different ones of {', '.join(DOF_NAMES)}")
    return np.eye(6)[[DOF_NAMES.index(name) for name in dof]]


@dataclass(frozen=True, kw_only=True)
class TwoLinkArm:
    """Two links with their masses on their own line; q = (q0, q1), q1 relative to the first link.

    Source: the blog, parts 2 and 4. It gives no masses; the defaults, uniform rods of 1 kg and 1 m, are ours.
    """

    length: Array = field(default_factory=lambda: np.ones(2))
    """Lengths L0, L1 [m], (2,)."""
    mass: Array = field(default_factory=lambda: np.ones(2))
    """Masses m0, m1 [kg], (2,)."""
    com: Array = field(default_factory=lambda: np.full(2, 0.5))
    """Distance of each centre of mass from its joint, along the link [m], (2,)."""
    inertia: Array = field(default_factory=lambda: np.full(2, 1.0 / 12.0))
    """Inertia of each link about z through its centre of mass [kg·m²], (2,)."""
    gravity: float = 0.0
    """Acceleration of free fall along −y [m/s²]; 0 is an arm that lies on a table."""

    def __post_init__(self) -> None:
        for name in ("length", "mass", "com", "inertia"):
            values = read_only(getattr(self, name))
            object.__setattr__(self, name, values)
            if values.shape != (2,) or not np.isfinite(values).all():
                raise InputError(f"TwoLinkArm: {name} is {values.tolist()}; expected two finite numbers")
        if min(*self.length, *self.mass, *self.inertia) <= 0.0 or not np.isfinite(self.gravity):
            raise InputError("TwoLinkArm: expected lengths, masses and inertias above 0, and a finite gravity")

    def position(self, q: Array) -> Array:
        """Tool position [L0 cos q0 + L1 cos(q0 + q1), L0 sin q0 + L1 sin(q0 + q1), 0], (3,) [m]."""
        L0, L1 = self.length
        a, b = q[0], q[0] + q[1]
        return np.array([L0 * np.cos(a) + L1 * np.cos(b), L0 * np.sin(a) + L1 * np.sin(b), 0.0])

    def rotation(self, q: Array) -> Array:
        """Tool rotation, base ← tool: by q0 + q1 about z, (3, 3)."""
        c, s = np.cos(q[0] + q[1]), np.sin(q[0] + q[1])
        return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    def jacobian(self, q: Array) -> Array:
        """Jacobian of the tool, linear rows first, base axes, (6, 2). Source: the blog, part 2."""
        L0, L1 = self.length
        a, b = q[0], q[0] + q[1]
        J = np.zeros((6, 2))
        J[0] = -L0 * np.sin(a) - L1 * np.sin(b), -L1 * np.sin(b)
        J[1] = L0 * np.cos(a) + L1 * np.cos(b), L1 * np.cos(b)
        J[5] = 1.0
        return J

    def mass_matrix(self, q: Array) -> Array:
        """M, (2, 2) [kg·m²]; only cos q1 changes it."""
        along, across, coupling = self._moments()
        c = coupling * np.cos(q[1])
        return np.array([[along + across + 2.0 * c, across + c], [across + c, across]])

    def coriolis_torque(self, q: Array, dq: Array) -> Array:
        """h = m1 L0 c1 sin q1 · [−q̇1(2 q̇0 + q̇1), q̇0²], (2,) [N·m]."""
        _, _, coupling = self._moments()
        return np.asarray(coupling * np.sin(q[1]) * np.array([-dq[1] * (2.0 * dq[0] + dq[1]), dq[0] ** 2]))

    def gravity_torque(self, q: Array) -> Array:
        """g, the torque that holds the arm still, (2,) [N·m]."""
        (m0, m1), (c0, c1), L0 = self.mass, self.com, self.length[0]
        far = m1 * c1 * np.cos(q[0] + q[1])
        return np.array([(m0 * c0 + m1 * L0) * np.cos(q[0]) + far, far]) * self.gravity

    def operational_inertia(self, q: Array, *dof: str) -> Array:
        """Λ = (J M⁻¹ Jᵀ)⁻¹ over the chosen degrees of freedom, J stripped **before** the inverse, (k, k).

        Damped where the arm cannot accelerate in some chosen direction, as next to a stretched or folded pose.

        Raises:
            InputError: for more than two degrees of freedom, or one out of the plane: no torque moves those.

        Source: the blog, part 4.
        """
        if not 1 <= len(dof) <= 2 or not set(dof) <= set(CONTROLLABLE):
            raise InputError(f"degrees of freedom {', '.join(dof)}; two joints can control one or two of x, y, rz")
        J = mask(*dof) @ self.jacobian(q)
        return damped_spd_inverse(J @ np.linalg.solve(self.mass_matrix(q), J.T), SINGULAR_MOBILITY)

    def at(self, state: State) -> Dynamics:
        """All terms at a state: every law that takes a `Dynamics` can drive this arm.

        Its six-row Λ and J̄ are damped ones, for six degrees of freedom cannot be controlled by two joints.
        """
        q, dq = state.q, state.dq
        J = self.jacobian(q)
        a, b = np.array([np.cos(q[0]), np.sin(q[0])]), np.array([np.cos(q[0] + q[1]), np.sin(q[0] + q[1])])
        centripetal = -self.length[0] * dq[0] ** 2 * a - self.length[1] * (dq[0] + dq[1]) ** 2 * b
        return Dynamics(
            t=state.t,
            q=q,
            dq=dq,
            p=self.position(q),
            R=self.rotation(q),
            J=J,
            dJdq=np.concatenate((centripetal, np.zeros(4))),
            M=self.mass_matrix(q),
            h=self.coriolis_torque(q, dq),
            g=self.gravity_torque(q),
            tau=state.tau,
        )

    def _moments(self) -> tuple[float, float, float]:
        """Inertia about the shoulder of link 0 with m1 in the elbow, of link 1 about the elbow, and m1 L0 c1."""
        (m0, m1), (c0, c1), (I0, I1), L0 = self.mass, self.com, self.inertia, self.length[0]
        return float(I0 + m0 * c0**2 + m1 * L0**2), float(I1 + m1 * c1**2), float(m1 * L0 * c1)
