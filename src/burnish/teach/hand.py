"""`Hand`: an operator without nerves, who presses the tool on a mould and slides it; for trials without a person.

It knows where the mould is meant to stand and what the wrist feels, no more. It moves the reference of an impedance as
a person at a device does: down until something is felt, then along, deeper where the force is too small.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, field

import numpy as np
from typing_extensions import Self

from burnish.core import Array, Dynamics, ToolReference
from burnish.errors import InputError
from burnish.polish.cell import Placement
from burnish.rotation import interpolate, log
from burnish.surface import DistanceGrid, touching
from burnish.trajectory.cubic import cubic
from burnish.trajectory.path import tool_rotations

DESCENT = 8e-3
"""Speed down to the mould [m/s]."""
TRAVEL = 0.04
"""Mean speed through the air [m/s]."""
ABOVE = 0.02
"""Height over the mould at which it crosses [m]."""
FELT = 1.0
"""Force that it notices [N]."""
PRESSING = 1.0
"""Time in which it presses before it slides [s]."""
CORRECTION = 2e-3
"""Speed by which it goes deeper for each newton that is missing [m/(N·s)]: about half a second to correct itself."""
FORCE = 8.5, 3.5
"""Mean force and how much it varies on the way [N]: 5 to 12."""
SWING, DRIFT = 0.022, 0.02
"""Half of the way to and fro, and how far it comes aside meanwhile [m]."""
SWINGS, SWING_TIME = 3, 6.0
"""To and fro in one contact, and how long each takes [s]: 23 mm/s at most, none where it turns round."""
TURN = 0.25
"""How fast it turns the tool with the surface, at most [rad/s]: over waves it goes slower, as a person does."""
POINTS = 400
"""Points of a contact's path."""
REST = 1.0
"""Time that it stands still before and after its work [s]."""


@dataclass(kw_only=True)
class Hand:
    """Two contacts side by side, each to and fro with a force that rises and falls; `done` when it has lifted off."""

    contacts: list[tuple[Array, Array]]
    """Points of contact and outward normals of each, base frame, (N, 3) each."""
    upright: Array
    """Tool rotation about which the tool turns least, base ← tool, (3, 3)."""
    done: bool = field(default=False, init=False)
    """Whether it has finished and is off the mould."""
    _steps: Generator[tuple[Array, Array], Dynamics, None] | None = field(default=None, init=False, repr=False)
    _last: tuple[float, Array, Array] = field(default=(0.0, np.zeros(3), np.eye(3)), init=False, repr=False)

    @classmethod
    def on(cls, grid: DistanceGrid, placement: Placement, upright: Array, tip_radius: float) -> Self:
        """Around the middle of a mould, where it is meant to stand.

        Raises:
            InputError: if there is nothing to touch.
        """
        u = np.linspace(0.0, 1.0, POINTS)
        contacts = []
        for side in (-1.0, 1.0):
            across = side * (0.004 + DRIFT * u)
            touch = touching(grid, np.column_stack([SWING * np.cos(2.0 * np.pi * SWINGS * u), across]), tip_radius)
            if np.isnan(touch.contact).any():
                raise InputError("the hand needs a mould of 50 × 50 mm without holes in its middle; choose another")
            contacts.append((placement.points(touch.contact), placement.directions(touch.normal)))
        return cls(contacts=contacts, upright=upright)

    def reset(self, arm: Dynamics) -> None:
        """Start from this pose."""
        self.done = False
        self._steps = self._work(arm)
        next(self._steps)
        self._last = arm.t, arm.p, arm.R

    def at(self, arm: Dynamics) -> ToolReference:
        """The reference at the instant of ``arm``."""
        assert self._steps is not None, "reset comes first"
        p, R = self._steps.send(arm)
        t, p0, R0 = self._last
        v = np.zeros(6)
        if arm.t > t:
            v = np.concatenate([p - p0, log(R @ R0.T)]) / (arm.t - t)
        self._last = arm.t, p, R
        return ToolReference(p=p, R=R, v=v, a=np.zeros(6))

    def _work(self, arm: Dynamics) -> Generator[tuple[Array, Array], Dynamics, None]:
        """The whole demonstration; poses out, the measured arm in."""
        p, R = arm.p, arm.R
        arm = yield from _stand(arm, p, R)
        for points, normals in self.contacts:
            start = tool_rotations(normals[:1], self.upright)[0]
            arm = yield from _across(arm, p, R, points[0] + ABOVE * normals[0], start)
            arm, p, R = yield from self._contact(arm, points, normals)
        arm = yield from _stand(arm, p, R)
        self.done = True
        while True:
            arm = yield p, R

    def _contact(
        self, arm: Dynamics, points: Array, normals: Array
    ) -> Generator[tuple[Array, Array], Dynamics, tuple[Dynamics, Array, Array]]:
        """Down until it is felt, press, slide, lift off."""
        R, t0, depth = tool_rotations(normals, self.upright), arm.t, -ABOVE
        felt = 0
        while felt < 2:
            t, n = arm.t, normals[0]
            arm = yield points[0] - depth * n, R[0]
            depth += DESCENT * (arm.t - t)
            felt = felt + 1 if _pressing(arm, n) > FELT else 0
        t0 = arm.t
        turned = float(np.linalg.norm(np.diff(normals, axis=0), axis=1).max()) * (len(points) - 1)
        # A cubic is half as fast again in its middle as on the whole.
        duration = max(SWINGS * SWING_TIME, 1.5 * turned / TURN)
        while arm.t - t0 < PRESSING + duration:
            t = arm.t
            u = max(t - t0 - PRESSING, 0.0) / duration
            # Slowly off and slowly to the end.
            x = cubic(u, 1.0)[0] * (len(points) - 1)
            k = min(int(x), len(points) - 2)
            p = points[k] + (x - k) * (points[k + 1] - points[k]) - depth * normals[k]
            wanted = FORCE[0] + FORCE[1] * np.sin(4.0 * np.pi * x / (len(points) - 1))
            arm = yield p, interpolate(R[k], R[k + 1], x - k)
            depth += CORRECTION * (min(1.0, (t - t0) / PRESSING) * wanted - _pressing(arm, normals[k])) * (arm.t - t)
        n, off = normals[-1], points[-1] - depth * normals[-1]
        arm = yield from _across(arm, off, R[-1], points[-1] + ABOVE * n, R[-1])
        return arm, points[-1] + ABOVE * n, R[-1]


def _stand(arm: Dynamics, p: Array, R: Array) -> Generator[tuple[Array, Array], Dynamics, Dynamics]:
    """Stand still for a while."""
    t0 = arm.t
    while arm.t - t0 < REST:
        arm = yield p, R
    return arm


def _across(
    arm: Dynamics, p0: Array, R0: Array, p: Array, R: Array
) -> Generator[tuple[Array, Array], Dynamics, Dynamics]:
    """From a pose to another, from rest to rest."""
    t0, duration = arm.t, max(1.0, float(np.linalg.norm(p - p0)) / TRAVEL)
    while arm.t - t0 < duration:
        s = cubic((arm.t - t0) / duration, duration)[0]
        arm = yield p0 + s * (p - p0), interpolate(R0, R, s)
    return arm


def _pressing(arm: Dynamics, n: Array) -> float:
    """Force that is felt along the normal [N]."""
    return 0.0 if arm.F is None else float(n @ arm.F[:3])
