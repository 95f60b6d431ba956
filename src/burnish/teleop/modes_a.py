"""The modes of thesis A, figure 6.4: free, translation and rotation on button 2, the fingers on button 1."""

from __future__ import annotations

from dataclasses import dataclass, replace

from typing_extensions import Self

from burnish.teleop.modes import Frame, Mode

FREE = Mode(name="free", translation=Frame.BASE, rotation=Frame.TOOL)
"""All six degrees of freedom. The thesis turns "around each axis of the end effector" and moves along the base's."""
TRANSLATION = Mode(name="translation", translation=Frame.BASE)
ROTATION = Mode(name="rotation", rotation=Frame.TOOL)
FINGERS = Mode(name="fingers", fingers=5)
"""The arm stands; the twist of the cap opens and closes the hand."""
NEXT = {FREE: TRANSLATION, TRANSLATION: ROTATION, ROTATION: FREE}


@dataclass(frozen=True, kw_only=True)
class ModesA:
    """Button 2 goes round free, translation and rotation; button 1 goes to the fingers, and either comes back."""

    mode: Mode = FREE
    """The mode now."""
    left: Mode = FREE
    """The mode that was left for the fingers."""
    fitted: bool = True
    """Whether there are fingers; without them button 1 does nothing."""

    @property
    def keys(self) -> dict[int, str]:
        """What each button does now."""
        if self.mode is FINGERS:
            return {1: f"back to {self.left.name}", 2: f"back to {self.left.name}"}
        return ({1: FINGERS.name} if self.fitted else {}) | {2: NEXT[self.mode].name}

    def pressed(self, button: int) -> Self:
        """The machine after this button went down."""
        if button not in self.keys:
            return self
        if self.mode is FINGERS:
            return replace(self, mode=self.left)
        if button == 1:
            return replace(self, mode=FINGERS, left=self.mode)
        return replace(self, mode=NEXT[self.mode])
