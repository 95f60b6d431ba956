"""The tab Teach: show the arm a job once, keep it, and let it be repeated."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from burnish.core import Array
from burnish.errors import InputError
from burnish.gui import theme
from burnish.gui.controls import allow, put
from burnish.gui.entries import labels
from burnish.gui.stage import Offer, may_edit
from burnish.library import DemonstrationRow, Row
from burnish.runtime.mailbox import Glance

if TYPE_CHECKING:
    from burnish.gui.page import Page

DEVICES = {
    "buttons on this page": "jog",
    "SpaceMouse": "spacemouse",
    "SpaceMouse by spacenavd": "spacenav",
    "gamepad": "gamepad",
    "a simulated hand": "hand",
}
"""Who leads the tool, and what the command line calls it."""
KEYS = {
    "enter": ("Go to the mould", "to the ready pose; of a replay: go on"),
    "r": ("Record", "what is shown from now on"),
    "e": ("Store", "keep what was shown, and go home"),
    "space": ("Cancel", "forget what was shown, and go home"),
    "p": ("Pause or go on", "of a replay"),
}
"""Keys of a session, what they are called here, and what they do."""
MOVES = {
    "x +": (0, 1.0), "x −": (0, -1.0), "y +": (1, 1.0), "y −": (1, -1.0), "up": (2, 1.0), "down": (2, -1.0),
}  # fmt: skip
"""Buttons that move the tool while they are held, by axis and sign, base axes."""
HOLD_HZ = 20.0
NONE = "–"
NOT_MOUNTED = Offer(may=False, why="no mould is chosen")
NOTHING_TAUGHT = Offer(may=False, why="nothing was taught yet")
HOW = (
    "A lesson: choose a mould in Job, start the lesson, go to the mould, record, lead the tool down and over the part, "
    "store. The arm is simulated."
)


class TeachTab:
    """Lessons and their repetition."""

    def __init__(self, page: Page) -> None:
        """Build it in the container that is open."""
        self._page, self._bench, gui = page, page.bench, page.gui
        self._rows: dict[str, Row] = {}
        gui.add_html(theme.text(HOW, dim=True))
        self.device = gui.add_dropdown("led by", tuple(DEVICES))
        self.start = gui.add_button("Start the lesson")
        with gui.add_folder("Lesson or replay"):
            self.keys = {key: gui.add_button(shown, hint=hint) for key, (shown, hint) in KEYS.items()}
        with gui.add_folder("Move the tool while a button is held"):
            self.speed = gui.add_slider("speed [% of 50 mm/s]", min=5, max=100, step=5, initial_value=40)
            self.moves = {shown: gui.add_button(shown) for shown in MOVES}
        with gui.add_folder("Repeat"):
            self.lesson = gui.add_dropdown("lesson", (NONE,))
            self.times = gui.add_number("times", 1, min=1, max=1000, step=1)
            self.pace = gui.add_number("times as fast", 1.0, min=0.25, max=2.0, step=0.25)
            self.replay = gui.add_button("Replay")
        act = page.act
        self.start.on_click(act(self._start))
        self.replay.on_click(act(self._replay))
        for key, button in self.keys.items():
            button.on_click(act(self._pressed(key)))
        for shown, button in self.moves.items():
            button.on_hold(self._held(*MOVES[shown]), callback_hz=HOLD_HZ)

    def refresh(self, glance: Glance | None) -> None:
        """Show what may be done now."""
        bench, mine = self._bench, self._page.command.mine
        may = may_edit(bench.stage, mine)
        self._rows = labels(list(bench.library.demonstrations()))
        put(self.lesson, options=tuple(self._rows) or (NONE,))
        allow(self.start, may if not may.may or bench.part is not None else NOT_MOUNTED)
        allow(self.replay, may if not may.may or self._rows else NOTHING_TAUGHT)
        waits = glance.waits_for if glance is not None and bench.live else ()
        for key, button in self.keys.items():
            put(button, disabled=not (mine and key in waits))
        jogged = mine and bench.live and DEVICES[self.device.value] == "jog" and bench.taught
        for button in self.moves.values():
            put(button, disabled=not jogged)

    def _start(self, event: Any) -> None:
        part = self._bench.part
        if part is None:
            raise InputError("no mould is chosen; choose one in Job first")
        folder = self._bench.new_folder("teach")
        unit = [] if part.unit == "auto" else ["--unit", part.unit]
        line = ["teach", "--mould", part.source, *unit, "--device", DEVICES[self.device.value], "--out", str(folder)]
        self._bench.run(line, folder, event.client_id)

    def _replay(self, event: Any) -> None:
        row = self._rows.get(self.lesson.value)
        if not isinstance(row, DemonstrationRow):
            raise InputError("no lesson is chosen; teach one first")
        part, folder = self._bench.part, self._bench.new_folder("replay")
        taught = self._bench.library.file(row, "recording")
        same = part is not None and part.mould.sha256 == row.mould_sha256
        mould = ["--mould", part.source] if part is not None and same else []
        line = ["replay", str(taught), *mould, "--repeats", str(int(self.times.value)), "--speed",
                f"{self.pace.value:g}", "--out", str(folder)]  # fmt: skip
        self._bench.run(line, folder, event.client_id)

    def _pressed(self, key: str) -> Callable[[Any], None]:
        return lambda event: self._bench.press(key)

    def _held(self, axis: int, sign: float) -> Callable[[Any], None]:
        """A callback that moves the tool for a fifth of a second."""

        def move(event: Any) -> None:
            if self._page.command.mine:
                self._bench.jog(twist(axis, sign, self.speed.value))

        return move


def twist(axis: int, sign: float, percent: float) -> Array:
    """A jog along one axis, (6,) in [-1, 1]."""
    moved = np.zeros(6)
    moved[axis] = sign * percent / 100.0
    return moved
