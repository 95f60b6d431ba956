"""`SpinningTip`: what a surface does to a spherical tip that a spindle turns, in the simulator and in the law alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import asin, inf, pi, sqrt

STANDSTILL = 1e-3
"""Sliding speed below which Coulomb friction is regularised [m/s], as in the simulated contact."""
MEAN_RING = 3.0 * pi / 16.0
"""Mean distance from the middle of a Hertz contact, by pressure and in contact radii."""
FAR = 30.0
"""k from which the series serve: they are then exact to 1e-6, and the closed forms lose digits."""

Vector = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class SpinningTip:
    """Coulomb friction over the Hertz contact of a sphere that slides and spins at once.

        u = v_t + Ω z × (−r n),    ω = Ω z·n,    a = (3 f r/(4 E*))^⅓,    k = |u|/(a|ω|)
        F = −µ f s(k) u/|u|,       m = −(3π/16) µ f a d(k) sign(ω) n

    with z the tool's axis, into the surface, n the outward normal, and s and d those of `slide_and_drill`. Upright, the
    drag is a torque about the axis, for the pressure of a sphere (3π/16) µ f a (a flat pad with even pressure would
    have ⅔), and hardly resists the feed; tilted, it pulls against the motion of the rim. The contact is that of a flat:
    curvature of the mould is not in a.
    """

    spindle: float
    """Ω, about the tool's z axis, right-handed [rad/s]."""
    friction: float
    """µ."""
    radius: float
    """Of the tip [m]."""
    modulus: float
    """E*, of the tip on the surface [Pa]."""

    def drag(
        self, force: float, normal: Sequence[float], axis: Sequence[float], velocity: Sequence[float]
    ) -> tuple[Vector, Vector]:
        """Force [N] and moment about the contact point [N·m] on the tip, in the axes of what is given.

        Args:
            force: normal force [N], ≥ 0.
            normal: outward unit normal of the surface, (3,).
            axis: unit vector of the tool's z axis, (3,).
            velocity: of the touching point without the spindle [m/s]; of more numbers the first three.
        """
        nx, ny, nz = normal
        x, y, z = axis
        vx, vy, vz = velocity[0], velocity[1], velocity[2]
        vn = vx * nx + vy * ny + vz * nz
        rim = self.radius * self.spindle
        ux = vx - vn * nx + rim * (z * ny - y * nz)
        uy = vy - vn * ny + rim * (x * nz - z * nx)
        uz = vz - vn * nz + rim * (y * nx - x * ny)
        speed = sqrt(ux * ux + uy * uy + uz * uz + STANDSTILL * STANDSTILL)
        a = (0.75 * force * self.radius / self.modulus) ** (1.0 / 3.0)
        turn = a * self.spindle * (x * nx + y * ny + z * nz)
        slide, drill = slide_and_drill(speed / abs(turn) if turn else inf)
        k = self.friction * force * slide / speed
        m = MEAN_RING * self.friction * force * a * (drill if turn > 0.0 else -drill)
        return (-k * ux, -k * uy, -k * uz), (-m * nx, -m * ny, -m * nz)


def slide_and_drill(k: float) -> tuple[float, float]:
    """Friction force and moment, of those of sliding and of spinning alone, at k = sliding speed/rim speed ≥ 0.

        s = (3π/32) (4k − k³),    d = 1 − k² + ⅜ k⁴                              up to k = 1
        s = (3/16) [(4k − k³) asin 1/k + (k² + 2) √(1 − 1/k²)],
        d = (2/π) [(1 − k² + ⅜ k⁴) asin 1/k + (¾ k − ⅜ k³) √(1 − 1/k²)]      beyond

    Source: own closed forms of the friction of a sliding and spinning contact after Contensou (1963); they agree with
    the sum over the contact to the digits of the sum.
    """
    if k <= 1.0:
        return 3.0 * pi / 32.0 * (4.0 - k * k) * k, 1.0 - k * k + 0.375 * k**4
    if k > FAR:
        return 1.0 - 0.1 / (k * k), 16.0 / (15.0 * pi * k)
    angle, root = asin(1.0 / k), sqrt(1.0 - 1.0 / (k * k))
    slide = 3.0 / 16.0 * ((4.0 - k * k) * k * angle + (k * k + 2.0) * root)
    drill = 2.0 / pi * ((1.0 - k * k + 0.375 * k**4) * angle + (0.75 - 0.375 * k * k) * k * root)
    return slide, drill
