"""How an abrasive tip slides over the surface where it touches it: along its path, and because it spins."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Self

from burnish.core import Array, read_only
from burnish.errors import InputError

MEAN_RING = 3.0 * np.pi / 16.0
"""Mean distance from the middle of a Hertz contact, by pressure and in contact radii: 3 ∫ √(1 − u²) u² du."""


@dataclass(frozen=True, kw_only=True)
class Rubbing:
    """N contacts of the tip with the surface, and how the abrasive moves over it there; mould frame.

    At a place ρ from the middle of the contact the abrasive slides with ``|velocity + spin · n × ρ|``.
    """

    contacts: Array
    """Points of contact [m], (N, 3)."""
    normals: Array
    """Outward unit normals there, (N, 3)."""
    force: Array
    """Normal force [N], (N,); what is not positive removes nothing."""
    velocity: Array
    """Velocity of the abrasive over the surface in the middle of the contact [m/s], (N, 3)."""
    spin: Array
    """Angular speed of the abrasive about the normal [rad/s], (N,)."""
    curvature: Array
    """Mean curvature of the surface there, for the size of the contact [1/m], convex positive, (N,)."""

    def __post_init__(self) -> None:
        for name in ("contacts", "normals", "force", "velocity", "spin", "curvature"):
            object.__setattr__(self, name, read_only(getattr(self, name)))
        count = len(self.contacts) if self.contacts.ndim else 0
        for name in ("contacts", "normals", "velocity", "force", "spin", "curvature"):
            found: Array = getattr(self, name)
            shape = (count, 3) if name in ("contacts", "normals", "velocity") else (count,)
            if found.shape != shape:
                raise InputError(f"removal: {name} has shape {found.shape}; expected {shape}, one row a sample")
            if not np.isfinite(found).all():
                raise InputError(f"removal: {name} is not finite in a sample; leave such samples out")

    @classmethod
    def of(
        cls,
        *,
        contacts: ArrayLike,
        normals: ArrayLike,
        force: ArrayLike,
        velocity: ArrayLike,
        spin: ArrayLike = 0.0,
        curvature: ArrayLike = 0.0,
    ) -> Self:
        """Contacts of a tip; spin and curvature may be the same for all of them."""
        count = np.shape(contacts)[:1]
        each = [
            np.broadcast_to(values, count) if np.ndim(values) == 0 else np.asarray(values)
            for values in (spin, curvature)
        ]
        arrays = [np.asarray(values, dtype=np.float64) for values in (contacts, normals, force, velocity)]
        return cls(
            contacts=arrays[0], normals=arrays[1], force=arrays[2], velocity=arrays[3], spin=each[0], curvature=each[1]
        )

    def pressing(self) -> NDArray[np.intp]:
        """Numbers of the contacts that have a force, (K,)."""
        return np.flatnonzero(self.force > 0.0)

    def __getitem__(self, rows: slice | NDArray[np.intp]) -> Rubbing:
        """Some of the contacts."""
        return Rubbing(**{name: getattr(self, name)[rows] for name in self.__dataclass_fields__})


@dataclass(frozen=True, kw_only=True)
class Spindle:
    """A spherical tip that turns about the tool's axis; at a rate of 0 only the path rubs.

    With the tip's centre at r n over the contact and the axis a out of the arm, the abrasive slides with
    ``v = v_feed + ω a × (−r n)`` in the middle of the contact and spins about the normal with ``ω a · n``. Upright the
    middle does not slide at all; leant by θ it slides with ω r sin θ.
    """

    rate: float
    """ω about the tool's axis [rad/s], right-handed about the direction out of the arm."""
    tip_radius: float
    """r [m]."""

    def __post_init__(self) -> None:
        if not (np.isfinite(self.rate) and 0.0 < self.tip_radius < np.inf):
            raise InputError(f"{self}; expected a finite rate [rad/s] and a positive radius [m]")

    def rubbing(
        self,
        *,
        contacts: ArrayLike,
        normals: ArrayLike,
        force: ArrayLike,
        velocity: ArrayLike,
        axes: ArrayLike,
        curvature: ArrayLike = 0.0,
    ) -> Rubbing:
        """What the abrasive does in N contacts.

        Args:
            contacts: points of contact, mould frame [m], (N, 3).
            normals: outward unit normals there, (N, 3).
            force: normal force [N], (N,).
            velocity: velocity of the tip's centre, mould frame [m/s], (N, 3).
            axes: unit vectors of the tool's axis out of the arm, mould frame, (N, 3).
            curvature: mean curvature of the surface [1/m], one for all or (N,).

        Raises:
            InputError: the arrays do not fit together, or hold a value that is not finite.
        """
        n = np.asarray(normals, dtype=np.float64)
        axes, velocity = np.asarray(axes, dtype=np.float64), np.asarray(velocity, dtype=np.float64)
        if not n.shape == axes.shape == velocity.shape == (len(n), 3):
            raise InputError(
                f"removal: normals {n.shape}, axes {axes.shape}, velocity {velocity.shape}; expected (N, 3) each"
            )
        slide = velocity + np.cross(self.rate * axes, -self.tip_radius * n)
        slide -= np.einsum("ij,ij->i", slide, n)[:, None] * n
        spin = self.rate * np.einsum("ij,ij->i", axes, n)
        return Rubbing.of(contacts=contacts, normals=n, force=force, velocity=slide, spin=spin, curvature=curvature)

    def speed(self, contact_radius: float, lean: float = 0.0) -> float:
        """Mean sliding speed over a Hertz contact by pressure, without feed [m/s].

        Exact upright, 3π/16 ω a, where the contact radius a is small against r.
        """
        radius, angle = np.meshgrid((np.arange(64) + 0.5) / 64.0, (np.arange(64) + 0.5) * np.pi / 32.0)
        across = self.tip_radius * np.sin(lean) + np.cos(lean) * contact_radius * radius * np.cos(angle)
        along = np.cos(lean) * contact_radius * radius * np.sin(angle)
        weight = radius * np.sqrt(1.0 - radius**2)
        return abs(self.rate) * float(np.sum(weight * np.hypot(across, along)) / np.sum(weight))
