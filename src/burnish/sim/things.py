"""Things that a hand can take: boxes, cylinders, and the table under them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from burnish.core import Array, read_only
from burnish.errors import InputError
from burnish.rotation import quaternion

HAND, THING = 1, 2
"""Who meets whom, as bits: things meet things and the hand; the parts of the hand do not meet each other."""
CONTACT = {"condim": 4, "solref": [5e-3, 1.0], "solimp": [0.95, 0.99, 1e-3, 0.5, 2.0]}
"""Contacts turn about their normal too, with friction, and settle within ten physics steps."""
SPIN = 5e-3
"""Friction against turning about the normal, as the radius of a patch [m]: a finger pad is about a centimetre wide."""


def _upright() -> Array:
    return read_only(np.eye(3))


@dataclass(frozen=True, kw_only=True)
class Box:
    """A loose box of uniform density."""

    name: str
    """What `SimRobot.truth_pose` calls it."""
    size: Array
    """Its edges along its own x, y and z [m], (3,)."""
    mass: float
    """[kg]."""
    p: Array
    """Where its middle is at the start, base frame [m], (3,)."""
    R: Array = field(default_factory=_upright)
    """How it stands then, base ← box, (3, 3)."""
    friction: float = 0.4
    """Coulomb friction µ; where two things meet the rougher one counts, and on the hand its pads' own."""

    def __post_init__(self) -> None:
        _check(self, 3)

    def put(self, spec: Any) -> None:
        """Into a MuJoCo specification."""
        _loose(self, spec).add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX, size=(0.5 * self.size).tolist(), mass=self.mass, **_surface(self.friction)
        )


@dataclass(frozen=True, kw_only=True)
class Cylinder:
    """A loose cylinder of uniform density about its own z."""

    name: str
    """What `SimRobot.truth_pose` calls it."""
    size: Array
    """Its diameter and its length [m], (2,)."""
    mass: float
    """[kg]."""
    p: Array
    """Where its middle is at the start, base frame [m], (3,)."""
    R: Array = field(default_factory=_upright)
    """How it stands then, base ← cylinder, (3, 3)."""
    friction: float = 0.4
    """Coulomb friction µ; where two things meet the rougher one counts, and on the hand its pads' own."""

    def __post_init__(self) -> None:
        _check(self, 2)

    def put(self, spec: Any) -> None:
        """Into a MuJoCo specification."""
        half = [*(0.5 * self.size).tolist(), 0.0]
        _loose(self, spec).add_geom(
            type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=half, mass=self.mass, **_surface(self.friction)
        )


@dataclass(frozen=True, kw_only=True)
class Table:
    """A level plane without an edge; things and fingers meet it, the arm's links do not."""

    height: float = 0.0
    """Above the base frame's origin [m]."""
    friction: float = 0.4
    """Coulomb friction µ; where two surfaces meet the rougher one counts."""
    name: str = field(default="table", init=False)
    """There is one."""

    def __post_init__(self) -> None:
        if not np.isfinite(self.height) or not 0.0 <= self.friction < np.inf:
            raise InputError(
                f"Table: height {self.height} m, friction {self.friction}; expected numbers, friction >= 0"
            )

    def put(self, spec: Any) -> None:
        """Into a MuJoCo specification."""
        plane = mujoco.mjtGeom.mjGEOM_PLANE
        spec.worldbody.add_geom(
            type=plane, pos=[0.0, 0.0, self.height], size=[0.0, 0.0, 0.1], **_surface(self.friction)
        )


Thing = Box | Cylinder | Table
"""Whatever stands around the hand."""


def body_of(name: str) -> str:
    """What the engine calls a thing, so that none can be mistaken for a part of the arm."""
    return f"thing {name}"


def _check(thing: Box | Cylinder, lengths: int) -> None:
    """Refuse what cannot be; make the arrays read-only.

    Raises:
        InputError: if a field has another shape or sign.
    """
    said = f"{type(thing).__name__} {thing.name!r}"
    for name, shape in (("size", (lengths,)), ("p", (3,)), ("R", (3, 3))):
        values = read_only(getattr(thing, name))
        object.__setattr__(thing, name, values)
        if values.shape != shape or not np.isfinite(values).all():
            raise InputError(f"{said}: {name} is {values.tolist()}; expected finite numbers of shape {shape}")
    if not (thing.size > 0.0).all() or not 0.0 < thing.mass < np.inf or not 0.0 <= thing.friction < np.inf:
        raise InputError(
            f"{said}: size {thing.size.tolist()} m, mass {thing.mass} kg, friction {thing.friction}; expected size and "
            "mass above 0, friction at least 0"
        )
    if not np.allclose(thing.R @ thing.R.T, np.eye(3), rtol=0.0, atol=1e-6) or np.linalg.det(thing.R) < 0.0:
        raise InputError(f"{said}: R = {thing.R.tolist()} is no rotation; expected an orthonormal right-handed matrix")


def _loose(thing: Box | Cylinder, spec: Any) -> Any:
    """A free body where the thing is."""
    body = spec.worldbody.add_body(name=body_of(thing.name), pos=thing.p.tolist(), quat=quaternion(thing.R).tolist())
    body.add_freejoint()
    return body


def _surface(friction: float) -> dict[str, Any]:
    """How a thing meets others."""
    return {"contype": THING, "conaffinity": HAND | THING, "friction": [friction, SPIN, 0.0], **CONTACT}
