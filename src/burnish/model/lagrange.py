"""Dynamics of an arm straight from Lagrange's equations: the oracle that owes nothing to an engine.

tau = d/dt ∂L/∂q̇ − ∂L/∂q = M(q) q̈ + C(q, q̇) q̇ + g(q), L = ½ q̇ᵀ M q̇ − U. All derivatives are exact, none is a
finite difference. It takes some hundred microseconds a state: for tests, and to read; `Model` is for the loop.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from burnish.core import Array, Dynamics, State, read_only
from burnish.errors import InputError
from burnish.model.dh import ChainPose, DHChain, jaco2_dh, jaco2_link_frames, skew
from burnish.model.inertia import Body
from burnish.model.jaco2_parts import jaco2_links


class _LinkTerms(NamedTuple):
    """What each link adds, at one q: its Jacobians at the centre of mass, and its inertia in base axes."""

    pose: ChainPose
    com: Array
    """(n, 3) [m], base axes."""
    J_v: Array
    """(n, 3, n): the link, the axis, the joint."""
    J_w: Array
    """(n, 3, n)."""
    inertia: Array
    """R I Rᵀ, (n, 3, 3) [kg·m²]."""


def _standard_gravity() -> Array:
    return read_only((0.0, 0.0, -9.81))


@dataclass(frozen=True, kw_only=True)
class LagrangeModel:
    """A serial arm of revolute joints as a DH chain and one rigid body a link.

    Source: thesis A, 3.3.3, and thesis B, eq 2.3–2.5. Both misprint the Coriolis term (eq 3.39 and 2.4 have a matrix
    minus a vector; meant is h = Ṁ q̇ − ½ ∂(q̇ᵀM q̇)/∂q) and then drop it; here it is kept. Thesis A, eq 3.22, has
    −∂P/∂q for −∂L/∂q, which would turn the sign of gravity.
    """

    chain: DHChain
    """The geometry."""
    links: tuple[Body, ...]
    """Link i described in **DH frame** i, i = 1 … n."""
    gravity: Array = field(default_factory=_standard_gravity)
    """Acceleration of free fall, base axes [m/s²], (3,)."""
    armature: Array = field(default_factory=lambda: read_only(0.0))
    """Rotor inertia reflected through the gears [kg·m²], (n,) or one number for all; part of M."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "gravity", read_only(self.gravity))
        object.__setattr__(self, "armature", read_only(self.armature))
        n = len(self.chain.a)
        if len(self.links) != n or self.gravity.shape != (3,) or self.armature.shape not in ((), (n,)):
            raise InputError(
                f"LagrangeModel: {len(self.links)} links, gravity of shape {self.gravity.shape} and armature of shape "
                f"{self.armature.shape} for {n} joints; expected a link a joint, (3,), and () or ({n},)"
            )

    def at(self, state: State) -> Dynamics:
        """All terms at a state, as `Model.at` gives them.

        Raises:
            InputError: if the state has another number of joints.
        """
        q, dq = state.q, state.dq
        if len(q) != len(self.links):
            raise InputError(f"the state has {len(q)} joints, the chain has {len(self.links)}")
        terms = self._terms(q)
        pose = terms.pose
        return Dynamics(
            t=state.t,
            q=q,
            dq=dq,
            p=pose.p,
            R=pose.R,
            J=pose.jacobian(pose.p, len(q)),
            dJdq=pose.jacobian_gradient(pose.p, len(q)) @ dq @ dq,
            M=self._mass_matrix(terms),
            h=_christoffel(self._mass_matrix_gradient(terms), dq) @ dq,
            g=self._gravity_torque(terms),
            tau=state.tau,
        )

    def mass_matrix(self, q: Array) -> Array:
        """M = Σ m J_vᵀ J_v + J_ωᵀ R I Rᵀ J_ω over the links, plus armature, (n, n) [kg·m²].

        Source: thesis A, eq 3.35; thesis B, eq 2.3.
        """
        return self._mass_matrix(self._terms(q))

    def mass_matrix_gradient(self, q: Array) -> Array:
        """∂M/∂q, [:, :, j] is the derivative by q_j, (n, n, n) [kg·m²/rad]."""
        return self._mass_matrix_gradient(self._terms(q))

    def coriolis_matrix(self, q: Array, dq: Array) -> Array:
        """C(q, q̇) from Christoffel symbols, the one for which Ṁ − 2C is skew; h = C q̇, (n, n) [N·m·s].

        C_ki = Σ_j ½ (∂M_ki/∂q_j + ∂M_kj/∂q_i − ∂M_ij/∂q_k) q̇_j.
        """
        return _christoffel(self.mass_matrix_gradient(q), dq)

    def gravity_torque(self, q: Array) -> Array:
        """g = ∂U/∂q, the torque that holds the arm still, (n,) [N·m]. Source: thesis A, eq 3.42."""
        return self._gravity_torque(self._terms(q))

    def acceleration(self, q: Array, dq: Array, tau: Array) -> Array:
        """q̈ = M⁻¹(tau − C q̇ − g) of the free arm, (n,) [rad/s²]."""
        terms = self._terms(q)
        h = _christoffel(self._mass_matrix_gradient(terms), dq) @ dq
        return np.asarray(np.linalg.solve(self._mass_matrix(terms), tau - h - self._gravity_torque(terms)))

    def potential_energy(self, q: Array) -> float:
        """U = −Σ m gravityᵀ com, zero with all of the mass in the base's origin [J]. Source: thesis A, eq 3.41."""
        return float(-self._masses @ self._terms(q).com @ self.gravity)

    def kinetic_energy(self, q: Array, dq: Array) -> float:
        """½ q̇ᵀ M q̇, rotors included [J]. Source: thesis A, eq 3.20."""
        return float(dq @ self.mass_matrix(q) @ dq / 2)

    @cached_property
    def _masses(self) -> Array:
        return np.array([link.mass for link in self.links])

    @cached_property
    def _coms(self) -> Array:
        return np.array([link.com for link in self.links])

    @cached_property
    def _tensors(self) -> Array:
        return np.array([link.tensor for link in self.links])

    @cached_property
    def _mass_rows(self) -> Array:
        """Each mass for its link's three rows of a stacked J_v, (3 n, 1)."""
        return np.repeat(self._masses, 3)[:, None]

    def _terms(self, q: Array) -> _LinkTerms:
        """Source: thesis A, eq 3.36–3.38: joint k moves link i when k ≤ i."""
        pose = self.chain.at(q)
        R, p = pose.T[1:, :3, :3], pose.T[1:, :3, 3]
        com = (R @ self._coms[:, :, None])[..., 0] + p
        moves = np.tri(len(q))[:, None, :]
        J_v = np.einsum("kab,ikb->iak", skew(pose.axis), com[:, None] - pose.origin) * moves  # z_k × (com_i − p_k)
        return _LinkTerms(pose, com, J_v, pose.axis.T * moves, R @ self._tensors @ np.swapaxes(R, 1, 2))

    def _mass_matrix(self, terms: _LinkTerms) -> Array:
        J_v, J_w = _stacked(terms.J_v), _stacked(terms.J_w)
        M = J_v.T @ (self._mass_rows * J_v) + J_w.T @ _stacked(terms.inertia @ terms.J_w)
        return np.asarray(M + np.diag(np.broadcast_to(self.armature, len(M))))

    def _mass_matrix_gradient(self, terms: _LinkTerms) -> Array:
        """∂M/∂q_j = X + Xᵀ, X = Σ m (∂J_v/∂q_j)ᵀ J_v + (∂J_ω/∂q_j − S_j J_ω)ᵀ R I Rᵀ J_ω over the links.

        S_j = S(z_j) comes from ∂(R I Rᵀ)/∂q_j = S_j R I Rᵀ − R I Rᵀ S_j. The derivatives of the Jacobians are those
        of `ChainPose.jacobian_gradient`; that of J_ω,k is S_j z_k for j < k, which leaves −S_j z_k for j ≥ k.
        """
        n = len(self.links)
        S, joint, moves = skew(terms.pose.axis), np.arange(n), np.tri(n)
        turned = S @ terms.J_v[:, None]  # [i, j, :, k] = S_j J_v,k of link i
        dJ_v = turned[:, np.minimum.outer(joint, joint), :, np.maximum.outer(joint, joint)]
        turns = (S @ terms.pose.axis.T).transpose(2, 0, 1)[:, :, None]  # [k, j, ·] = S_j z_k
        dJ_w = -turns * (moves.T[:, :, None] * moves.T)[..., None]  # for k ≤ j ≤ i
        X = dJ_v.reshape(n * n, -1) @ (self._mass_rows * _stacked(terms.J_v))
        X += dJ_w.reshape(n * n, -1) @ _stacked(terms.inertia @ terms.J_w)
        X = X.reshape(n, n, n).swapaxes(1, 2)
        return np.asarray(X + X.swapaxes(0, 1))

    def _gravity_torque(self, terms: _LinkTerms) -> Array:
        return np.asarray(-np.einsum("i,iak,a->k", self._masses, terms.J_v, self.gravity))


def jaco2_lagrange() -> LagrangeModel:
    """The JACO2 with the links of `jaco2_links`, no armature, gravity along −z."""
    links = jaco2_links()[1:]
    return LagrangeModel(
        chain=jaco2_dh(),
        links=tuple(link.seen_from(T) for link, T in zip(links, jaco2_link_frames(), strict=True)),
    )


def _stacked(terms: Array) -> Array:
    """(n, 3, m) of the links as one matrix, (3 n, m)."""
    return terms.reshape(-1, terms.shape[-1])


def _christoffel(gradient: Array, dq: Array) -> Array:
    """C of `LagrangeModel.coriolis_matrix` from ∂M/∂q, (n, n)."""
    rate = gradient @ dq
    half = np.einsum("kji,j->ki", gradient, dq)
    return np.asarray(0.5 * (rate + half - half.T))
