"""Contact of a spherical tip with a mould, from the signed distance of its surface.

The force depends on the surface alone, not on how it was meshed: with φ the distance of the tip's centre and
n = ∇φ/|∇φ| the outward normal, a tip of radius r is pressed by ``δ = r − φ`` and feels

    f_n = max(0, k δ − c v·n),   f_t = −µ f_n v_t/√(v_t² + v₀²)

with v the velocity of the touching point. Plain floats on nested lists: in Python that is several times faster
than arrays of three numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt
from typing import NamedTuple

from burnish.core import Array
from burnish.model.spin import SpinningTip
from burnish.model.tool import PolishingTool
from burnish.surface import DistanceGrid

STIFFNESS = 100e3
"""Stiffness of the felt against steel [N/m]; several times the tip's spring, which is what yields."""
DAMPING = 40.0
"""Damping of the contact [N·s/m]: about 0.3 of critical for a 50 g tip."""
SLIP_SPEED = 1e-3
"""Speed below which Coulomb friction is regularised [m/s]; a twentieth of a slow feed."""

Vector = tuple[float, float, float]
NONE = (0.0, 0.0, 0.0)


class Touch(NamedTuple):
    """What the mould does to the tip at one instant, in the axes of the mould."""

    normal_force: float
    """Along the outward normal [N], ≥ 0."""
    force: Vector
    """Whole force on the tip [N]."""
    normal: Vector
    """Outward unit normal of the surface."""
    point: Vector
    """Where it acts, on the sphere [m]."""
    slip: float
    """Tangential speed of the tip over the surface, that of its spindle left out [m/s]."""
    moment: Vector = NONE
    """Moment on the tip about the touching point [N·m]."""


class SphereOnSurface:
    """A sphere against the distance grid of a mould; both in the mould's frame."""

    def __init__(self, grid: DistanceGrid, radius: float, friction: float) -> None:
        self._x0, self._y0, self._z0 = (float(c) for c in grid.origin)
        self._per_cell = 1.0 / float(grid.spacing)
        self._values = grid.values.tolist()
        self._last = tuple(size - 2 for size in grid.values.shape)
        self._cell = (0, 0, 0)
        self._trilinear = self._at(0, 0, 0)
        self.radius = radius
        self.friction = friction

    def distance(self, x: float, y: float, z: float) -> tuple[float, float, float, float] | None:
        """Signed distance [m] and its gradient at a point, trilinear; None outside the grid."""
        s = self._per_cell
        u, v, w = (x - self._x0) * s, (y - self._y0) * s, (z - self._z0) * s
        if u < 0.0 or v < 0.0 or w < 0.0:
            return None
        cell = i, j, k = int(u), int(v), int(w)
        if cell != self._cell:
            last = self._last
            if i > last[0] or j > last[1] or k > last[2]:
                return None
            # The tip stays in a cell for many steps.
            self._cell, self._trilinear = cell, self._at(i, j, k)
        u -= i
        v -= j
        w -= k
        a, au, av, aw, auv, auw, avw, auvw = self._trilinear
        gx = au + v * (auv + w * auvw) + w * auw
        gy = av + w * avw
        gz = aw + u * (auw + v * auvw) + v * avw
        return a + u * gx + v * gy + w * aw, gx * s, (gy + u * (auv + w * auvw)) * s, gz * s

    def _at(self, i: int, j: int, k: int) -> tuple[float, float, float, float, float, float, float, float]:
        """Coefficients of 1, u, v, w, uv, uw, vw and uvw in a cell, u, v, w from 0 to 1."""
        plane0, plane1 = self._values[i], self._values[i + 1]
        row00, row01, row10, row11 = plane0[j], plane0[j + 1], plane1[j], plane1[j + 1]
        a, c001, c010, c011 = row00[k], row00[k + 1], row01[k], row01[k + 1]
        c100, c101, c110, c111 = row10[k], row10[k + 1], row11[k], row11[k + 1]
        au, av, aw = c100 - a, c010 - a, c001 - a
        auv, auw, avw = c110 - c100 - av, c101 - c100 - aw, c011 - c010 - aw
        return a, au, av, aw, auv, auw, avw, c111 - c110 - c101 + c100 - avw

    def touch(self, centre: Vector, motion: Callable[[], tuple[Vector, Vector]]) -> Touch | None:
        """The contact at the tip's centre [m]; None in the air.

        Args:
            centre: of the sphere [m].
            motion: its velocity [m/s] and angular velocity [rad/s]; asked for only where it touches.
        """
        found = self.distance(*centre)
        if found is None:
            return None
        phi, nx, ny, nz = found
        depth = self.radius - phi
        if depth <= 0.0:
            return None
        size = sqrt(nx * nx + ny * ny + nz * nz)
        if size < 1e-6:
            return None
        nx, ny, nz = nx / size, ny / size, nz / size
        # Velocity of the touching point: centre + spin × (−φ n).
        velocity, (wx, wy, wz) = motion()
        vx = velocity[0] - phi * (wy * nz - wz * ny)
        vy = velocity[1] - phi * (wz * nx - wx * nz)
        vz = velocity[2] - phi * (wx * ny - wy * nx)
        vn = vx * nx + vy * ny + vz * nz
        fn = STIFFNESS * depth - DAMPING * vn
        if fn < 0.0:
            fn = 0.0
        tx, ty, tz = vx - vn * nx, vy - vn * ny, vz - vn * nz
        slip2 = tx * tx + ty * ty + tz * tz
        drag = self.friction * fn / sqrt(slip2 + SLIP_SPEED * SLIP_SPEED)
        return Touch(
            fn,
            (fn * nx - drag * tx, fn * ny - drag * ty, fn * nz - drag * tz),
            (nx, ny, nz),
            (centre[0] - phi * nx, centre[1] - phi * ny, centre[2] - phi * nz),
            sqrt(slip2),
        )


class SpinningSphere(SphereOnSurface):
    """The same sphere turned by a spindle: its friction is that of `SpinningTip`."""

    def __init__(self, grid: DistanceGrid, tip: SpinningTip, axis: Array) -> None:
        """A tip over a grid.

        Args:
            grid: distance to the mould.
            tip: the tip and its spindle.
            axis: unit vector of the tool's z axis in the mould's frame, (3,); whoever owns it keeps it up to date.
        """
        super().__init__(grid, tip.radius, tip.friction)
        self._spinning, self._axis = tip, axis

    def touch(self, centre: Vector, motion: Callable[[], tuple[Vector, Vector]]) -> Touch | None:
        """As that of a sphere that does not spin, with the drag of the spindle in place of its friction."""
        touch = super().touch(centre, motion)
        if touch is None:
            return None
        (vx, vy, vz), (wx, wy, wz) = motion()
        rx, ry, rz = (point - middle for point, middle in zip(touch.point, centre, strict=True))
        velocity = (vx + wy * rz - wz * ry, vy + wz * rx - wx * rz, vz + wx * ry - wy * rx)
        fn, n = touch.normal_force, touch.normal
        (fx, fy, fz), moment = self._spinning.drag(fn, n, self._axis.tolist(), velocity)
        return touch._replace(force=(fn * n[0] + fx, fn * n[1] + fy, fn * n[2] + fz), moment=moment)


def contact_of(grid: DistanceGrid, tool: PolishingTool, axis: Array) -> SphereOnSurface:
    """The contact of a tool's tip with a mould; ``axis`` is that of the tool, as for `SpinningSphere`."""
    if tool.spinning is None:
        return SphereOnSurface(grid, tool.tip_radius, tool.friction)
    return SpinningSphere(grid, tool.spinning, axis)


def plain(vector: Array) -> Vector:
    """Three Python floats of an array."""
    x, y, z = vector.tolist()
    return x, y, z
