"""Find where the mould really stands, from a few touches of the tip."""

from __future__ import annotations

import numpy as np

from burnish.core import Array
from burnish.errors import PlanError
from burnish.polish.cell import Placement
from burnish.rotation import exp
from burnish.surface import DistanceGrid

SHIFT_DOUBT = 1.5e-3
"""How far a mould may stand from where it is meant to, per axis [m] (one standard deviation)."""
TURN_DOUBT = np.deg2rad(1.5)
"""How far it may be turned, per axis [rad]."""
TOUCH_DOUBT = 0.1e-3
"""How exactly a touch is felt [m]: 5 mm/s for two late samples."""
GATE = 0.5e-3
"""What a touch may be left off the located surface [m]."""

TOLD = np.repeat([0.5e-3, np.deg2rad(0.5)], 3)
"""Standard deviation of shift [m] and turn [rad] above which a direction counts as not told by the touches."""
AXES = ("shift along x", "shift along y", "shift along z", "turn about x", "turn about y", "turn about z")


def touch_points(points: Array, count: int = 5) -> Array:
    """Indices of ``count`` path points that lie far from each other, in the order of a short way round.

    The middle first, then always the point farthest from all chosen ones; sorted by angle about the middle.
    """
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    chosen = [int(np.argmin(np.linalg.norm(points - middle, axis=1)))]
    away = np.linalg.norm(points - points[chosen[0]], axis=1)
    while len(chosen) < min(count, len(points)):
        chosen.append(int(np.argmax(away)))
        away = np.minimum(away, np.linalg.norm(points - points[chosen[-1]], axis=1))
    around = np.arctan2(*(points[chosen[1:]] - middle)[:, 1::-1].T)
    return np.array([chosen[0], *np.array(chosen[1:])[np.argsort(around)]])


def locate(grid: DistanceGrid, nominal: Placement, centres: Array, radius: float) -> Placement:
    """The placement that explains the touches best, near the nominal one.

    Least squares in a small shift s and turn w of the mould about the mean touch: minimise
    ``Σ (φ(c_i) − r)²/σ² + |s|²/σ_s² + |w|²/σ_w²``, by Gauss–Newton. What the touches cannot tell (a plate may have
    slid in its plane) stays nominal.

    Args:
        grid: distance to the mould, in its frame.
        nominal: where it is meant to stand.
        centres: centre of the spherical tip at each touch, base frame [m], (N, 3).
        radius: of the tip [m].

    Raises:
        PlanError: if a touch lies further than 0.5 mm off the located surface: it is another mould.
    """
    pivot = centres.mean(axis=0)
    placement = nominal
    x = np.zeros(6)
    doubt = np.repeat([SHIFT_DOUBT, TURN_DOUBT], 3)
    residual = np.zeros(len(centres))
    for _ in range(10):
        phi, gradient = grid.at((centres - placement.p) @ placement.R)
        n = gradient @ placement.R.T
        residual = phi - radius
        # Moving the mould by s and w moves its surface under the tip by n·(s + w × (c − pivot)).
        A = -np.column_stack([n, np.cross(centres - pivot, n)]) / TOUCH_DOUBT
        normal = A.T @ A + np.diag(doubt**-2)
        step = np.linalg.solve(normal, -(A.T @ (residual / TOUCH_DOUBT)) - x / doubt**2)
        x = x + step
        turn = exp(x[3:])
        placement = Placement(p=pivot + x[:3] + turn @ (nominal.p - pivot), R=turn @ nominal.R)
        if float(np.linalg.norm(step)) < 1e-9:
            break
    worst = float(np.abs(grid.at((centres - placement.p) @ placement.R)[0] - radius).max())
    if not worst <= GATE:
        raise PlanError(
            f"the touched points do not fit the mould: {1e3 * worst:.1f} mm is left at one; expected at most "
            f"{1e3 * GATE:.1f} mm. Check that this mould is mounted, and how"
        )
    return placement


def doubt_left(grid: DistanceGrid, placement: Placement, centres: Array, radius: float) -> Array:
    """Standard deviation of shift and turn that the touches leave, base axes [m, rad], (6,).

    The square root of the diagonal of (AᵀA/σ² + diag(prior⁻²))⁻¹ at the located placement; arguments as for `locate`.
    """
    _, gradient = grid.at((centres - placement.p) @ placement.R)
    n = gradient @ placement.R.T
    A = -np.column_stack([n, np.cross(centres - centres.mean(axis=0), n)]) / TOUCH_DOUBT
    doubt = np.repeat([SHIFT_DOUBT, TURN_DOUBT], 3)
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(A.T @ A + np.diag(doubt**-2)))))


def untold(spread: Array) -> str:
    """What a standard deviation of shift and turn (6,) leaves open, in words for an operator; empty if nothing."""
    return ", ".join(
        f"{name} (±{1e3 * value:.1f} mm)" if i < 3 else f"{name} (±{np.rad2deg(value):.1f}°)"
        for i, (name, value) in enumerate(zip(AXES, spread, strict=True))
        if value > TOLD[i]
    )
