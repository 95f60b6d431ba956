"""What the operator's device moves: modes, the buttons that change them, and the deadman.

Pure: buttons and axes in, what is wanted out. Buttons count from 1, as the theses do; axes are those of `Reading`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import Enum
from typing import NamedTuple, Protocol

from typing_extensions import Self

from burnish.teleop.device import AT_REST, Axes


class Frame(Enum):
    """Whose axes a motion is about."""

    BASE = "base"
    """The arm's base, as the operator stands to it."""
    TOOL = "tool"
    """The tool, as it is turned now."""


@dataclass(frozen=True, kw_only=True)
class Mode:
    """What the device moves; what has no frame is not moved."""

    name: str
    """For the screen and the recording."""
    translation: Frame | None = None
    """Axes along which the cap's push moves the tool."""
    rotation: Frame | None = None
    """Axes about which the cap's turn turns the tool."""
    fingers: int | None = None
    """Index of the axis that opens (negative) and closes (positive) the fingers."""


class Wanted(NamedTuple):
    """What the operator asks for, in shares of the largest speeds."""

    push: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Translation in the mode's frame, each in [−1, 1]."""
    turn: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Rotation in the mode's frame, each in [−1, 1]."""
    close: float = 0.0
    """Fingers in [−1, 1]; positive closes."""


class Modes(Protocol):
    """A machine of modes: a mode, and the machine after a button."""

    @property
    def mode(self) -> Mode:
        """The mode now."""

    @property
    def keys(self) -> dict[int, str]:
        """What each button does now."""

    def pressed(self, button: int) -> Self:
        """The machine after this button went down; a button without a meaning changes nothing."""


@dataclass(frozen=True, kw_only=True)
class Panel:
    """The device's buttons and what they have led to.

    A button acts when it goes down. One that is down when the panel first sees it has to be released before it counts,
    the deadman above all.
    """

    modes: Modes
    """The machine of modes."""
    deadman: int | None = None
    """Button that has to be held for anything to move; None where nobody set one. It changes no mode."""
    held: bool = field(default=False)
    """Whether the deadman is held, and was seen released before."""
    down: tuple[bool, ...] | None = field(default=None)
    """The buttons at the last step."""

    @property
    def live(self) -> bool:
        """Whether the operator may move anything."""
        return self.deadman is None or self.held

    def step(self, buttons: tuple[bool, ...]) -> Panel:
        """The panel after these buttons; of several that go down at once the lowest comes first."""
        before = buttons if self.down is None or len(self.down) != len(buttons) else self.down
        modes, held = self.modes, self.held
        for number, (was, is_down) in enumerate(zip(before, buttons, strict=True), 1):
            if number == self.deadman:
                held = is_down and (held or not was)
            elif is_down and not was:
                modes = modes.pressed(number)
        return Panel(modes=modes, deadman=self.deadman, held=held, down=buttons)

    def let_go(self) -> Panel:
        """The panel after the arm was taken from the operator: the deadman has to be pressed anew."""
        return replace(self, held=False)

    def wanted(self, axes: Axes) -> Wanted:
        """What the mode takes from the axes; nothing where the deadman is not held."""
        mode = self.modes.mode
        x, y, z, rx, ry, rz = axes if self.live else AT_REST
        return Wanted(
            push=(x, y, z) if mode.translation else (0.0, 0.0, 0.0),
            turn=(rx, ry, rz) if mode.rotation else (0.0, 0.0, 0.0),
            close=axes[mode.fingers] if mode.fingers is not None and self.live else 0.0,
        )
