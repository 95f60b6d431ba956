"""Whether the contact stays what it was: its stiffness and its height, from pass to pass."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

STIFFNESS_SHARE = 0.2
"""Change of the stiffness against the first pass that is reported; between strokes it scatters by a few per cent."""
HEIGHT = 0.3e-3
"""Change of the height of the contact that is reported [m]: three times what a touch is good for."""
LEAST_FORCE = 1.0
"""Below this the felt has hardly begun to bear [N]."""
FEWEST = 5
"""Readings of a force ramp from which a stiffness is taken."""


@dataclass(kw_only=True)
class Drift:
    """Force against deflection while the force rises, and height while the tool moves, by pass.

    The arm's own height h over the planned contact falls as the force F rises: h = h₀ − F/k. The slope over the force
    ramp of a stroke is 1/k, with the tip's spring, the felt and the mould's mount in series. A worn felt is stiffer and
    lies lower; a loose mount is softer.
    """

    _ramp: dict[tuple[int, int], list[tuple[float, float]]] = field(default_factory=dict, init=False, repr=False)
    _height: dict[int, tuple[int, float]] = field(default_factory=dict, init=False, repr=False)

    def pressed(self, number: int, leg: int, height: float, force: float) -> None:
        """A reading while the tool stands and the force rises: pass, leg, height [m], force [N]."""
        if force > LEAST_FORCE:
            self._ramp.setdefault((number, leg), []).append((force, height))

    def rubbed(self, number: int, height: float) -> None:
        """A reading while the tool moves under its force: pass, height over the planned contact [m]."""
        count, total = self._height.get(number, (0, 0.0))
        self._height[number] = count + 1, total + height

    def stiffness(self, number: int) -> float:
        """Stiffness of the contact in a pass, the median over its strokes [N/m]; NaN where none could be taken."""
        slopes = []
        for (passed, _), pairs in self._ramp.items():
            force, height = np.array(pairs).T
            if passed == number and len(pairs) >= FEWEST and np.ptp(force) > 2.0 * LEAST_FORCE:
                slopes.append(-np.polyfit(force, height, 1)[0])
        yields = float(np.median(slopes)) if slopes else np.nan
        return 1.0 / yields if yields > 0.0 else np.nan

    def height(self, number: int) -> float:
        """Mean height of the contact over the plan in a pass [m]; NaN before it."""
        count, total = self._height.get(number, (0, np.nan))
        return total / max(count, 1)

    def warnings(self) -> list[str]:
        """What has changed since the first pass, a sentence each."""
        passes = sorted(self._height)
        said = []
        for number in passes[1:]:
            first, now = self.stiffness(passes[0]), self.stiffness(number)
            if abs(now / first - 1.0) > STIFFNESS_SHARE:
                said.append(
                    f"pass {number}: the contact yields at {1e-3 * now:.1f} kN/m, {1e-3 * first:.1f} kN/m in pass "
                    f"{passes[0]}; look at the felt and at how the mould is held"
                )
            sunk = self.height(number) - self.height(passes[0])
            if abs(sunk) > HEIGHT:
                where = "lower" if sunk < 0.0 else "higher"
                said.append(
                    f"pass {number}: the contact lies {1e3 * abs(sunk):.1f} mm {where} than in pass {passes[0]}; the "
                    "tip is worn, or the mould has moved"
                )
        return said
