"""Kinematics of a chain of revolute joints in classic Denavit–Hartenberg form.

Frame 0 is the base; frame i is fixed to link i and has its z along joint i + 1. Notation as in ``burnish.core``.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from burnish.core import Array, read_only
from burnish.errors import InputError


def skew(w: Array) -> Array:
    """S(w) with S(w) x = w × x; w (..., 3) gives (..., 3, 3). Source: thesis A, eq 3.32."""
    S = np.zeros((*w.shape, 3))
    S[..., 2, 1], S[..., 0, 2], S[..., 1, 0] = w[..., 0], w[..., 1], w[..., 2]
    return S - np.swapaxes(S, -1, -2)


@dataclass(frozen=True, kw_only=True)
class ChainPose:
    """A chain at one q: having one is the proof that its frames belong together."""

    T: Array
    """Homogeneous transforms base ← frame i, i = 0 … n, (n + 1, 4, 4) [m]."""
    axis: Array
    """Axis of each joint in base axes, along growing q_i: ± z of frame i − 1, (n, 3)."""
    origin: Array
    """A point on each axis, the origin of frame i − 1, in base axes, (n, 3) [m]."""

    @property
    def p(self) -> Array:
        """Tool position, the origin of frame n, base axes, (3,) [m]."""
        return np.asarray(self.T[-1, :3, 3])

    @property
    def R(self) -> Array:
        """Tool rotation, base ← frame n, (3, 3)."""
        return np.asarray(self.T[-1, :3, :3])

    def jacobian(self, point: Array, link: int) -> Array:
        """Geometric Jacobian of a point fixed to a link: [z × (p − p_i); z] a column, linear rows first.

        Args:
            point: the point in base axes [m], (3,).
            link: the link that carries it, 1 … n; later joints do not move it, their columns are zero.

        Returns:
            (6, n) [m, 1], base axes.

        Source: thesis A, eq 3.9–3.11 for the tool and 3.36–3.38 for a link.
        """
        moves = np.arange(len(self.axis)) < link
        J_v = (skew(self.axis) @ (point - self.origin)[:, :, None])[..., 0]
        return np.asarray((np.hstack((J_v, self.axis)) * moves[:, None]).T)

    def jacobian_gradient(self, point: Array, link: int) -> Array:
        """∂J/∂q of that Jacobian, exactly: [:, k, j] is the derivative of column k by q_j, (6, n, n).

        Joint j turns all that comes after it, so with k ≥ j both parts of column k turn by z_j × column k;
        with k < j the axis stays and the point moves: ∂J_v,k/∂q_j = z_k × J_v,j and ∂J_ω,k/∂q_j = 0.

        Source: own derivation; neither thesis writes it, as both drop J̇ q̇.
        """
        n = len(self.axis)
        J = self.jacobian(point, link)
        turned_v = skew(self.axis) @ J[:3]  # [j, :, k] = z_j × J_v,k
        turned_w = skew(self.axis) @ J[3:]
        first, last = np.minimum.outer(np.arange(n), np.arange(n)), np.maximum.outer(np.arange(n), np.arange(n))
        gradient = np.empty((6, n, n))
        gradient[:3] = np.moveaxis(turned_v[first, :, last], -1, 0)
        gradient[3:] = np.einsum("jak,jk->akj", turned_w, np.triu(np.ones((n, n)), 1))
        return gradient


@dataclass(frozen=True, kw_only=True)
class DHChain:
    """Classic (distal) DH table of n revolute joints: T = Rz(θ) Tz(d) Tx(a) Rx(α), θ = sign · q + offset.

    Source: thesis A, eq 3.3–3.4 and tables 3.3–3.4. Table 3.3 heads its columns α_{i−1}, a_{i−1}; its own eq 3.4
    uses α_i, a_i, and so do we: read the other way the tool is up to 1.5 m off.
    """

    alpha: Array
    """Twist of each link [rad], (n,)."""
    a: Array
    """Length of each link [m], (n,)."""
    d: Array
    """Offset along each joint axis [m], (n,)."""
    theta_sign: Array
    """+1 or −1: whether θ grows or falls with q, (n,)."""
    theta_offset: Array
    """θ at q = 0 [rad], (n,)."""

    def __post_init__(self) -> None:
        for item in fields(self):
            object.__setattr__(self, item.name, read_only(getattr(self, item.name)))
        columns = [getattr(self, item.name) for item in fields(self)]
        if any(column.shape != self.alpha.shape or column.ndim != 1 for column in columns):
            shapes = [column.shape for column in columns]
            raise InputError(f"DHChain: columns of shapes {shapes}; expected five vectors of one length")
        if not all(np.isfinite(column).all() for column in columns) or not np.all(np.abs(self.theta_sign) == 1.0):
            raise InputError("DHChain: found a number that is not finite, or a sign other than ±1; mend the table")

    def at(self, q: Array) -> ChainPose:
        """All frames at q [rad], (n,). Source: thesis A, eq 3.3–3.4."""
        theta = self.theta_sign * q + self.theta_offset
        c, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(self.alpha), np.sin(self.alpha)
        zero, one = np.zeros_like(c), np.ones_like(c)
        A = np.array(
            [
                [c, -ca * s, sa * s, self.a * c],
                [s, ca * c, -sa * c, self.a * s],
                [zero, sa, ca, self.d],
                [zero, zero, zero, one],
            ]
        )
        T = np.empty((len(theta) + 1, 4, 4))
        T[0] = np.eye(4)
        for i in range(len(theta)):
            T[i + 1] = T[i] @ A[:, :, i]
        return ChainPose(T=T, axis=self.theta_sign[:, None] * T[:-1, :3, 2], origin=T[:-1, :3, 3])

    def jacobian(self, q: Array) -> Array:
        """Geometric Jacobian of the tool point, linear rows first, base axes, (6, n). Source: thesis A, eq 3.10."""
        pose = self.at(q)
        return pose.jacobian(pose.p, len(q))

    def mixed_jacobian(self, q: Array) -> Array:
        """Jacobian with linear rows in base axes and angular rows in tool axes, Rᵀ J_ω, (6, n).

        Source: thesis A, eq 3.12–3.13. Only its orientation PIDs want this form; the laws here take base axes.
        """
        pose = self.at(q)
        J = pose.jacobian(pose.p, len(q))
        return np.vstack((J[:3], pose.R.T @ J[3:]))

    def J_dot_dq(self, q: Array, dq: Array) -> Array:
        """J̇ q̇ of the tool, its acceleration at q̈ = 0, base axes, (6,) [m/s², rad/s²]."""
        pose = self.at(q)
        return np.asarray(pose.jacobian_gradient(pose.p, len(q)) @ dq @ dq)


def jaco2_dh() -> DHChain:
    """The JACO2 with six joints and the 60° wrist; frame 6 is the tool, in the centre of the hand.

    q are the vendor's joint angles in radians, θ = ∓q + offset. Source: thesis A, tables 3.1–3.4. Table 3.2 writes
    d4b with D5 and an open bracket; the vendor has D4, of the same length.
    """
    D1, D2, D3, D4, D5, D6, e2 = 0.2755, 0.4100, 0.2073, 0.0741, 0.0741, 0.1600, 0.0098
    aa = np.pi / 6
    ratio = np.sin(aa) / np.sin(2 * aa)
    d4b, d5b, d6b = D3 + ratio * D4, ratio * (D4 + D5), ratio * D5 + D6
    return DHChain(
        alpha=np.array([np.pi / 2, np.pi, np.pi / 2, 2 * aa, 2 * aa, np.pi]),
        a=np.array([0.0, D2, 0.0, 0.0, 0.0, 0.0]),
        d=np.array([D1, 0.0, -e2, -d4b, -d5b, -d6b]),
        theta_sign=np.array([-1.0, 1.0, 1.0, 1.0, 1.0, 1.0]),
        theta_offset=np.array([0.0, -np.pi / 2, np.pi / 2, 0.0, -np.pi, np.pi / 2]),
    )


def jaco2_link_frames() -> Array:
    """Fixed transforms DH frame i ← link frame i of the JACO2, i = 1 … 6, (6, 4, 4) [m].

    A link frame (the vendor's description, where COM and inertia are given) has its origin and its z on joint i;
    the DH frame of the same link has its z on joint i + 1. 0.11875 m from the shoulder down to link frame 1, and
    the sideways steps 1.6 mm and 9.8 + 1.6 mm, are the vendor's; the rest follows from the DH table: link frames
    4 and 5 sit half of d5b down their axis, which leans by 60° in the DH frame, and link frame 6 sits D6 away.
    """
    c, s = np.cos(np.pi / 3), np.sin(np.pi / 3)
    wrist = jaco2_dh().d[4] / 2
    rotations = [
        [[-1, 0, 0], [0, 0, -1], [0, -1, 0]],
        [[0, -1, 0], [-1, 0, 0], [0, 0, -1]],
        [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
        [[-1, 0, 0], [0, -c, s], [0, s, c]],
        [[-1, 0, 0], [0, -c, s], [0, s, c]],
        [[0, 1, 0], [1, 0, 0], [0, 0, -1]],
    ]
    origins = [
        [0, -0.11875, 0],
        [-0.4100, 0, 0.0016],
        [0, 0.0114, 0],
        [0, -wrist * s, -wrist * c],
        [0, -wrist * s, -wrist * c],
        [0, 0, -0.1600],
    ]
    T = np.tile(np.eye(4), (6, 1, 1))
    T[:, :3, :3], T[:, :3, 3] = rotations, origins
    return read_only(T)
