"""The modes of thesis B, section 3.3: one button goes round them."""

from __future__ import annotations

from dataclasses import dataclass, replace

from typing_extensions import Self

from burnish.teleop.modes import Frame, Mode

POLISHING = Mode(name="polishing", translation=Frame.BASE)
"""Position only: the tool keeps its orientation."""
MIXED = Mode(name="turn about tool", translation=Frame.BASE, rotation=Frame.TOOL)
""""A more intuitive way for starters"."""
BASE = Mode(name="all in base", translation=Frame.BASE, rotation=Frame.BASE)
TOOL = Mode(name="all in tool", translation=Frame.TOOL, rotation=Frame.TOOL)
FINGERS = Mode(name="fingers", fingers=3)
"""The turn about x moves the fingers. The thesis has a threshold and one speed; here the speed follows the cap."""
ROUND = (POLISHING, MIXED, BASE, TOOL, FINGERS)


@dataclass(frozen=True, kw_only=True)
class ModesB:
    """Button 1, the left one, goes round the modes; the fingers come last, where there are some."""

    mode: Mode = POLISHING
    """The mode now."""
    fitted: bool = True
    """Whether there are fingers; the thesis took them off for the polishing tool."""

    @property
    def keys(self) -> dict[int, str]:
        """What each button does now."""
        return {1: self._next().name}

    def pressed(self, button: int) -> Self:
        """The machine after this button went down."""
        return replace(self, mode=self._next()) if button == 1 else self

    def _next(self) -> Mode:
        count = len(ROUND) if self.fitted else len(ROUND) - 1
        return ROUND[(ROUND.index(self.mode) + 1) % count]
