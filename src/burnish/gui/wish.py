"""What the operator asks for: mould, recipe and arm, with every edit kept so that it can be undone."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from burnish.errors import InputError
from burnish.polish.recipe import FEED, FORCE, MOST_PASSES, Pass, Recipe
from burnish.polish.recipe_file import PATTERNS

PLAIN = "parallel lines"
OWN = "as the recipe says"
SHOWN = {
    PLAIN: None,
    "lines, hemmed at walls": "raster",
    "cross-hatch": "cross_hatch",
    "spiral": "spiral",
    "along the contour": "contour",
    "lines of equal distance": "geodesic",
}
"""Patterns in plain words, and what a recipe calls them; None is the raster of a bare ``burnish polish``."""
ARMS = {
    "realistic (friction, delay, errors)": "honest",
    "realistic, stiff gears": "honest-stiff",
    "ideal (no errors)": "ideal",
}
"""Simulated arms in plain words."""
SENSORS = {"at the wrist": "wrist", "joint torques": "joint"}
"""What it feels with."""
PACES = {"as fast as it can": 0.0, "real time": 1.0, "4 times real time": 4.0}
"""How the simulated arm keeps to the clock on the wall, times real time."""
UNDONE_AT_MOST = 100


@dataclass(frozen=True, kw_only=True)
class Wish:
    """One job as the page shows it."""

    recipe: Recipe = field(default_factory=Recipe)
    """The recipe, with whatever the page does not show."""
    passes: int = 1
    """How often it is done."""
    arm: str = "honest"
    """Name of the simulated arm."""
    sensor: str = "wrist"
    """Name of what it feels with."""
    seed: int = 0
    """Seed of all random errors."""
    pace: float = 0.0
    """Times real time; 0 is as fast as it can."""

    @property
    def pattern(self) -> str:
        """The pattern in plain words."""
        passes = self.recipe.passes
        if not passes:
            return PLAIN
        return next((shown for shown, name in SHOWN.items() if name and passes == (_pass(name),)), OWN)

    def with_force(self, newton: float) -> Wish:
        """Pressed with this force [N].

        Raises:
            InputError: it is out of range.
        """
        return replace(self, recipe=replace(self.recipe, force=float(newton)))

    def with_feed(self, mm_per_s: float) -> Wish:
        """At this speed [mm/s].

        Raises:
            InputError: it is out of range.
        """
        feed = min(max(1e-3 * float(mm_per_s), FEED.low), FEED.high) if _at_an_end(mm_per_s) else 1e-3 * mm_per_s
        return replace(self, recipe=replace(self.recipe, feed=feed))

    def with_pattern(self, shown: str) -> Wish:
        """Covered like this; `OWN` leaves the recipe's passes as they are.

        Raises:
            InputError: there is no such pattern.
        """
        if shown == OWN:
            return self
        if shown not in SHOWN:
            raise InputError(f"there is no pattern {shown!r}; expected {', '.join(SHOWN)}")
        name = SHOWN[shown]
        return replace(self, recipe=replace(self.recipe, passes=() if name is None else (_pass(name),)))

    def with_passes(self, number: int) -> Wish:
        """Done this often.

        Raises:
            InputError: it is out of range.
        """
        most = max(1, MOST_PASSES // max(1, len(self.recipe.passes)))
        if not 1 <= number <= most:
            raise InputError(f"{number} times over is out of range; expected 1 to {most} with this recipe")
        return replace(self, passes=int(number))

    def on(self, **changed: Any) -> Wish:
        """With another arm, sensor, seed or pace."""
        return replace(self, **changed)

    def words(self, mould: str, unit: str, recipe: Path, out: Path) -> list[str]:
        """The command line that does it.

        Args:
            mould: bundled name or path of the file.
            unit: of that file, or ``auto``.
            recipe: the recipe's file.
            out: folder of the results.
        """
        return [
            "polish", "--mould", mould, "--unit", unit, "--recipe", str(recipe), "--passes", str(self.passes),
            "--arm", self.arm, "--sensor", self.sensor, "--seed", str(self.seed), "--out", str(out),
            "--pace", f"{self.pace:g}",
        ]  # fmt: skip


@dataclass(kw_only=True)
class Edits:
    """The wish as it is now, and as it was before each edit."""

    now: Wish = field(default_factory=Wish)
    """The latest."""
    before: list[Wish] = field(default_factory=list)
    """Older ones, the oldest first."""
    undone: list[Wish] = field(default_factory=list)
    """Newer ones that were undone, the newest first."""

    def change(self, wish: Wish) -> bool:
        """Take another wish; false if it is the same."""
        if wish == self.now:
            return False
        self.before = [*self.before, self.now][-UNDONE_AT_MOST:]
        self.now, self.undone = wish, []
        return True

    def undo(self) -> bool:
        """Back to what was before the last edit; false if there is nothing before."""
        if not self.before:
            return False
        self.undone.append(self.now)
        self.now = self.before.pop()
        return True

    def redo(self) -> bool:
        """Take back the last `undo`; false if there is none."""
        if not self.undone:
            return False
        self.before.append(self.now)
        self.now = self.undone.pop()
        return True


FORCE_N = (FORCE.low, FORCE.high)
FEED_MM_S = (1e3 * FEED.low, 1e3 * FEED.high)
"""Ranges as the page shows them."""


def _pass(name: str) -> Pass:
    return Pass(pattern=PATTERNS[name]())


def _at_an_end(mm_per_s: float) -> bool:
    """Whether a feed is one end of its range but for rounding."""
    return any(abs(mm_per_s - end) < 1e-9 * end for end in FEED_MM_S)
