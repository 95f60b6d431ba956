"""Rigid bodies, and the one rigid body that several of them make: thesis A's augmented link."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from burnish.core import Array, read_only
from burnish.errors import InputError

TRIANGLE_TOLERANCE = 1e-9
"""By how much, of the largest principal moment, the triangle inequality may fail: rounding, no more."""


def _identity() -> Array:
    return np.eye(3)


@dataclass(frozen=True, kw_only=True)
class Body:
    """A rigid body: mass, centre of mass, and inertia about that centre; physical, or it cannot be built.

    Physical means: the mass is positive, the inertia is positive definite, and its largest principal moment is at
    most the sum of the other two (else some part of the body would have a negative mass).
    """

    name: str
    """What it is, for messages and tables."""
    mass: float
    """Mass [kg]."""
    com: Array
    """Centre of mass in the frame that the body is described in [m], (3,)."""
    inertia: Array
    """Inertia about the centre of mass in the axes ``axes`` [kg·m²], (3, 3). Off the diagonal stand −∫xy dm and
    its like; CAD programs often print +∫xy dm."""
    axes: Array = field(default_factory=_identity)
    """Rotation frame ← axes of the inertia, (3, 3)."""

    def __post_init__(self) -> None:
        for name, shape in (("com", (3,)), ("inertia", (3, 3)), ("axes", (3, 3))):
            values = read_only(getattr(self, name))
            object.__setattr__(self, name, values)
            if values.shape != shape or not np.isfinite(values).all():
                raise InputError(f"{self.name}: {name} is {values.tolist()}; expected finite numbers of shape {shape}")
        if not (np.isfinite(self.mass) and self.mass > 0.0):
            raise InputError(f"{self.name}: mass {self.mass} kg; expected a finite mass above 0")
        scale = float(np.abs(self.inertia).max())
        if not np.allclose(self.inertia, self.inertia.T, rtol=0.0, atol=1e-9 * scale):
            raise InputError(f"{self.name}: the inertia is not symmetric; check its products of inertia")
        moments = np.linalg.eigvalsh(self.inertia)
        if moments[0] <= 0.0:
            raise InputError(f"{self.name}: principal moments {moments} kg·m²; expected all above 0")
        if moments[2] > moments[0] + moments[1] + TRIANGLE_TOLERANCE * moments[2]:
            raise InputError(
                f"{self.name}: principal moments {moments} kg·m²; expected the largest to be at most the sum of the "
                "others, as of any body. Check the axes and the point that the inertia was given about"
            )
        if not np.allclose(self.axes @ self.axes.T, np.eye(3), rtol=0.0, atol=1e-9) or np.linalg.det(self.axes) < 0.0:
            raise InputError(f"{self.name}: axes are not a rotation; expected an orthonormal right-handed matrix")

    @property
    def tensor(self) -> Array:
        """Inertia about the centre of mass in the axes of the frame, axes I axesᵀ [kg·m²], (3, 3)."""
        return np.asarray(self.axes @ self.inertia @ self.axes.T)

    def tensor_about(self, point: Array) -> Array:
        """Inertia about another point, I + m Sᵀ(r) S(r), r from that point to the centre of mass [kg·m²], (3, 3).

        The parallel-axis theorem. Source: thesis A, eq 3.30–3.32, with the body's own mass; the thesis prints the
        summed mass of link and actuator there, which counts each of them twice.
        """
        r = self.com - point
        return np.asarray(self.tensor + self.mass * (r @ r * np.eye(3) - np.outer(r, r)))

    def seen_from(self, T: Array) -> Body:
        """The same body described in another frame.

        Args:
            T: homogeneous transform other frame ← this frame, (4, 4) [m]. Source: thesis A, eq 3.27.
        """
        R, p = T[:3, :3], T[:3, 3]
        return Body(name=self.name, mass=self.mass, com=R @ self.com + p, inertia=self.inertia, axes=R @ self.axes)


def combine(bodies: Sequence[Body], name: str) -> Body:
    """The one body that several bodies, rigidly joined and described in one frame, are.

    m = Σ m_i, com = Σ m_i com_i / m, inertia = Σ (I_i + m_i Sᵀ(r_i) S(r_i)) with r_i = com_i − com, frame axes.

    Raises:
        InputError: if there is no body.

    Source: thesis A, eq 3.26, 3.28 and 3.30–3.33, eq 3.30 mended as `Body.tensor_about` says.
    """
    if not bodies:
        raise InputError(f"{name}: no body to combine; expected at least one")
    mass = sum(body.mass for body in bodies)
    com = sum((body.mass * body.com for body in bodies), np.zeros(3)) / mass
    inertia = sum((body.tensor_about(com) for body in bodies), np.zeros((3, 3)))
    return Body(name=name, mass=mass, com=com, inertia=inertia)


def solid_cylinder(*, name: str, mass: float, com: Array, axis: Array, diameter: float, length: float) -> Body:
    """A cylinder of uniform density: m r²/2 about its axis, m (3r² + l²)/12 across it; ``axis`` a unit vector."""
    r = diameter / 2
    return _round_body(name, mass, com, axis, along=mass * r**2 / 2, across=mass * (3 * r**2 + length**2) / 12)


def hoop(*, name: str, mass: float, com: Array, axis: Array, diameter: float) -> Body:
    """A thin ring: m r² about its axis, half of that across it; ``axis`` a unit vector."""
    r = diameter / 2
    return _round_body(name, mass, com, axis, along=mass * r**2, across=mass * r**2 / 2)


def _round_body(name: str, mass: float, com: Array, axis: Array, *, along: float, across: float) -> Body:
    """A body of revolution with these principal moments along and across its axis."""
    inertia = across * np.eye(3) + (along - across) * np.outer(axis, axis)
    return Body(name=name, mass=mass, com=com, inertia=inertia)
